// Static frames (/tf_static), as far as a map needs them: the positions of sensors on the robot.

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
    if (!this._parents.has(name) && name.endsWith('_optical_frame')) return {x: point.z, y: -point.x, z: -point.y};
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
export function scanPoints({angle_min: first, angle_increment: step, range_max: most, ranges}) {
  const points = [];
  for (const [index, range] of ranges.entries()) {
    if (range === null || range > most) continue;  // null: infinite, without an echo
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
