// The Robotont's world from above: walls, cylinders and marker panels below; path, scan, detected markers and the robot
// above them. World: x to the right, y up, metres. Messages are stored, and drawn in the next frame.

import {cssColour, el, inNextFrame} from './dom.js';

const RADIUS = 0.18;      // [m] of the robot
const LOW = 0.1;          // [m] lower objects are drawn pale: the robot rolls over them
const MARGIN = 0.4;       // [m]
const EMPTY = 3;          // [m] shown around the robot in an empty world
const MAX_POINTS = 20000; // of a path
const NEAR = 0.01;        // [m] between two points of a path
const ZOOM = 1.25;
const REACH = 14;         // [px] around a panel in which a press selects it

export class WorldMap {
  // `onPlace` gets the robot's new pose, `onMove` a dragged panel {name, x, y, yaw}.
  constructor(label, onPlace, onMove) {
    this.ground = el('canvas', {role: 'img', 'aria-label': label});
    this.over = el('canvas', {'aria-hidden': 'true'});
    const zoom = [['+', 'Larger', () => this.zoom(1.4)], ['−', 'Smaller', () => this.zoom(1 / 1.4)], ['⤢', 'Show everything', () => this.fit()]];
    this.element = el('div', {class: 'map', tabIndex: 0}, this.ground, this.over, el('div', {class: 'zoom'}, zoom.map(([sign, text, action]) => el('button', {
      type: 'button', 'aria-label': text, title: text, on: {click: action, pointerdown: (event) => event.stopPropagation()}}, el('span', {'aria-hidden': 'true'}, sign)))));
    this.world = null;
    this.frames = 0;
    this.placing = false;
    this._onPlace = onPlace;
    this._onMove = onMove;
    this._moved = null;     // the dragged panel
    this.clear();
    this.draw = inNextFrame(() => this._draw());
    this._view = null;      // {x, y, scale [px/m]} of the centre; null: show everything
    this._stale = true;     // the ground must be redrawn
    this._observer = new ResizeObserver(() => this._resize());
    this._observer.observe(this.element);
    this._recolour = () => this.redraw();
    addEventListener('themechange', this._recolour);
    this._listen();
  }

  close() {
    this._observer.disconnect();
    this.draw.cancel();
    removeEventListener('themechange', this._recolour);
  }

  // Forget the robot and its measurements.
  clear() {
    this.robot = null;      // {x, y, yaw}
    this.odometry = null;   // the same, by its odometry
    this.path = [];
    this.odometryPath = [];
    this.scan = [];         // points {x, y} in the robot's frame
    this.seen = [];         // {id, x, y} in the robot's frame
  }

  setWorld(world) {
    this.world = world;
    this.redraw();
  }

  setRobot(pose) {
    extend(this.path, pose);
    this.robot = pose;
    if (!this._view && !this._holds(pose)) this._stale = true;
    this.draw();
  }

  setOdometry(pose) {
    extend(this.odometryPath, pose);
    this.odometry = pose;
    this.draw();
  }

  redraw() {
    this._stale = true;
    this.draw();
  }

  zoom(factor, at = null) {
    const {x, y, scale} = this._extent();
    const next = Math.max(10, Math.min(2000, scale * factor));
    const fixed = at ?? {x, y};
    this._view = {x: fixed.x + (x - fixed.x) * scale / next, y: fixed.y + (y - fixed.y) * scale / next, scale: next};
    this.redraw();
  }

  fit() {
    this._view = null;
    this.redraw();
  }

  // Return the position [m] of a pointer event.
  position(event) {
    const box = this.element.getBoundingClientRect();
    const {x, y, scale} = this._extent();
    return {x: x + (event.clientX - box.left - box.width / 2) / scale, y: y - (event.clientY - box.top - box.height / 2) / scale};
  }

  _resize() {
    const width = Math.round(this.element.clientWidth * devicePixelRatio);
    const height = Math.round(this.element.clientHeight * devicePixelRatio);
    if (!width || !height || (this.ground.width === width && this.ground.height === height)) return;
    for (const canvas of [this.ground, this.over]) {
      canvas.width = width;
      canvas.height = height;
    }
    this._stale = true;
    this._draw();
  }

  _bounds() {
    const points = [];
    for (const box of this.world?.boxes ?? []) points.push(...corners(box));
    for (const {x, y, radius} of this.world?.cylinders ?? []) points.push({x: x - radius, y: y - radius}, {x: x + radius, y: y + radius});
    for (const {x, y} of this.world?.panels ?? []) points.push({x, y});
    if (!points.length) points.push({x: -EMPTY, y: -EMPTY}, {x: EMPTY, y: EMPTY});
    if (this.robot) points.push(this.robot);
    const xs = points.map(({x}) => x);
    const ys = points.map(({y}) => y);
    return {left: Math.min(...xs) - MARGIN, right: Math.max(...xs) + MARGIN, bottom: Math.min(...ys) - MARGIN, top: Math.max(...ys) + MARGIN};
  }

  _holds({x, y}) {
    const {left, right, bottom, top} = this._fitted ?? {left: 1, right: 0, bottom: 1, top: 0};
    return left < x && x < right && bottom < y && y < top;
  }

  // Return {x, y, scale [CSS px/m]} of the visible part.
  _extent() {
    if (this._view) return this._view;
    this._fitted ||= this._bounds();
    const {left, right, bottom, top} = this._fitted;
    const scale = Math.min(this.element.clientWidth / (right - left), this.element.clientHeight / (top - bottom));
    return {x: (left + right) / 2, y: (bottom + top) / 2, scale: scale || 1};
  }

  _context(canvas) {
    const context = canvas.getContext('2d');
    const {x, y, scale} = this._extent();
    const dots = scale * devicePixelRatio;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.setTransform(dots, 0, 0, -dots, canvas.width / 2 - x * dots, canvas.height / 2 + y * dots);
    context.lineJoin = context.lineCap = 'round';
    this._pixel = 1 / scale;  // [m] of a CSS pixel
    return context;
  }

  _draw() {
    if (this._stale) {
      this._stale = false;
      this._fitted = null;
      this._drawGround(this._context(this.ground));
    }
    this._drawOver(this._context(this.over));
    this.frames += 1;
  }

  _drawGround(context) {
    this._drawGrid(context);
    const solids = [...this.world?.boxes ?? [], ...this.world?.cylinders ?? []];
    solids.sort((a, b) => a.bottom + a.height - b.bottom - b.height);
    const rim = cssColour('--muted');
    for (const solid of solids) {
      context.beginPath();
      if (solid.radius) context.arc(solid.x, solid.y, solid.radius, 0, 2 * Math.PI);
      else trace(context, corners(solid));
      context.globalAlpha = solid.bottom + solid.height <= LOW ? 0.25 : 1;
      context.fillStyle = `rgb(${solid.colour.map(Number).join(' ')})`;
      context.fill();
      context.strokeStyle = rim;
      context.lineWidth = this._pixel;
      context.stroke();
    }
    context.globalAlpha = 1;
    for (const panel of this.world?.panels ?? []) this._drawPanel(context, panel);
  }

  _drawGrid(context) {
    const {x, y, scale} = this._extent();
    const [width, height] = [this.element.clientWidth / scale / 2, this.element.clientHeight / scale / 2];
    const step = 10 ** Math.ceil(Math.log10(25 / scale));  // [m] at least 25 px
    context.strokeStyle = cssColour('--line');
    context.lineWidth = this._pixel;
    context.beginPath();
    for (let at = Math.ceil((x - width) / step) * step; at < x + width; at += step) {
      context.moveTo(at, y - height);
      context.lineTo(at, y + height);
    }
    for (let at = Math.ceil((y - height) / step) * step; at < y + height; at += step) {
      context.moveTo(x - width, at);
      context.lineTo(x + width, at);
    }
    context.stroke();
    this._text(context, `${step} m`, x - width + 8 * this._pixel, y - height + 8 * this._pixel, cssColour('--muted'), 'left');
  }

  _drawPanel(context, {x, y, yaw, size, marker_id: id}) {
    const [dx, dy] = [-Math.sin(yaw) * size / 2, Math.cos(yaw) * size / 2];
    context.strokeStyle = cssColour('--bad');
    context.lineWidth = Math.max(0.04, 3 * this._pixel);
    context.beginPath();
    context.moveTo(x - dx, y - dy);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    const away = 0.12 + 9 * this._pixel;
    this._text(context, id, x - Math.cos(yaw) * away, y - Math.sin(yaw) * away, cssColour('--bad'));
  }

  _text(context, text, x, y, colour, align = 'center') {
    context.save();
    context.translate(x, y);
    context.scale(this._pixel, -this._pixel);
    context.fillStyle = colour;
    context.font = '600 13px system-ui, sans-serif';
    context.textAlign = align;
    context.textBaseline = align === 'center' ? 'middle' : 'alphabetic';
    context.fillText(String(text), 0, 0);
    context.restore();
  }

  _drawOver(context) {
    const accent = cssColour('--accent');
    if (this._moved) this._drawPanel(context, this._moved);
    if (!this.robot) return;
    const drift = this.odometry && Math.hypot(this.odometry.x - this.robot.x, this.odometry.y - this.robot.y) > 0.02;
    if (drift) this._drawPath(context, this.odometryPath, cssColour('--series-2'), [6, 6]);
    this._drawPath(context, this.path, accent, []);
    this._at(context, this.robot, () => this._drawPoints(context, this.scan));
    if (this.mark) this._drawRobot(context, this.mark, accent, 0.5);
    if (drift) this._drawRobot(context, this.odometry, cssColour('--series-2'), 0.35);
    this._drawRobot(context, this.robot, accent, 1);
    this._drawSeen(context);
  }

  _drawPath(context, path, colour, dashes) {
    if (path.length < 2) return;
    context.strokeStyle = colour;
    context.lineWidth = 2 * this._pixel;
    context.setLineDash(dashes.map((length) => length * this._pixel));
    context.beginPath();
    for (const {x, y} of path) context.lineTo(x, y);
    context.stroke();
    context.setLineDash([]);
  }

  // Draw something in the frame of a pose.
  _at(context, {x, y, yaw}, draw) {
    context.save();
    context.translate(x, y);
    context.rotate(yaw);
    draw();
    context.restore();
  }

  // Draw the points of a laser scan.
  _drawPoints(context, points) {
    context.fillStyle = cssColour('--series-2');
    const size = 3 * this._pixel;
    for (const {x, y} of points) context.fillRect(x - size / 2, y - size / 2, size, size);
  }

  _drawRobot(context, {x, y, yaw}, colour, opacity) {
    context.save();
    context.translate(x, y);
    context.rotate(yaw);
    context.globalAlpha = opacity;
    context.beginPath();
    context.arc(0, 0, RADIUS, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
    context.strokeStyle = cssColour('--surface');
    context.lineWidth = 2 * this._pixel;
    context.stroke();
    context.beginPath();
    trace(context, [{x: 0.15, y: 0}, {x: -0.11, y: 0.08}, {x: -0.06, y: 0}, {x: -0.11, y: -0.08}]);
    context.fillStyle = cssColour('--surface');
    context.fill();
    context.restore();
  }

  _drawSeen(context) {
    const colour = cssColour('--good');
    const {x, y, yaw} = this.robot;
    for (const marker of this.seen) {
      const [mx, my] = [x + marker.x * Math.cos(yaw) - marker.y * Math.sin(yaw), y + marker.x * Math.sin(yaw) + marker.y * Math.cos(yaw)];
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = this._pixel;
      context.setLineDash([4 * this._pixel, 4 * this._pixel]);
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(mx, my);
      context.stroke();
      context.setLineDash([]);
      context.beginPath();
      context.arc(mx, my, 11 * this._pixel, 0, 2 * Math.PI);
      context.fill();
      this._text(context, marker.id, mx, my, cssColour('--surface'));
    }
  }

  _listen() {
    const map = this.element;
    let start = null;
    map.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? ZOOM : 1 / ZOOM, this.position(event));
    }, {passive: false});
    map.addEventListener('pointerdown', (event) => {
      if (event.button || start) return;
      map.setPointerCapture(event.pointerId);
      start = {...this.position(event), id: event.pointerId, yaw: this.robot?.yaw ?? 0};
      start.panel = this.placing ? null : this._panelAt(start);
      if (this.placing) this._aim(start, event);
    });
    map.addEventListener('pointermove', (event) => {
      if (event.pointerId !== start?.id) return;
      if (this.placing) {
        this._aim(start, event);
      } else if (start.panel) {
        const {x, y} = this.position(event);
        this._moved = {...start.panel, x: start.panel.x + x - start.x, y: start.panel.y + y - start.y};
        this.draw();
      } else {
        const now = this.position(event);
        const {x, y, scale} = this._extent();
        this._view = {x: x + start.x - now.x, y: y + start.y - now.y, scale};
        this.redraw();
      }
    });
    const end = (event) => {
      if (event.pointerId !== start?.id) return;
      start = null;
      if (event.type === 'pointerup') {
        if (this.mark) this._onPlace(this.mark);
        if (this._moved) this._onMove(this._moved);
      }
      this.mark = this._moved = null;
      this.draw();
    };
    map.addEventListener('pointerup', end);
    map.addEventListener('pointercancel', end);
  }

  _panelAt({x, y}) {
    const reach = REACH / this._extent().scale;
    return this.world?.panels?.find((panel) => Math.hypot(panel.x - x, panel.y - y) < Math.max(reach, panel.size / 2)) ?? null;
  }

  _aim(start, event) {
    const {x, y} = this.position(event);
    const far = Math.hypot(x - start.x, y - start.y) > RADIUS;
    this.mark = {x: start.x, y: start.y, yaw: far ? Math.atan2(y - start.y, x - start.x) : start.yaw};
    this.draw();
  }
}

// Add a position to a path if it differs from the last one; a jump starts a new path.
function extend(path, {x, y}) {
  const last = path[path.length - 1];
  if (last && Math.hypot(x - last.x, y - last.y) < NEAR) return;
  if (last && Math.hypot(x - last.x, y - last.y) > 1) path.length = 0;
  path.push({x, y});
  if (path.length > MAX_POINTS) path.splice(0, MAX_POINTS / 10);
}

function corners({x, y, yaw, length, width}) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => ({
    x: x + cos * a * length / 2 - sin * b * width / 2, y: y + sin * a * length / 2 + cos * b * width / 2}));
}

function trace(context, points) {
  for (const {x, y} of points) context.lineTo(x, y);
  context.closePath();
}
