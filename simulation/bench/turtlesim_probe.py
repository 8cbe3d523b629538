"""Client of a turtlesim_node (see probing.py). Where rospy's threads would be slower, the connections are its own.

Poses are received as bytes (AnyMsg), so the receiver does no decoding that could delay its clock.
"""
import itertools
import random
import select
import struct
import threading
import time

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty
from turtlesim.msg import Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from figures import intervals, rate_in_window, stratified_phases
from probing import COME_UP, Silent, await_true, clock, repeat, say
from rostest_support import tcpros

POSE = struct.Struct('<5f')  # x, y, theta, linear_velocity, angular_velocity
FRAME = 4 + POSE.size  # [bytes] of a pose on its connection
TICK = 0.016  # [s] turtlesim's
ONE_ANSWER = 2.0  # [s] for a command to show
DRIVE_PERIOD = 0.5  # [s] between two commands, inside the watchdog's second
SETTLE = 1.0  # [s] before and after a window
CALLERS = 4  # that call at once
SAME_FRAME = 0.5 * TICK  # [s] between two answers of one frame, at most
SERVICES = {  # class, values by the name of the turtle to spawn or kill
    'clear': (Empty, lambda name: ()), 'reset': (Empty, lambda name: ()),
    'spawn': (Spawn, lambda name: (2.0, 2.0, 0.0, name)), 'kill': (Kill, lambda name: (name,)),
    'turtle1/set_pen': (SetPen, lambda name: (1, 2, 3, 2, 0)),
    'turtle1/teleport_absolute': (TeleportAbsolute, lambda name: (5.0, 5.0, 0.0)),
    'turtle1/teleport_relative': (TeleportRelative, lambda name: (0.0, 0.1))}


class Receiver:
    """Collects the stamps [s] of the poses of some turtles, by name."""

    def __init__(self, turtles):
        self.stamps = {turtle: [] for turtle in turtles}
        self._last = {}
        self._subscribers = [
            rospy.Subscriber(f'{turtle}/pose', rospy.AnyMsg, self._received, callback_args=turtle, tcp_nodelay=True)
            for turtle in turtles]
        await_true(lambda: all(self.stamps.values()), COME_UP, 'a pose of every turtle')

    def _received(self, message, turtle):
        self.stamps[turtle].append(clock())
        self._last[turtle] = message._buff

    def resting(self):
        """Return the names of the turtles whose last pose shows no speed."""
        return [turtle for turtle, data in self._last.items() if POSE.unpack(data)[3] == 0.0]

    def clear(self):
        """Forget all poses so far."""
        for stamps in self.stamps.values():
            stamps.clear()


def drive(turtles, speed=1.0, turn=2.0, period=DRIVE_PERIOD):
    """Drive turtles in circles until the process ends."""
    publishers = [rospy.Publisher(f'{turtle}/cmd_vel', Twist, queue_size=1) for turtle in turtles]
    message = Twist()
    message.linear.x, message.angular.z = speed, turn
    repeat(period, lambda: [publisher.publish(message) for publisher in publishers])


def require_moving(receiver):
    """Raise Silent if a turtle stands still: a node may save work on it, and the figures would be too good."""
    resting = receiver.resting()
    if resting:
        raise Silent(f'{len(resting)} of {len(receiver.stamps)} turtles do not move, such as {resting[0]}')


def listen(turtles, seconds, driving=False):
    """Subscribe to all poses, say so, then report how many of each came in this time."""
    names = [f'turtle{number}' for number in range(1, turtles + 1)]
    receiver = Receiver(names)
    if driving:
        drive(names)
        await_true(lambda: not receiver.resting(), COME_UP, 'every turtle moving')
    time.sleep(SETTLE)
    receiver.clear()
    say(ready=True)
    begun = clock()
    time.sleep(seconds)
    elapsed = clock() - begun
    received = [list(stamps) for stamps in receiver.stamps.values()]
    if driving:
        require_moving(receiver)
    say(rates=[rate_in_window(stamps, elapsed, 3 * TICK) for stamps in received])
    time.sleep(SETTLE)  # stay subscribed while the bench takes its last reading


def listen_many(turtles, seconds):
    """Do as listen does, but count bytes instead of poses: to decode a thousand would take the node's core."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode('/turtlesim')
    sockets = [tcpros.subscribe(uri, f'/turtle{number}/pose', Pose) for number in range(1, turtles + 1)]
    for each in sockets:
        tcpros.receive(each, FRAME)
        each.setblocking(False)
    time.sleep(SETTLE)
    say(ready=True)
    drain(sockets)
    begun, counts = clock(), [0] * len(sockets)
    while clock() - begun < seconds:
        time.sleep(10 * TICK)
        counts = [count + more for count, more in zip(counts, drain(sockets))]
    elapsed = clock() - begun
    say(rates=[count / FRAME / elapsed for count in counts])
    time.sleep(SETTLE)  # stay subscribed while the bench takes its last reading


def drain(sockets):
    """Read all bytes that wait in the sockets; return how many each had."""
    counts = []
    for each in sockets:
        try:
            counts.append(len(each.recv(65536)))
        except BlockingIOError:
            counts.append(0)
    return counts


class SpeedWatch:
    """Notes when the pose of turtle1 first shows a speed [m/s]."""

    def __init__(self):
        self._awaited = None
        self._shown = threading.Event()
        self.stamp = 0.0
        self._subscriber = rospy.Subscriber('turtle1/pose', rospy.AnyMsg, self._received, tcp_nodelay=True)

    def expect(self, speed):
        """Wait for this speed from now on."""
        self._shown.clear()
        self._awaited = speed

    def await_shown(self):
        """Return the time of the pose that showed it; raise Silent if none did."""
        if not self._shown.wait(ONE_ANSWER):
            raise Silent(f'no pose showed linear_velocity {self._awaited:g} within {ONE_ANSWER:g} s of its cmd_vel')
        return self.stamp

    def _received(self, message):
        stamp = clock()
        awaited = self._awaited
        if awaited is not None and abs(POSE.unpack(message._buff)[3] - awaited) < 1e-5:
            self.stamp = stamp
            self._awaited = None
            self._shown.set()


def cmd_vel(count):
    """Report the times [s] from publishing a speed to the pose that shows it, at phases spread over the tick."""
    watch = SpeedWatch()
    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1, tcp_nodelay=True)
    await_true(lambda: publisher.get_num_connections() > 0, COME_UP, 'a subscriber to turtle1/cmd_vel')
    message = Twist()
    message.angular.z = 2.0
    times = []
    reference = clock()
    for number, phase in enumerate(stratified_phases(count + 1, random.Random(1))):
        message.linear.x = 0.5 + 0.001 * (number % 1000)  # a circle under 1.5 m wide, well inside the arena
        watch.expect(message.linear.x)
        time.sleep(max(0.0, reference + TICK * phase - clock()))
        sent = clock()
        publisher.publish(message)
        reference = watch.await_shown()
        times.append(reference - sent)
    say(times=times[1:])


def spawn(turtles):
    """Spawn turtles in a grid until there are so many."""
    rospy.wait_for_service('spawn', COME_UP)
    call = rospy.ServiceProxy('spawn', Spawn, persistent=True)
    for number in range(2, turtles + 1):
        call(1.0 + number % 10, 1.0 + number // 10 % 10, 0.0, f'turtle{number}')
    say(turtles=turtles)


class Caller(tcpros.Caller):
    """A persistent connection to a service, without the waiting of rospy's ServiceProxy."""

    def __init__(self, service):
        rospy.wait_for_service(service, COME_UP)
        kind, self._values = SERVICES[service]
        name = rospy.resolve_name(service)
        super().__init__(tcpros.address(rosgraph.Master(rospy.get_name()).lookupService(name)), name, kind)

    def begin(self, name):
        """Send a request; ``name`` is that of the turtle to spawn or kill."""
        self.send(*self._values(name))

    def end(self):
        """Read the answer."""
        well, text = self.answer()
        if not well:
            raise Silent(f'a call failed: {text.decode()}')

    def time(self, name):
        """Return the time [s] of a call."""
        begun = clock()
        self.begin(name)
        self.end()
        return clock() - begun


def together(callers, names):
    """Return (time [s] until all callers, who call at once, are answered; in how many frames)."""
    begun = clock()
    for caller, name in zip(callers, names):
        caller.begin(name)
    stamps, waiting = [], {caller.socket: caller for caller in callers}
    while waiting:
        for each in select.select(list(waiting), [], [], COME_UP)[0]:
            waiting.pop(each).end()
            stamps.append(clock())
    return stamps[-1] - begun, 1 + sum(pause > SAME_FRAME for pause in intervals(stamps))


def calls(service, count):
    """Report the times [s] of calls: back to back, single ones at phases spread evenly, and several at once.

    Turtles that a kill needs are spawned, those of a spawn are killed, outside the times.
    """
    callers = [Caller(service) for _ in range(CALLERS)]
    opposite = {'spawn': 'kill', 'kill': 'spawn'}.get(service)
    helper = Caller(opposite) if opposite else None
    fresh = (f'bench{number}' for number in itertools.count())

    def timed(number, call):
        names = [next(fresh) for _ in range(number)]
        for name in names if opposite == 'spawn' else ():
            helper.time(name)
        found = call(names)
        for name in names if opposite == 'kill' else ():
            helper.time(name)
        return found

    def at_phases(count, number, call):
        for phase in stratified_phases(count, random.Random(1)):
            time.sleep(TICK * (1.0 + phase))
            yield timed(number, call)
    back = timed(count + 1, lambda names: [callers[0].time(name) for name in names])[1:]
    single = list(at_phases(count, 1, lambda names: callers[0].time(names[0])))
    at_once = list(at_phases(count // 2, CALLERS, lambda names: together(callers, names)))
    say(back=back, single=single, together=[seconds for seconds, _ in at_once], frames=[each for _, each in at_once])


def many(turtles):
    """Say when ready, then spawn turtles up to this number: times [s] and turtle1's longest pose gap [s]."""
    receiver, caller = Receiver(['turtle1']), Caller('spawn')
    say(ready=True)
    receiver.clear()
    times = [caller.time(f'turtle{number}') for number in range(2, turtles + 1)]
    say(times=times, gap=max(intervals(receiver.stamps['turtle1'])))


def reset():
    """Report the time [s] of a reset and turtle1's longest pose gap [s] during it and shortly after."""
    receiver, caller = Receiver(['turtle1']), Caller('reset')
    receiver.clear()
    seconds = caller.time('')
    time.sleep(SETTLE)
    say(seconds=seconds, gap=max(intervals(receiver.stamps['turtle1'])))
