// Frames: the tree of coordinate frames, with each frame's pose in its parent.
import {el, emptyState, fill, inNextFrame} from '../app/dom.js';
import {Notice, Panel, setText} from './lib/parts.js';
import {clean} from './lib/values.js';
import {bare, heading} from '../app/frames.js';

const PERIOD = 500; // ms between two drawings
const SPAN = 5; // s over which a rate is measured
const OLD = 5; // s without a message after which a frame that moves counts as lost
const MAX_FRAMES = 500;
const MAX_DEPTH = 100;

export const help = [
  'The tree of frames that nodes send on /tf and /tf_static. Each line has the pose of a frame in its parent: x, y and z in '
    + 'metres; roll, pitch and yaw in degrees. Red lines say what is wrong with a frame.',
  'In a terminal: rosrun tf tf_echo PARENT CHILD, rosrun tf view_frames.'];

export default class FramesPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._tree = new FrameTree();
    this._rows = new Map();
    this._count = el('p', {class: 'muted small', role: 'status'});
    this._notice = new Notice();
    this._empty = el('div', {});
    this._body = el('tbody', {});
    this._table = el('table', {class: 'frames'}, el('thead', {}, el('tr', {}, ['Frame', 'x, y, z [m]', 'roll, pitch, yaw [°]', 'Rate']
      .map((title) => el('th', {scope: 'col'}, title)))), this._body);
    fill(element, this._count, this._notice.element, this._empty, el('div', {class: 'table-box', tabIndex: 0, role: 'region', 'aria-label': 'Frames'}, this._table));
    for (const [topic, fixed] of [['/tf', false], ['/tf_static', true]]) {
      this.scope.add(context.ros.subscribe(topic, 'tf2_msgs/TFMessage',
        (message) => this._tree.add(message, fixed, performance.now() / 1000), {length: 100}));
    }
    const draw = inNextFrame(() => this._draw());
    const timer = setInterval(draw, PERIOD);
    this.scope.add(() => { clearInterval(timer); draw.cancel(); });
    this._draw();
  }

  _draw() {
    const {rows, trees} = this._tree.rows(performance.now() / 1000);
    this._table.hidden = !rows.length;
    if (!rows.length) {
      fill(this._empty, emptyState('No frames yet', 'A robot, or a node with a tf broadcaster, sends them.',
                                   'roslaunch robotont_gazebo world_minimaze.launch'));
    } else {
      fill(this._empty);
    }
    setText(this._count, rows.length ? `${rows.length} frames` : '');
    this._notice.say(trees > 1 ? `${trees} trees are not connected: no pose can be computed between their frames.` : '', true);
    const names = new Set(rows.map(({name}) => name));
    for (const [name, row] of this._rows) {
      if (!names.has(name)) {
        row.element.remove();
        this._rows.delete(name);
      }
    }
    rows.forEach((row, index) => {
      if (!this._rows.has(row.name)) this._rows.set(row.name, new FrameRow(row.name));
      const shown = this._rows.get(row.name);
      if (this._body.children[index] !== shown.element) this._body.insertBefore(shown.element, this._body.children[index] || null);
      shown.update(row);
    });
  }
}

class FrameRow {
  constructor(name) {
    this._faults = el('div', {class: 'error small'});
    this._name = el('th', {scope: 'row'}, el('bdi', {}, clean(name, 200)), this._faults);
    this._cells = [1, 2, 3].map(() => el('td', {class: 'number'}));
    this.element = el('tr', {}, this._name, this._cells);
  }

  update({depth, frame, faults}) {
    this._name.style.paddingInlineStart = `${0.6 + 1.2 * Math.min(depth, 12)}em`;
    setText(this._faults, faults.join('; '));
    const [place, angles, rate] = this._cells;
    if (!frame) {
      setText(rate, 'root');
      return;
    }
    const {x, y, z} = frame.transform.translation;
    setText(place, [x, y, z].map((value) => numeral(value, 3)).join('  '));
    setText(angles, rollPitchYaw(frame.transform.rotation).map((value) => numeral(value * 180 / Math.PI, 1)).join('  '));
    setText(rate, frame.fixed ? 'static' : `${numeral(rateOf(frame), 1)} Hz`);
  }
}

function numeral(value, digits) {
  return Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1') : '?';
}

export class FrameTree {
  constructor() {
    this._frames = new Map(); // name: {parent, transform, fixed, times, other}
  }

  // Add a tf2_msgs/TFMessage; `now` [s].
  add({transforms}, fixed, now) {
    for (const {header, child_frame_id: child, transform} of transforms) {
      const name = bare(child);
      const parent = bare(header.frame_id);
      const known = this._frames.get(name);
      if (!known && this._frames.size >= MAX_FRAMES) continue;
      const times = known && !fixed ? known.times : [];
      times.push(now);
      while (times[0] < now - SPAN) times.shift();
      // two parents in turn: two nodes send this frame
      const other = known && known.parent !== parent ? known.parent : known?.other;
      this._frames.set(name, {parent, transform, fixed, times, other});
    }
  }

  // Return [{name, depth, frame, faults}] from the roots down; `frame` is null for a root, `faults` are texts.
  rows(now) {
    const children = new Map();
    for (const [name, {parent}] of this._frames) {
      if (!children.has(parent)) children.set(parent, []);
      children.get(parent).push(name);
    }
    const rows = [];
    const seen = new Set();
    const add = (name, depth) => {
      if (seen.has(name) || depth > MAX_DEPTH) return;
      seen.add(name);
      const frame = this._frames.get(name) || null;
      rows.push({name, depth, frame, faults: frame ? faultsOf(frame, now) : []});
      for (const child of (children.get(name) || []).sort()) add(child, depth + 1);
    };
    const roots = [...children.keys()].filter((name) => !this._frames.has(name)).sort();
    for (const root of roots) add(root, 0);
    for (const name of this._frames.keys()) { // what no root leads to is a circle
      if (!seen.has(name)) {
        const first = rows.length;
        add(name, 0);
        rows[first].faults.push('it is its own ancestor: the frames below form a circle');
      }
    }
    return {rows, trees: roots.length};
  }
}

function faultsOf(frame, now) {
  const faults = [];
  const age = now - frame.times[frame.times.length - 1];
  if (!frame.fixed && age > OLD) faults.push(`nothing has come for ${Math.floor(age)} s`);
  if (frame.other) faults.push(`two nodes disagree about its parent: also ${frame.other}`);
  return faults;
}

// Return the rate [Hz] at which a frame comes, 0 if that cannot be said.
export function rateOf({times}) {
  const span = times[times.length - 1] - times[0];
  return span > 0 ? (times.length - 1) / span : 0;
}

// Return roll, pitch and yaw [rad] of a quaternion: fixed axes x, y, z, as euler_from_quaternion returns them.
export function rollPitchYaw(rotation) {
  const {x, y, z, w} = rotation;
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
          Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
          heading(rotation)];
}
