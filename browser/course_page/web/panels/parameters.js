// Parameters: list, set, delete, add.
import {commandLine, el, emptyState, fill, styleSheet} from '../app/dom.js';
import {button, labelled, Notice, Scope, setText} from './lib/parts.js';
import {NamespaceList} from './lib/namespaces.js';
import {flatten, kindOf, parseValue, shortValue, valueText} from './lib/parameter_values.js';
import {clean} from './lib/values.js';

styleSheet('panels/panels.css');

const LIST = 2; // s between two polls
const NAME = /^\/?[A-Za-z][\w/]*$/;
const SURE = 4000; // ms in which a second press confirms the deletion

export default {
  id: 'parameters',
  title: 'Parameters',
  help: ['All parameters of the master. Most nodes read theirs only once, when they start.',
         'In a terminal: rosparam list, rosparam get, rosparam set, rosparam delete.'],
  mount(element, context) {
    const panel = new ParametersPanel(element, context);
    return () => panel.scope.end();
  },
};

class ParametersPanel {
  constructor(element, context) {
    this.context = context;
    this.scope = new Scope(context.ros);
    this._rows = new Map();
    this._filter = labelled('Filter', {type: 'search', value: context.parameters.filter || '',
                                       placeholder: 'a part of a name or value', on: {input: () => this._arrange()}});
    this._count = el('p', {class: 'muted small', role: 'status'});
    this.notice = new Notice();
    this.command = el('div', {});
    this._empty = el('div', {});
    this._list = new NamespaceList('parameters');
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, this._count), this.notice.element, this.command,
         this._empty, this._list.element, this._new());
    this.load = this.scope.every(LIST, () => this._load(), (error) => this.notice.say(error.message, true));
  }

  async _load() {
    const found = new Map(flatten(await this.context.rosapi.parameter('/', {})).filter(([name]) => name !== '/'));
    if (this.scope.ended) return;
    for (const [name, row] of this._rows) {
      if (!found.has(name)) {
        row.element.remove();
        this._rows.delete(name);
      }
    }
    for (const [name, value] of found) {
      if (!this._rows.has(name)) this._rows.set(name, new ParameterRow(this, name));
      this._rows.get(name).update(value);
    }
    this._arrange();
  }

  _arrange() {
    const words = this._filter.input.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const [name, row] of this._rows) {
      const hit = words.every((word) => `${name} ${row.text}`.toLowerCase().includes(word));
      row.element.hidden = !hit;
      shown += hit;
    }
    this._list.arrange(this._rows.values(), words.length > 0);
    setText(this._count, words.length ? `${shown} of ${this._rows.size} parameters` : `${this._rows.size} parameters`);
    if (!this._rows.size) {
      fill(this._empty, emptyState('No parameters', 'Nodes and launch files set them.', 'rosparam set /example 1.5'));
    } else {
      fill(this._empty, shown ? [] : el('p', {class: 'muted'}, 'No name or value contains this. Clear the filter to see all.'));
    }
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

class ParameterRow {
  constructor(panel, name) {
    this.name = name;
    this.text = '';
    this._panel = panel;
    this._json = '';
    this._editor = null;
    this._value = el('bdi', {class: 'value'});
    this._kind = el('span', {class: 'muted small'});
    this._body = el('div', {class: 'row-body stack', hidden: true});
    this._button = el('button', {type: 'button', class: 'row-head', 'aria-expanded': 'false',
                                 on: {click: () => (this._editor ? this._close() : this._open())}},
                      el('bdi', {class: 'row-name'}, clean(name, 300)), this._kind, this._value);
    this.element = el('li', {}, this._button, this._body);
  }

  update(value) {
    const json = JSON.stringify(value);
    if (json === this._json) return;
    this._json = json;
    this.text = shortValue(value);
    setText(this._value, this.text);
    setText(this._kind, kindOf(value));
    if (this._editor && this._editor.value === this._before) this._editor.value = this._before = valueText(value);
  }

  _close() {
    this._editor = null;
    this._body.hidden = true;
    this._button.setAttribute('aria-expanded', 'false');
    fill(this._body);
  }

  _open() {
    this._button.setAttribute('aria-expanded', 'true');
    this._body.hidden = false;
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
        await this._panel.context.rosapi.deleteParameter(this.name);
        this._panel.notice.say(`${this.name} is deleted.`);
        fill(this._panel.command, commandLine(`rosparam delete ${this.name}`));
        this._panel.load();
      });
    });
    fill(this._body, this._editor, hint, el('div', {class: 'row'},
      button('Set', () => this._attempt(async () => {
        const text = this._editor.value;
        await this._panel.set(this.name, text);
        this._before = text;
      }), {class: 'primary'}), remove));
  }

  async _attempt(work) {
    try {
      await work();
    } catch (error) {
      this._panel.notice.say(error.message, true);
    }
  }
}
