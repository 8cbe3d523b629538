// When a step of the course counts as done, judged by the graph and by poses.
import {isDebugNode} from './system.js';

const TWIST = 'geometry_msgs/Twist';
const POSE = 'turtlesim/Pose';
const ODOMETRY = 'nav_msgs/Odometry';
const MARKERS = 'AlvarMarkers'; // the message's name, the same in both packages
const NEAR = 0.15; // m between start and end of a path that is closed
const JUMP = 0.5; // m beyond what the speed explains
const STOPPED = 0.02; // m/s

// step: its sign
export const RULES = {
  1: 'a node publishes velocities for a turtle',
  2: 'a node subscribes to the pose of a turtle',
  3: 'a node that also reads the pose has driven a turtle to x = 10, where it stands',
  4: 'a node that also reads the pose has driven a turtle along a path that ends where it began',
  5: 'there is a second turtle',
  6: 'a node offers the service gotoPose',
  7: 'a turtle is put to four positions while a program runs',
  8: 'a node subscribes to the markers that the tracker finds',
  9: 'a node publishes velocities for the robot, and it moves',
  10: 'a node that also reads the odometry has driven the robot along a path that ends where it began',
  11: 'a node that also reads the markers drives the robot',
};

// Watches the system and poses; `done(number)` is called for each observed step, perhaps repeatedly.
export class Watcher {
  constructor(done) {
    this._done = done;
    this._paths = new Map(); // topic of poses: Path
    this._drivers = {turtle: [], robot: []}; // nodes that read poses and publish velocities
    this._others = [];
  }

  // Return the topics of poses: [{name, type}].
  static poseTopics(system) {
    return [...system.types].filter(([, type]) => type === POSE || type === ODOMETRY).map(([name, type]) => ({name, type}));
  }

  // Note who publishes and subscribes to what.
  update(system) {
    const typed = (type) => new Set([...system.types].filter(([, one]) => one === type).map(([name]) => name));
    const poses = typed(POSE);
    const odometry = typed(ODOMETRY);
    const turtles = new Set([...poses].map((name) => name.replace(/pose$/, 'cmd_vel')));
    const velocities = typed(TWIST);
    const markers = new Set([...system.types].filter(([, type]) => type.endsWith(`/${MARKERS}`)).map(([name]) => name));
    const nodes = [...system.nodes].filter(([name]) => !isDebugNode(name)).map(([name, node]) => ({name, ...node}));
    const simulators = nodes.filter(({publishing}) => publishing.some((name) => poses.has(name) || odometry.has(name)));
    const programs = nodes.filter((node) => !simulators.includes(node));
    const reads = (topics) => ({subscribing}) => subscribing.some((name) => topics.has(name));
    const drives = ({publishing}) => publishing.some((name) => turtles.has(name));
    const drivesRobot = ({publishing}) => odometry.size > 0 && publishing.some((name) => velocities.has(name) && !turtles.has(name));
    this._drivers = {turtle: programs.filter(drives).filter(reads(poses)), robot: programs.filter(drivesRobot).filter(reads(odometry))};
    this._others = programs;
    this._robotDriven = programs.some(drivesRobot);
    const seen = {
      1: programs.some(drives), 2: programs.some(reads(poses)), 5: poses.size > 1,
      6: nodes.some(({services}) => services.some((name) => name.endsWith('/gotoPose'))),
      8: programs.some(reads(markers)), 11: programs.some((node) => drivesRobot(node) && reads(markers)(node)),
    };
    for (const [number, yes] of Object.entries(seen)) if (yes) this._done(Number(number));
  }

  // Note a pose of a turtle, or of odometry, at a time [s].
  pose(topic, type, message, time) {
    const robot = type === ODOMETRY;
    const {x, y} = robot ? message.pose.pose.position : message;
    const speed = robot ? Math.hypot(message.twist.twist.linear.x, message.twist.twist.linear.y) : Math.abs(message.linear_velocity);
    if (![x, y, speed].every(Number.isFinite)) return;
    if (!this._paths.has(topic)) this._paths.set(topic, new Path());
    const path = this._paths.get(topic);
    const driver = this._drivers[robot ? 'robot' : 'turtle'][0];
    path.take(x, y, speed, time, driver ? driver.name : '');
    if (robot) {
      if (this._robotDriven && path.driven > 0.1) this._done(9);
      if (path.closed(1)) this._done(10);
      return;
    }
    if (path.owned > 0.5 && Math.abs(x - 10) < 0.1 && speed < STOPPED) this._done(3);
    if (path.closed(3)) this._done(4);
    if (path.jumps >= 4 && this._others.length) this._done(7);
  }
}

// The path of a vehicle since its driver appeared.
export class Path {
  constructor() {
    this.driven = 0; // m, with or without a driver
    this.jumps = 0;
    this._last = null;
    this._start = null;
    this._driver = '';
    this._area = 0; // m^2 inside the path; driving to and fro adds nothing
    this.owned = 0; // m, by the driver, which reads poses
  }

  take(x, y, speed, time, driver) {
    const last = this._last;
    this._last = {x, y, speed, time};
    if (driver !== this._driver || !this._start) {
      this._driver = driver;
      this._start = {x, y};
      this.owned = this._area = this.driven = 0;
    }
    if (!last) return;
    const step = Math.hypot(x - last.x, y - last.y);
    if (step > JUMP + 2 * Math.max(speed, last.speed) * (time - last.time)) {
      this.jumps += 1;
      this._start = {x, y};
      this.owned = this._area = this.driven = 0;
      return;
    }
    this.driven += step;
    if (driver) this.owned += step;
    this._area += ((last.x - this._start.x) * (y - this._start.y) - (x - this._start.x) * (last.y - this._start.y)) / 2;
  }

  // Return whether the driver has come back to the start after at least `length` [m], around an area.
  closed(length) {
    return this.owned >= length && Math.abs(this._area) >= (length / 8) ** 2
      && Math.hypot(this._last.x - this._start.x, this._last.y - this._start.y) < NEAR;
  }
}
