// Values of messages as text, and the size of a message.

const MAX_LENGTH = 200; // characters of a text
const ELEMENTS = 8; // of an array, in one line
const INVISIBLE = /[\u0000-\u001f\u007f-\u009f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]/g;
const SIZES = {bool: 1, byte: 1, char: 1, int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4,
               int64: 8, uint64: 8, float64: 8, time: 8, duration: 8};
const LENGTH = 4; // bytes before a text or an array
export const FLOATS = new Set(['float32', 'float64']);
const BYTES = new Set(['uint8', 'char']);

// Return a text in one line: invisible characters are written out, and it is cut off at `longest` characters.
// With `lines`, it keeps its line feeds.
export function clean(text, longest = MAX_LENGTH, lines = false) {
  const cut = String(text).slice(0, longest);
  const shown = cut.replace(INVISIBLE, (character) => (lines && character === '\n' ? '\n' :
    {'\n': '\\n', '\t': '\\t', '\r': '\\r'}[character]
    || `\\u${character.charCodeAt(0).toString(16).padStart(4, '0')}`));
  return text.length > longest ? `${shown}…` : shown;
}

// Return the text of a number with at most 7 digits, which is what float32 has.
export function numberText(value) {
  if (typeof value === 'bigint') return String(value);
  if (Number.isNaN(value)) return 'NaN';
  if (!Number.isFinite(value)) return value > 0 ? 'Infinity' : '-Infinity';
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(7)));
}

// Return the number that a float is; JSON has neither NaN nor infinity: the bridge sends null, or a text.
export function toNumber(value) {
  if (typeof value === 'boolean') return value ? 1 : 0;
  if (value === null || value === undefined) return NaN;
  if (typeof value === 'object' && 'secs' in value) return value.secs + value.nsecs * 1e-9;
  return Number(value);
}

export function isArray(value) {
  return Array.isArray(value) || ArrayBuffer.isView(value);
}

// Return the elements of an array field; bytes come as base64 in JSON.
export function elements(value, type) {
  if (isArray(value)) return value;
  if (typeof value === 'string' && BYTES.has(type)) return fromBase64(value);
  return [];
}

function fromBase64(text) {
  try {
    const binary = atob(text);
    const bytes = new Uint8Array(binary.length);
    for (let i = 0; i < binary.length; i += 1) bytes[i] = binary.charCodeAt(i);
    return bytes;
  } catch {
    return new Uint8Array(0);
  }
}

// Return how many elements an array field has, without decoding it.
function lengthOf(value) {
  if (typeof value === 'string') return Math.floor(value.length * 3 / 4) - (value.match(/=*$/)[0].length);
  return isArray(value) ? value.length : 0;
}

// Return a value in one short line; `type` is that of an element, or '' if it is unknown.
export function short(value, type = '', array = false) {
  if (array) return shortArray(value, type);
  if (FLOATS.has(type)) return value === null ? 'NaN or infinite' : numberText(toNumber(value));
  if (value === null || value === undefined) return 'null';
  if (typeof value === 'number' || typeof value === 'bigint') return numberText(value);
  if (typeof value === 'boolean') return value ? 'True' : 'False';
  if (typeof value === 'string') return `"${clean(value)}"`;
  if (isArray(value)) return shortArray(value, type);
  if ('secs' in value && 'nsecs' in value) return `${value.secs}.${String(value.nsecs).padStart(9, '0')} s`;
  const parts = Object.entries(value).slice(0, 6).map(([name, part]) => (
    `${clean(name, 30)}: ${isArray(part) ? `[${part.length}]`
      : part !== null && typeof part === 'object' && !('secs' in part) ? '…' : short(part)}`));
  return parts.join(', ');
}

function shortArray(value, type) {
  const count = lengthOf(value);
  if (typeof value === 'string') return `${count} bytes`;
  if (count === 0) return 'empty';
  const plain = value[0] === null || typeof value[0] !== 'object';
  if (!plain) return `${count} ${count === 1 ? 'element' : 'elements'}`;
  const first = Array.from(value.slice(0, ELEMENTS), (element) => short(element, type)).join(', ');
  return count > ELEMENTS ? `[${first}, …] ${count} elements` : `[${first}]`;
}

// Return the number of bytes that ROS sends for a value.
export function sizeOf(value, type, array, types) {
  if (array !== null && array !== undefined) {
    const count = lengthOf(value);
    const head = array === 0 ? LENGTH : 0;
    if (type in SIZES) return head + count * SIZES[type];
    let size = head;
    for (const element of elements(value, type)) size += sizeOf(element, type, null, types);
    return size;
  }
  if (type in SIZES) return SIZES[type];
  if (type === 'string') return LENGTH + utf8Length(String(value));
  let size = 0;
  for (const field of types.fieldsOf(type)) {
    size += value ? sizeOf(value[field.name], field.type, field.array, types) : 0;
  }
  return size;
}

function utf8Length(text) {
  let size = text.length;
  for (let i = 0; i < text.length; i += 1) {
    const code = text.charCodeAt(i);
    if (code > 0x7f) size += code > 0x7ff && (code < 0xd800 || code > 0xdfff) ? 2 : 1;
  }
  return size;
}

// Return a number of bytes, or of bytes a second, as text.
export function bytesText(bytes) {
  if (bytes < 1000) return `${Math.round(bytes)} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(bytes < 1e4 ? 1 : 0)} kB`;
  return `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;
}

// Return the value at a path such as ['pose', 'position', 'x'] or ['ranges', 3], or undefined.
export function at(message, path) {
  let value = message;
  for (const part of path) {
    if (value === null || typeof value !== 'object') {
      if (typeof value !== 'string' || typeof part !== 'number') return undefined;
      value = fromBase64(value);
    }
    if (!Object.prototype.hasOwnProperty.call(value, part)) return undefined;
    value = value[part];
  }
  return value;
}

// Return the path in a text such as 'pose/position/x' or 'ranges[3]', or null if it is invalid.
export function parsePath(text) {
  const path = [];
  for (const part of text.split('/').filter(Boolean)) {
    const found = /^([A-Za-z_]\w*)((?:\[\d+\])*)$/.exec(part);
    if (!found) return null;
    path.push(found[1], ...(found[2].match(/\d+/g) || []).map(Number));
  }
  return path;
}

// Return a short name without the number that rospy gives anonymous nodes; of a long name the end is kept, which tells
// more than its start.
export function shortName(full, limit = 34) {
  const name = full.replace(/_\d+_\d{10,}$/, '');
  return name.length > limit ? `…${name.slice(1 - limit)}` : name;
}
