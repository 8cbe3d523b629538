// turtlesim: its canvas with the turtles, and everything that its services do.

import {Caller} from '../app/calls.js';
import {el, emptyState, fill} from '../app/dom.js';
import {Drawing} from '../app/drawing.js';
import {Driver, OtherDrivers, driveButtons, driveByHand, joystick, limitSlider} from '../app/drive.js';
import {Panel} from '../app/scope.js';
import {SimulationCard, wide} from '../app/simulation.js';

const POLL_INTERVAL = 2;  // [s] between two searches for simulators
const SHOW = 100;         // [ms] between two changes of the numbers
const PENS = ['#b3b8ff', '#ffffff', '#000000', '#ff5252', '#ffd740', '#69f0ae'];
const BUTTONS = [
  [null, ['forward', '▲', 'Forward'], null],
  [['left', '⟲', 'Turn left'], 'stop', ['right', '⟳', 'Turn right']],
  [null, ['back', '▼', 'Back'], null],
];

export const help = [
  'Drive the chosen turtle with the arrow keys or W, A, S, D, with the buttons, or with the round stick. Space stops it.',
  'Choose what a click on the canvas does above it: choose a turtle, move it there, or spawn a new one. Drag to turn it.',
  'Below the canvas is the command that does the same in a terminal.',
];

export default class TurtlePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._element = element;
    this._caller = new Caller(context);
    this._node = '';
    this._nodes = [];
    this._turtle = context.parameters.turtle || 'turtle1';
    this._tool = 'select';
    this._shown = 0;
    this._drawing = new Drawing(context.ros, 'The canvas of turtlesim', (turtles) => this._update(turtles));
    this._driver = new Driver(context.ros, () => (this._find() ? this._topic('cmd_vel') : ''),
      {linear: 2, angular: 2}, (held) => this._driving(held));
    this._others = new OtherDrivers(this._driver, context);
    if (context.keys) this.scope.add(driveByHand(this._driver));
    this._build();
    this._follow(context.parameters.node || '/turtlesim');  // usually it runs, and is shown at once
    this.scope.add(context.ros.onState((state) => {
      if (!state.master || !state.server) this._setNodes([]);
    }));
    this.scope.every(POLL_INTERVAL, () => this._poll(), console.warn);
  }

  close() {
    super.close();
    this._driver.close();
    this._drawing.close();
    this._simulation.follow('');
  }

  // -------------------------------------------------------------------------------------------- which simulator

  async _poll() {
    const {rosapi} = this.context;
    const topics = await rosapi.topicsOfType('turtlesim/Drawing');
    const publishers = await Promise.all(topics.map((topic) => rosapi.publishers(topic)));
    this._setNodes(topics.filter((_, index) => publishers[index].length).map((topic) => topic.replace(/\/drawing$/, '')));
    await this._others.check();
  }

  _setNodes(nodes) {
    if (String(nodes) !== String(this._nodes)) {
      this._nodes = nodes;
      fill(this._choice, nodes.map((node) => el('option', {value: node}, node)));
      this._choice.hidden = nodes.length < 2;
    }
    const requested = this.context.parameters.node;
    const node = nodes.includes(requested) ? requested : nodes.includes(this._node) ? this._node : nodes[0] || '';
    this._choice.value = node;
    if (node !== this._node) this._follow(node);
  }

  _follow(node) {
    this._node = node;
    this._drawing.follow(node);
    this._simulation.follow(node);
    if (node) {
      fill(this._element, this._view);
      this._drawing.draw();
    } else {
      this._showNothing();
    }
  }

  _showNothing() {
    fill(this._element, emptyState('No turtlesim is running.',
      'Start one in a terminal; the turtle then appears here by itself:',
      'rosrun turtlesim turtlesim_node', 'roslaunch turtle_robotont turtlesim.launch'));
  }

  // Return a name such as `spawn` with the simulator's namespace in front.
  _name(name) {
    return name.startsWith('/') ? name : `${this._node.replace(/[^/]*$/, '')}${name}`;
  }

  _topic(name) {
    return this._name(`${this._turtle}/${name}`);
  }

  _find() {
    return this._drawing.turtles.find((turtle) => turtle.name === this._turtle);
  }

  // -------------------------------------------------------------------------------------------- what it looks like

  _build() {
    this._choice = el('select', {'aria-label': 'Simulator', hidden: true, on: {change: () => {
      this.context.setParameters({node: this._choice.value});
      this._setNodes(this._nodes);
    }}});
    this._drawing.element.classList.add('select');
    this._view = el('div', {class: 'turtle'},
      el('div', {class: 'view'}, el('div', {class: 'toolbar'}, this._choice, this._tools()), this._drawing.element, this._caller.element),
      el('div', {class: 'stack'}, this._driveCard(), this._simulationCard(), this._penCard(), this._placeCard()));
    this._listenToPointer();
  }

  _tools() {
    const buttons = [['select', 'Choose'], ['teleport', 'Move'], ['spawn', 'Spawn']].map(([tool, text]) => el('button', {
      type: 'button', 'aria-pressed': String(tool === this._tool), on: {click: () => {
        this._tool = tool;
        for (const [index, button] of buttons.entries()) {
          button.setAttribute('aria-pressed', String(['select', 'teleport', 'spawn'][index] === tool));
        }
        this._drawing.element.classList.toggle('select', tool === 'select');
      }}}, text));
    return el('div', {class: 'row', role: 'group', 'aria-label': 'Effect of a click on the canvas'},
      el('span', {class: 'muted small'}, 'A click:'), buttons);
  }

  _driveCard() {
    this._turtles = el('select', {'aria-label': 'Turtle', class: 'grow', on: {change: () => this._choose(this._turtles.value)}});
    this._numbers = ['x', 'y', 'theta'].map(() => el('dd', {class: 'number'}, '–'));
    const texts = ['x [m]', 'y [m]', 'θ [rad]'];
    return el('section', {class: 'card drive', 'aria-label': 'Drive'},
      el('div', {class: 'toolbar'}, el('h2', {}, 'Drive'), this._turtles),
      el('dl', {class: 'pose'}, this._numbers.map((number, index) => el('div', {}, el('dt', {}, texts[index]), number))),
      this._others.element,
      el('div', {class: 'controls'}, driveButtons(this._driver, BUTTONS, this.context.announce),
        joystick(this._driver, 'drive', (x, y) => ({x: y, turn: -x}), 'drive')),
      limitSlider(this._driver, 'linear', 'Speed', 'm/s', 5, 0.1),
      limitSlider(this._driver, 'angular', 'Turn', 'rad/s', 6, 0.1));
  }

  _simulationCard() {
    this._simulation = new SimulationCard(this.context.ros, (name, args) => this._call(name, args, true),
      this._button('Clear', () => this._call('clear')), this._button('Reset', () => this._call('reset')),
      this._button('Save a picture', async () => {
        const answer = await this._call('snapshot', {}, true);
        if (answer) this.context.toast(answer.success ? `Saved as ${answer.message}` : answer.message, answer.success ? 'info' : 'error');
      }));
    this._drawing.element.append(this._simulation.badge);
    return this._simulation.element;
  }

  _penCard() {
    this._colour = el('input', {type: 'color', value: PENS[0], 'aria-label': 'Colour', on: {change: () => this._setPen()}});
    this._width = el('input', {type: 'number', min: 1, max: 255, value: 3, on: {change: () => this._setPen()}});
    this._up = el('input', {type: 'checkbox', on: {change: () => this._setPen()}});
    return el('details', {class: 'card', open: wide()}, el('summary', {}, 'Pen'),
      el('div', {class: 'row'}, this._colour, PENS.map((colour) => el('button', {
        type: 'button', class: 'swatch', 'aria-label': `Colour ${colour}`, style: {background: colour, minWidth: '28px', minHeight: '28px', padding: 0},
        on: {click: () => {
          this._colour.value = colour;
          this._setPen();
        }}}))),
      el('div', {class: 'row'}, el('label', {class: 'field', style: {width: '6em'}}, 'Width [px]', this._width),
        el('label', {class: 'check'}, this._up, 'Pen up')));
  }

  _placeCard() {
    const field = (max, value) => el('input', {type: 'number', step: 'any', min: max === Math.PI ? -7 : 0, max, value});
    const [x, y, theta] = [field(11.09, 5.5), field(11.09, 5.5), field(7, 0)];
    const name = el('input', {type: 'text', autocomplete: 'off', placeholder: 'next number', maxLength: 200});
    const pose = () => ({x: Number(x.value), y: Number(y.value), theta: Number(theta.value)});
    return el('details', {class: 'card', open: wide()}, el('summary', {}, 'Place'),
      el('div', {class: 'stack'},
        el('div', {class: 'fields'}, el('label', {class: 'field'}, 'x [m]', x), el('label', {class: 'field'}, 'y [m]', y),
          el('label', {class: 'field'}, 'θ [rad]', theta)),
        el('div', {class: 'row'}, this._button('Move', () => this._teleport(pose())),
          this._button('Kill', () => this._call('kill', {name: this._turtle}))),
        el('div', {class: 'row'}, el('label', {class: 'field grow'}, 'Name of a new one', name),
          this._button('Spawn', () => this._spawn({...pose(), name: name.value.trim()}), 'primary'))));
  }

  _button(text, action, kind = '') {
    return el('button', {type: 'button', class: kind, on: {click: action}}, text);
  }

  // -------------------------------------------------------------------------------------------- what it does

  // Call a service of the simulator; `own`: one of the node, such as ~pause. Return its answer, or null if it was refused.
  _call(name, args = {}, own = false) {
    return this._caller.call(own ? `${this._node}/${name}` : this._name(name), args);
  }

  _teleport({x, y, theta}) {
    return this._call(`${this._turtle}/teleport_absolute`, {x, y, theta});
  }

  async _spawn(pose) {
    const answer = await this._call('spawn', pose);
    if (answer) this._choose(answer.name);
  }

  _setPen() {
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(this._colour.value.slice(at, at + 2), 16));
    const width = Math.max(1, Math.min(255, Math.round(Number(this._width.value)) || 1));
    return this._call(`${this._turtle}/set_pen`, {r, g, b, width, off: this._up.checked ? 1 : 0});
  }

  _choose(name) {
    this._driver.stop();
    this._turtle = name;
    this.context.setParameters({turtle: name === 'turtle1' ? '' : name});
    this._shown = 0;
    this._drawing.draw();
  }

  _driving({x, turn}) {
    if (x || turn) {
      const {linear, angular} = this._driver.limits;
      this._caller.show(`rostopic pub -r 10 ${this._topic('cmd_vel')} geometry_msgs/Twist `
        + `'{linear: {x: ${(x * linear).toFixed(1)}}, angular: {z: ${(turn * angular).toFixed(1)}}}'`);
    }
  }

  // -------------------------------------------------------------------------------------------- from the drawing

  _update(turtles) {
    const now = performance.now();
    if (now < this._shown + SHOW) {
      this._late ||= setTimeout(() => {
        this._late = 0;
        this._update(this._drawing.turtles);
      }, SHOW);
      return;
    }
    this._shown = now;
    const names = turtles.map((turtle) => turtle.name);
    if (String(names) !== this._names) {
      this._names = String(names);
      if (names.length && !names.includes(this._turtle)) this._turtle = names[0];
      fill(this._turtles, names.length ? names.map((name) => el('option', {value: name}, name)) : el('option', {}, 'no turtle'));
    }
    if (this._turtles.value !== this._turtle) this._turtles.value = this._turtle;
    this._drawing.highlight = this._turtle;
    const turtle = this._find();
    for (const [index, key] of ['x', 'y', 'theta'].entries()) {
      const text = turtle ? turtle[key].toFixed(2) : '–';
      if (this._numbers[index].textContent !== text) this._numbers[index].textContent = text;
    }
  }

  _listenToPointer() {
    const arena = this._drawing.element;
    let start = null;
    const aim = (event) => {
      const end = this._drawing.position(event);
      const far = Math.hypot(end.x - start.x, end.y - start.y) > 0.3;
      return {...start, theta: far ? Math.atan2(end.y - start.y, end.x - start.x) : start.theta};
    };
    const end = () => {
      start = this._drawing.mark = null;
      this._drawing.draw();
    };
    arena.addEventListener('pointerdown', (event) => {
      const pose = this._drawing.position(event);
      if (event.button) return;
      if (this._tool === 'select') {
        const turtle = this._drawing.turtleAt(pose);
        if (turtle) this._choose(turtle.name);
        return;
      }
      event.preventDefault();
      arena.setPointerCapture(event.pointerId);
      start = {...pose, theta: this._tool === 'teleport' ? this._find()?.theta ?? 0 : 0, image: this._find()?.image ?? 'noetic'};
      this._drawing.mark = start;
      this._drawing.draw();
    });
    arena.addEventListener('pointermove', (event) => {
      if (!start) return;
      this._drawing.mark = aim(event);
      this._drawing.draw();
    });
    arena.addEventListener('pointerup', (event) => {
      if (!start) return;
      const {x, y, theta} = aim(event);
      const pose = {x: round(x), y: round(y), theta: round(theta)};
      if (this._tool === 'teleport') this._teleport(pose);
      else this._spawn({...pose, name: ''});
      end();
    });
    arena.addEventListener('pointercancel', end);
  }
}

function round(value) {
  return Math.round(value * 100) / 100;
}
