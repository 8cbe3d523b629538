"""The node turtlesim_node: turtlesim's interface on a SharedWorld, stepped by a SimulatorClock.

Threading contract: the main thread steps: it answers all services that were called since the last step, moves the
turtles and publishes (frame_services). Calls of the master for a service run in a separate thread, which changes
neither the world nor ``_interfaces``; subscribers run in rospy's threads and access the world under SharedWorld's
lock; separate threads make images and drawings (image_server.py, drawing_server.py).
"""
from __future__ import annotations

import contextlib
import gc
import math
import socket
from typing import Any, Callable, Generator, Iterable, Mapping

import rospy
from std_srvs.srv import Empty, EmptyResponse

from kinematic_core.worlds.turtle_world import ARENA_SIZE, BACKGROUND, DT, START, Colour, UnknownTurtle, random_start
from rospy_support import parameters, reachability, registration, rospy_internals
from rospy_support.master import Master, NoMaster
from rospy_support.parameters import Computed, Integer, Numbers, Table
from sim_ros import clock, recording
from sim_ros.clock import SimulatorClock, init_simulator
from sim_ros.parent_link import ParentLink
from turtlesim import image_server
from turtlesim.drawing_server import DrawingServer
from turtlesim.image_server import ImageServer
from turtlesim.names import TurtleNames
from turtlesim.shared_world import SharedWorld
from turtlesim.srv import Kill, KillResponse, Spawn, SpawnResponse
from turtlesim.turtle_interface import TurtleInterface

FIRST = 'turtle1'
FREEZE_EVERY = 50  # turtles: garbage collection takes 50 ms with a thousand turtles, so it skips older ones
BACKGROUND_PARAMETERS = [Integer(f'~background_{channel}', default, 0, 255)
                         for channel, default in zip('rgb', BACKGROUND)]
START_PARAMETER = Numbers('~start', Computed('by `~seed`'), length=3, unit='m, m, rad')
PARAMETERS = Table(*BACKGROUND_PARAMETERS, Table(clock.PARAMETERS, clock.SEED, START_PARAMETER, recording.RECORD,
                                                 image_server.PARAMETERS, run_only=True))  # the original has no such


class TurtlesimNode:
    """turtlesim's node, with turtle1."""

    def __init__(self, connection: socket.socket | None = None) -> None:
        """Read the parameters and register everything. Call ``init_simulator`` first.

        ``connection``: a socket for a ParentLink, whose commands drive turtle1.
        """
        self._parent = ParentLink(connection, self._drive) if connection else None
        self._clock = SimulatorClock(DT, self._parent)
        self._background = BACKGROUND
        self._asked_in_batch: int | None = None  # the last one in which the master was asked for the background
        self._set_background()
        self._shared = SharedWorld(self._initial_background(), _start())
        self._shared.record_if_asked()
        self._master = Master()
        self._wall_turn = 0
        for name, service, handler in (('clear', Empty, self._clear), ('reset', Empty, self._reset),
                                       ('spawn', Spawn, self._spawn), ('kill', Kill, self._kill)):
            self._clock.services.add(name, service, handler)
        rospy.loginfo('Starting turtlesim with node name %s', rospy.get_name())
        self._interfaces = {FIRST: TurtleInterface(FIRST, self._shared, self._clock.services)}
        self._names = TurtleNames([FIRST])
        _log_spawn(FIRST, *self._shared.world.start)
        self._image_server = ImageServer(self._shared)
        self._drawing_server = DrawingServer(self._shared)
        registration.on_return(self._set_background)

    def _drive(self, linear: float, angular: float) -> None:
        with contextlib.suppress(UnknownTurtle), self._shared.lock:
            self._shared.world.command(FIRST, linear, 0.0, angular)
            self._shared.note('cmd', linear, 0.0, angular, request=recording.PARENT)

    def run(self) -> None:
        try:
            self._clock.run(self._step)
        finally:
            self._shared.end_recording()
        self._image_server.close()
        self._drawing_server.close()

    def _step(self) -> None:
        readings = self._shared.step()
        if self._parent:
            self._parent.moved(self._shared.world.steps, {turtle.name: turtle.pose()[:3] for turtle, _, _ in readings})
        at_wall: list[tuple[float, float]] = []
        for turtle, colour, wall in readings:
            interface = self._interfaces.get(turtle.name)
            if interface is not None:
                interface.publish(turtle, colour)
            if wall is not None:
                at_wall.append(wall)
        if at_wall:
            self._warn_of_wall(at_wall)

    def _warn_of_wall(self, at_wall: list[tuple[float, float]]) -> None:
        """Warn once per step, for each turtle in turn: logging a hundred lines per step would stop the simulator."""
        self._wall_turn += 1
        rospy.logwarn('Oh no! I hit the wall! (Clamping from [x=%f, y=%f])', *at_wall[self._wall_turn % len(at_wall)])

    def _clear(self, request: Any) -> Generator[Callable[[], Any], Any, EmptyResponse]:
        rospy.loginfo('Clearing turtlesim.')
        background = yield self._ask_background
        with self._shared.lock:
            self._shared.drawn.canvas.fill(background)
            self._shared.note('clear', *background, request=request)
        return EmptyResponse()

    def _reset(self, request: Any) -> Generator[Callable[[], Any], Any, EmptyResponse]:
        rospy.loginfo('Resetting turtlesim.')
        first = self._interfaces.get(FIRST)  # its subscribers stay connected
        gone = [interface for interface in self._interfaces.values() if interface is not first]
        background = yield self._ask_background
        if first is None:
            same = [each for each in gone if rospy.resolve_name(each.name) == rospy.resolve_name(FIRST)]  # '/turtle1'
            if same:
                yield lambda: self._disconnect(same)
            first = yield lambda: self._connect(FIRST)
        if gone:
            yield lambda: self._disconnect(gone)
        with self._shared.lock:
            self._shared.drawn.reset(background)
            self._shared.note('reset', *background, request=request)
        self._interfaces, self._names = {FIRST: first}, TurtleNames([FIRST])
        gc.unfreeze()
        _log_spawn(FIRST, *self._shared.world.start)
        return EmptyResponse()

    def _spawn(self, request: Any) -> Generator[Callable[[], Any], Any, SpawnResponse]:
        with self._shared.change() as world:
            name = request.name or world.next_name(self._names)
            self._names.check(name)
            world.check_spawn(request.x, request.y, request.theta, name)
        interface = yield lambda: self._connect(name)
        with self._shared.lock:
            self._shared.world.spawn(request.x, request.y, request.theta, request.name, self._names)
            self._shared.note('spawn', request.x, request.y, request.theta, turtle=name, request=request)
        self._interfaces[name] = interface
        self._names.add(name)
        if len(self._interfaces) % FREEZE_EVERY == 0:
            gc.freeze()
        _log_spawn(name, request.x, request.y, request.theta)
        return SpawnResponse(name)

    def _kill(self, request: Any) -> Generator[Callable[[], Any], Any, KillResponse]:
        with self._shared.change() as world:
            world.kill(request.name)
            self._shared.note('kill', turtle=request.name, request=request)
        interface = self._interfaces.pop(request.name)
        self._names.remove(request.name)
        yield lambda: self._disconnect([interface])
        if len(self._interfaces) < FREEZE_EVERY:
            gc.unfreeze()
        return KillResponse()

    def _read_background(self, values: Mapping[str, Any] | None = None) -> Colour:
        """Return the background colour in the private parameters; an invalid one makes the service call fail.

        ``values`` are those of the parameters, if they have already been read.
        """
        try:
            self._background = tuple(parameter.read(values=values) for parameter in BACKGROUND_PARAMETERS)
            return self._background
        except parameters.MasterAway:
            return self._background  # without a master, nobody can have set another one
        except parameters.ParameterError as error:
            rospy.logerr('%s', error)
            raise rospy.ServiceException(str(error)) from None

    def _ask_background(self) -> Colour:
        """Like _read_background, but ask the master once per batch, with a time limit."""
        batch = self._clock.services.batch
        if batch != self._asked_in_batch:
            try:
                self._read_background(self._master.parameters([each.name for each in BACKGROUND_PARAMETERS]))
            except NoMaster:
                pass  # without a master, nobody can have set another one
            self._asked_in_batch = batch
        return self._background

    def _set_background(self) -> None:
        """Set the parameters that are missing: at the start, and on a restarted master, which has none."""
        for parameter, value in zip(BACKGROUND_PARAMETERS, self._background):
            if not rospy.has_param(parameter.name):
                rospy.set_param(parameter.name, value)

    def _initial_background(self) -> Colour:
        try:
            return self._read_background()
        except rospy.ServiceException:
            rospy.logwarn('Continuing with the background %s; correct the parameter, then call clear.',
                          BACKGROUND)
            return BACKGROUND

    def _connect(self, name: str) -> TurtleInterface:
        """Return a new turtle's TurtleInterface; the call fails if it cannot be registered with the master."""
        with rospy_internals.collected_registrations() as calls:
            interface = TurtleInterface(name, self._shared, self._clock.services)
        try:
            self._master.register(calls)
        except NoMaster as error:
            with rospy_internals.collected_unregistrations():
                interface.shutdown()
            raise rospy.ServiceException(f'the turtle {name!r} cannot be registered: {error}; start roscore and call '
                                         'again') from None
        return interface

    def _disconnect(self, interfaces: Iterable[TurtleInterface]) -> None:
        """Remove the interfaces of turtles that are gone, and unregister them if there is a master."""
        with rospy_internals.collected_unregistrations() as calls:
            for interface in interfaces:
                interface.shutdown()
        try:
            self._master.unregister(calls)
        except NoMaster as error:
            rospy.logwarn('%s: it may still list turtles that are gone.', error)


def _start() -> tuple[float, float, float]:
    """Return the start of turtle1: ~start, by default a random pose from ~seed, or the centre as in the original."""
    seed = clock.SEED.read()
    start = START_PARAMETER.read(list(random_start(seed) if seed else START))
    if not (0.0 <= start[0] <= ARENA_SIZE and 0.0 <= start[1] <= ARENA_SIZE and abs(start[2]) <= math.pi):
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name("~start")} is {start}; it must be x, y from 0 to '
            f'{ARENA_SIZE:.4f} m and a heading from -pi to pi')
    return tuple(start)


def _log_spawn(name: str, x: float, y: float, theta: float) -> None:
    rospy.loginfo('Spawning turtle [%s] at x=[%f], y=[%f], theta=[%f]', name, x, y, theta)


def main(connection: socket.socket | None = None) -> None:
    """Run turtlesim_node; ``connection``: that of a ParentLink."""
    init_simulator('turtlesim', PARAMETERS)
    reachability.watch()
    TurtlesimNode(connection).run()
