"""The environment of the demo: a master, a simulator, the nodes of a step, and an observer of the turtle.

Threads: rospy calls the recorders' callbacks in its own threads, one per topic; they only append.
Processes: each has its own process group; ``DemoHarness.close`` ends it, or the kernel (SIGINT) if the demo is killed.
"""
import contextlib
import glob
import math
import os
import shutil
import signal
import subprocess
import time

import cv2
import roslib.packages
import rospy
from sim_ros.srv import SetRate
from std_srvs.srv import Empty, Trigger
from turtlesim.msg import Color, Pose

from course_grader.demo.core import track_metrics
from kinematic_core.worlds.turtle_world import ARENA_SIZE
from plain_support import unwritten, write_whole
from plain_support.processes import BackgroundProcess, end_with_parent
from rospy_support import servers
from rospy_support.own_master import MasterError, own_master

CENTRE = ARENA_SIZE / 2.0  # [m] x and y where a turtle starts
EXACT = 1e-3  # [m]
STEP_TIMEOUT = 120.0  # [s] for anything that a step starts or waits for; a loaded machine needs up to 40
REST_POSES = 312  # of turtlesim, 5 s of its time, in which a turtle must come to rest
END_STAGES = ((signal.SIGINT, 4.0), (signal.SIGTERM, 1.0), (signal.SIGKILL, 1.0))  # enough for a roslaunch
POLL = 0.02  # [s]
BACKGROUND = [f'turtlesim/background_{channel}' for channel in 'rgb']


class DemoError(RuntimeError):
    """A step cannot continue; the text says what it waited for."""


class Process(BackgroundProcess):
    """A command in the background, with its output in a file; it ends if the demo is killed."""

    def __init__(self, command, log):
        super().__init__(command, log, preexec_fn=end_with_parent)

    def wait(self, timeout):
        """Return its exit code; raise DemoError with its last line if it has not ended within ``timeout`` [s]."""
        try:
            return self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise DemoError(f'{os.path.basename(self.command[0])} has not ended within {timeout:g} s; it said: '
                            f'{self.last_line()}') from None

    def interrupt(self):
        """Press Ctrl-C."""
        self.process.send_signal(signal.SIGINT)

    def stop(self, stages=END_STAGES):
        """End it, at first with SIGINT."""
        super().stop(stages)


class Recorder:
    """Records the messages of a topic, each converted by ``convert``."""

    def __init__(self, topic, message_type, convert):
        self.entries = []
        self._subscriber = rospy.Subscriber(topic, message_type, lambda message: self.entries.append(convert(message)),
                                            tcp_nodelay=True)

    def end(self):
        """Stop recording."""
        self._subscriber.unregister()


class Observer:
    """Records the motion of one turtle, from its poses and colours.

    It does not subscribe to cmd_vel, so that a program that waits for a subscriber there waits for the simulator.
    """

    def __init__(self, turtle):
        self._poses = Recorder(f'{turtle}/pose', Pose, lambda pose: pose)
        self._colours = Recorder(f'{turtle}/color_sensor', Color, lambda colour: (colour.r, colour.g, colour.b))

    def clear(self):
        """Discard everything recorded so far."""
        for recorder in (self._poses, self._colours):
            recorder.entries.clear()

    @property
    def track(self):
        """Return the poses seen, in order."""
        return list(self._poses.entries)

    @property
    def colours(self):
        """Return the colour sensor's readings (r, g, b), in order."""
        return list(self._colours.entries)


class DemoHarness:
    """A master on a free port, a simulator without a display, and an observer of turtle1, from open to close."""

    def __init__(self, output):
        """``output`` is the folder for pictures; the output of the nodes goes to its subfolder log."""
        self.output, self._log = output, os.path.join(output, 'log')
        self._processes, self._until_closed = [], contextlib.ExitStack()
        self._kept = []  # pictures of the current step, (height, width, 3) uint8 BGR
        self._background = {}  # the parameters of the simulator's background, as they were at the start
        self.seen = None  # the Observer, once open

    def open(self):
        """Start master, simulator and observer; raise DemoError if they do not start."""
        try:
            os.makedirs(self._log, exist_ok=True)
        except OSError as error:
            raise DemoError(unwritten(error, 'choose another folder with --output')) from None
        for old in glob.glob(os.path.join(self._log, '[0-9][0-9]_*.log')):
            os.remove(old)
        os.environ.update(ROS_HOSTNAME='localhost', PYTHONUNBUFFERED='1')
        os.environ.pop('ROS_NAMESPACE', None)
        try:
            master = self._until_closed.enter_context(own_master(os.path.join(self._log, 'master.log')))
        except MasterError as error:
            raise DemoError(str(error)) from None
        os.environ['ROS_MASTER_URI'] = master.uri
        simulator = self.start('roslaunch', 'turtle_robotont', 'turtlesim.launch', 'window:=false')
        servers.protect()
        rospy.init_node('demo', disable_signals=True)
        self.seen = Observer('turtle1')
        self.until(lambda: self.seen.track, 'the simulator publishes no pose', STEP_TIMEOUT, simulator)
        self._background = {name: rospy.get_param(name) for name in BACKGROUND if rospy.has_param(name)}

    def close(self):
        """End all started processes, the latest first; a second Ctrl-C does not interrupt it."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while self._processes:
            self._processes.pop().stop()
        self._until_closed.close()

    def start(self, *command):
        """Start a command in the background; return its Process."""
        number = len(glob.glob(os.path.join(self._log, '*.log')))
        name = os.path.splitext(os.path.basename(command[0]))[0]
        process = Process(command, os.path.join(self._log, f'{number:02d}_{name}.log'))
        self._processes.append(process)
        return process

    def rosrun(self, script, *arguments):
        """Start a program of turtle_robotont, half a second faster than rosrun; return its Process."""
        paths = roslib.packages.find_node('turtle_robotont', script)
        if not paths:
            raise DemoError(f'package turtle_robotont has no node {script}; build the workspace with ./run build')
        return self.start(paths[0], *arguments)

    def typed(self, *command):
        """Type a command and wait until it ends; raise DemoError if it fails."""
        process = self.start(*command)
        if process.wait(STEP_TIMEOUT) != 0 or 'ERROR' in process.output():
            raise DemoError(f'{" ".join(command)} failed: {process.last_line()}')

    def end_nodes(self):
        """End all processes except master and simulator."""
        while len(self._processes) > 1:
            self._processes.pop().stop()

    def until(self, condition, trouble, timeout, process=None):
        """Wait until ``condition()`` is true; raise DemoError(trouble) after ``timeout`` [s] or if the process ends."""
        deadline = time.monotonic() + timeout
        while not condition():
            ended = process is not None and not process.runs()
            if ended or time.monotonic() > deadline:
                said = f'; {os.path.basename(process.command[0])} printed: {process.last_line()}' if process else ''
                raise DemoError(f'{trouble}: {"it has ended" if ended else f"waited {timeout:g} s"}{said}')
            time.sleep(POLL)

    def until_rest(self):
        """Wait until the turtle stops, for REST_POSES at most; the track shows whether it did."""
        last = len(self.seen.track) + REST_POSES
        with contextlib.suppress(DemoError):
            self.until(lambda: track_metrics.stands_still(self.seen.track) or len(self.seen.track) > last,
                       'the turtle does not stop', STEP_TIMEOUT)

    def reset(self):
        """Reset the simulator: the turtle in the centre, an empty arena in its first colour; clear the observer."""
        if not self._processes[0].runs():
            raise DemoError('the simulator has ended')
        for name, value in self._background.items():
            rospy.set_param(name, value)
        self.call('reset', Empty)
        self.seen.clear()
        self.until(lambda: any(math.hypot(pose.x - CENTRE, pose.y - CENTRE) < EXACT for pose in self.seen.track[-1:]),
                   'the turtle is not in the centre after a reset', STEP_TIMEOUT)
        self.seen.clear()
        self.until(lambda: self.seen.track, 'the simulator publishes no pose after a reset', STEP_TIMEOUT)

    def call(self, service, service_type, *request):
        """Call a service; return its answer."""
        rospy.wait_for_service(service, STEP_TIMEOUT)
        return rospy.ServiceProxy(service, service_type)(*request)

    def set_rate(self, rate):
        """Run simulated time ``rate`` times as fast, if the simulator supports it."""
        with contextlib.suppress(rospy.ROSException):
            rospy.wait_for_service('turtlesim/set_rate', 0.05)
            rospy.ServiceProxy('turtlesim/set_rate', SetRate)(rate)

    def keep(self, picture):
        """Add a picture of the current step, (height, width, 3) uint8 BGR."""
        self._kept.append(picture)

    def kept(self, name):
        """Save the added pictures as ``name``.png, ``name``_2.png and so on; return their paths."""
        paths = [os.path.join(self.output, f'{name}{f"_{number}" if number > 1 else ""}.png')
                 for number in range(1, len(self._kept) + 1)]
        for path, picture in zip(paths, self._kept):
            _, png = cv2.imencode('.png', picture)
            try:
                write_whole(path, png.tobytes())
            except OSError as error:
                raise DemoError(unwritten(error, 'choose another folder with --output')) from None
        self._kept.clear()
        return paths

    def picture(self, name):
        """Save the simulator's image as ``name``.png; return its path, or None if there is no ~snapshot service."""
        try:
            rospy.wait_for_service('turtlesim/snapshot', 0.05)
        except rospy.ROSException:
            return None
        rospy.set_param('turtlesim/snapshot_dir', self._log)
        answer = self.call('turtlesim/snapshot', Trigger)
        if not answer.success:
            raise DemoError(answer.message)
        return shutil.move(answer.message, os.path.join(self.output, f'{name}.png'))
