"""Helpers for all rostests: deadlines, collected messages, refused calls, and the interface of a simulator.

Nothing here waits for a fixed time: ``until`` polls a condition up to a deadline. The deadlines are generous, because a
loaded machine with two cores has to meet them; they only cost time when a test fails. A machine may also stand still
for a second, with all its processes. So short times are measured by kinematic_core's ActiveTimer, which leaves such
gaps out, and rates are medians (``median_rate``).
"""
import ast
import contextlib
import os
import pathlib
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client
from xml.etree import ElementTree

import rosgraph
import roslib.packages
import rosnode
import rospy
import rosunit
from geometry_msgs.msg import Twist, Vector3
from rosgraph_msgs.msg import Log
from std_srvs.srv import Empty, Trigger
from turtlesim.msg import Color, Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

import rostest
from plain_support.processes import BackgroundProcess
from rostest_support.waiting import DEADLINE, until

PACKAGE = 'turtle_robotont'
END_STAGES = tuple((number, 20.0) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL))  # [s]

DT = 0.016  # [s] one step of the simulator
ARENA = 11.0888891  # [m] side of the arena
MIDDLE = 5.544444561004639  # [m] x and y of the start of turtle1; a float32
PIXELS_PER_METRE = 45.0
BACKGROUND = (69, 86, 255)
PEN = (179, 184, 255)
FLOAT32_TOLERANCE = 1e-5  # [m, rad] largest rounding error of float32 fields and their sums

CHANGE = 'TURTLE_ROBOTONT_CHANGE'  # set in the environment: leave out what is nightly


def nightly(method):
    """Mark a method of a test case: ./run test leaves it out, ./run test --all and ./run test NAME do not."""
    method.is_nightly = True
    return method


def run(*cases):
    """Run, as a rostest node, the methods that args= in the .test file names; without args, run all."""
    owners = {method: case for case in reversed(cases) for method in unittest.defaultTestLoader.getTestCaseNames(case)}
    methods = _methods() or list(owners)
    if not owners.keys() >= set(methods):
        raise SystemExit(f'{sys.argv[0]} has no {", ".join(sorted(set(methods) - owners.keys()))}')
    if CHANGE in os.environ:
        methods = [name for name in methods if not getattr(getattr(owners[name], name), 'is_nightly', False)]
    apart = {case: type(case.__name__, (_Apart, case), {'__module__': case.__module__}) for case in cases}
    suite = unittest.TestSuite(apart[owners[method]](method) for method in methods)
    rospy.init_node(_name())
    result = rosunit.create_xml_runner(PACKAGE, _name(), _result_file()).run(suite)
    rosunit.print_unittest_summary(result)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0 if result.wasSuccessful() else 1)  # rospy's shutdown takes 0.6 s, and the master ends now anyway


class _Apart(unittest.TestCase):
    """A test that deletes the parameters that are new after it, except those of nodes that still run."""

    def run(self, result=None):
        before = rospy.get_param('/')
        super().run(result)
        running = rosnode.get_node_names()
        for name in rospy.get_param('/').keys() - before.keys():
            if f'/{name}' not in running:
                with contextlib.suppress(KeyError):  # a node that ends may have deleted it in the meantime
                    rospy.delete_param(f'/{name}')
        return result


def _methods():
    return [argument for argument in sys.argv[1:] if argument.startswith('test_')]


def _name():
    """Return the name of the method that is run, or that of the script if it runs several."""
    methods = _methods()
    return methods[0] if len(methods) == 1 else pathlib.Path(sys.argv[0]).stem


def _result_file():
    """Return the file for the results that rostest has named; None if the test was started by hand."""
    return next((argument[len(rostest.XML_OUTPUT_FLAG):] for argument in sys.argv
                 if argument.startswith(rostest.XML_OUTPUT_FLAG)), None)


def skip(reason):
    """Print why a rostest node cannot run here, and write that as its result; rosunit itself cannot skip tests."""
    print(reason, file=sys.stderr)
    path = _result_file()
    if path:
        suite = ElementTree.Element('testsuite', name=_name(), tests='1', failures='0', errors='0', time='0')
        case = ElementTree.SubElement(suite, 'testcase', classname='skipped', name=_name(), time='0')
        ElementTree.SubElement(case, 'skipped', message=reason)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        ElementTree.ElementTree(suite).write(path)


def median_rate(times, span):
    """Return the rate [Hz] of times [s]: the median over all sections of ``span`` periods.

    Single late or missing periods do not change it; a rate that is wrong most of the time does.
    """
    return span / statistics.median(later - earlier for earlier, later in zip(times, times[span:]))


def proxy(name, service):
    """Wait for a service; return its proxy."""
    rospy.wait_for_service(name, DEADLINE)
    return rospy.ServiceProxy(name, service)


def restore_parameter(name, value):
    """Set a parameter to its previous value; delete it if that is None."""
    if value is not None:
        rospy.set_param(name, value)
    elif rospy.has_param(name):
        rospy.delete_param(name)


def node_api(node):
    """Return the slave API of a node, an xmlrpc.client.ServerProxy."""
    return xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(node))


def registered_names(node):
    """Return the names that a node has registered with the master: (published, subscribed, services), sets."""
    state = rosgraph.Master(rospy.get_name()).getSystemState()
    return tuple({name for name, nodes in kind if node in nodes} for kind in state)


class Collected:
    """Collects the messages of a topic from now on, oldest first."""

    def __init__(self, topic, message_type):
        self.topic = topic
        self.messages = []
        self.times = []  # [s, monotonic] arrival times of the messages
        self.subscriber = rospy.Subscriber(topic, message_type, self._store, tcp_nodelay=True)

    def _store(self, message):
        self.times.append(time.monotonic())
        self.messages.append(message)

    def index(self, fits=lambda message: True, what='a message', start=None, deadline=DEADLINE):
        """Return the index of the first message that fits, from ``start`` on (without it: from now on)."""
        start = len(self.messages) if start is None else start
        return until(lambda: [number for number, message in enumerate(self.messages[start:], start) if fits(message)],
                     f'{what} on {self.topic}', deadline)[0]

    def next(self, fits=lambda message: True, what='a message', deadline=DEADLINE):
        """Return the first message from now on that fits."""
        return self.messages[self.index(fits, what, deadline=deadline)]

    def some(self, start, number, deadline=DEADLINE):
        """Return ``number`` messages from the index ``start`` on."""
        until(lambda: len(self.messages) >= start + number, f'{number} messages on {self.topic}', deadline)
        return self.messages[start:start + number]

    def more(self, number, deadline=DEADLINE):
        """Return the next ``number`` messages."""
        return self.some(len(self.messages), number, deadline)

    def rate(self, number, span, deadline=2.0 * DEADLINE):
        """Return the median_rate [Hz] of the next ``number`` messages."""
        start = len(self.times)
        until(lambda: len(self.times) >= start + number, f'{number} messages on {self.topic}', deadline)
        return median_rate(self.times[start:start + number], span)


class NodeLog:
    """Collects the log messages of a node on /rosout from now on."""

    def __init__(self, node):
        self._node = node
        self._log = Collected('/rosout', Log)
        # the topic is latched: the last line that came before is the sign that the two are connected
        until(lambda: [entry for entry in self._log.messages if entry.name == node], f'a connection with {node}')
        self._log.messages.clear()

    def texts(self, level):
        """Return the texts logged at a level (Log.INFO, Log.WARN, Log.ERROR)."""
        return [entry.msg for entry in list(self._log.messages) if entry.name == self._node and entry.level == level]

    def wait(self, level, pattern, deadline=DEADLINE):
        """Return the first text at the level that matches the regular expression completely."""
        return until(lambda: [text for text in self.texts(level) if re.fullmatch(pattern, text, re.DOTALL)],
                     lambda: f'a line {pattern!r}; there were: {self.texts(level)}', deadline)[0]


class SimulatorCase(unittest.TestCase):
    """A test with a simulator; ``simulator`` is the name of its node, ``space`` the namespace of its turtles."""

    simulator = '/turtlesim'
    space = '/'

    _used = set()  # simulators that an earlier test has used, so that they need a reset

    def setUp(self):
        """Wait for turtle1, and undo changes of an earlier test; without ``simulator`` the test starts its own."""
        if self.simulator:
            if self.simulator in self._used:
                proxy(f'{self.simulator}/resume', Trigger)()
                self.call('reset')
            self.wait_for_turtle1()
            self._used.add(self.simulator)

    def wait_for_turtle1(self):
        """Wait until turtle1 can be called."""
        rospy.wait_for_service(f'{self.space}turtle1/teleport_relative', DEADLINE)

    def poses(self, turtle='turtle1'):
        """Return the Collected poses of a turtle, of which there is one already."""
        return self._begun(Collected(f'{self.space}{turtle}/pose', Pose))

    def colors(self, turtle='turtle1'):
        """Return the Collected colours under a turtle, of which there is one already."""
        return self._begun(Collected(f'{self.space}{turtle}/color_sensor', Color))

    def _begun(self, collected):
        self.addCleanup(collected.subscriber.unregister)
        until(lambda: collected.messages, f'a first message on {collected.topic}')
        return collected

    def pose(self, turtle='turtle1'):
        """Return a pose published after this was called."""
        return rospy.wait_for_message(f'{self.space}{turtle}/pose', Pose, DEADLINE)

    def color(self, turtle='turtle1'):
        """Return (r, g, b) under a turtle, published after this was called."""
        message = rospy.wait_for_message(f'{self.space}{turtle}/color_sensor', Color, DEADLINE)
        return message.r, message.g, message.b

    def driver(self, topic='turtle1/cmd_vel', subscribers=1):
        """Return a function (linear_x, linear_y, angular_z) that publishes a Twist to that many subscribers."""
        publisher = rospy.Publisher(f'{self.space}{topic}', Twist, queue_size=10, tcp_nodelay=True)
        self.addCleanup(publisher.unregister)
        until(lambda: publisher.get_num_connections() >= subscribers, f'{subscribers} subscribers of {publisher.name}')
        return lambda x=0.0, y=0.0, turn=0.0: publisher.publish(Vector3(x, y, 0.0), Vector3(0.0, 0.0, turn))

    def call(self, name, *values):
        """Call a service of the simulator."""
        kind = SERVICES[name.rsplit('/', 1)[-1]]
        return proxy(f'{self.simulator if name == "snapshot" else self.space.rstrip("/")}/{name}', kind)(*values)

    def refused(self, name, *values):
        """Call a service that must fail; return the text of the failure."""
        with self.assertRaises(rospy.ServiceException, msg=f'{name} {values}') as failure:
            self.call(name, *values)
        said = re.search(r'b(["\']).*\1$', str(failure.exception), re.DOTALL)  # rospy quotes the text as bytes
        return ast.literal_eval(said.group()).decode() if said else str(failure.exception)

    def jump(self, x, y, theta=0.0, turtle='turtle1'):
        """Teleport a turtle without drawing; its pen is down afterwards, in its first colour."""
        self.call(f'{turtle}/set_pen', 0, 0, 0, 0, 1)
        self.call(f'{turtle}/teleport_absolute', x, y, theta)
        self.call(f'{turtle}/set_pen', *PEN, 3, 0)

    def set_parameter(self, name, value):
        """Set a private parameter of the simulator until the end of the test."""
        name = f'{self.simulator}/{name}'
        self.addCleanup(restore_parameter, name, rospy.get_param(name, None))
        rospy.set_param(name, value)

    def temporary_directory(self):
        """Return a directory that is removed after the test."""
        directory = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, directory, ignore_errors=True)
        return directory

    def snapshot(self):
        """Return the bytes of the PNG file that ~snapshot saves."""
        self.set_parameter('snapshot_dir', self.temporary_directory())
        answer = self.call('snapshot')
        self.assertTrue(answer.success, answer.message)
        with open(answer.message, 'rb') as file:
            return file.read()

    def turtles(self):
        """Return the names of the turtles, according to their topics."""
        published, _, _ = registered_names(self.simulator)
        return {topic[len(self.space):-len('/pose')] for topic in published if topic.endswith('/pose')}

    def state(self):
        """Return all that a refused call must not change: every turtle's pose, and the bytes of the image."""
        return {name: self.pose(name) for name in self.turtles()}, self.snapshot()

    def assert_unchanged(self, state):
        """Assert that the simulator runs, and that its state is that of an earlier call of ``state``."""
        poses, picture = self.state()
        self.assertEqual(state[0], poses)
        self.assertEqual(state[1], picture, 'the picture changed')

    def assert_pose(self, pose, x, y, theta, tolerance=FLOAT32_TOLERANCE):
        """Assert a position [m] and a heading [rad]."""
        for field, value in (('x', x), ('y', y), ('theta', theta)):
            self.assertAlmostEqual(value, getattr(pose, field), delta=tolerance, msg=f'{field} of {pose}')


SERVICES = {'clear': Empty, 'reset': Empty, 'spawn': Spawn, 'kill': Kill, 'set_pen': SetPen, 'snapshot': Trigger,
            'teleport_absolute': TeleportAbsolute, 'teleport_relative': TeleportRelative}


class Process(BackgroundProcess):
    """A program that a test starts; its output is kept. Use it in a with statement."""

    def __init__(self, *command, stdin=subprocess.DEVNULL, **environment):
        self._file = tempfile.NamedTemporaryFile()
        super().__init__(command, self._file.name, own_group=False, stdin=stdin,  # roslaunch ends the test's group
                         env=dict(os.environ, PYTHONUNBUFFERED='1', **environment))

    def wait_for_output(self, pattern, deadline=DEADLINE):
        """Wait until its output matches a regular expression; return the match."""
        return until(lambda: re.search(pattern, self.output()), lambda: f'{pattern!r} in:\n{self.output()}', deadline)

    def stop(self, stages=END_STAGES):
        """End it as Ctrl-C does, or by force if that does not help; its output is deleted."""
        super().stop(stages)
        self._file.close()


SIMULATOR = (roslib.packages.find_node('turtlesim', 'turtlesim_node') or [None])[0]


def own_simulator(*arguments, **environment):
    """Start a turtlesim_node as a Process."""
    return Process(SIMULATOR, *arguments, **environment)
