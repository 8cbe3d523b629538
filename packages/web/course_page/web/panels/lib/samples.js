// The last minute of some fields of one topic.
import {at, parsePath, toNumber} from './values.js';

const MAX_AGE = 60; // s
const MAX_SAMPLES = 15000; // 60 s at 250 Hz
const SLACK = 1.05; // surplus before old samples are dropped together, because dropping moves all others

export class Samples {
  constructor() {
    this.times = []; // s
    this._columns = new Map(); // path: {parts, values}
  }

  get paths() {
    return [...this._columns.keys()];
  }

  add(path) {
    if (!this._columns.has(path)) {
      this._columns.set(path, {parts: parsePath(path), values: Array(this.times.length).fill(null)});
    }
  }

  remove(path) {
    this._columns.delete(path);
  }

  // Return the values of a path; null stands for NaN, infinity and missing values.
  values(path) {
    return this._columns.get(path).values;
  }

  // Add a message that came at a time [s].
  take(message, time) {
    this.times.push(time);
    for (const {parts, values} of this._columns.values()) {
      const value = toNumber(at(message, parts));
      values.push(Number.isFinite(value) ? value : null);
    }
    if (this.times.length > MAX_SAMPLES * SLACK || time - this.times[0] > MAX_AGE * SLACK) this._forget(time);
  }

  _forget(time) {
    let first = Math.max(0, this.times.length - MAX_SAMPLES);
    while (this.times[first] < time - MAX_AGE) first += 1;
    this.times.splice(0, first);
    for (const {values} of this._columns.values()) values.splice(0, first);
  }
}

// Merge columns [times, values] with different times into [times, values, ...]: all times once, in order; undefined where
// a column has no value.
export function merge(columns) {
  const tables = [...new Set(columns.map(([times]) => times))];
  if (tables.length === 1) return [tables[0], ...columns.map(([, values]) => values)];
  const all = Float64Array.from(tables.flat()).sort();
  let length = 0;
  for (const time of all) {
    if (length === 0 || time !== all[length - 1]) {
      all[length] = time;
      length += 1;
    }
  }
  const times = Array.from(all.subarray(0, length));
  return [times, ...columns.map(([own, values]) => {
    const found = Array(length);
    let next = 0;
    for (let i = 0; i < length && next < own.length; i += 1) {
      if (times[i] === own[next]) {
        found[i] = values[next];
        next += 1;
        while (own[next] === times[i]) next += 1; // two messages at once
      }
    }
    return found;
  })];
}

// Return a CSV file with a line for each time; missing values are empty.
export function toCsv(labels, [times, ...columns]) {
  const head = ['time', ...labels].map((label) => `"${label.replace(/"/g, '""')}"`).join(',');
  const lines = times.map((time, i) => [time.toFixed(4), ...columns.map((values) => values[i] ?? '')].join(','));
  return `${[head, ...lines].join('\n')}\n`;
}

// Return {last, min, max} of the values whose time is from `from` to `to`, or null for each if there are none.
export function summary(times, values, from, to) {
  let last = null;
  let min = null;
  let max = null;
  for (let i = times.length - 1; i >= 0 && times[i] >= from; i -= 1) {
    const value = values[i];
    if (value === null || value === undefined || times[i] > to) continue;
    if (last === null) last = value;
    if (min === null || value < min) min = value;
    if (max === null || value > max) max = value;
  }
  return {last, min, max};
}
