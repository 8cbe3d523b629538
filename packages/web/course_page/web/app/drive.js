// Driving by keys, buttons, joysticks, gamepads and touch.
//
// Safety: velocities are sent every PERIOD while a key, button or joystick is held, and one zero velocity on release. All
// are released when the page loses the focus, is hidden or left. If the page itself stops working, the server's dead
// man's switch stops the vehicle DEADMAN after the last message.

import {el} from './dom.js';

const PERIOD = 50;     // [ms] between two velocities
const DEADMAN = 0.5;   // [s]
const PULSE = 500;     // [ms] of driving per click without a pointer, as screen readers send it
const LATELY = 2000;   // [ms] after which this page does not drive any more; older than the server's last report
const TWIST = 'geometry_msgs/Twist';
const KEYS = {
  ArrowUp: 'forward', ArrowDown: 'back', ArrowLeft: 'left', ArrowRight: 'right',
  KeyW: 'forward', KeyS: 'back', KeyA: 'left', KeyD: 'right', KeyQ: 'strafeLeft', KeyE: 'strafeRight',
};
// Velocity of each: x forward, y to the left, turn counter-clockwise, each -1 to 1.
const DIRECTIONS = {
  forward: {x: 1}, back: {x: -1}, left: {turn: 1}, right: {turn: -1}, strafeLeft: {y: 1}, strafeRight: {y: -1},
};

// Sends the velocities of one vehicle.
export class Driver {
  // `topic()` returns the current topic, '' for none; `limits` {linear [m/s], angular [rad/s]} may be changed;
  // `onChange({x, y, turn})` gets the sum of the held inputs, each -1 to 1.
  constructor(ros, topic, limits, onChange = () => {}) {
    this._ros = ros;
    this._topic = topic;
    this.limits = limits;
    this._onChange = onChange;
    this._held = new Map();  // source: {x, y, turn}
    this._timer = 0;
    this._moving = '';       // the topic that needs a zero velocity
    this._drove = -Infinity; // [ms] when this page drove last
    this._ends = [
      ros.onOpen(() => ros.send({op: 'deadman', timeout: DEADMAN})),
      ros.onState((state) => (state.link === 'open' && !state.stalled) || this.stop()),
      listen(window, 'blur', () => this.stop()),
      listen(window, 'pagehide', () => this.stop()),
      listen(document, 'visibilitychange', () => document.hidden && this.stop()),
    ];
  }

  // Hold an input; `source` identifies it: a key, a button or a joystick.
  hold(source, {x = 0, y = 0, turn = 0}) {
    const idle = !this._held.size;
    this._held.set(source, {x, y, turn});
    if (idle) {
      clearInterval(this._timer);
      this._timer = setInterval(() => this._send(), PERIOD);
    }
    this._send();
  }

  release(source) {
    if (this._held.delete(source)) this._held.size ? this._send() : this.stop();
  }

  // Release all inputs, and stop the vehicle if this page has moved it.
  stop() {
    clearInterval(this._timer);
    this._held.clear();
    this._onChange({x: 0, y: 0, turn: 0});
    if (this._moving) {
      this._ros.publish(this._moving, TWIST, twist(0, 0, 0));
      this._moving = '';
    }
  }

  // Always send a zero velocity: the Stop button must also stop a vehicle that another program moves.
  halt() {
    this._moving = this._topic();
    this.stop();
  }

  get topic() {
    return this._topic();
  }

  // Whether this page drives, or has just stopped.
  get drives() {
    return performance.now() - this._drove < LATELY;
  }

  get held() {
    const sum = {x: 0, y: 0, turn: 0};
    for (const input of this._held.values()) for (const key of Object.keys(sum)) sum[key] += input[key];
    for (const key of Object.keys(sum)) sum[key] = Math.max(-1, Math.min(1, sum[key]));
    return sum;
  }

  close() {
    this.stop();
    for (const end of this._ends) end();
  }

  _send() {
    if (this._ros.state.stalled) return;  // it would come late
    const topic = this._topic();
    if (this._moving && this._moving !== topic) {
      this._ros.publish(this._moving, TWIST, twist(0, 0, 0));
      this._moving = '';
    }
    const {x, y, turn} = this.held;
    this._onChange({x, y, turn});
    const {linear, angular} = this.limits;
    if (topic && this._ros.publish(topic, TWIST, twist(x * linear, y * linear, turn * angular))) {
      this._moving = topic;
      this._drove = performance.now();
    }
  }
}

// Says who else drives the vehicle of a driver, each time that `check()` is called.
export class OtherDrivers {
  constructor(driver, {ros, rosapi}) {
    this._driver = driver;
    this._ros = ros;
    this._rosapi = rosapi;
    this.element = el('p', {class: 'others', role: 'status', hidden: true});
  }

  async check() {
    const {topic, drives} = this._driver;
    const nodes = topic ? (await this._rosapi.publishers(topic)).filter((node) => node !== this._ros.node) : [];
    const text = othersText(topic, nodes, (this._ros.driving[topic] ?? 0) - (drives ? 1 : 0));
    if (this.element.textContent !== text) this.element.textContent = text;
    this.element.hidden = !text;
  }
}

// Return the sentences about `nodes` that publish on a topic, and about a number of other `pages` that drive.
export function othersText(topic, nodes, pages) {
  const texts = [];
  if (nodes.length) texts.push(`${nodes.join(', ')} ${nodes.length > 1 ? 'publish' : 'publishes'} on ${topic}, too.`);
  if (pages > 0) texts.push(pages > 1 ? `${pages} other pages drive now.` : 'Another page drives now.');
  return texts.join(' ');
}

function twist(x, y, turn) {
  return {linear: {x, y, z: 0}, angular: {x: 0, y: 0, z: turn}};
}

function listen(target, event, listener) {
  target.addEventListener(event, listener);
  return () => target.removeEventListener(event, listener);
}

// Drive with keyboard and gamepad; `sideways`: also to the side. Return a function that ends it.
export function driveByHand(driver, options) {
  const ends = [driveByKeys, driveByGamepad].map((drive) => drive(driver, options));
  return () => ends.forEach((end) => end());
}

// Drive with the keyboard unless a field has the focus; `sideways`: Q and E, too.
function driveByKeys(driver, {sideways = false} = {}) {
  const used = (event) => {
    const name = KEYS[event.code];
    const field = event.target.closest?.('input:not([type=checkbox], [type=radio]), select, textarea, [contenteditable]');
    const other = event.ctrlKey || event.altKey || event.metaKey;
    return name && !field && !other && (sideways || !name.startsWith('strafe')) ? name : null;
  };
  const down = (event) => {
    if (event.code === 'Space' && !event.target.closest?.('button, input, select, textarea, summary, a')) {
      event.preventDefault();
      driver.halt();
    }
    const name = used(event);
    if (!name) return;
    event.preventDefault();
    if (!event.repeat) driver.hold(`key ${event.code}`, DIRECTIONS[name]);
  };
  const ends = [listen(document, 'keydown', down),
    listen(document, 'keyup', (event) => driver.release(`key ${event.code}`))];
  return () => ends.forEach((end) => end());
}

// Drive with the first gamepad while the page has the focus.
function driveByGamepad(driver, {sideways = false} = {}) {
  let held = false;
  const poll = () => {
    const pad = document.hasFocus() ? [...navigator.getGamepads()].find((gamepad) => gamepad?.connected) : null;
    const input = pad ? gamepadInput(pad, sideways) : null;
    if (pad && pad.buttons[1]?.pressed) driver.halt();
    if (input) driver.hold('gamepad', input);
    else if (held) driver.release('gamepad');
    held = Boolean(input);
  };
  const timer = setInterval(poll, PERIOD);
  return () => {
    clearInterval(timer);
    if (held) driver.release('gamepad');
  };
}

// Return the held input {x, y, turn} of a gamepad, null in the middle: the left stick drives; the right one turns if the left
// one drives `sideways`.
export function gamepadInput({axes, buttons}, sideways) {
  const [left, up, right] = [0, 1, 2].map((axis) => 0 - dead(axes[axis] || 0)); // right and down are positive
  const input = sideways ? {x: up, y: left, turn: right} : {x: up, y: 0, turn: left};
  return buttons[1]?.pressed || !(input.x || input.y || input.turn) ? null : input;
}

// Return buttons that drive while they are held. `names`: keys of DIRECTIONS with their texts, null for a gap;
// `announce(text)` tells a screen reader the effect of a click.
export function driveButtons(driver, rows, announce) {
  const stop = el('button', {type: 'button', class: 'danger stop', on: {click: () => {
    driver.halt();
    announce('Stopped');
  }}}, 'Stop');
  return el('div', {class: 'pad', role: 'group', 'aria-label': 'Drive'}, rows.flat().map((cell) => {
    if (cell === null) return el('span');
    return cell === 'stop' ? stop : holdButton(driver, ...cell, announce);
  }));
}

function holdButton(driver, name, sign, text, announce) {
  const source = `button ${name}`;
  let held = false;
  let keyed = false;  // a key press was handled; ignore the click that it causes
  const hold = () => {
    held = true;
    driver.hold(source, DIRECTIONS[name]);
  };
  const release = () => {
    held = false;
    driver.release(source);
  };
  return el('button', {type: 'button', 'aria-label': text, title: text, on: {
    pointerdown: (event) => {
      if (event.button) return;
      event.currentTarget.setPointerCapture(event.pointerId);
      hold();
    },
    pointerup: release, pointercancel: release, lostpointercapture: release, blur: release,
    contextmenu: (event) => event.preventDefault(),
    keydown: (event) => {
      if ((event.key === 'Enter' || event.key === ' ') && !event.repeat) {
        keyed = true;
        hold();
      }
    },
    keyup: release,
    click: (event) => {
      const done = event.detail || held || keyed;
      keyed = false;
      if (done) return;
      hold();
      setTimeout(release, PULSE);
      announce(`${text} for ${PULSE / 1000} seconds`);
    },
  }}, el('span', {'aria-hidden': 'true'}, sign));
}

// Return a joystick for fingers and mouse. `axes(x, y)` maps its position, right and up -1 to 1, to the held input.
export function joystick(driver, name, axes, label) {
  const knob = el('div', {class: 'knob'});
  const stick = el('div', {class: 'joystick', 'aria-hidden': 'true'}, knob, el('span', {}, label));
  let pointer = null;
  const move = (event) => {
    if (event.pointerId !== pointer) return;
    const box = stick.getBoundingClientRect();
    const reach = box.width / 2 - knob.offsetWidth / 4;
    let x = (event.clientX - box.left - box.width / 2) / reach;
    let y = (box.top + box.height / 2 - event.clientY) / reach;
    const far = Math.max(1, Math.hypot(x, y));
    x /= far;
    y /= far;
    knob.style.transform = `translate(${x * reach}px, ${-y * reach}px)`;
    driver.hold(`stick ${name}`, axes(dead(x), dead(y)));
  };
  const release = (event) => {
    if (event.pointerId !== pointer) return;
    pointer = null;
    knob.style.transform = '';
    driver.release(`stick ${name}`);
  };
  for (const [event, listener] of Object.entries({
    pointerdown: (start) => {
      if (pointer !== null) return;
      start.preventDefault();
      pointer = start.pointerId;
      stick.setPointerCapture(pointer);
      move(start);
    },
    pointermove: move, pointerup: release, pointercancel: release, lostpointercapture: release,
  })) stick.addEventListener(event, listener);
  return stick;
}

// Return a stick's position with a dead zone of a tenth around the middle of each axis.
function dead(value) {
  return Math.abs(value) < 0.1 ? 0 : (value - Math.sign(value) * 0.1) / 0.9;
}

// Return a slider for one of the driver's limits.
export function limitSlider(driver, key, text, unit, max, step) {
  const shown = el('span', {class: 'number'});  // an output element would take the slider's label
  const show = () => { shown.textContent = `${driver.limits[key].toFixed(1)} ${unit}`; };
  const slider = el('input', {type: 'range', min: step, max, step, value: driver.limits[key], on: {input: () => {
    driver.limits[key] = Number(slider.value);
    show();
  }}});
  show();
  return el('label', {class: 'field limit'}, el('span', {class: 'row'}, el('span', {class: 'grow'}, text), shown), slider);
}
