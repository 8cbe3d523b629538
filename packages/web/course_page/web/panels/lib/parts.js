// Parts of forms and files that panels use. Texts become text nodes: nothing from ROS is ever HTML.
import {el, fill, styleSheet} from '../../app/dom.js';

export {Panel, Scope} from '../../app/scope.js';

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
export function suggestions(limit = 300) {
  const list = el('datalist', {id: newId()});
  let shown = '';
  return [list, (texts) => {
    const few = texts.slice(0, limit);
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
