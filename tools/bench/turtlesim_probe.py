"""Client of a turtlesim_node (see probing.py). Where rospy's threads would be slower, the connections are its own.

Poses are received as bytes (AnyMsg), so the receiver does no decoding that could delay its clock.
"""
import contextlib
import struct
import time

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose
from turtlesim.srv import Spawn, TeleportAbsolute

from figures import stratified_phases
from probing import COME_UP, Silent, await_true, clock, say
from rostest_support import tcpros
from topic_probe import drive

POSE = struct.Struct('<5f')  # x, y, theta, linear_velocity, angular_velocity
FRAME = 4 + POSE.size  # [bytes] of a pose on its connection
TICK = 0.016  # [s] turtlesim's
ONE_ANSWER = 2.0  # [s] for a command to show
SETTLE = 1.0  # [s] before and after a window


class Poses:
    """The poses of the turtles 1 to ``count``, counted as bytes: to decode a thousand would take the node's core."""

    def __init__(self, count):
        uri = rosgraph.Master(rospy.get_name()).lookupNode('/turtlesim')
        self._sockets = [tcpros.subscribe(uri, f'/turtle{number}/pose', Pose) for number in range(1, count + 1)]
        self._last = [tcpros.receive(each, FRAME) for each in self._sockets]
        self.bytes = [0] * count

    def read(self):
        """Read what has come until a tick has ended; return the time [s]."""
        self._drain()
        self._sockets[0].setblocking(True)
        self._take(0, tcpros.receive(self._sockets[0], FRAME))
        time.sleep(TICK / 2)
        stamp = clock()
        self._drain()
        return stamp

    def _drain(self):
        for place, each in enumerate(self._sockets):
            each.setblocking(False)
            with contextlib.suppress(BlockingIOError):
                self._take(place, each.recv(65536))

    def _take(self, place, data):
        self.bytes[place] += len(data)
        self._last[place] = (self._last[place] + data)[-FRAME:]

    def are_moving(self):
        """Return whether the last poses of all turtles show a speed; a node may save work on others."""
        self.read()
        return all(POSE.unpack(data[4:])[3] for data in self._last)


def listen(turtles, seconds):
    """Subscribe to all poses of turtles that drive, say so, then report how many [Hz] of each came in this time."""
    poses = Poses(turtles)
    drive([f'turtle{number}/cmd_vel' for number in range(1, turtles + 1)])
    await_true(poses.are_moving, COME_UP, 'every turtle moving')
    time.sleep(SETTLE)
    say(ready=True)
    begun = stamp = poses.read()
    poses.bytes = [0] * turtles
    while stamp - begun < seconds:
        time.sleep(10 * TICK)
        stamp = poses.read()
    rates = [count / FRAME / (stamp - begun) for count in poses.bytes]
    if not poses.are_moving():
        raise Silent('a turtle has stopped, so the figures would be too good')
    say(rates=rates)
    time.sleep(SETTLE)  # stay subscribed while the bench takes its last reading


def cmd_vel(count):
    """Report the times [s] from publishing a speed to the pose that shows it, at phases spread over the tick."""
    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1, tcp_nodelay=True)
    await_true(publisher.get_num_connections, COME_UP, 'a subscriber to turtle1/cmd_vel')
    poses = tcpros.subscribe(rosgraph.Master(rospy.get_name()).lookupNode('/turtlesim'), '/turtle1/pose', Pose)
    message = Twist()
    message.angular.z = 2.0
    times, shown = [], clock()
    for number, phase in enumerate(stratified_phases(count + 1)):
        message.linear.x = 0.5 + 0.001 * (number % 1000)  # a circle under 1.5 m wide, well inside the arena
        time.sleep(max(0.0, shown + TICK * phase - clock()))
        sent = clock()
        publisher.publish(message)
        while abs(POSE.unpack(tcpros.receive(poses, FRAME)[4:])[3] - message.linear.x) > 1e-5:
            if clock() - sent > ONE_ANSWER:
                raise Silent(f'no pose showed linear_velocity {message.linear.x:g} within {ONE_ANSWER:g} s')
        shown = clock()
        times.append(shown - sent)
    say(times=times[1:])


def caller_of(service, kind):
    """Return a function that calls a service and returns the time [s], without the waiting of rospy's ServiceProxy."""
    rospy.wait_for_service(service, COME_UP)
    name = rospy.resolve_name(service)
    caller = tcpros.Caller(tcpros.address(rosgraph.Master(rospy.get_name()).lookupService(name)), name, kind)

    def call(*values):
        begun = clock()
        well, text = caller.call(*values)
        if not well:
            raise Silent(f'a call failed: {text.decode()}')
        return clock() - begun
    return call


def teleport(count):
    """Report the times [s] of calls, back to back."""
    call = caller_of('turtle1/teleport_absolute', TeleportAbsolute)
    say(back=[call(5.0, 5.0, 0.0) for _ in range(count + 1)][1:])


def many(turtles):
    """Spawn turtles up to this number."""
    call = caller_of('spawn', Spawn)
    for number in range(2, turtles + 1):
        call(2.0, 2.0, 0.0, f'turtle{number}')
    say(spawned=True)
