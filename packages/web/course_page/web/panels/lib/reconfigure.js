// The messages of dynamic_reconfigure as lists for a form, and back.

const LISTS = {bool: 'bools', int: 'ints', str: 'strs', double: 'doubles'}; // types of parameters: fields of a Config

// Return Map {name: value} of a dynamic_reconfigure/Config.
export function valuesOf(config) {
  return new Map(Object.values(LISTS).flatMap((list) => config[list].map(({name, value}) => [name, value])));
}

// Return [{name, type, text, min, max, usual, choices}] of a dynamic_reconfigure/ConfigDescription, each name once.
export function parametersOf(description) {
  const [least, most, usual] = ['min', 'max', 'dflt'].map((key) => valuesOf(description[key]));
  const found = new Map();
  for (const {parameters} of description.groups) {
    for (const {name, type, description: text, edit_method: edit} of parameters) {
      if (!(type in LISTS)) continue;
      found.set(name, {name, type, text, min: least.get(name), max: most.get(name), usual: usual.get(name), choices: choicesOf(edit)});
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
