// The tree of frames that /tf and /tf_static describe.
import {bare, heading} from '../../app/frames.js';

const SPAN = 5; // s over which a rate is measured
const OLD = 5; // s without a message after which a frame that moves counts as lost
const MAX_FRAMES = 500;
const MAX_DEPTH = 100;

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
