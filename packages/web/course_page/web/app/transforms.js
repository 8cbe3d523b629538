// All frames (/tf and /tf_static) in the plane: where one is in another now.

import {bare, heading} from './frames.js';

const DEEPEST = 100;  // frames between two

export class Transforms {
  constructor(ros) {
    this._parents = new Map();  // name: {parent, x, y, yaw}
    const take = ({transforms}) => {
      for (const {header, child_frame_id: child, transform: {translation: {x, y}, rotation}} of transforms) {
        this._parents.set(bare(child), {parent: bare(header.frame_id), x, y, yaw: heading(rotation)});
      }
    };
    const ends = ['/tf', '/tf_static'].map((topic) => ros.subscribe(topic, 'tf2_msgs/TFMessage', take, {length: 100}));
    this.close = () => ends.forEach((end) => end());
  }

  // Return the pose {x, y, yaw} of a frame in another; null if it is not known.
  pose(frame, target) {
    const chain = this._chain(bare(frame));
    const other = this._chain(bare(target));
    const common = chain.findIndex(({name}) => other.some((step) => step.name === name));
    if (common < 0) return null;
    const end = other.findIndex(({name}) => name === chain[common].name);
    return compose(inverse(other[end].pose), chain[common].pose);
  }

  // Return the ancestors of a frame, itself first: [{name, pose of the frame in it}].
  _chain(frame) {
    const chain = [{name: frame, pose: {x: 0, y: 0, yaw: 0}}];
    for (let name = frame; this._parents.has(name) && chain.length < DEEPEST;) {
      const step = this._parents.get(name);
      name = step.parent;
      chain.push({name, pose: compose(step, chain[chain.length - 1].pose)});
    }
    return chain;
  }
}

// Return a pose that is given in another pose's frame in that pose's own outer frame.
function compose(outer, {x, y, yaw}) {
  const [cos, sin] = [Math.cos(outer.yaw), Math.sin(outer.yaw)];
  return {x: outer.x + cos * x - sin * y, y: outer.y + sin * x + cos * y, yaw: outer.yaw + yaw};
}

function inverse({x, y, yaw}) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return {x: -cos * x - sin * y, y: sin * x - cos * y, yaw: -yaw};
}
