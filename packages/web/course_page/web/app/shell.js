// The page around the panels: menu, addresses, states of the connection, messages.
import {addressOf, besideOf, besideParameters, MOST_BESIDE, ownParameters, parseAddress} from './address.js';
import {CROSS, commandLine, el, fill, icon, store, stored} from './dom.js';
import {PANELS} from './panels.js';
import {Rosapi} from './rosapi.js';

const TOAST_TIME = 8000;   // [ms]
const MAX_TOASTS = 3;
const CONNECTING = 1500;   // [ms] before the page says that it connects
const LAYOUTS = 'layouts';  // in the browser's storage
const MAX_LAYOUTS = 30;
const MAX_LAYOUT_NAME = 60; // characters
const READY = {
  'Turtle, plot, graph': '#/turtle?plot.fields=/turtle1/pose/x,/turtle1/pose/y&beside=plot,graph',
  'Robotont, camera, frames, console': '#/robot?beside=image,frames,console',
};

const find = (id) => document.getElementById(id);

export function startShell(ros) {
  const shell = new Shell(ros);
  makeMenu();
  makeThemeButton();
  find('theme').before(layoutMenu((id) => panelOf(id)?.title ?? id));
  addEventListener('hashchange', () => shell.route());
  ros.onState((state) => shell.showState(state));
  ros.statuses.add(({level, text}) => toast(text, level));
  setTimeout(() => shell.showState(ros.state), CONNECTING);
  shell.route();
}

// Tell a screen reader something.
export function announce(text) {
  find('live').textContent = '';
  setTimeout(() => { find('live').textContent = text; }, 50);  // so that the same text is read again
}

// Show a short message for a while; `level`: error, warning or info.
export function toast(text, level = 'info') {
  const toasts = find('toasts');
  const same = [...toasts.children].find((other) => other.firstChild.textContent === text);
  same?.remove();
  const close = el('button', {class: 'plain', type: 'button', 'aria-label': 'Close', on: {click: () => message.remove()}}, icon(CROSS));
  const message = el('div', {class: `toast ${level}`}, el('span', {}, text), close);
  toasts.append(message);
  while (toasts.children.length > MAX_TOASTS) toasts.firstChild.remove();
  setTimeout(() => message.remove(), TOAST_TIME);
}

class Shell {
  constructor(ros) {
    this._ros = ros;
    this._rosapi = new Rosapi(ros);
    this._shown = [...document.querySelectorAll('#panels > .panel')].map((element) => new Slot(element));
  }

  route() {
    const {id, parameters} = parseAddress(location.hash);
    const first = panelOf(id) || PANELS[0];
    const others = besideOf(first.id, parameters).map(panelOf).filter(Boolean);
    const kept = besideParameters(parameters, others.map((panel) => panel.id));
    for (const link of find('menu').querySelectorAll('a')) {
      const current = link.dataset.id === first.id;
      if (current) link.setAttribute('aria-current', 'page');
      else link.removeAttribute('aria-current');
      link.href = addressOf(link.dataset.id, kept);
      if (current) showLink(link);
    }
    document.title = `${first.title} – turtle_robotont`;
    document.body.classList.toggle('two', others.length > 0);
    document.body.classList.toggle('several', others.length > 1);
    document.body.classList.toggle('four', others.length > 2);
    this._show(0, first, ownParameters(parameters));
    for (let index = 1; index <= MOST_BESIDE; index += 1) {
      const panel = others[index - 1];
      this._show(index, panel, panel ? ownParameters(parameters, panel.id) : {});
    }
  }

  _show(index, panel, own) {
    const slot = this._shown[index];
    const key = panel ? JSON.stringify([index > 0, panel.id, own]) : '';
    if (slot.key === key) return;
    slot.key = key;
    slot.element.hidden = !panel;
    slot.clear();
    if (panel) this._mount(slot, panel, own, index === 0);
  }

  async _mount(slot, panel, parameters, isFirst) {
    const body = el('div', {class: 'body'});
    const head = el('header', {class: 'head'}, el('h1', {}, panel.title));
    fill(slot.element, head, body);
    const turn = slot.turn;
    let module;
    try {
      module = await import(`../panels/${panel.id}.js`);
    } catch (error) {
      console.error(error);
      fill(body, el('p', {class: 'empty'}, `This panel could not be loaded: ${error.message}. Reload the page.`));
      return;
    }
    if (slot.turn !== turn) return;
    head.append(helpOf(panel, module.help), isFirst ? this._besideChoice(panel) : closeBeside(panel));
    const context = {
      ros: this._ros, rosapi: this._rosapi, parameters, announce, toast, commandLine, keys: isFirst,
      // Change the panel's part of the address without mounting it again.
      setParameters: (changes) => {
        if (slot.turn !== turn) return;
        const {id, parameters: now} = parseAddress(location.hash);
        Object.assign(parameters, changes);
        const named = Object.entries(changes).map(([key, value]) => [isFirst ? key : `${panel.id}.${key}`, value]);
        history.replaceState(null, '', addressOf(id || PANELS[0].id, {...now, ...Object.fromEntries(named)}));
        const own = ownParameters(parseAddress(location.hash).parameters, isFirst ? '' : panel.id);
        slot.key = JSON.stringify([!isFirst, panel.id, own]);
      },
      // Show another panel.
      open: (id, own = {}) => {
        const {parameters: now} = parseAddress(location.hash);
        location.hash = addressOf(id, {...own, ...besideParameters(now, besideOf(id, now))});
      },
    };
    try {
      slot.shown = new module.default(body, context);
    } catch (error) {
      console.error(error);
      fill(body, el('p', {class: 'empty'}, `This panel does not work: ${error.message}`));
    }
  }

  _besideChoice(panel) {
    const choice = el('select', {
      'aria-label': 'Show another panel beside this one', class: 'beside-choice',
      on: {change: () => {
        const {id, parameters} = parseAddress(location.hash);
        const others = [...besideOf(id, parameters), choice.value].slice(-MOST_BESIDE);
        choice.value = '';
        location.hash = addressOf(id || panel.id, {...ownParameters(parameters), ...besideParameters(parameters, others)});
      }},
    }, el('option', {value: ''}, 'Beside …'),
    PANELS.filter((other) => other !== panel).map(({id, title}) => el('option', {value: id}, title)));
    return choice;
  }

  showState(state) {
    const shown = describe(state);
    const pill = find('link');
    if (pill.textContent !== shown.short) {
      pill.textContent = shown.short;
      pill.className = `pill ${shown.kind}`;
    }
    const banner = find('banner');
    const early = state.link === 'connecting' && state.master && state.server && performance.now() < CONNECTING;
    banner.hidden = shown.kind === 'good' || early;
    document.body.classList.toggle('offline', shown.kind !== 'good');
    if (!banner.hidden && banner.dataset.shown !== shown.title) {
      fill(banner, el('strong', {}, shown.title), el('p', {}, shown.text), shown.commands.map(commandLine));
    }
    banner.dataset.shown = banner.hidden ? '' : shown.title;
  }
}

// A slot for a panel.
class Slot {
  constructor(element) {
    this.element = element;
    this.key = '';
    this.turn = 0;
    this.shown = null;
  }

  clear() {
    this.turn += 1;
    try {
      this.shown?.close();
    } catch (error) {
      console.error(error);
    }
    this.shown = null;
    this.element.replaceChildren();
  }
}

function describe(state) {
  if (!state.server) {
    return {kind: 'bad', short: 'No server', title: 'The server of this page does not answer.',
      text: 'It has stopped, or the network is interrupted. Type this in a terminal; the page then connects by itself:',
      commands: ['roslaunch turtle_robotont browser.launch']};
  }
  if (!state.master) {
    return {kind: 'bad', short: 'No roscore', title: 'No roscore is running.',
      text: `ROS needs one${state.uri ? ` at ${state.uri}` : ''}. Start a simulator in the panel Start, or type one of these lines `
        + 'in a terminal. The page then connects by itself.',
      commands: ['roscore', 'roslaunch turtle_robotont turtlesim.launch']};
  }
  if (state.stalled) {
    return {kind: 'bad', short: 'No answer', title: 'Nothing has come from the server for 2 s.',
      text: 'What you see here is old, and buttons have no effect: the network or the server stands still. The page goes on '
        + 'by itself. What it drives stops by itself.', commands: []};
  }
  if (state.link === 'open') return {kind: 'good', short: 'Connected', title: '', text: '', commands: []};
  return {kind: 'busy', short: state.link === 'lost' ? 'Reconnecting' : 'Connecting',
    title: state.link === 'lost' ? 'The connection to ROS was lost.' : 'Connecting to ROS.',
    text: 'The page tries again twice a second. You do not need to do anything.', commands: []};
}

function helpOf({title}, texts) {
  return el('details', {class: 'help'}, el('summary', {'aria-label': `About ${title}`}, '?'),
    el('div', {class: 'card'}, texts.map((text) => el('p', {}, text))));
}

function closeBeside(panel) {
  return el('button', {class: 'plain', type: 'button', 'aria-label': `Close ${panel.title}`, on: {click: () => {
    const {id, parameters} = parseAddress(location.hash);
    const others = besideOf(id, parameters).filter((other) => other !== panel.id);
    location.hash = addressOf(id, {...ownParameters(parameters), ...besideParameters(parameters, others)});
  }}}, icon(CROSS));
}

function panelOf(id) {
  return PANELS.find((panel) => panel.id === id);
}

function makeMenu() {
  const groups = new Map();
  for (const panel of PANELS) {
    if (!groups.has(panel.group)) groups.set(panel.group, []);
    groups.get(panel.group).push(panel);
  }
  fill(find('menu'), [...groups].map(([name, panels]) => el('div', {class: 'group'},
    el('h2', {}, name), panels.map((panel) => el('a', {href: addressOf(panel.id), dataset: {id: panel.id}},
      icon(panel.icon), el('span', {}, panel.title))))));
}

// Scroll the menu, and nothing else, so that a link is in the middle.
function showLink(link) {
  const menu = find('menu');
  const [box, there] = [menu.getBoundingClientRect(), link.getBoundingClientRect()];
  menu.scrollLeft += there.x + there.width / 2 - box.x - box.width / 2;
  menu.scrollTop += there.y + there.height / 2 - box.y - box.height / 2;
}

function makeThemeButton() {
  const button = find('theme');
  button.append(icon('M12 3a9 9 0 1 0 0 18V3zM12 3a9 9 0 0 1 0 18'));
  button.addEventListener('click', () => dispatchEvent(new Event('switchtheme')));
}

// Return the saved layouts, {name: address}; what is in the browser may be anything.
export function savedLayouts(kept) {
  return Object.fromEntries(Object.entries(kept ?? {}).filter(([, address]) => /^#\/\w+/.test(address)).slice(0, MAX_LAYOUTS));
}

// Return the menu of layouts; `titleOf(id)` is the title of a panel.
function layoutMenu(titleOf) {
  const name = el('input', {type: 'text', autocomplete: 'off', maxLength: MAX_LAYOUT_NAME});
  const list = el('ul', {});
  const read = () => savedLayouts(stored(LAYOUTS));
  const write = (layouts) => {
    store(LAYOUTS, layouts);
    show();
  };
  const link = (title, address) => el('a', {href: address, on: {click: () => { menu.open = false; }}}, title);
  function show() {
    const saved = read();
    fill(list, Object.entries(READY).map(([title, address]) => el('li', {}, link(title, address))),
         Object.entries(saved).map(([title, address]) => el('li', {}, link(title, address), el('button', {
           class: 'plain', type: 'button', 'aria-label': `Delete the layout ${title}`, on: {click: () => {
             const {[title]: gone, ...others} = saved;
             write(others);
           }}}, icon(CROSS)))));
  }
  const save = (event) => {
    event.preventDefault();
    const {id, parameters} = parseAddress(location.hash);
    const usual = [id || 'turtle', ...besideOf(id, parameters)].map(titleOf).join(', ');
    write({...read(), [name.value.trim() || usual.slice(0, MAX_LAYOUT_NAME)]: location.hash || '#/turtle'});
    name.value = '';
  };
  const menu = el('details', {class: 'layouts', on: {toggle: show}}, el('summary', {}, 'Layouts'),
    el('div', {class: 'card'}, list, el('form', {class: 'row', on: {submit: save}},
      el('label', {class: 'field'}, 'Name for what is shown now', name), el('button', {type: 'submit'}, 'Save'))));
  return menu;
}
