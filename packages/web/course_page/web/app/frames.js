// Frames as far as maps need them: the positions of sensors on the robot, and all frames in the plane.

const DEEPEST = 100;  // frames between two

// The static frames (/tf_static).
export class Frames {
  constructor(ros) {
    this._parents = new Map();  // name: {parent, translation, rotation}
    this.close = ros.subscribe('/tf_static', 'tf2_msgs/TFMessage', ({transforms}) => {
      for (const {header, child_frame_id: child, transform} of transforms) {
        this._parents.set(bare(child), {parent: bare(header.frame_id), ...transform});
      }
    }, {length: 100});
  }

  // Return a point {x, y, z} of a frame in the root of the static frames, the robot's own frame.
  // An unknown frame counts as the robot's own; an optical one looks ahead.
  toRobot(frame, point) {
    let name = bare(frame);
    if (!this._parents.has(name) && /_optical(_frame)?$/.test(name)) return {x: point.z, y: -point.x, z: -point.y};
    for (let depth = 0; depth < 100 && this._parents.has(name); depth += 1) {
      const {parent, translation, rotation} = this._parents.get(name);
      const turned = rotate(rotation, point);
      point = {x: turned.x + translation.x, y: turned.y + translation.y, z: turned.z + translation.z};
      name = parent;
    }
    return point;
  }
}

// Return the name of a frame without the leading slash of tf's older programs.
export function bare(name) {
  return name.replace(/^\//, '');
}

// Return a point rotated by a quaternion.
export function rotate({x, y, z, w}, point) {
  const tx = 2 * (y * point.z - z * point.y);
  const ty = 2 * (z * point.x - x * point.z);
  const tz = 2 * (x * point.y - y * point.x);
  return {x: point.x + w * tx + y * tz - z * ty, y: point.y + w * ty + z * tx - x * tz, z: point.z + w * tz + x * ty - y * tx};
}

// Return the points {x, y, z} of a sensor_msgs/LaserScan in the frame of the scanner.
export function scanPoints({angle_min: first, angle_increment: step, range_max: max, ranges}) {
  const points = [];
  for (const [index, range] of ranges.entries()) {
    if (range === null || range > max) continue;  // null: infinite, without an echo
    const angle = first + index * step;
    points.push({x: range * Math.cos(angle), y: range * Math.sin(angle), z: 0});
  }
  return points;
}

// Return a geometry_msgs/Pose seen from above.
export function planar({position: {x, y}, orientation}) {
  return {x, y, yaw: heading(orientation)};
}

// Return the heading [rad] of a quaternion, counter-clockwise from +x.
export function heading({x, y, z, w}) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

// All frames (/tf and /tf_static) in the plane: where one is in another now.
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
