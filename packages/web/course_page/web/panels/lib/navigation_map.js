// What rviz shows for navigation, from above: map and costmaps below; particles, scan, paths, footprint and robot above.
// Everything is stored in the frame it comes in, and drawn in the frame of the map.

import {cssColour} from '../../app/dom.js';
import {WorldMap} from '../../app/map.js';

const ARROW = 0.12;       // [m] of a particle
const MARGIN = 0.4;       // [m]

export class NavigationMap extends WorldMap {
  // `poseOf(frame)` returns the pose of a frame in that of the map, or null; `onPlace(pose)` gets the arrow of a tool.
  constructor(label, poseOf, onPlace) {
    super(label, onPlace, () => {});
    this._poseOf = poseOf;
    this.hidden = new Set();  // names of layers
    this.grids = new Map();   // name: {frame, x, y, yaw, resolution, canvas, known [cells]}
    this.lines = new Map();   // name: {frame, points, colour, closed}
    this.cloud = null;        // {frame, poses}
    this.rays = null;         // {frame, points}
  }

  // Take a nav_msgs/OccupancyGrid; `colours`: a Uint32Array of the 256 colours of its values.
  setGrid(name, {header, info, data}, {x, y, yaw}, colours) {
    const {width, height, resolution} = info;
    let canvas = this.grids.get(name)?.canvas;
    if (!canvas || canvas.width !== width || canvas.height !== height) {
      canvas = document.createElement('canvas');
      canvas.width = width;
      canvas.height = height;
    }
    const context = canvas.getContext('2d');
    const image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const known = {left: width, right: 0, bottom: height, top: 0};  // [cells]
    for (let index = 0; index < pixels.length; index += 1) {
      pixels[index] = colours[data[index] & 255];
      if (data[index] < 0) continue;
      const [column, row] = [index % width, Math.floor(index / width)];
      if (column < known.left) known.left = column;
      if (column >= known.right) known.right = column + 1;
      if (row < known.bottom) known.bottom = row;
      known.top = row + 1;
    }
    context.putImageData(image, 0, 0);
    const before = this.grids.get(name)?.known;
    this.grids.set(name, {frame: header.frame_id, x, y, yaw, resolution, canvas, known});
    if (String(Object.values(before ?? {})) !== String(Object.values(known))) this.redraw();
    else this.draw();
  }

  _bounds() {
    const grid = this.grids.get('map');
    if (!grid) return super._bounds();
    const {x, y, resolution, known: {left, right, bottom, top}} = grid;
    if (left >= right) return super._bounds();
    return {left: x + left * resolution - MARGIN, right: x + right * resolution + MARGIN,
      bottom: y + bottom * resolution - MARGIN, top: y + top * resolution + MARGIN};
  }

  _drawGround(context) {
    this._drawGrid(context);
  }

  _drawOver(context) {
    for (const [name, grid] of this.grids) if (!this.hidden.has(name)) this._drawCells(context, grid);
    if (this.cloud && !this.hidden.has('particles')) this._in(context, this.cloud.frame, () => this._drawParticles(context));
    if (this.rays && !this.hidden.has('scan')) this._in(context, this.rays.frame, () => this._drawPoints(context, this.rays.points));
    for (const [name, line] of this.lines) {
      if (!this.hidden.has(name)) this._in(context, line.frame, () => this._drawLine(context, line));
    }
    if (this.goal) this._in(context, this.goal.frame, () => this._drawRobot(context, this.goal, cssColour('--bad'), 0.6));
    if (this.robot) this._drawRobot(context, this.robot, cssColour('--accent'), 1);
    if (this.mark) this._drawRobot(context, this.mark, cssColour('--good'), 0.7);
  }

  // Draw something in a frame, if its pose in the map is known.
  _in(context, frame, draw) {
    const pose = this._poseOf(frame);
    if (pose) this._at(context, pose, draw);
  }

  _drawCells(context, grid) {
    this._in(context, grid.frame, () => this._at(context, grid, () => {
      context.scale(grid.resolution, grid.resolution);
      context.imageSmoothingEnabled = false;
      context.drawImage(grid.canvas, 0, 0);  // y is up, as in the grid
    }));
  }

  _drawParticles(context) {
    context.strokeStyle = cssColour('--bad');
    context.lineWidth = this._pixel;
    context.beginPath();
    for (const {x, y, yaw} of this.cloud.poses) {
      context.moveTo(x, y);
      context.lineTo(x + ARROW * Math.cos(yaw), y + ARROW * Math.sin(yaw));
    }
    context.stroke();
  }

  _drawLine(context, {points, colour, closed}) {
    if (points.length < 2) return;
    context.strokeStyle = cssColour(colour);
    context.lineWidth = 2.5 * this._pixel;
    context.beginPath();
    for (const {x, y} of points) context.lineTo(x, y);
    if (closed) context.closePath();
    context.stroke();
  }
}

// Return the colours of a map's values: free, occupied, unknown, as rviz has them.
export function mapColours() {
  return table((value) => (value < 0 ? [112, 137, 134, 255] : Array(3).fill(Math.round(254 - 2.54 * Math.min(value, 100))).concat(255)));
}

// Return those of a costmap, which lies over the map: far from obstacles transparent, then blue to red; obstacles violet.
export function costColours() {
  return table((value) => {
    if (value <= 0) return [0, 0, 0, 0];
    if (value >= 100) return [190, 0, 190, 200];
    if (value === 99) return [0, 170, 190, 150];
    return [Math.round(2.55 * value), 0, Math.round(255 - 2.55 * value), 110];
  });
}

function table(colour) {
  const bytes = new Uint8ClampedArray(4 * 256);
  for (let index = 0; index < 256; index += 1) bytes.set(colour(index < 128 ? index : index - 256), 4 * index);
  return new Uint32Array(bytes.buffer);
}
