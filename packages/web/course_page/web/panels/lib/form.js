// A form made of the fields of a message type: nested types, arrays, times, defaults, errors at their field.
import {el} from '../../app/dom.js';
import {button, newId} from './parts.js';
import {clean, FLOATS} from './values.js';

const RANGES = {int8: [-128n, 127n], uint8: [0n, 255n], byte: [-128n, 127n], char: [0n, 255n],
                int16: [-32768n, 32767n], uint16: [0n, 65535n],
                int32: [-2147483648n, 2147483647n], uint32: [0n, 4294967295n],
                int64: [-9223372036854775808n, 9223372036854775807n], uint64: [0n, 18446744073709551615n]};
const SPECIAL = {nan: 'NaN', inf: 'Infinity', infinity: 'Infinity', '-inf': '-Infinity', '-infinity': '-Infinity'};
const MAX_ITEMS = 100; // of an array of messages
const MAX_DEPTH = 12; // of types in types

export class Invalid extends Error {}

// Return the value of a text for a primitive type; throw Invalid. NaN and infinity stay texts, for JSON.
export function parse(text, type) {
  const trimmed = text.trim();
  if (type === 'string') return text;
  if (type === 'bool') {
    const values = {true: true, 1: true, false: false, 0: false};
    if (trimmed.toLowerCase() in values) return values[trimmed.toLowerCase()];
    throw new Invalid(`"${clean(text, 40)}" is neither true nor false.`);
  }
  if (FLOATS.has(type)) {
    if (trimmed.toLowerCase() in SPECIAL) return SPECIAL[trimmed.toLowerCase()];
    if (trimmed === '' || !/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(trimmed)) {
      throw new Invalid(trimmed.includes(',')
        ? `"${clean(text, 40)}" is not a number. Use a point, not a comma: 0.5`
        : `"${clean(text, 40)}" is not a number. Examples: 0.5, -2, 1e-3, inf, nan`);
    }
    if (!Number.isFinite(Number(trimmed))) throw new Invalid(`${clean(trimmed, 40)} is too large for a ${type}.`);
    return Number(trimmed);
  }
  if (!/^[-+]?\d{1,25}$/.test(trimmed)) {
    throw new Invalid(`"${clean(text, 40)}" is not a whole number. Example: 3`);
  }
  const value = BigInt(trimmed.replace('+', ''));
  const [low, high] = RANGES[type];
  if (value < low || value > high) throw new Invalid(`${value} is not allowed: a ${type} is from ${low} to ${high}.`);
  if (value > BigInt(Number.MAX_SAFE_INTEGER) || value < -BigInt(Number.MAX_SAFE_INTEGER)) {
    throw new Invalid(`${value} is larger than a browser can send; at most ${Number.MAX_SAFE_INTEGER}.`);
  }
  return Number(value);
}

// Return the values of an array written as 1, 2, 3 or [1, 2, 3] or ["a", "b"]; throw Invalid.
export function parseArray(text, type, length) {
  const trimmed = text.trim();
  let parts;
  if (type === 'string' && trimmed.startsWith('[')) {
    try {
      parts = JSON.parse(trimmed).map(String);
    } catch {
      throw new Invalid('This is not a list of texts. Example: ["first", "second"]');
    }
  } else {
    const inner = trimmed.replace(/^\[/, '').replace(/\]$/, '').trim();
    parts = inner === '' ? [] : inner.split(/\s*[,;]\s*|\s+/);
  }
  if (length && parts.length !== length) throw new Invalid(`${parts.length} values; this array has exactly ${length}.`);
  return parts.map((part, i) => {
    try {
      return parse(part, type);
    } catch (error) {
      throw new Invalid(`Value ${i + 1}: ${error.message}`);
    }
  });
}

const zero = (type) => (type === 'string' ? '' : type === 'bool' ? 'false' : FLOATS.has(type) ? '0.0' : '0');

// A form of all fields of `types`; `now` returns the ROS time for stamps.
export class Form {
  constructor(types, now = () => Date.now() / 1000) {
    this._types = types;
    this._now = now;
    const fields = types.fieldsOf();
    this._root = this._message(types.root, 0);
    this.element = el('div', {class: 'form'}, fields.length ? this._root.elements
      : el('p', {class: 'muted'}, 'It takes no values.'));
  }

  // Return the message; throw Invalid with the first error, whose field gets the focus.
  read(focus = true) {
    const wrong = [];
    const value = this._root.read(wrong);
    if (wrong.length) {
      if (focus) wrong[0].input.focus();
      throw new Invalid(wrong.length === 1 ? wrong[0].text : `${wrong.length} fields are wrong. ${wrong[0].text}`);
    }
    return value;
  }

  // Show the values of a message; missing fields keep their values.
  write(message) {
    this._root.write(message);
  }

  _message(type, depth) {
    const parts = this._types.fieldsOf(type).map((field) => [field.name, this._field(field, type, depth)]);
    return {
      elements: parts.map(([, part]) => part.element),
      read: (wrong) => Object.fromEntries(parts.map(([name, part]) => [name, part.read(wrong)])),
      write: (message) => parts.forEach(([name, part]) => {
        if (message && message[name] !== undefined && message[name] !== null) part.write(message[name]);
      }),
    };
  }

  _field(field, parent, depth) {
    const {name, type, array} = field;
    if (depth > MAX_DEPTH) return this._constant(name, array === null ? {} : []);
    if (array !== null) {
      return this._types.isPrimitive(type) && type !== 'time' && type !== 'duration'
        ? this._line(name, `${type}[${array || ''}]`, array ? Array(array).fill(zero(type)).join(', ') : '',
                     (text) => parseArray(text, type, array),
                     (value) => (Array.from(value).map((element) => (type === 'string' ? JSON.stringify(element) : element))).join(', '),
                     array ? `${array} values, with commas between them` : 'Values with commas between them; may be empty')
        : this._list(field, depth);
    }
    if (type === 'bool') return this._checkbox(name);
    if (type === 'time') return this._time(name);
    if (type === 'duration') {
      return this._line(name, 'duration [s]', '0.0', (text) => seconds(parse(text, 'float64')),
                        (value) => String(value.secs + value.nsecs * 1e-9));
    }
    if (this._types.isPrimitive(type)) {
      return this._line(name, type, zero(type), (text) => parse(text, type), String,
                        type === 'string' ? '' : this._constants(parent, type));
    }
    const inner = this._message(type, depth + 1);
    const body = inner.elements.length ? inner.elements : el('p', {class: 'muted'}, 'No fields.');
    return {...inner, element: el('fieldset', {}, el('legend', {}, name, ' ', el('small', {}, type)), body)};
  }

  _constants(parent, type) {
    if (FLOATS.has(type)) return '';
    const constants = this._types.constantsOf(parent).filter(([, value]) => /^-?\d+$/.test(value));
    return constants.slice(0, 12).map(([name, value]) => `${value} ${name}`).join(', ');
  }

  _constant(name, value) {
    return {element: el('p', {class: 'muted'}, `${name}: nested too deeply for a form; it stays empty`),
            read: () => value, write: () => {}};
  }

  _line(name, type, start, read, text, help = '') {
    const id = newId();
    const input = el('input', {id, value: start, autocomplete: 'off', spellcheck: false, autocapitalize: 'off',
                              'aria-describedby': `${id}-help ${id}-error`});
    const error = el('p', {id: `${id}-error`, class: 'error small', hidden: true});
    const show = (message) => {
      error.hidden = !message;
      error.textContent = message;
      if (message) input.setAttribute('aria-invalid', 'true');
      else input.removeAttribute('aria-invalid');
    };
    const check = () => {
      try {
        const value = read(input.value);
        show('');
        return value;
      } catch (wrong) {
        if (!(wrong instanceof Invalid)) throw wrong;
        show(wrong.message);
        return wrong;
      }
    };
    // Not at `change`, which comes when a button is pressed: an error that appears or disappears would move the button.
    input.addEventListener('input', () => input.hasAttribute('aria-invalid') && check());
    return {
      element: el('div', {}, el('label', {class: 'field'}, el('span', {}, el('strong', {}, name), ` ${type}`), input),
                  el('p', {id: `${id}-help`, class: 'muted small', hidden: !help}, help), error),
      read: (wrong) => {
        const value = check();
        if (value instanceof Invalid) wrong.push({input, text: `${name}: ${value.message}`});
        return value;
      },
      write: (value) => {
        input.value = text(value);
        show('');
      },
    };
  }

  _checkbox(name) {
    const input = el('input', {type: 'checkbox'});
    return {element: el('div', {}, el('label', {class: 'check'}, input, name, el('small', {class: 'muted'}, 'bool'))),
            read: () => input.checked, write: (value) => {
              input.checked = Boolean(value);
            }};
  }

  _time(name) {
    const line = this._line(name, 'time [s]', '0.0', (text) => seconds(parse(text, 'float64')),
                            (value) => `${value.secs}.${String(value.nsecs).padStart(9, '0')}`);
    const now = el('input', {type: 'checkbox', on: {change: () => {
      line.element.querySelector('input').disabled = now.checked;
    }}});
    return {element: el('div', {class: 'time'}, line.element,
                        el('label', {class: 'check'}, now, `${name}: the time of sending`)),
            read: (wrong) => (now.checked ? seconds(this._now()) : line.read(wrong)),
            write: line.write};
  }

  // An array of messages or times, whose elements come and go.
  _list({name, type, array}, depth) {
    const items = [];
    const body = el('div', {});
    const count = el('small', {'aria-live': 'polite'});
    const add = button(`Add to ${name}`, () => insert().focus(), {class: 'small', hidden: array > 0});
    const say = () => {
      count.textContent = `${type}[${array || ''}], ${items.length} ${items.length === 1 ? 'element' : 'elements'}`;
      add.disabled = items.length >= MAX_ITEMS;
      items.forEach(({remove}, i) => {
        remove.hidden = array > 0 || i < items.length - 1;
      });
    };
    const pop = () => {
      items.pop().box.remove();
      say();
    };
    const insert = () => {
      const item = this._field({name: `${name}[${items.length}]`, type, array: null}, type, depth + 1);
      const remove = button('Remove the last', () => {
        pop();
        add.focus();
      }, {class: 'small'});
      const box = el('div', {class: 'item'}, item.element, remove);
      items.push({item, box, remove});
      body.append(box);
      say();
      return box.querySelector('input, button') || remove;
    };
    for (let i = 0; i < Math.min(array, MAX_ITEMS); i += 1) insert();
    say();
    return {
      element: el('fieldset', {}, el('legend', {}, name, ' ', count), body, add),
      read: (wrong) => items.map(({item}) => item.read(wrong)),
      write: (values) => {
        while (!array && items.length > values.length) pop();
        while (!array && items.length < Math.min(values.length, MAX_ITEMS)) insert();
        items.forEach(({item}, i) => i < values.length && item.write(values[i]));
      },
    };
  }
}

function seconds(value) {
  if (typeof value !== 'number' || !Number.isFinite(value)) throw new Invalid('A time must be a finite number.');
  let secs = Math.floor(value);
  let nsecs = Math.round((value - secs) * 1e9);
  if (nsecs === 1e9) {
    secs += 1;
    nsecs = 0;
  }
  return {secs, nsecs};
}
