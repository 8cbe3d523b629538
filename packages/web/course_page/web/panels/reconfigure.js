// Reconfigure: the parameters of dynamic_reconfigure, which nodes read while they run.
import {commandLine, el, emptyState, fill} from '../app/dom.js';
import {choice, Notice, Panel, setText} from './lib/parts.js';
import {clean} from './lib/values.js';

const LIST = 2; // s between two polls
const TYPE = 'dynamic_reconfigure/ConfigDescription';
const SUFFIX = '/parameter_descriptions';
const LISTS = {bool: 'bools', int: 'ints', str: 'strs', double: 'doubles'}; // types of parameters: fields of a Config

export const help = [
  'Parameters that can be changed while a node runs, with dynamic_reconfigure: move_base has some. A change is sent '
    + 'when you leave the field or press Enter; the node answers with its new values.',
  'In a terminal: rosrun dynamic_reconfigure dynparam list, dynparam get, dynparam set.'];

export default class ReconfigurePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._ends = [];
    this._listed = null;
    this._choice = choice('Node', [], () => this._choose(this._choice.input.value));
    this.notice = new Notice();
    this.command = el('div', {});
    this._body = el('div', {});
    fill(element, el('div', {class: 'toolbar'}, this._choice.element), this.notice.element, this.command, this._body);
    this.scope.every(LIST, () => this._list(), (error) => this.notice.say(error.message, true));
  }

  async _list() {
    const nodes = (await this.context.rosapi.topicsOfType(TYPE)).filter((name) => name.endsWith(SUFFIX))
      .map((name) => name.slice(0, -SUFFIX.length)).sort();
    if (this.scope.ended || this._listed === nodes.join('\n')) return;
    this._listed = nodes.join('\n');
    this._choice.element.hidden = !nodes.length;
    fill(this._choice.input, nodes.map((name) => el('option', {value: name}, clean(name, 200))));
    if (!nodes.length) {
      this._stop();
      fill(this._body, emptyState('No node can be reconfigured', 'Nodes with dynamic_reconfigure appear here when they start.',
                                  'rosrun dynamic_reconfigure dynparam list'));
      return;
    }
    const requested = this.context.parameters.node;
    this._choice.input.value = nodes.includes(requested) ? requested : nodes[0];
    this._choose(this._choice.input.value);
  }

  _stop() {
    for (const end of this._ends.splice(0)) end();
  }

  _choose(node) {
    this._stop();
    this.context.setParameters({node});
    this._node = node;
    this._rows = new Map();
    this._values = new Map();
    fill(this._body, el('p', {class: 'muted'}, 'Waiting for the description of its parameters.'));
    const {ros} = this.context;
    this._ends.push(this.scope.add(ros.subscribe(node + SUFFIX, TYPE, (message) => this._describe(message))));
    this._ends.push(this.scope.add(ros.subscribe(`${node}/parameter_updates`, 'dynamic_reconfigure/Config',
                                                 (message) => this._update(message))));
  }

  _describe(message) {
    this._rows = new Map(parametersOf(message).map((parameter) => [parameter.name, new Row(this, parameter)]));
    fill(this._body, el('div', {class: 'reconfigure'}, [...this._rows.values()].map(({element}) => element)));
    for (const [name, value] of this._values) this._rows.get(name)?.show(value);
  }

  _update(message) {
    this._values = valuesOf(message);
    for (const [name, value] of this._values) this._rows.get(name)?.show(value);
  }

  async set(parameter, text) {
    try {
      const value = parseFor(parameter, text);
      fill(this.command, commandLine(`rosrun dynamic_reconfigure dynparam set ${this._node} ${parameter.name} ${JSON.stringify(value)}`));
      const {config} = await this.context.ros.call(`${this._node}/set_parameters`, {config: changeOf(parameter, value)});
      this._update(config);
      this.notice.say('');
    } catch (error) {
      this.notice.say(error.message, true);
    }
  }
}

class Row {
  constructor(panel, parameter) {
    this._parameter = parameter;
    const {name, type, text, min, max, usual, choices} = parameter;
    const label = {'aria-label': name};
    const change = () => panel.set(parameter, type === 'bool' && !choices.length ? String(this._input.checked) : this._input.value);
    if (choices.length) {
      this._input = el('select', {...label, on: {change}}, choices.map(([value, title]) => el('option', {value}, title)));
    } else if (type === 'bool') {
      this._input = el('input', {...label, type: 'checkbox', on: {change}});
    } else {
      this._input = el('input', {...label, autocomplete: 'off', spellcheck: false, inputmode: type === 'str' ? 'text' : 'decimal', on: {change}});
    }
    const range = type === 'int' || type === 'double' ? `${short(min, '-∞')} to ${short(max, '∞')}; ` : '';
    this._hint = el('small', {class: 'muted'});
    setText(this._hint, `${clean(text, 300)} (${range}usually ${usual === '' ? 'empty' : usual})`);
    this.element = el('div', {}, el('strong', {}, clean(name, 100)), this._input, this._hint);
  }

  show(value) {
    if (document.activeElement === this._input && this._input.type !== 'checkbox') return;
    if (this._input.type === 'checkbox') this._input.checked = value;
    else this._input.value = value;
  }
}

function short(value, unlimited) {
  return value === null || Math.abs(value) >= 1e9 ? unlimited : String(value);
}

// Return Map {name: value} of a dynamic_reconfigure/Config.
function valuesOf(config) {
  return new Map(Object.values(LISTS).flatMap((list) => config[list].map(({name, value}) => [name, value])));
}

// Return [{name, type, text, min, max, usual, choices}] of a dynamic_reconfigure/ConfigDescription, each name once.
export function parametersOf(description) {
  const [min, max, usual] = ['min', 'max', 'dflt'].map((key) => valuesOf(description[key]));
  const found = new Map();
  for (const {parameters} of description.groups) {
    for (const {name, type, description: text, edit_method: edit} of parameters) {
      if (!(type in LISTS)) continue;
      found.set(name, {name, type, text, min: min.get(name), max: max.get(name), usual: usual.get(name), choices: choicesOf(edit)});
    }
  }
  return [...found.values()];
}

// Return the Config that changes one parameter.
export function changeOf({name, type}, value) {
  const config = {bools: [], ints: [], strs: [], doubles: [], groups: []};
  config[LISTS[type]].push({name, value});
  return config;
}

// Return what a user has typed as a value of a parameter; throw an Error with what is allowed. Infinity comes as null.
export function parseFor({name, type, min, max}, text) {
  if (type === 'str') return text;
  if (type === 'bool') return text === 'true';
  const value = Number(text);
  if (!text.trim() || !Number.isFinite(value) || (type === 'int' && !Number.isInteger(value))) {
    throw new Error(`${name} is "${text}"; it must be a ${type === 'int' ? 'whole ' : ''}number.`);
  }
  if (value < (min ?? -Infinity) || value > (max ?? Infinity)) {
    throw new Error(`${name} is ${text}; it must be from ${min ?? '-∞'} to ${max ?? '∞'}.`);
  }
  return value;
}

// Return [[value, name]] of an enumeration, which is Python's text of a dictionary; [] if there is none.
function choicesOf(edit) {
  if (!/^\{.*'enum': \[/s.test(edit)) return [];
  return [...edit.matchAll(/\{[^{}]*\}/g)].map(([entry]) => [read(entry, 'value'), read(entry, 'name')])
    .filter(([value, name]) => value !== null && name !== null);
}

function read(entry, key) {
  const found = entry.match(new RegExp(`'${key}': (?:'([^']*)'|"([^"]*)"|([^,}]+))`));
  return found ? found[1] ?? found[2] ?? found[3].trim() : null;
}
