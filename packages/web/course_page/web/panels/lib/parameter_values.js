// Values of parameters, from and to typed text.
import {clean} from './values.js';

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

export function kindOf(value) {
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

export function shortValue(value) {
  return typeof value === 'string' ? clean(value, 120) : clean(JSON.stringify(value), 120);
}
