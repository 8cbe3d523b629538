// The Robotont from above, with what it sees; driving it.

import {Caller} from '../app/calls.js';
import {el, emptyState, fill, styleSheet} from '../app/dom.js';
import {Driver, OtherDrivers, driveButtons, driveByHand, joystick, limitSlider} from '../app/drive.js';
import {Frames, planar, scanPoints} from '../app/frames.js';
import {WorldMap} from '../app/map.js';
import {Panel} from '../app/scope.js';
import {SimulationCard} from '../app/simulation.js';
import {Video} from '../app/video.js';

styleSheet('panels/robot.css');

const POLL_INTERVAL = 2;    // [s] between two searches for robots
const SHOW = 100;           // [ms] between two changes of the numbers
const SEEN = 500;           // [ms] that a marker is shown after it was seen
const SCANS = 10;           // [Hz]
const IMAGE_WIDTH = 640;    // [px]
const BUTTONS = [
  [['left', '⟲', 'Turn left'], ['forward', '▲', 'Forward'], ['right', '⟳', 'Turn right']],
  [['strafeLeft', '◀', 'Sideways to the left'], 'stop', ['strafeRight', '▶', 'Sideways to the right']],
  [null, ['back', '▼', 'Back'], null],
];

export const help = [
  'Drive with the arrow keys or W, A, S, D; Q and E drive sideways, Space stops. On a phone, use both round sticks at once.',
  'The map shows the robot, its path, what the laser scanner measures and the markers that the tracker sees (green). If the '
    + 'odometry differs from the true pose, it is shown in orange.',
  'Drag a marker (red) to move it.',
  'Drag the map to move it, use the wheel or the buttons to zoom. After “Place the robot”, click where it should be, and drag '
    + 'to where it should look.',
];

export default class RobotPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._element = element;
    this._caller = new Caller(context);
    this._robots = [];      // namespaces, as / or /robot1/
    this._robot = undefined;  // null: none; undefined: not known yet
    this._ends = [];        // of the subscriptions of this robot
    this._images = '';
    this._shown = 0;
    this._frames = new Frames(context.ros);
    this._map = new WorldMap('The world of the Robotont from above', (pose) => this._setPose(pose), (panel) => this._move(panel));
    this._driver = new Driver(context.ros, () => (this._robot ? `${this._robot}cmd_vel` : ''),
      {linear: 0.5, angular: 1.5}, (held) => this._driving(held));
    this._others = new OtherDrivers(this._driver, context);
    if (context.keys) this.scope.add(driveByHand(this._driver, {sideways: true}));
    this._build();
    this.scope.add(context.ros.onState((state) => {
      if (!state.master || !state.server) this._setRobots([], []);
      this._showImage();
    }));
    this._search = this.scope.every(POLL_INTERVAL, () => this._poll(), console.warn);
    this.scope.listen(document, 'visibilitychange', () => this._showImage());
  }

  close() {
    super.close();
    clearInterval(this._forget);
    this._unfollow();
    this._driver.close();
    this._map.close();
    this._frames.close();
    this._video.stop();
  }

  // -------------------------------------------------------------------------------------------- which robot

  async _poll() {
    const {rosapi} = this.context;
    const topics = await rosapi.topics();
    const odometry = topics.filter(({name, type}) => type === 'nav_msgs/Odometry' && name.endsWith('/odom')).map(({name}) => name);
    const publishers = await Promise.all(odometry.map((topic) => rosapi.publishers(topic)));
    const robots = odometry.filter((_, index) => publishers[index].length).map((topic) => topic.slice(0, -'odom'.length));
    this._setRobots(robots, topics);
    const images = topics.filter(({type}) => type === 'sensor_msgs/Image').map(({name}) => name);
    const shown = await Promise.all(images.map((topic) => rosapi.publishers(topic)));
    const published = images.filter((_, index) => shown[index].length);
    const own = published.filter((topic) => topic.startsWith(this._robot));
    this._setImages(own.length ? own : published);
    await this._others.check();
  }

  _setRobots(robots, topics) {
    if (String(robots) !== String(this._robots)) {
      this._robots = robots;
      fill(this._choice, robots.map((name) => el('option', {value: name}, name)));
      this._choice.hidden = robots.length < 2;
    }
    const requested = this.context.parameters.robot;
    const robot = robots.includes(requested) ? requested : robots.includes(this._robot) ? this._robot : robots[0] ?? null;
    this._choice.value = robot ?? '';
    const has = (name) => topics.some((topic) => topic.name === `${robot}${name}`);
    const simulated = has('robotont_gazebo/ground_truth');
    if (robot !== this._robot || simulated !== this._simulated) this._follow(robot, simulated);
  }

  _unfollow() {
    for (const end of this._ends) end();
    this._ends = [];
    this._simulation.follow('');
  }

  _follow(robot, simulated) {
    this._driver.stop();
    this._unfollow();
    this._robot = robot;
    this._simulated = simulated;
    this._map.clear();
    this._map.setWorld(null);
    if (robot === null) {
      this._showNothing();
      return;
    }
    const {ros} = this.context;
    const subscribe = (name, type, callback, options) => this._ends.push(ros.subscribe(`${robot}${name}`, type, callback, options));
    subscribe('odom', 'nav_msgs/Odometry', (message) => this._takeOdometry(message), {rate: 30});
    if (simulated) {
      subscribe('robotont_gazebo/ground_truth', 'nav_msgs/Odometry', (message) => this._takePose(message), {rate: 30});
      subscribe('robotont_gazebo/world', 'std_msgs/String', ({data}) => this._map.setWorld(parsed(data)));
    }
    subscribe('scan', 'sensor_msgs/LaserScan', (message) => this._takeScan(message), {rate: SCANS});
    subscribe('ar_pose_marker', 'ar_track_alvar_msgs/AlvarMarkers', (message) => this._takeMarkers(message), {rate: 30});
    if (simulated) this._simulation.follow(`${robot}robotont_gazebo`);
    this._simulation.element.hidden = this._placeButton.hidden = !simulated;
    fill(this._element, this._view);
    this._map.redraw();
  }

  _showNothing() {
    fill(this._element, emptyState('No Robotont is running.',
      'Start a simulated one in a terminal; it then appears here by itself. The second line has a laser scanner instead of a camera:',
      'roslaunch robotont_gazebo world_minimaze_ar.launch',
      'roslaunch robotont_gazebo world_minimaze.launch model:=robotont_gazebo_lidar'));
  }

  // -------------------------------------------------------------------------------------------- messages

  _takePose({pose: {pose}}) {
    this._map.setRobot(planar(pose));
    this._showNumbers();
  }

  _takeOdometry(message) {
    if (this._simulated) this._map.setOdometry(planar(message.pose.pose));
    else this._takePose(message);
  }

  _takeScan(scan) {
    this._map.scan = scanPoints(scan).map((point) => this._frames.toRobot(scan.header.frame_id, point));
    this._map.draw();
  }

  _takeMarkers({markers}) {
    const now = performance.now();
    const seen = markers.map(({id, header, pose: {pose: {position}}}) => ({
      id, time: now, ...this._frames.toRobot(header.frame_id, position)}));
    const ids = new Set(seen.map(({id}) => id));
    this._map.seen = [...this._map.seen.filter(({id, time}) => !ids.has(id) && now - time < SEEN), ...seen];
    this._map.draw();
  }

  _forgetMarkers() {
    const now = performance.now();
    const still = this._map.seen.filter(({time}) => now - time < SEEN);
    if (still.length !== this._map.seen.length) {
      this._map.seen = still;
      this._map.draw();
    }
  }

  _showNumbers() {
    const now = performance.now();
    if (now < this._shown + SHOW) return;
    this._shown = now;
    for (const [index, key] of ['x', 'y', 'yaw'].entries()) this._numbers[index].textContent = this._map.robot[key].toFixed(2);
  }

  // -------------------------------------------------------------------------------------------- what it looks like

  _build() {
    this._choice = el('select', {'aria-label': 'Robot', hidden: true, on: {change: () => {
      this.context.setParameters({robot: this._choice.value});
      this._search();
    }}});
    this._placeButton = el('button', {type: 'button', 'aria-pressed': 'false', on: {click: () => this._setPlacing(!this._map.placing)}}, 'Place the robot');
    const forget = el('button', {type: 'button', on: {click: () => {
      this._map.path = [];
      this._map.odometryPath = [];
      this._map.draw();
    }}}, 'Clear the path');
    const cards = [this._cameraCard(), this._driveCard(), this._simulationCard()];
    this._map.element.append(this._simulation.badge);
    this._view = el('div', {class: 'robot'},
      el('div', {class: 'view'}, el('div', {class: 'row'}, this._choice, this._placeButton, forget), this._map.element, this._caller.element),
      el('div', {class: 'stack'}, cards));
    this._forget = setInterval(() => this._forgetMarkers(), SEEN / 2);
  }

  _driveCard() {
    const texts = ['x [m]', 'y [m]', 'yaw [rad]'];
    this._numbers = texts.map(() => el('dd', {class: 'number'}, '–'));
    return el('section', {class: 'card drive', 'aria-label': 'Drive'}, el('h2', {}, 'Drive'),
      el('dl', {class: 'pose'}, this._numbers.map((number, index) => el('div', {}, el('dt', {}, texts[index]), number))),
      this._others.element,
      el('div', {class: 'controls'},
        joystick(this._driver, 'move', (x, y) => ({x: y, y: -x}), 'move'),
        joystick(this._driver, 'turn', (x) => ({turn: -x}), 'turn'),
        driveButtons(this._driver, BUTTONS, this.context.announce)),
      limitSlider(this._driver, 'linear', 'Speed', 'm/s', 1.5, 0.1),
      limitSlider(this._driver, 'angular', 'Turn', 'rad/s', 4, 0.1));
  }

  _cameraCard() {
    this._image = el('img', {alt: 'The image of the camera'});
    this._video = new Video(this._image);
    this._image.addEventListener('error', () => setTimeout(() => this._showImage(true), 1000 * POLL_INTERVAL));
    this._imageChoice = el('select', {'aria-label': 'Image', on: {change: () => {
      this.context.setParameters({image: this._imageChoice.value});
      this._showImage();
    }}});
    this._camera = el('details', {class: 'card camera', open: true, hidden: true, on: {toggle: () => this._showImage()}},
      el('summary', {}, 'Camera'), this._image, this._imageChoice);
    return this._camera;
  }

  _simulationCard() {
    this._simulation = new SimulationCard(this.context.ros,
      (name, args) => this._caller.call(`${this._robot}robotont_gazebo/${name}`, args));
    return this._simulation.element;
  }

  _setImages(topics) {
    const sorted = [...topics.filter((name) => name.endsWith('/debug_image')), ...topics.filter((name) => name.includes('/color/')),
      ...topics.filter((name) => !name.includes('/color/') && !name.endsWith('/debug_image') && !name.includes('turtlesim'))];
    if (String(sorted) === this._images) return;
    this._images = String(sorted);
    const before = this.context.parameters.image || this._imageChoice.value;
    fill(this._imageChoice, sorted.map((name) => el('option', {value: name}, name.endsWith('/debug_image') ? `${name} (what the tracker finds)` : name)));
    this._imageChoice.value = sorted.includes(before) ? before : sorted[0] ?? '';
    this._camera.hidden = !sorted.length;
    this._showImage();
  }

  // Show the chosen image while somebody can see it; a hidden stream would occupy a connection of the browser.
  _showImage(again = false) {
    const topic = this._camera.open && !document.hidden && this.context.ros.connected ? this._imageChoice.value : '';
    if (!topic) {
      this._video.stop();
      this._streamed = '';
    } else if (topic !== this._streamed || again) {
      this._streamed = topic;
      this._video.show({topic, type: 'mjpeg', quality: 70, width: IMAGE_WIDTH, time: Date.now()});
    }
  }

  // -------------------------------------------------------------------------------------------- what it does

  _setPlacing(placing) {
    this._map.placing = placing;
    this._map.element.classList.toggle('placing', placing);
    this._placeButton.setAttribute('aria-pressed', String(placing));
  }

  _setPose({x, y, yaw}) {
    this._setPlacing(false);
    this._caller.call(`${this._robot}robotont_gazebo/set_pose`, {x: round(x), y: round(y), yaw: round(yaw)});
  }

  _move({name, x, y, yaw}) {
    this._caller.call(`${this._robot}robotont_gazebo/move_marker`, {name, x: round(x), y: round(y), yaw: round(yaw, 1e4)});
  }

  _driving({x, y, turn}) {
    if (!x && !y && !turn) return;
    const {linear, angular} = this._driver.limits;
    this._caller.show(`rostopic pub -r 10 ${this._robot}cmd_vel geometry_msgs/Twist '{linear: {x: ${(x * linear).toFixed(1)}, `
      + `y: ${(y * linear).toFixed(1)}}, angular: {z: ${(turn * angular).toFixed(1)}}}'`);
  }
}

function round(value, parts = 100) {
  return Math.round(value * parts) / parts;
}

// Return the world in a JSON text; an empty one if the text is invalid.
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}
