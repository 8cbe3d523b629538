// The log of all nodes: /rosout_agg, with levels and filters, as many messages as fit.
import {el, emptyState, fill} from '../app/dom.js';
import {button, labelled, Panel, save, setText, suggestions} from './lib/parts.js';
import {clean, shortName} from './lib/values.js';

const DRAW = 0.2; // s between two updates
const SHOWN = 400; // lines at a time
const NEAR = 40; // px from the end of the list that count as the end
const MAX_LENGTH = 4000; // characters of a message

export const help = [
  'What all nodes log; at first the last 1000 messages since the server of this page was started. Choose levels, or '
    + 'filter by node and text; repeated messages are counted.', 'In a terminal: rostopic echo /rosout_agg.'];

export default class ConsolePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._log = new Log();
    this._changed = true;
    this._paused = false;
    const levels = (context.parameters.levels || '').split(',').filter((name) => name in LEVELS);
    this._levels = new Map(Object.entries(LEVELS).map(([name, level]) => [level, labelled(title(name), {
      type: 'checkbox', checked: levels.length ? levels.includes(name) : level >= LEVELS.info,
      on: {change: () => this._filterChanged()}})]));
    const [nodes, setNodes] = suggestions();
    this._setNodes = setNodes;
    this._node = labelled('Node', {type: 'search', placeholder: 'any', list: nodes.id, value: context.parameters.node || '',
                                   on: {input: () => this._filterChanged()}});
    this._text = labelled('Text', {type: 'search', placeholder: 'any', value: context.parameters.text || '',
                                   on: {input: () => this._filterChanged()}});
    this._count = el('p', {class: 'muted small'});
    this._pause = button('Pause', () => this._setPaused(!this._paused), {'aria-pressed': 'false'});
    this._empty = el('div', {});
    this._list = el('ol', {class: 'log', role: 'log', 'aria-live': 'off', 'aria-label': 'Messages', tabIndex: 0});
    this._follow = button('Newest', () => this._toEnd(), {class: 'primary follow', hidden: true});
    this._drawn = [];
    fill(element, el('div', {class: 'toolbar'}, el('fieldset', {class: 'row plain-set'}, el('legend', {class: 'unseen'}, 'Levels'),
      [...this._levels.values()].map(({element: check}) => check)), this._node.element, nodes, this._text.element,
    el('div', {class: 'row'}, this._pause, button('Clear', () => {
      this._log.clear();
      this._filterChanged();
    }), button('Save', () => save('rosout.txt', this._log.asText(this._filter()))))), this._count, this._empty,
    el('div', {class: 'log-box'}, this._list, this._follow));
    this._list.addEventListener('scroll', () => { this._follow.hidden = this._atEnd(); });
    const early = []; // until those of before have come
    let add = (message) => early.push(message);
    this._fetchEarlier().then((messages) => {
      add = (message) => this._log.add(message);
      for (const message of merged(messages, early)) add(message);
      this._changed = true;
    });
    this.scope.add(context.ros.subscribe('/rosout_agg', 'rosgraph_msgs/Log', (message) => {
      if (this._paused) this._missed = (this._missed || 0) + 1;
      else add(message);
      this._changed = true;
    }, {length: 1000}));
    this.scope.every(DRAW, () => this._draw());
  }

  // Return the messages of before; none from a server that keeps none.
  async _fetchEarlier() {
    try {
      const answer = await fetch('log');
      return answer.ok ? await answer.json() : [];
    } catch {
      return [];
    }
  }

  _filter() {
    return {levels: new Set([...this._levels].filter(([, {input}]) => input.checked).map(([level]) => level)),
            node: this._node.input.value.trim().toLowerCase(), text: this._text.input.value.trim().toLowerCase()};
  }

  _filterChanged() {
    const chosen = Object.keys(LEVELS).filter((name) => this._levels.get(LEVELS[name]).input.checked);
    this.context.setParameters({levels: chosen.join(',') === 'info,warn,error,fatal' ? '' : chosen.join(','),
                                node: this._node.input.value.trim(), text: this._text.input.value.trim()});
    this._drawn = [];
    fill(this._list);
    this._changed = true;
    this._draw();
    this._toEnd();
  }

  _setPaused(paused) {
    this._paused = paused;
    this._missed = 0;
    this._pause.textContent = paused ? 'Continue' : 'Pause';
    this._pause.setAttribute('aria-pressed', String(paused));
    this._changed = true;
    this._draw();
  }

  _atEnd() {
    return this._list.scrollHeight - this._list.scrollTop - this._list.clientHeight < NEAR;
  }

  _toEnd() {
    this._list.scrollTop = this._list.scrollHeight;
    this._follow.hidden = true;
  }

  _draw() {
    if (!this._changed) return;
    this._changed = false;
    const found = this._log.find(this._filter());
    const shown = found.slice(-SHOWN);
    const follow = this._atEnd();
    const kept = new Map(this._drawn.map((line) => [line.entry, line]));
    const lines = shown.map((entry) => kept.get(entry) || new Line(entry));
    const staying = new Set(lines);
    for (const line of this._drawn) if (!staying.has(line)) line.element.remove();
    for (const line of lines) {
      if (!line.element.isConnected) this._list.append(line.element);
      line.update();
    }
    this._drawn = lines;
    if (follow) this._toEnd();
    else this._follow.hidden = false;
    this._setNodes(this._log.nodes());
    const missed = this._paused ? ` Paused: ${this._missed || 0} new messages are not shown.` : '';
    const dropped = this._log.dropped ? ` The oldest ${this._log.dropped} are forgotten.` : '';
    setText(this._count, `${found.length} of ${this._log.size} messages`
      + `${found.length > shown.length ? `; the last ${shown.length} are shown` : ''}.${dropped}${missed}`);
    if (!this._log.size) {
      fill(this._empty, emptyState('Nothing logged yet', 'Messages of rospy.loginfo, logwarn and logerr appear here.',
        'rosrun turtle_robotont velocity_publisher.py'));
    } else {
      fill(this._empty, found.length ? [] : el('p', {class: 'muted'},
        'No message matches. Choose more levels, or clear the filters.'));
    }
    this._list.hidden = !found.length;
  }
}

class Line {
  constructor(entry) {
    this.entry = entry;
    this._times = el('span', {class: 'pill', hidden: true});
    this._clock = el('time', {class: 'number muted'});
    const text = clean(entry.text, MAX_LENGTH, true);
    this.element = el('li', {class: `level-${entry.name}`}, el('details', {},
      el('summary', {}, el('span', {class: `pill level`}, entry.name.toUpperCase()), this._clock,
        el('bdi', {class: 'muted node', title: clean(entry.node, 200)}, clean(shortName(entry.node, 60))), el('bdi', {class: 'text'}, text), this._times),
      el('p', {class: 'small muted'}, `${clean(entry.file, 200)}, line ${entry.line}, function ${clean(entry.function, 100)}`)));
  }

  update() {
    setText(this._clock, timeText(this.entry.stamp));
    this._times.hidden = this.entry.count < 2;
    setText(this._times, `${this.entry.count} times`);
  }
}

function title(name) {
  return name[0].toUpperCase() + name.slice(1);
}

// Return a ROS time as the time of day, or as seconds if it is simulated.
function timeText({secs, nsecs}) {
  if (secs < 1e8) return `${(secs + nsecs * 1e-9).toFixed(3)} s`;
  const date = new Date(secs * 1000);
  return `${date.toTimeString().slice(0, 8)}.${String(Math.floor(nsecs / 1e6)).padStart(3, '0')}`;
}

const LEVELS = {debug: 1, info: 2, warn: 4, error: 8, fatal: 16};
const NAMES = Object.fromEntries(Object.entries(LEVELS).map(([name, level]) => [level, name]));
const MAX_MESSAGES = 5000;
const MAX_TEXT = 10000; // characters of a message
const MOST_NODES = 300;
const LOOK_BACK = 3; // newest messages that are searched for a repeated one

// Return two lists of messages as one; the first ones of `later` can be in `earlier`, too.
export function merged(earlier, later) {
  const key = ({header: {stamp}, name, msg}) => JSON.stringify([stamp.secs, stamp.nsecs, name, msg]);
  const known = new Set(earlier.map(key));
  return [...earlier, ...later.filter((message) => !known.has(key(message)))];
}

export class Log {
  constructor(limit = MAX_MESSAGES) {
    this.dropped = 0;
    this._limit = limit;
    this._entries = [];
    this._nodes = new Set();
  }

  get size() {
    return this._entries.length;
  }

  // Add a rosgraph_msgs/Log message.
  add(message) {
    const node = String(message.name);
    const text = String(message.msg).slice(0, MAX_TEXT);
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
    const excess = this._entries.length - this._limit;
    if (excess > this._limit / 10) { // not one by one, because that moves all others
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
