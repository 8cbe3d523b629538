// Navigation: map, costmaps, particles, paths; where the robot is, and where it shall go.

import {el, emptyState, fill, styleSheet} from '../app/dom.js';
import {bare, planar, scanPoints, Transforms} from '../app/frames.js';
import {Panel} from '../app/scope.js';
import {NavigationMap, costColours, mapColours} from './lib/navigation_map.js';

styleSheet('panels/robot.css');

const FRAME = 'map';                  // unless the map names another one
const BASES = ['base_footprint', 'base_link'];
const REFRESH = 100;                  // [ms] between two positions of the robot
const COVARIANCE = [0.25, 0.25, 0.0685];  // of x, y [m^2] and yaw [rad^2], those of rviz: 0.5 m and 15 degrees
const LAYERS = [['map', 'Map'], ['global', 'Costmap of the map'], ['local', 'Costmap around the robot'], ['particles', 'Particles'],
  ['scan', 'Laser scan'], ['plan', 'Path to the goal'], ['local plan', 'Path of the next seconds'], ['footprint', 'Footprint']];
const TOOLS = {
  estimate: ['2D Pose Estimate', 'Drag an arrow from where the robot is to where it looks.'],
  goal: ['2D Nav Goal', 'Drag an arrow from where the robot shall go to where it shall look then.'],
};
const STATES = ['waits', 'drives', 'cancelled', 'reached', 'given up', 'refused', 'is being cancelled', 'is being recalled', 'recalled', 'lost'];

export const help = [
  'What rviz shows for mapping and navigation: the map, costmaps, the particles of amcl, the laser scan, paths, the robot and its goal.',
  '2D Pose Estimate tells amcl where the robot is, 2D Nav Goal tells move_base where to drive: press the button, then drag an arrow '
    + 'on the map.',
  'Drag the map to move it, use the wheel or the buttons to zoom.',
];

export default class MapPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._frame = FRAME;
    this._tool = '';
    this._transforms = new Transforms(context.ros);
    this._map = new NavigationMap('Map, robot and paths from above', (frame) => this._transforms.pose(frame, this._frame), (pose) => this._use(pose));
    this._build(element);
    this._subscribe();
    this._timer = setInterval(() => this._placeRobot(), REFRESH);
  }

  close() {
    super.close();
    clearInterval(this._timer);
    this._map.close();
    this._transforms.close();
  }

  _subscribe() {
    const {ros} = this.context;
    const [map, costs] = [mapColours(), costColours()];
    const line = (name, colour, closed = false) => ({header, poses, polygon}) => {
      const points = polygon ? polygon.points : poses.map(({pose}) => pose.position);
      this._map.lines.set(name, {frame: header.frame_id, points, colour, closed});
      this._map.draw();
    };
    const topics = [
      ['/map', 'nav_msgs/OccupancyGrid', (message) => this._takeGrid('map', message, map), 1],
      ['/move_base/global_costmap/costmap', 'nav_msgs/OccupancyGrid', (message) => this._takeGrid('global', message, costs), 1],
      ['/move_base/local_costmap/costmap', 'nav_msgs/OccupancyGrid', (message) => this._takeGrid('local', message, costs), 2],
      ['/particlecloud', 'geometry_msgs/PoseArray', (message) => this._takeParticles(message), 2],
      ['/scan', 'sensor_msgs/LaserScan', (message) => this._takeScan(message), 5],
      ['/move_base/NavfnROS/plan', 'nav_msgs/Path', line('plan', '--good'), 5],
      ['/move_base/GlobalPlanner/plan', 'nav_msgs/Path', line('plan', '--good'), 5],
      ['/move_base/TrajectoryPlannerROS/local_plan', 'nav_msgs/Path', line('local plan', '--accent'), 5],
      ['/move_base/DWAPlannerROS/local_plan', 'nav_msgs/Path', line('local plan', '--accent'), 5],
      ['/move_base/local_costmap/footprint', 'geometry_msgs/PolygonStamped', line('footprint', '--text', true), 5],
      ['/move_base/current_goal', 'geometry_msgs/PoseStamped', (message) => this._takeGoal(message), 0],
      ['/move_base/status', 'actionlib_msgs/GoalStatusArray', ({status_list: list}) => this._takeStatus(list), 2],
    ];
    for (const [topic, type, callback, rate] of topics) this.scope.add(ros.subscribe(topic, type, callback, {rate}));
  }

  // -------------------------------------------------------------------------------------------- messages

  _takeGrid(name, message, colours) {
    if (name === 'map') {
      this._frame = bare(message.header.frame_id) || FRAME;
      this._hint.hidden = true;
    }
    this._map.setGrid(name, message, planar(message.info.origin), colours);
  }

  _takeParticles({header, poses}) {
    this._map.cloud = {frame: header.frame_id, poses: poses.map(planar)};
    this._map.draw();
  }

  _takeScan(scan) {
    this._map.rays = {frame: scan.header.frame_id, points: scanPoints(scan)};
    this._map.draw();
  }

  _takeGoal({header, pose}) {
    this._map.goal = {frame: header.frame_id, ...planar(pose)};
    this._map.draw();
  }

  _takeStatus(list) {
    const last = list[list.length - 1];
    if (!last) return;
    const reason = last.status === 4 || last.status === 5 ? `: ${last.text}` : '';
    const text = `Goal: ${STATES[last.status] ?? last.status}${reason}`;
    if (this._status.textContent !== text) this._status.textContent = text;
    if (last.status > 1 && this._map.goal) {
      this._map.goal = null;
      this._map.draw();
    }
  }

  _placeRobot() {
    const pose = BASES.map((base) => this._transforms.pose(base, this._frame)).find(Boolean) ?? null;
    const before = this._map.robot;
    if (pose && before && pose.x === before.x && pose.y === before.y && pose.yaw === before.yaw) return;
    this._map.robot = pose;
    this._where.textContent = pose
      ? `Robot at x ${pose.x.toFixed(2)} m, y ${pose.y.toFixed(2)} m, ${(pose.yaw * 180 / Math.PI).toFixed(0)}°`
      : `Nothing says where the robot is in the frame ${this._frame}.`;
    this._map.draw();
  }

  // -------------------------------------------------------------------------------------------- what it looks like

  _build(element) {
    this._buttons = Object.entries(TOOLS).map(([name, [title, text]]) => el('button', {
      type: 'button', title: text, 'aria-pressed': 'false', dataset: {tool: name}, on: {click: () => this._take(this._tool === name ? '' : name)}}, title));
    this._where = el('p', {}, 'Nothing says yet where the robot is.');
    this._status = el('p', {role: 'status'}, 'No goal yet.');
    this._told = el('p', {}, '');
    this._hint = emptyState('There is no map yet.', 'Start a robot with a laser scanner, and make a map, or show one that you have saved:',
      'roslaunch robotont_gazebo world_minimaze.launch model:=robotont_gazebo_lidar', 'roslaunch robotont_demos gmapping.launch',
      'rosrun map_server map_server mymap.yaml');
    const layers = LAYERS.map(([name, text]) => el('label', {class: 'row'}, el('input', {type: 'checkbox', checked: true, on: {change: ({target}) => {
      if (target.checked) this._map.hidden.delete(name);
      else this._map.hidden.add(name);
      this._map.draw();
    }}}), ` ${text}`));
    fill(element, el('div', {class: 'robot'},
      el('div', {class: 'view'}, el('div', {class: 'row'}, this._buttons), this._map.element, this._told),
      el('div', {class: 'stack'}, this._hint,
        el('section', {class: 'card', 'aria-label': 'Robot'}, el('h2', {}, 'Robot'), this._where, this._status),
        el('section', {class: 'card', 'aria-label': 'Layers'}, el('h2', {}, 'Layers'), layers))));
  }

  // Take a tool into the hand; '': none.
  _take(tool) {
    this._tool = tool;
    this._map.placing = Boolean(tool);
    this._map.element.classList.toggle('placing', this._map.placing);
    for (const button of this._buttons) button.setAttribute('aria-pressed', String(button.dataset.tool === tool));
    this._told.textContent = tool ? TOOLS[tool][1] : '';
  }

  _use({x, y, yaw}) {
    const {ros, toast} = this.context;
    const header = {stamp: {secs: 0, nsecs: 0}, frame_id: this._frame};
    const pose = {position: {x, y, z: 0}, orientation: {x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2)}};
    const covariance = Array(36).fill(0);
    [0, 7, 35].forEach((entry, index) => { covariance[entry] = COVARIANCE[index]; });
    const sent = this._tool === 'goal'
      ? ros.publish('/move_base_simple/goal', 'geometry_msgs/PoseStamped', {header, pose})
      : ros.publish('/initialpose', 'geometry_msgs/PoseWithCovarianceStamped', {header, pose: {pose, covariance}});
    const name = TOOLS[this._tool][0];
    this._take('');
    if (!sent) toast('There is no connection to ROS.', 'error');
    else this._told.textContent = `${name}: x ${x.toFixed(2)} m, y ${y.toFixed(2)} m, ${(yaw * 180 / Math.PI).toFixed(0)}°`;
  }
}
