"""Client of a turtlesim_node, run by the bench as a process of its own so that nothing else disturbs its clock.

`turtlesim_probe.py first_pose | rate | cmd_vel | service | spawn | listen`; every answer is one line of JSON.
Poses are received as bytes (AnyMsg), so the receiver does no decoding that could delay its clock. rospy calls back in
one thread a topic; those only append to lists and set events, the main thread does the rest.
"""

import argparse
import gc
import json
import random
import struct
import sys
import threading
import time

import rospy
from geometry_msgs.msg import Twist
from turtlesim.srv import SetPen, Spawn, TeleportAbsolute

from figures import rate_in_window, stratified_phases

clock = time.perf_counter  # CLOCK_MONOTONIC on Linux: one clock for all processes
POSE = struct.Struct('<5f')  # x, y, theta, linear_velocity, angular_velocity
TICK = 0.016  # [s] turtlesim's
COME_UP = 20.0  # [s] for a node to be seen
ONE_ANSWER = 2.0  # [s] for a command to show
DRIVE_PERIOD = 0.5  # [s] between two commands, inside the watchdog's second


class Silent(RuntimeError):
    """The node did not do what the probe waited for."""


def say(**document):
    """Print one answer."""
    print(json.dumps(document), flush=True)


def await_true(condition, patience, what):
    """Return once condition() is true; raise Silent after ``patience`` [s]."""
    deadline = clock() + patience
    while not condition():
        if clock() > deadline or rospy.is_shutdown():
            raise Silent(f'{what}: not within {patience:g} s')
        time.sleep(0.005)


class Receiver:
    """Collects the stamps [s] of the poses of some turtles, by name."""

    def __init__(self, turtles):
        self.stamps = {turtle: [] for turtle in turtles}
        self._last = {}
        self._subscribers = [
            rospy.Subscriber(f'{turtle}/pose', rospy.AnyMsg, self._received, callback_args=turtle, tcp_nodelay=True)
            for turtle in turtles]

    def _received(self, message, turtle):
        self.stamps[turtle].append(clock())
        self._last[turtle] = message._buff

    def resting(self):
        """Return the names of the turtles whose last pose shows no speed."""
        return [turtle for turtle, data in self._last.items() if POSE.unpack(data)[3] == 0.0]

    def await_all(self):
        """Return once every turtle's pose has come at least once."""
        await_true(lambda: all(self.stamps.values()), COME_UP, 'a pose of every turtle')

    def clear(self):
        """Forget all poses so far."""
        for stamps in self.stamps.values():
            stamps.clear()


def first_pose(_options):
    """Say that all is ready, then report when the first pose came."""
    receiver = Receiver(['turtle1'])
    say(ready=True)
    receiver.await_all()
    say(stamp=receiver.stamps['turtle1'][0])


def rate(options):
    """Report the stamps of turtle1's poses in options.seconds."""
    receiver = Receiver(['turtle1'])
    receiver.await_all()
    time.sleep(options.settle)
    receiver.clear()
    time.sleep(options.seconds)
    say(stamps=list(receiver.stamps['turtle1']))


class Driver:
    """Drives turtles in circles of 0.5 m radius until the process ends; its thread is a daemon."""

    def __init__(self, turtles):
        self._publishers = [rospy.Publisher(f'{turtle}/cmd_vel', Twist, queue_size=1) for turtle in turtles]
        self._message = Twist()
        self._message.linear.x, self._message.angular.z = 1.0, 2.0
        threading.Thread(target=self._drive, daemon=True).start()

    def _drive(self):
        while not rospy.is_shutdown():
            for publisher in self._publishers:
                publisher.publish(self._message)
            time.sleep(DRIVE_PERIOD)


def require_moving(receiver):
    """Raise Silent when a turtle stands still: a node may save work on it, and the figures would be too good."""
    resting = receiver.resting()
    if resting:
        raise Silent(f'{len(resting)} of {len(receiver.stamps)} turtles do not move, such as {resting[0]}')


def listen(options):
    """Subscribe to all poses, say so, then report how many of each came in options.seconds."""
    names = [f'turtle{number}' for number in range(1, options.turtles + 1)]
    receiver = Receiver(names)
    receiver.await_all()
    if options.drive:
        Driver(names)
        await_true(lambda: not receiver.resting(), COME_UP, 'every turtle moving')
    time.sleep(options.settle)
    receiver.clear()
    say(ready=True)
    begun = clock()
    time.sleep(options.seconds)
    elapsed = clock() - begun
    received = [list(stamps) for stamps in receiver.stamps.values()]
    if options.drive:
        require_moving(receiver)
    say(rates=[rate_in_window(stamps, elapsed, 3 * TICK) for stamps in received])
    time.sleep(options.settle)  # stay subscribed while the bench takes its last reading


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
        """Return the time of the pose that showed it; raise Silent when none did."""
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


def cmd_vel(options):
    """Times [s] from publishing a speed to the pose that shows it, at phases spread evenly over the tick."""
    watch = SpeedWatch()
    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1, tcp_nodelay=True)
    await_true(lambda: publisher.get_num_connections() > 0, COME_UP, 'a subscriber to turtle1/cmd_vel')
    message = Twist()
    message.angular.z = 2.0
    times = []
    reference = clock()
    for number, phase in enumerate(stratified_phases(options.count + 1, random.Random(options.seed))):
        message.linear.x = 0.5 + 0.001 * (number % 1000)  # a circle under 1.5 m wide, well inside the arena
        watch.expect(message.linear.x)
        time.sleep(max(0.0, reference + TICK * phase - clock()))
        sent = clock()
        publisher.publish(message)
        reference = watch.await_shown()
        times.append(reference - sent)
    say(times=times[1:])


def _pen_calls():
    while True:
        for red in range(0, 256, 5):
            yield red, 100, 50, 2, 0


def _teleports():
    rng = random.Random(1)
    while True:
        yield rng.uniform(1.0, 10.0), rng.uniform(1.0, 10.0), 0.0


SERVICES = {'set_pen': (SetPen, _pen_calls), 'teleport_absolute': (TeleportAbsolute, _teleports)}


def service(options):
    """Report the times [s] of calls back to back: with a connection each (ServiceProxy's default) or one for all."""
    kind, requests = SERVICES[options.service]
    name = f'turtle1/{options.service}'
    rospy.wait_for_service(name, COME_UP)
    kept = rospy.ServiceProxy(name, kind, persistent=True) if options.persistent else None
    times = []
    for _, request in zip(range(options.count + 1), requests()):
        begun = clock()
        call = kept or rospy.ServiceProxy(name, kind)
        call(*request)
        times.append(clock() - begun)
    say(times=times[1:])


def spawn(options):
    """Spawn turtles in a grid until there are options.turtles."""
    rospy.wait_for_service('spawn', COME_UP)
    call = rospy.ServiceProxy('spawn', Spawn, persistent=True)
    for number in range(2, options.turtles + 1):
        call(1.0 + number % 10, 1.0 + number // 10 % 10, 0.0, f'turtle{number}')
    say(turtles=options.turtles)


TASKS = {task.__name__: task for task in (first_pose, rate, listen, cmd_vel, service, spawn)}


def parse(arguments, tasks, services):
    """Return the options of one task."""
    parser = argparse.ArgumentParser(description='one measurement at a running turtlesim_node')
    parser.add_argument('task', choices=sorted(tasks))
    parser.add_argument('--seconds', type=float, default=5.0, help='window [s]')
    parser.add_argument('--settle', type=float, default=1.0, help='pause before and after the window [s]')
    parser.add_argument('--count', type=int, default=100, help='samples')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--turtles', type=int, default=1)
    parser.add_argument('--service', choices=sorted(services), default='set_pen')
    parser.add_argument('--persistent', action='store_true')
    parser.add_argument('--drive', action='store_true', help='keep the turtles moving')
    return parser.parse_args(arguments)


def run_task(tasks, options):
    """Run ``tasks[options.task](options)`` in a node of its own; return the exit code of a probe."""
    gc.disable()
    rospy.init_node('bench_probe', anonymous=True, disable_rosout=True, disable_signals=True)
    try:
        tasks[options.task](options)
    except (Silent, AssertionError, OSError, rospy.ROSException, rospy.ServiceException) as error:
        print(f'{options.task}: {error}', file=sys.stderr)
        return 1
    finally:
        rospy.signal_shutdown('done')
    return 0


def main(tasks=TASKS, services=SERVICES):
    """Run the task that the command line names; ``tasks`` {name: function(options)}."""
    options = parse(sys.argv[1:], tasks, services)
    return run_task(tasks, options)


if __name__ == '__main__':
    sys.exit(main())
