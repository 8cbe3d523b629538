// Log messages in bounded memory; repeated ones are counted.

export const LEVELS = {debug: 1, info: 2, warn: 4, error: 8, fatal: 16};
const NAMES = Object.fromEntries(Object.entries(LEVELS).map(([name, level]) => [level, name]));
const MAX_MESSAGES = 5000;
const MAX_LENGTH = 10000; // characters of a message
const MOST_NODES = 300;
const LOOK_BACK = 3; // newest messages that are searched for a repeated one

// Return two lists of messages as one; the first ones of `later` can be in `earlier`, too.
export function merged(earlier, later) {
  const key = ({header: {stamp}, name, msg}) => JSON.stringify([stamp.secs, stamp.nsecs, name, msg]);
  const known = new Set(earlier.map(key));
  return [...earlier, ...later.filter((message) => !known.has(key(message)))];
}

export class Log {
  constructor(most = MAX_MESSAGES) {
    this.dropped = 0;
    this._most = most;
    this._entries = [];
    this._nodes = new Set();
  }

  get size() {
    return this._entries.length;
  }

  // Add a rosgraph_msgs/Log message.
  add(message) {
    const node = String(message.name);
    const text = String(message.msg).slice(0, MAX_LENGTH);
    const same = this._entries.slice(-LOOK_BACK).find((entry) => (
      entry.text === text && entry.node === node && entry.level === message.level));
    if (same) {
      same.count += 1;
      same.stamp = message.header.stamp;
      return;
    }
    this._entries.push({
      level: message.level, name: NAMES[message.level] || 'info', node, text, stamp: message.header.stamp, count: 1,
      file: String(message.file).slice(0, 300), line: Number(message.line), function: String(message.function).slice(0, 200)});
    if (this._nodes.size < MOST_NODES) this._nodes.add(node);
    const excess = this._entries.length - this._most;
    if (excess > this._most / 10) { // not one by one, because that moves all others
      this._entries.splice(0, excess);
      this.dropped += excess;
    }
  }

  clear() {
    this._entries = [];
    this._nodes.clear();
    this.dropped = 0;
  }

  nodes() {
    return [...this._nodes].sort();
  }

  // Return the entries that match {levels, node, text}; texts are in lower case.
  find({levels, node, text}) {
    return this._entries.filter((entry) => levels.has(entry.level) && (!node || entry.node.toLowerCase().includes(node))
      && (!text || entry.text.toLowerCase().includes(text)));
  }

  // Return those entries as the lines of a file.
  asText(filter) {
    return this.find(filter).map(({level, node, text, stamp, count}) => (
      `[${(NAMES[level] || '').toUpperCase()}] [${stamp.secs}.${String(stamp.nsecs).padStart(9, '0')}] ${node}: ${text}`
      + `${count > 1 ? ` (${count} times)` : ''}\n`)).join('');
  }
}
