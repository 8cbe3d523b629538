// Parameters: list, set, delete, add.
import {commandLine, el, fill} from '../app/dom.js';
import {button, labelled, setText} from './lib/parts.js';
import {Row, RowsPanel} from './lib/rows.js';
import {clean} from './lib/values.js';

const LIST = 2; // s between two polls
const NAME = /^\/?[A-Za-z][\w/]*$/;
const SURE = 4000; // ms in which a second press confirms the deletion

export const help = [
  'All parameters of the master. Most nodes read theirs only once, when they start.',
  'In a terminal: rosparam list, rosparam get, rosparam set, rosparam delete.'];

export default class ParametersPanel extends RowsPanel {
  constructor(element, context) {
    super(context, 'parameters', 'name or value',
          ['No parameters', 'Nodes and launch files set them.', 'rosparam set /example 1.5']);
    this.command = el('div', {});
    this.build(element, {before: this.command, after: this._new()});
    this.load = this.scope.every(LIST, () => this._load(), (error) => this.notice.say(error.message, true));
  }

  async _load() {
    const found = new Map(flatten(await this.context.rosapi.parameter('/', {})).filter(([name]) => name !== '/'));
    if (this.scope.ended) return;
    for (const [name, row] of this.rows) if (!found.has(name)) this.remove(row);
    for (const [name, value] of found) {
      if (!this.rows.has(name)) this.rows.set(name, new ParameterRow(this, name));
      this.rows.get(name).update(value);
    }
    this.arrange();
  }

  async set(name, text) {
    const {value, error} = parseValue(text);
    if (error) throw new Error(error);
    await this.context.rosapi.setParameter(name, value);
    this.notice.say(`${name} is set to ${shortValue(value)}.`);
    const quoted = valueText(value).replace(/'/g, "'\\''");
    fill(this.command, commandLine(`rosparam set ${name} '${quoted}'`));
    this.load();
  }

  _new() {
    const name = labelled('Name', {placeholder: '/example'});
    const value = labelled('Value', {placeholder: '1.5'});
    const hint = el('p', {class: 'muted small'}, 'Numbers, true, false, [1, 2], {"a": 1}; all else is a text.');
    value.input.addEventListener('input', () => setText(hint, describe(value.input.value)));
    const add = async () => {
      const text = name.input.value.trim();
      try {
        if (!NAME.test(text)) {
          name.input.focus();
          throw new Error(`"${clean(text, 60)}" is not a name of a parameter. Use letters, digits, _ and /, as in /node/speed.`);
        }
        await this.set(text.startsWith('/') ? text : `/${text}`, value.input.value);
        name.input.value = value.input.value = '';
      } catch (error) {
        this.notice.say(error.message, true);
      }
    };
    return el('details', {class: 'card'}, el('summary', {}, 'Set a parameter that is not in the list'),
              el('form', {class: 'toolbar', on: {submit: (event) => {
                event.preventDefault();
                add();
              }}}, name.element, value.element, el('button', {type: 'submit'}, 'Set')), hint);
  }
}

function describe(text) {
  const {kind, error} = parseValue(text);
  return error || {text: 'This is a text.', int: 'This is a whole number.', double: 'This is a number.',
                   bool: 'This is true or false.', list: 'This is a list.', map: 'This is a map of names and values.'}[kind];
}

class ParameterRow extends Row {
  constructor(panel, name) {
    const [kind, value] = [el('span', {class: 'muted small'}), el('bdi', {class: 'value'})];
    super(panel, name, kind, value);
    this._json = '';
    this._editor = null;
    this._kind = kind;
    this._value = value;
  }

  update(value) {
    const json = JSON.stringify(value);
    if (json === this._json) return;
    this._json = json;
    const text = shortValue(value);
    this.searched = `${this.name} ${text}`;
    setText(this._value, text);
    setText(this._kind, kindOf(value));
    if (this._editor && this._editor.value === this._before) this._editor.value = this._before = valueText(value);
  }

  close() {
    this._editor = null;
    this.expand(false);
    fill(this.body);
  }

  open() {
    this.expand(true);
    const value = JSON.parse(this._json);
    this._before = valueText(value);
    this._editor = el('textarea', {rows: Math.min(12, Math.ceil(this._before.length / 60)), spellcheck: false,
                                   value: this._before, 'aria-label': `Value of ${this.name}`});
    const hint = el('p', {class: 'muted small'}, describe(this._before));
    this._editor.addEventListener('input', () => setText(hint, describe(this._editor.value)));
    let sure = false;
    const remove = button('Delete', async () => {
      if (!sure) {
        sure = true;
        remove.textContent = 'Press again to delete';
        setTimeout(() => {
          sure = false;
          remove.textContent = 'Delete';
        }, SURE);
        return;
      }
      await this._attempt(async () => {
        await this.panel.context.rosapi.deleteParameter(this.name);
        this.panel.notice.say(`${this.name} is deleted.`);
        fill(this.panel.command, commandLine(`rosparam delete ${this.name}`));
        this.panel.load();
      });
    });
    fill(this.body, this._editor, hint, el('div', {class: 'row'},
      button('Set', () => this._attempt(async () => {
        const text = this._editor.value;
        await this.panel.set(this.name, text);
        this._before = text;
      }), {class: 'primary'}), remove));
  }

  async _attempt(work) {
    try {
      await work();
    } catch (error) {
      this.panel.notice.say(error.message, true);
    }
  }
}

// Return {value, kind} of a text as rosparam reads it: numbers, true and false, lists, maps; anything else is a text.
export function parseValue(text) {
  const trimmed = text.trim();
  if (/^[[{"]/.test(trimmed)) {
    try {
      const value = JSON.parse(trimmed);
      return {value, kind: kindOf(value)};
    } catch {
      return {value: null, kind: '', error: 'This is not complete. Lists look like [1, 2], maps like {"a": 1}, texts '
                                            + 'like "abc".'};
    }
  }
  if (/^(true|false)$/i.test(trimmed)) return {value: trimmed.toLowerCase() === 'true', kind: 'bool'};
  if (/^[-+]?\d+$/.test(trimmed) && Number.isSafeInteger(Number(trimmed))) return {value: Number(trimmed), kind: 'int'};
  if (/^[-+]?(\d+\.\d*|\.\d+|\d+)(e[-+]?\d+)?$/i.test(trimmed) && Number.isFinite(Number(trimmed))) {
    return {value: Number(trimmed), kind: 'double'};
  }
  return {value: trimmed, kind: 'text'};
}

function kindOf(value) {
  if (Array.isArray(value)) return 'list';
  if (value !== null && typeof value === 'object') return 'map';
  if (typeof value === 'boolean') return 'bool';
  if (typeof value === 'number') return Number.isInteger(value) ? 'int' : 'double';
  return 'text';
}

// Return the text that `parseValue` reads as this value.
export function valueText(value) {
  if (typeof value !== 'string') return JSON.stringify(value);
  const read = parseValue(value);
  return read.kind === 'text' && read.value === value ? value : JSON.stringify(value);
}

// Return [[name, value]] of all parameters in a tree, sorted; empty maps are kept.
export function flatten(tree, prefix = '') {
  if (tree === null || typeof tree !== 'object' || Array.isArray(tree)) return [[prefix || '/', tree]];
  const found = Object.entries(tree).flatMap(([name, value]) => (
    value !== null && typeof value === 'object' && !Array.isArray(value) && Object.keys(value).length
      ? flatten(value, `${prefix}/${name}`) : [[`${prefix}/${name}`, value]]));
  return prefix ? found : found.sort(([a], [b]) => (a < b ? -1 : 1));
}

function shortValue(value) {
  return typeof value === 'string' ? clean(value, 120) : clean(JSON.stringify(value), 120);
}
