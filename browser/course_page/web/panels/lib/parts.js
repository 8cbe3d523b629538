// Parts of forms, timers and files that all panels use. Texts become text nodes: nothing from ROS is ever HTML.
import {el, fill, styleSheet} from '../../app/dom.js';

styleSheet('panels/panels.css');

let numbers = 0;

// Return an id that no other element has.
export function newId() {
  numbers += 1;
  return `part-${numbers}`;
}

// Set the text of an element only if it differs: screen readers and layout notice each change.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function button(label, click, properties = {}) {
  return el('button', {type: 'button', ...properties, on: {click}}, label);
}

const PLAIN = {autocomplete: 'off', spellcheck: false, autocapitalize: 'off'};

// Return {element, input}: an input with its label.
export function labelled(label, properties = {}) {
  const check = properties.type === 'checkbox';
  const input = el('input', {...(check ? {} : PLAIN), ...properties});
  return {element: el('label', {class: check ? 'check' : 'field'}, check ? [input, label] : [label, input]), input};
}

// Return {element, input}: a select with its label; `choices` are [value, text].
export function choice(label, choices, change = () => {}) {
  const input = el('select', {on: {change}}, choices.map(([value, text]) => el('option', {value}, text)));
  return {element: el('label', {class: 'field'}, label, input), input};
}

// Return a list of suggestions for inputs whose `list` is its id, and a function that sets them.
export function suggestions(most = 300) {
  const list = el('datalist', {id: newId()});
  let shown = '';
  return [list, (texts) => {
    const few = texts.slice(0, most);
    if (few.join('\n') === shown) return;
    shown = few.join('\n');
    fill(list, few.map((text) => el('option', {value: text})));
  }];
}

// Return a value as an argument of rosservice call and rostopic pub, quoted for a shell.
export function asArgument(value) {
  return `'${yaml(value).replace(/'/g, "'\\''")}'`;
}

function yaml(value) {
  if (Array.isArray(value)) return `[${value.map(yaml).join(', ')}]`;
  if (value !== null && typeof value === 'object') {
    return `{${Object.entries(value).map(([name, part]) => `${name}: ${yaml(part)}`).join(', ')}}`;
  }
  return {NaN: '.nan', Infinity: '.inf', '-Infinity': '-.inf'}[value] || JSON.stringify(value);
}

// The subscriptions, timers and listeners that a panel must end.
export class Scope {
  constructor(ros) {
    this.ros = ros;
    this.ended = false;
    this._ends = new Set();
  }

  // Call a function at the end; return one that calls it earlier.
  add(end) {
    const once = () => {
      if (this._ends.delete(once)) end();
    };
    this._ends.add(once);
    if (this.ended) once();
    return once;
  }

  listen(target, name, listener, options) {
    target.addEventListener(name, listener, options);
    return this.add(() => target.removeEventListener(name, listener, options));
  }

  // Call `work` now and again `seconds` after it has ended, while the page is visible and ROS is connected; `work` may
  // be async, `failed` gets its error. Return a function that asks for a call at once.
  every(seconds, work, failed = console.error) {
    let timer = null;
    let running = false;
    let again = false;
    const run = async () => {
      clearTimeout(timer);
      again = running;
      if (running || this.ended) return;
      running = true;
      try {
        if (!document.hidden && this.ros.connected) await work();
      } catch (error) {
        if (!this.ended) failed(error);
      }
      running = false;
      if (!this.ended) timer = setTimeout(run, again ? 0 : seconds * 1000);
    };
    this.add(() => clearTimeout(timer));
    this.listen(document, 'visibilitychange', () => document.hidden || run());
    this.add(this.ros.onState(() => this.ros.connected && run()));
    run();
    return run;
  }

  end() {
    this.ended = true;
    for (const end of [...this._ends]) end();
  }
}

// A panel whose subscriptions, timers and listeners are in its scope.
export class Panel {
  constructor(context) {
    this.context = context;
    this.scope = new Scope(context.ros);
  }

  close() {
    this.scope.end();
  }
}

// Let the browser save a text or a Blob as a file.
export function save(name, content, type = 'text/plain') {
  const link = el('a', {href: URL.createObjectURL(content instanceof Blob ? content : new Blob([content], {type})),
                        download: name});
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A status line; only errors interrupt a screen reader.
export class Notice {
  constructor() {
    this.element = el('p', {class: 'notice', role: 'status', hidden: true});
  }

  say(text, bad = false) {
    this.element.hidden = !text;
    this.element.classList.toggle('bad', bad);
    setText(this.element, text);
  }
}

const loaded = new Map();

// Load a script that is not a module, once.
export function loadScript(url) {
  if (!loaded.has(url)) {
    loaded.set(url, new Promise((resolve, reject) => {
      const script = el('script', {src: url, on: {load: resolve, error: () => {
        loaded.delete(url);
        reject(new Error(`${url} cannot be loaded`));
      }}});
      document.head.append(script);
    }));
  }
  return loaded.get(url);
}
