// Frames: the tree of coordinate frames, with each frame's pose in its parent.
import {el, emptyState, fill, inNextFrame} from '../app/dom.js';
import {Notice, Panel, setText} from './lib/parts.js';
import {FrameTree, rateOf, rollPitchYaw} from './lib/frame_tree.js';
import {clean} from './lib/values.js';

const PERIOD = 500; // ms between two drawings

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
