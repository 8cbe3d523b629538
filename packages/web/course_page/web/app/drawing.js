// turtlesim's canvas and turtles: draws the messages of ~drawing (turtlesim/Drawing) on two canvases, one over the other.
//
// The lower canvas shows turtlesim's own 500 x 500 pixels, which the simulator sends as runs of one colour, so that it
// equals a snapshot. The upper one shows the turtles in the resolution of the screen.

import {el, inNextFrame} from './dom.js';

const SIZE = 500;        // [px] of turtlesim's canvas
const METRE = 45;        // [px]
const ARENA = (SIZE - 1) / METRE;  // [m]
const SPRITE = 45;              // [px]
const PIXEL_BITS = 18;          // of a run's first number: its first pixel; the other bits: its length
const OPAQUE = 0xff000000;
const WAIT = 1000;              // [ms] until all pixels are requested again

const sprites = new Map();      // name: an image

function sprite(name, loaded) {
  if (!sprites.has(name)) {
    const image = new Image();
    image.src = `turtles/${encodeURIComponent(name)}.png`;
    image.onload = loaded;
    sprites.set(name, image);
  }
  const image = sprites.get(name);
  return image.complete && image.naturalWidth ? image : null;
}

// Return the bytes of a base64 text. Uint8Array.from with a function takes seven times as long, 40 ms for a full canvas.
function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let at = 0; at < letters.length; at += 1) bytes[at] = letters.charCodeAt(at);
  return bytes;
}

export class Drawing {
  // `label`: of the canvas, for screen readers; `onTurtles(turtles)` is called before each frame that shows a new message.
  constructor(ros, label, onTurtles) {
    this._ros = ros;
    this._onTurtles = onTurtles;
    this.canvas = el('canvas', {class: 'strokes', width: SIZE, height: SIZE, role: 'img', 'aria-label': label});
    this.over = el('canvas', {class: 'turtles', 'aria-hidden': 'true'});
    this.element = el('div', {class: 'arena'}, this.canvas, this.over);
    this._strokes = this.canvas.getContext('2d', {willReadFrequently: true});
    this._image = this._strokes.createImageData(SIZE, SIZE);
    this._pixels = new Uint32Array(this._image.data.buffer);
    this._top = SIZE;      // first row of `_image` that is not on the canvas yet
    this._bottom = -1;
    this.turtles = [];     // {name, image, x, y, theta}
    this.frames = 0;       // drawn with turtles
    this.highlight = '';   // the name of a turtle with a ring around it
    this.mark = null;      // {x, y, theta}: where a turtle would be placed
    this.draw = inNextFrame(() => this._draw());
    this._observer = new ResizeObserver(() => this._resize());
    this._observer.observe(this.element);
    this._end = () => {};
    this._node = '';
  }

  // Show the simulator whose node has this name, such as /turtlesim; '': none.
  follow(node) {
    if (node === this._node) return;
    this._end();
    this._node = node;
    this._number = null;   // of the newest message on the canvas; null: unknown
    this._early = [];
    this.turtles = [];
    this._fetching = false;
    if (!node) return;
    const unsubscribe = this._ros.subscribe(`${node}/drawing`, 'turtlesim/Drawing', (message) => this._take(message), {length: 120});
    const endState = this._ros.onState((state) => {
      if (state.link === 'open' && state.master) this._fetch();
      else this._number = null;
    });
    this._end = () => {
      unsubscribe();
      endState();
    };
  }

  close() {
    this.follow('');
    this._observer.disconnect();
    this.draw.cancel();
  }

  _take(message) {
    if (this._number === null) {
      this._early.push(message);
      this._fetch();
    } else if (message.number === this._number + 1) {
      this._show(message);
    } else {            // messages were lost, or the simulator has restarted
      this._number = null;
      this._early = [message];
      this._fetch();
    }
  }

  // Request all pixels, then apply the changes since.
  async _fetch() {
    if (this._fetching || this._number !== null || !this._ros.connected) return;
    const node = this._node;
    this._fetching = true;
    try {
      const {drawing} = await this._ros.call(`${node}/get_drawing`);
      if (node !== this._node) return;
      this._show(drawing);
      const early = this._early.filter((message) => message.number > drawing.number);
      this._early = [];
      for (const message of early) this._take(message);
    } catch {
      await new Promise((resolve) => setTimeout(resolve, WAIT));
    } finally {
      if (node === this._node) {
        this._fetching = false;
        if (this._early.length && this._number === null) this._fetch();
      }
    }
  }

  _show(message) {
    this._number = message.number;
    const bytes = bytesOf(message.runs);
    const numbers = new DataView(bytes.buffer);
    for (let at = 0; at < bytes.length; at += 8) {
      const run = numbers.getUint32(at, true);
      const first = run & ((1 << PIXEL_BITS) - 1);
      const row = Math.floor(first / SIZE);
      this._pixels.fill(numbers.getUint32(at + 4, true) | OPAQUE, first, first + (run >>> PIXEL_BITS));
      if (row < this._top) this._top = row;
      if (row > this._bottom) this._bottom = row;
    }
    this.turtles = message.names.map((name, index) => ({
      name, image: message.images[index], x: message.x[index], y: message.y[index], theta: message.theta[index]}));
    this.draw();
  }

  _resize() {
    const size = Math.round(this.element.clientWidth * devicePixelRatio);
    if (size && this.over.height !== size) {  // its width may be 300 from the start, its height is not
      this.over.width = this.over.height = size;
      this._draw();
    }
  }

  _draw() {
    if (this._bottom >= this._top) {
      this._strokes.putImageData(this._image, 0, 0, 0, this._top, SIZE, this._bottom - this._top + 1);
      this._top = SIZE;
      this._bottom = -1;
    }
    const context = this.over.getContext('2d');
    const scale = this.over.width / SIZE;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.over.width, this.over.height);
    for (const turtle of this.turtles) this._drawTurtle(context, scale, turtle, 1);
    if (this.mark) this._drawTurtle(context, scale, this.mark, 0.6);
    this._onTurtles(this.turtles);
    if (this.turtles.length && !this.frames) performance.mark('first picture');
    if (this.turtles.length) this.frames += 1;
  }

  _drawTurtle(context, scale, {name, image, x, y, theta}, opacity) {
    const turn = Math.PI / 2 - theta;  // its image faces up
    const cos = scale * Math.cos(turn);
    const sin = scale * Math.sin(turn);
    context.setTransform(cos, sin, -sin, cos, (x * METRE + 0.5) * scale, (SIZE - 0.5 - y * METRE) * scale);
    context.globalAlpha = opacity;
    if (name !== undefined && name === this.highlight && this.turtles.length > 1) {
      context.beginPath();
      context.arc(0, 0, 0.62 * SPRITE, 0, 2 * Math.PI);
      context.lineWidth = 2;
      context.strokeStyle = '#fff';
      context.stroke();
    }
    const picture = sprite(image, this.draw);
    if (picture) context.drawImage(picture, -SPRITE / 2, -SPRITE / 2, SPRITE, SPRITE);
    context.globalAlpha = 1;
  }

  // Return the position [m] in the arena of a pointer event.
  position(event) {
    const box = this.element.getBoundingClientRect();
    const clip = (value) => Math.max(0, Math.min(ARENA, value));
    return {x: clip(((event.clientX - box.left) / box.width) * SIZE / METRE),
      y: clip(ARENA - ((event.clientY - box.top) / box.height) * SIZE / METRE)};
  }

  // Return the turtle nearest to a position, within its own size, or undefined.
  turtleAt({x, y}) {
    const near = this.turtles.map((turtle) => [Math.hypot(turtle.x - x, turtle.y - y), turtle])
      .filter(([distance]) => distance < SPRITE / METRE / 1.5).sort((a, b) => a[0] - b[0]);
    return near[0]?.[1];
  }
}
