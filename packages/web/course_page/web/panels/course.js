// The steps of the course; the page of a step is read when it is opened. A step is marked done once it is observed.
import {commandLine, el, emptyState, fill, store, stored} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {PANELS} from '../app/panels.js';
import {button, Notice, Panel, setText} from './lib/parts.js';
import {RULES, Watcher} from './lib/course_rules.js';
import {System} from './lib/system.js';

const COURSE = new URL('../course/', import.meta.url);
const POSES = 10; // messages a second
const MOST_VEHICLES = 5;
const STORE = 'course steps'; // in the browser's storage: {number of the step: when it was done}
const TERMINAL = /\s+# terminal (\d+)\s*$/;

export const help = [
  'The steps of the course with their commands. While this panel is open, also beside another one, it looks at nodes '
    + 'and poses, and ticks a step off as soon as it sees that it is done. You can also tick it yourself.'];

export default class CoursePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._element = element;
    this._notice = new Notice();
    const done = stored(STORE);
    this._done = done !== null && typeof done === 'object' ? done : {};
    this._poses = new Map();
    this._load();
    this.scope.add(() => this._poses.forEach((end) => end()));
  }

  async _load() {
    fill(this._element, el('p', {class: 'muted'}, 'Loading the course …'));
    let steps;
    try {
      steps = JSON.parse(await read('steps'));
    } catch (error) {
      if (!this.scope.ended) fill(this._element, emptyState('The course cannot be shown', error.message));
      return;
    }
    if (this.scope.ended) return;
    this._show(steps);
    const watcher = new Watcher((number) => this._see(number));
    new System(this.scope, this.context.rosapi, (system) => {
      this._notice.say('');
      watcher.update(system);
      this._watchPoses(watcher, system);
    }, (error) => this._notice.say(error.message, true));
  }

  _watchPoses(watcher, system) {
    const topics = Watcher.poseTopics(system).slice(0, MOST_VEHICLES);
    for (const [name, end] of this._poses) {
      if (!topics.some((topic) => topic.name === name)) {
        end();
        this._poses.delete(name);
      }
    }
    for (const {name, type} of topics) {
      if (!this._poses.has(name)) {
        this._poses.set(name, this.context.ros.subscribe(name, type, (message) => (
          watcher.pose(name, type, message, performance.now() / 1000)), {rate: POSES}));
      }
    }
  }

  _show(steps) {
    this._steps = new Map(steps.map((step) => [step.number, this._step(step)]));
    this._progress = el('progress', {max: this._steps.size, 'aria-label': 'Steps done'});
    this._count = el('p', {class: 'muted'});
    let sure = false;
    const again = button('Start again', () => {
      if (sure) {
        this._done = {};
        store(STORE, this._done);
        this._mark();
      }
      sure = !sure;
      again.textContent = sure ? 'Press again to forget all marks' : 'Start again';
    });
    fill(this._element, el('div', {class: 'toolbar'}, this._progress, this._count, again), this._notice.element,
         el('ol', {class: 'steps'}, [...this._steps.values()].map(({element}) => element)));
    this._mark();
    const number = this.context.parameters.step || [...this._steps.keys()].find((step) => !this._done[step]);
    const first = this._steps.get(number);
    if (first) first.details.open = true;
    if (this.context.parameters.step && first) first.element.scrollIntoView();
  }

  _step({number, title, folder, panels}) {
    const tick = el('input', {type: 'checkbox', 'aria-label': `Step ${number} is done`, on: {change: () => {
      if (tick.checked) this._done[number] = Date.now();
      else delete this._done[number];
      store(STORE, this._done);
      this._mark();
    }}});
    const state = el('span', {class: 'pill'});
    const links = panels.map((id) => PANELS.find((panel) => panel.id === id)).filter(Boolean).map((panel) => (
      el('a', {class: 'button-link', href: addressOf(panel.id, {beside: 'course'})}, panel.title)));
    const text = el('div');
    let loaded = false;
    const details = el('details', {on: {toggle: async () => {
      if (!details.open) return;
      this.context.setParameters({step: number});
      if (loaded) return;
      loaded = true;
      try {
        fill(text, parseStep(await read(`${folder}/README.md`)).map((block) => show(block, folder)));
      } catch (error) {
        loaded = false;
        fill(text, emptyState('This step cannot be shown', error.message));
      }
    }}},
      el('summary', {}, el('span', {class: 'step-title'}, `${number}. ${title}`), state),
      links.length ? el('div', {class: 'row'}, el('span', {class: 'muted small'}, 'Look at it in'), links) : null,
      text, el('p', {class: 'muted small'}, `This step is marked when ${RULES[number] || 'you tick it'}.`));
    return {element: el('li', {class: 'card step'}, tick, details), details, tick, state};
  }

  // Mark a step that has been observed.
  _see(number) {
    if (this._done[number] || this.scope.ended) return;
    this._done[number] = Date.now();
    store(STORE, this._done);
    this._mark();
    this.context.announce(`Step ${number} of the course is done.`);
    this.context.toast(`Step ${number} of the course is done.`);
  }

  _mark() {
    let count = 0;
    for (const [number, {tick, state}] of this._steps) {
      const done = Boolean(this._done[number]);
      count += done;
      tick.checked = done;
      setText(state, done ? 'Done' : 'Not yet');
      state.classList.toggle('good', done);
    }
    this._progress.value = count;
    setText(this._count, `${count} of ${this._steps.size} steps done`);
  }
}

// Return the text of a file of the course; raise an Error that says which one is missing.
async function read(name) {
  const answer = await fetch(new URL(name, COURSE));
  if (!answer.ok) throw new Error(`course/${name} cannot be read (${answer.status} ${answer.statusText})`);
  return answer.text();
}

function show(block, folder) {
  if (block.kind === 'commands') {
    return el('div', {class: 'commands'}, block.commands.map(({terminal, text}) => el('div', {class: 'typed'},
      el('span', {class: 'terminal', title: terminal ? `Terminal ${terminal}` : ''},
        el('span', {class: 'unseen'}, 'Terminal '), terminal), commandLine(text))));
  }
  if (block.kind === 'output') return el('pre', {class: 'output', tabIndex: 0, 'aria-label': 'What you should see'}, block.text);
  if (block.kind === 'code') return el('pre', {class: 'code', tabIndex: 0}, el('code', {}, block.text));
  if (block.kind === 'image') {
    return el('img', {class: 'course-image', src: new URL(`${folder}/${block.address}`, COURSE).href, alt: block.text, loading: 'lazy'});
  }
  if (block.kind === 'heading') return el('h2', {}, block.text);
  if (block.kind === 'list') return el('ul', {}, block.items.map((item) => el('li', {}, parts(item))));
  return el('p', {}, parts(block.text));
}

function parts(text) {
  return inline(text).map(({kind, text: shown, address}) => {
    if (kind === 'link') {
      return /^https?:/.test(address) ? el('a', {href: address, target: '_blank', rel: 'noopener noreferrer'}, shown) : shown;
    }
    return kind === 'text' ? shown : el({key: 'kbd'}[kind] || kind, {}, shown);
  });
}

// The text of a page is course/NN_name/README.md: there is no other copy of the course.

// Return the blocks of a page below its heading: {kind, ...}: text {text}, heading {text}, list {items}, commands {commands:
// [{terminal, text}]}, output or code {text}, image {text, address}.
export function parseStep(markdown) {
  return parseBlocks(markdown.split('\n').slice(1));
}

function parseBlocks(lines) {
  const blocks = [];
  let terminal = '';
  for (let i = 0; i < lines.length; i += 1) {
    const line = lines[i];
    const fence = /^```(\w*)/.exec(line);
    if (fence) {
      const inner = [];
      for (i += 1; i < lines.length && !lines[i].startsWith('```'); i += 1) inner.push(lines[i]);
      if (fence[1] === 'bash') {
        const commands = inner.filter((text) => text.trim()).map((text) => {
          const found = TERMINAL.exec(text);
          if (found) [, terminal] = found;
          return {terminal, text: text.replace(TERMINAL, '').trim()};
        });
        blocks.push({kind: 'commands', commands});
      } else {
        blocks.push({kind: fence[1] === 'text' ? 'output' : 'code', text: inner.join('\n')});
      }
    } else if (line.startsWith('## ')) {
      blocks.push({kind: 'heading', text: line.slice(3)});
    } else if (/^!\[/.test(line)) {
      const image = /^!\[([^\]]*)\]\(([^)]+)\)/.exec(line);
      if (image) blocks.push({kind: 'image', text: image[1], address: image[2]});
    } else if (/^(\* |\d+\. )/.test(line)) {
      let block = blocks[blocks.length - 1];
      if (!block || block.kind !== 'list' || lines[i - 1] === '') blocks.push(block = {kind: 'list', items: []});
      block.items.push(line.replace(/^(\* |\d+\. )/, ''));
    } else if (/^ +\S/.test(line) && blocks.length && blocks[blocks.length - 1].kind === 'list') {
      const {items} = blocks[blocks.length - 1];
      items[items.length - 1] += ` ${line.trim()}`;
    } else if (line.trim() && !line.startsWith('<!--')) {
      const block = blocks[blocks.length - 1];
      if (block && block.kind === 'text' && lines[i - 1] && lines[i - 1].trim()) block.text += ` ${line.trim()}`;
      else blocks.push({kind: 'text', text: line.trim()});
    }
  }
  return blocks;
}

// Return the parts of a line: {kind, text, address}, with kind text, code, strong, em, key or link.
function inline(text) {
  const pattern = /`([^`]+)`|\*\*([^*]+)\*\*|\*([^*]+)\*|<kbd>([^<]+)<\/kbd>|\[([^\]]+)\]\(([^)\s]+)\)/g;
  const parts = [];
  let end = 0;
  for (const found of text.matchAll(pattern)) {
    if (found.index > end) parts.push({kind: 'text', text: text.slice(end, found.index)});
    const [, code, strong, em, key, link, address] = found;
    const kind = code !== undefined ? 'code' : strong !== undefined ? 'strong' : em !== undefined ? 'em'
      : key !== undefined ? 'key' : 'link';
    parts.push({kind, text: code ?? strong ?? em ?? key ?? link, address});
    end = found.index + found[0].length;
  }
  if (end < text.length) parts.push({kind: 'text', text: text.slice(end)});
  return parts;
}
