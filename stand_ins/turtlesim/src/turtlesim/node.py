"""The node turtlesim_node: turtlesim's interface on a SharedWorld, stepped by a SimulatorClock.

Threading contract: the main thread steps and publishes; services and subscribers run in rospy's threads and
reach the world through SharedWorld's lock; ``_interfaces_lock`` orders spawn, kill and reset, which talk to the
master; pictures are made by a thread of their own (picture.py).
"""
import math
import threading

import rosgraph
import rospy
from std_srvs.srv import Empty, EmptyResponse

from kinematic_core.turtle_world import ARENA_SIZE, BACKGROUND, DT, START, random_start
from kinematic_ros import params, reachability, recording, registration
from kinematic_ros.clock import SimulatorClock, init_simulator
from turtlesim.names import check_turtle_name
from turtlesim.picture import PictureServer
from turtlesim.shared_world import SharedWorld
from turtlesim.srv import Kill, KillResponse, Spawn, SpawnResponse
from turtlesim.turtle_interface import TurtleInterface

FIRST = 'turtle1'


class TurtlesimNode:
    """turtlesim's node, with turtle1."""

    def __init__(self):
        """Read the parameters and register everything; ``init_simulator`` has been called."""
        self._clock = SimulatorClock(DT)
        self._background = BACKGROUND
        self._set_background()
        self._shared = SharedWorld(self._initial_background(), _start())
        self._record()
        self._interfaces = {}
        self._interfaces_lock = threading.Lock()
        self._wall_turn = 0
        rospy.loginfo('Starting turtlesim with node name %s', rospy.get_name())
        self._connect(FIRST)
        _log_spawn(FIRST, *self._shared.world.start)
        for name, service, handler in (('clear', Empty, self._clear), ('reset', Empty, self._reset),
                                       ('spawn', Spawn, self._spawn), ('kill', Kill, self._kill)):
            rospy.Service(name, service, handler)
        self._pictures = PictureServer(self._shared)
        registration.on_return(self._set_background)

    def run(self):
        """Step until shutdown."""
        try:
            self._clock.run(self._step)
        finally:
            self._shared.end_recording()
        self._pictures.close()

    def _step(self):
        readings = self._shared.step()
        at_wall = []
        for turtle, colour, wall in readings:
            interface = self._interfaces.get(turtle.name)
            if interface is not None:
                interface.publish(turtle, colour)
            if wall is not None:
                at_wall.append(wall)
        self._shared.published()
        if at_wall:
            self._warn_of_wall(at_wall)

    def _warn_of_wall(self, at_wall):
        """Warn once a step, of each turtle in turn: logging a hundred lines a step would stop the simulator."""
        self._wall_turn += 1
        rospy.logwarn('Oh no! I hit the wall! (Clamping from [x=%f, y=%f])', *at_wall[self._wall_turn % len(at_wall)])

    def _record(self):
        recording.begin(lambda path: self._shared.record(path, self._background))

    def _clear(self, request):
        background = self._read_background()
        rospy.loginfo('Clearing turtlesim.')
        with self._shared.lock:
            self._shared.canvas.fill(background)
            self._shared.note('clear', *background, request=request)
        return EmptyResponse()

    def _reset(self, request):
        background = self._read_background()
        rospy.loginfo('Resetting turtlesim.')
        with self._interfaces_lock:
            _require_master(FIRST)
            for name in set(self._interfaces) - {FIRST}:
                self._interfaces.pop(name).shutdown()
            with self._shared.lock:
                self._shared.reset(background)
                self._shared.note('reset', *background, request=request)
            if FIRST not in self._interfaces:
                self._connect(FIRST)
        _log_spawn(FIRST, *self._shared.world.start)
        return EmptyResponse()

    def _spawn(self, request):
        namespace = rospy.get_namespace()
        with self._interfaces_lock:
            with self._shared.change() as world:
                # /turtle2 means the same as turtle2 in the namespace /
                taken = {name[len(namespace):] for name in world.turtles if name.startswith(namespace)}
                check_turtle_name(request.name or world.next_name(taken), world.turtles)
                name = world.spawn(request.x, request.y, request.theta, request.name, taken)
                self._shared.note('spawn', request.x, request.y, request.theta, turtle=name, request=request)
            try:
                self._connect(name)
            except Exception:
                with self._shared.change() as world:
                    world.kill(name)
                    self._shared.note('kill', turtle=name)
                raise
        _log_spawn(name, request.x, request.y, request.theta)
        return SpawnResponse(name)

    def _kill(self, request):
        with self._interfaces_lock:
            with self._shared.change() as world:
                world.kill(request.name)
                self._shared.note('kill', turtle=request.name, request=request)
            self._interfaces.pop(request.name).shutdown()
        return KillResponse()

    def _read_background(self):
        """Return the colour that the private parameters ask for; a bad one fails the service call."""
        try:
            self._background = tuple(params.integer(f'~background_{channel}', default, 0, 255)
                                     for channel, default in zip('rgb', BACKGROUND))
            return self._background
        except params.MasterAway:
            return self._background  # there is nobody to have set another one
        except params.ParameterError as error:
            rospy.logerr('%s', error)
            raise rospy.ServiceException(str(error)) from None

    def _set_background(self):
        """Set the parameters that are absent: at the start, and on a new master, which has none."""
        for channel, value in zip('rgb', self._background):
            if not rospy.has_param(f'~background_{channel}'):
                rospy.set_param(f'~background_{channel}', value)

    def _initial_background(self):
        try:
            return self._read_background()
        except rospy.ServiceException:
            rospy.logwarn('Going on with the background %s until the parameter is right and clear is called.',
                          BACKGROUND)
            return BACKGROUND

    def _connect(self, name):
        """Give a turtle its topics and services; they exist when this returns."""
        _require_master(name)
        self._interfaces[name] = TurtleInterface(name, self._shared)


def _require_master(name):
    """Fail the service call when nothing can be registered: rospy would wait, and with it every later call."""
    if not rosgraph.is_master_online():
        raise rospy.ServiceException(f'the turtle {name!r} cannot be registered: no ROS master answers at '
                                     f'{rosgraph.get_master_uri()}; start roscore and call again')


def _start():
    """Return where turtle1 begins: in the middle like the original, where ~seed draws it, or where ~start says."""
    seed = params.integer('~seed', 0, 0)
    start = params.numbers('~start', list(random_start(seed) if seed else START), length=3, unit='m, m, rad')
    if not (0.0 <= start[0] <= ARENA_SIZE and 0.0 <= start[1] <= ARENA_SIZE and abs(start[2]) <= math.pi):
        raise params.ParameterError(f'parameter {rospy.resolve_name("~start")} is {start}; it must be x, y from 0 to '
                                    f'{ARENA_SIZE:.4f} m and a heading from -pi to pi')
    return tuple(start)


def _log_spawn(name, x, y, theta):
    rospy.loginfo('Spawning turtle [%s] at x=[%f], y=[%f], theta=[%f]', name, x, y, theta)


def main():
    """Run turtlesim_node."""
    init_simulator('turtlesim')
    reachability.watch()
    TurtlesimNode().run()
