"""One grading: a private master, the simulator in lockstep, the student's program, and an observer; all are ended.

Everything runs in simulated time, which is paused until the program has registered with the master (or ended), so a
slow start costs nothing. In lockstep no step starts before the nodes have finished the last one, so the result does not
depend on the machine, and the simulator makes its steps as fast as the nodes are idle. The grader is one of these
nodes: it looks when PERIOD has passed, and reads what is printed before the next step starts. A program that uses the
wall clock, or never sleeps, is observed in real time instead.

Threads: the main thread watches; the stimuli and rospy's callbacks run in their own and only append to lists.
"""
import contextlib
import json
import math
import os
import random
import subprocess
import sys
import time
import xmlrpc.client

import rosgraph
import roslib.packages
import rospy
from sim_ros.msg import ClockStatus
from sim_ros.srv import Step
from std_srvs.srv import Trigger

from course_grader.attempt import static_analysis
from course_grader.attempt.recording_reader import RecordingReader
from course_grader.attempt.stimuli import take_line
from course_grader.isolation import sandbox
from course_grader.rules import judging, scoring
from course_grader.rules.observation import Event, Observed
from kinematic_core.timing.pacing import BEGIN
from kinematic_core.timing.recorder import ACTIVE
from kinematic_core.timing.stall_free_timer import ActiveTimer
from kinematic_core.worlds import robot_world, turtle_world
from process_support import processes
from rospy_support import own_master, servers

NODE, STIMULI = '/grader', '/grader_stimuli'
POLL = 0.02  # [s] of wall time
PERIOD = 0.5  # [s] of simulated time between two looks at the master and at the score
ENDING = 3.0  # [s] of wall time that a simulator may take to shut down, or a program to end when its nodes have
PATIENCE = 20.0  # [s] of wall time in which master and simulator must be there
START_PATIENCE = 10.0  # [s] of wall time in which a program that rests should have registered with the master
LONGEST_START = 60.0  # [s] the same for one that is busy, for example with its imports
COMPLETE = 0.4  # [s] at rest after which all that a launch file or script starts is there
LONGEST_COMPLETION = 15.0  # [s] in which that should be
AFTER_END = 2.5  # [s] of simulated time that are still observed when the program has ended
ENOUGH_REST = 3.0  # [s] of simulated time at rest after which a complete score cannot change any more
SLOWEST_PACE = 0.8  # of real time: below it a program that never rests cannot be judged
SLOWEST_WALL_PACE = 0.95  # the same for one that uses the wall clock
FLOODED = 0.5  # share of the wall time that a simulator computes, which by itself takes a twentieth
LONGEST_STALL = 0.25  # [s] for which the machine may have stood still in real time
LAG = 0.1  # [s] of simulated time by which a recording may be behind
SLACK = 20.0  # [s] of wall time on top of the exercise's own time: the hard limit


class SessionError(RuntimeError):
    """The grading failed; the text says why. It is not the student's fault."""


class Session:
    """A grading of ``command`` by an Exercise."""

    def __init__(self, exercise, command, seed, folder, real_time=False, packages=None):
        """``folder`` takes all files; ``real_time``: at the speed of the wall clock, whatever the program does.

        ``packages``: folder with the program's packages, by default that of the package in which its file lies.
        """
        self.exercise, self.seed, self._folder = exercise, seed, str(folder)
        self._command, self.remarks = sandbox.runnable(command)
        self._packages = packages or sandbox.package_of(self._command)
        if self._packages:
            os.environ['ROS_PACKAGE_PATH'] = os.pathsep.join(
                filter(None, (self._packages, os.environ.get('ROS_PACKAGE_PATH'))))
        own = static_analysis.simulators(self._command)
        if own:
            raise sandbox.CommandError(f'the launch file starts its own simulator ({", ".join(own)}), but the '
                                       'grader has already started one: remove that node from the launch file')
        self._slowest_pace = SLOWEST_PACE
        clock = static_analysis.looks_at_the_wall_clock(self._command)
        if clock:
            self._slowest_pace = SLOWEST_WALL_PACE
            self.remarks.append(f'the program uses the wall clock ({clock}), so it is graded in real time; use '
                                'rospy.sleep, rospy.Rate and rospy.Time to be graded faster')
            real_time = True
        self.lockstep = not real_time
        self._random = random.Random(seed)
        self.observed = Observed()
        self._looked, self._heard = 0.0, 0
        self._students = set()  # names of nodes that were seen
        self._following = False  # whether one of them follows /clock
        self.busy = ''  # the nodes that never slept, so that lockstep continued without them
        self.flooded = False  # the simulator was busy with what the nodes sent it

    def run(self):
        """Grade; return the Verdict. Raise SessionError."""
        os.environ['ROS_HOSTNAME'] = 'localhost'
        for name in ('ROS_IP', 'ROS_NAMESPACE'):
            os.environ.pop(name, None)
        with sandbox.Sandbox(self._folder, {}) as box:
            for name in ('ROS_HOME', 'ROS_LOG_DIR', 'TMPDIR'):
                os.environ[name] = box.environment[name]
            self._start_master(box)
            rospy.set_param('/use_sim_time', True)
            servers.protect()
            # the command's remaps are not its own; in real time it polls, and nobody waits for it
            rospy.init_node(NODE[1:], argv=[], disable_signals=True, disable_rostime=not self.lockstep)
            self._observe(box)
        return scoring.decide(self.exercise, self.observed)

    def _start_master(self, box):
        """Start a master, which ends with the sandbox."""
        log = os.path.join(box.folder, 'master.txt')
        try:
            master = own_master.start_master(
                lambda command: processes.BackgroundProcess(command, log, env=box.environment), patience=PATIENCE)
        except own_master.MasterError as error:
            raise SessionError(str(error)) from None
        os.environ['ROS_MASTER_URI'] = box.environment['ROS_MASTER_URI'] = master.uri

    def _observe(self, box):
        simulator = box.start(self._simulator_command(box), log='simulator.txt')
        reader = RecordingReader(self._record, self._dt, self.observed, STIMULI)
        step, resume = rospy.ServiceProxy(f'{self._simulator}/step', Step), f'{self._simulator}/resume'
        self._until(lambda: self._offers(step.resolved_name), simulator, 'simulator')  # the last that it offers
        rospy.Subscriber(f'{self._simulator}/clock_status', ClockStatus, self._on_status)
        try:
            student = sandbox.Student(box, self._command, reader.read)
        except sandbox.CommandError as error:
            self.observed.trouble = str(error)
            return
        self.observed.lines = student.lines
        try:
            self._follow(box, reader, student, simulator, step, resume)
        except (rospy.ServiceException, rospy.ROSException):
            if not self._ended_by_student(simulator):
                raise
        self.observed.lines = list(student.lines)  # what it says when it is ended does not count
        if student.dropped:
            self.remarks.append(f'the program printed {len(student.lines) + student.dropped} lines; only the first '
                                f'{len(student.lines)} count')
        reader.close()
        simulator.kill()  # nobody needs its goodbye
        with contextlib.suppress(FileNotFoundError):
            os.rename(self._record + ACTIVE, self._record)

    def _follow(self, box, reader, student, simulator, step, resume):
        """Start time when the program has started, and watch until the end."""
        self._wait_for_student(student, step, reader)
        self.observed.start = reader.read()
        stimuli = self._start_stimuli(box, reader)
        if not self.lockstep:
            rospy.ServiceProxy(resume, Trigger)()
        self._watch(reader, student, simulator, stimuli, step)

    def _runs(self, simulator):
        """Return whether the simulator runs, or False when the program ended it; raise SessionError when it crashed."""
        if simulator.poll() is None:
            return True
        if self._ended_by_student(simulator):
            return False
        raise SessionError(f'the simulator ended with exit code {simulator.returncode}')

    def _ended_by_student(self, simulator):
        """Return whether simulator or grader were told to end, by rosnode kill or a node of their name; note it."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            simulator.wait(ENDING)
        if simulator.poll() != 0 and not rospy.is_shutdown():
            return False  # it crashed, or was killed
        self.observed.trouble = (
            'the program ended the simulator or the grader, by rosnode kill or by a node of the same name '
            f'({self._simulator}, {NODE}): choose another name, and start no simulator, as one is already running')
        return True

    def _wait_for_student(self, student, step, reader):
        """Keep time (nearly) paused until a node has started and, of several processes, all have."""
        waiting, rest = ActiveTimer(), sandbox.ProgramIdleTimer(student)
        while (not self._student_is_there() and student.exit_code() is None and rest.look() < START_PATIENCE
               and waiting.look() < LONGEST_START):
            step(1)  # for nodes that wait for the first time
            reader.read()
            time.sleep(POLL)
        waiting, rest = ActiveTimer(), sandbox.ProgramIdleTimer(student)
        while (self.lockstep and processes.descendant_ids(student.process.pid) and student.exit_code() is None
               and rest.look() < COMPLETE and waiting.look() < LONGEST_COMPLETION):
            time.sleep(POLL)

    def _start_stimuli(self, box, reader):
        """Return the program of the stimuli, ready to start, or None if there are no stimuli."""
        if not self.exercise.stimuli:
            return None
        command = [sys.executable, '-m', take_line.__module__, STIMULI[1:], json.dumps(self.exercise.stimuli),
                   str(self.seed), str(BEGIN / 1e9 + self.observed.start + reader.dt)]  # tick 0 is the first step
        doing = sandbox.Student(box, command, lambda: 0.0)
        self._until(lambda: doing.lines, doing.process, 'stimuli')
        return doing

    def _watch(self, reader, student, simulator, stimuli, step):
        """Watch the run until the time is over, or the verdict can no longer change."""
        watching, limit = ActiveTimer(), self.exercise.time + SLACK
        used, stood = processes.cpu_time(simulator.pid), 0.0
        while reader.now < self.exercise.time and self._runs(simulator):
            before = time.monotonic()
            if self.lockstep:
                step(math.ceil(min(PERIOD, self.exercise.time - reader.now) / reader.dt - 1e-6))
            else:
                time.sleep(POLL)
                stood = max(stood, time.monotonic() - before - POLL)
            reader.read()
            self._listen(stimuli)
            if self._has_ended(student, reader.now) > AFTER_END and _done(stimuli):
                break
            if watching.look() > limit or self.busy:
                self.observed.kept_up = False
                break
            if reader.now >= self._looked + PERIOD:
                self._looked, followed = reader.now, self._following
                self._look_at_names()
                if self.lockstep and followed and not self._following:
                    self._wait_for_the_end(student)
                if self._settled(stimuli):
                    break
        with contextlib.suppress(OSError):  # it may have ended
            self.flooded = processes.cpu_time(simulator.pid) - used > FLOODED * watching.look()
        self.observed.timed_out = reader.now >= self.exercise.time
        if not (self._was_there() or self.observed.trouble or self.observed.events or self.observed.commands):
            self.observed.trouble = 'the program never started a node; does it call rospy.init_node?'
        if not self.lockstep:
            self._note_pace(watching, stood, reader.now)

    def _wait_for_the_end(self, student):
        """Wait for a program whose nodes have just ended: rospy's shutdown waits in wall time for its threads."""
        waiting = ActiveTimer()
        while student.exit_code() is None and not self._following and waiting.look() < ENDING:
            time.sleep(POLL)
            self._look_at_names()

    def _note_pace(self, watching, stood, now):
        """Note whether a run of ``now`` [s] kept real time, without a gap."""
        missing = watching.look() + watching.lost - now
        if missing > (1.0 - self._slowest_pace) * now + LAG:
            self.observed.kept_up = False
        elif stood > LONGEST_STALL and scoring.decide(self.exercise, self.observed).score < 100.0:
            self.observed.kept_up = False  # the commands of that time came late

    def _has_ended(self, student, now):
        """Return for how long [s] the program has ended, below 0 while it runs; note its end."""
        observed = self.observed
        if observed.ended_at is None and student.exit_code() is not None:
            student.drain()
            observed.ended_at, observed.exit_code, observed.trouble = now, student.exit_code(), student.trouble()
        return -1.0 if observed.ended_at is None else now - observed.ended_at

    def _listen(self, stimuli):
        """Read what the stimuli have done since the last time."""
        if stimuli:
            new = stimuli.lines[self._heard:]
            self._heard += len(new)
            for line in new:
                take_line(line.text, self.observed)

    def _settled(self, stimuli):
        """Return whether the verdict is final."""
        if judging.shortcuts(self.observed, self.exercise.allows) or self.observed.trouble:
            return True
        return (_done(stimuli) and len(self.observed.track) > 0 and self.observed.standstill() > ENOUGH_REST
                and scoring.decide(self.exercise, self.observed).score >= 100.0)

    def _simulator_command(self, box):
        """Return the command line of the exercise's simulator, which starts paused."""
        self._record = os.path.join(box.folder, 'record.csv')
        for old in (self._record, self._record + ACTIVE):  # of an earlier grading
            with contextlib.suppress(FileNotFoundError):
                os.remove(old)
        start = {axis: self._random.uniform(*limits) for axis, limits in self.exercise.start.items()}
        common = ['_rate:=1', '_clock:=true', '_paused:=true', f'_lockstep:={str(self.lockstep).lower()}']
        common.append(f'_record:={json.dumps(self._record)}')  # YAML: a folder may be called "Team #1"
        if self.exercise.simulator == 'turtlesim':
            self._simulator, self._dt = '/turtlesim', turtle_world.DT
            x, y = (start.get(axis, self._random.uniform(4.0, 7.0)) for axis in 'xy')
            return [_executable('turtlesim', 'turtlesim_node'), *common, '_window:=false',
                    f'_start:=[{x:.4f}, {y:.4f}, {start["theta"]:.4f}]']
        self._simulator, self._dt = '/robotont_gazebo', robot_world.DT
        return [_executable('robotont_gazebo', 'robotont_gazebo'), *common, '_model:=robotont_gazebo_basic',
                f'_x:={start.get("x", 0.0):.4f}', f'_y:={start.get("y", 0.0):.4f}', f'_yaw:={start["theta"]:.4f}']

    def _on_status(self, status):
        if status.late_steps:
            self.observed.kept_up = False
            self.busy = ', '.join(sorted(set(status.busy.split(', ')) & self._students))

    def _offers(self, service):
        try:
            return bool(rosgraph.Master(NODE).lookupService(service))
        except rosgraph.MasterError:
            return False

    def _until(self, condition, process, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            if process.poll() is not None:
                raise SessionError(f'the {what} ended immediately with exit code {process.returncode}; see {what}.txt')
            if time.monotonic() > end:
                raise SessionError(f'the {what} did not start within {PATIENCE:g} s')
            time.sleep(POLL)

    def _student_is_there(self):
        """Return whether a node of the student is running."""
        state = rosgraph.Master(NODE).getSystemState()
        self._students = {node for kind in state for _, users in kind for node in users} - self._own()
        self._following = bool(self._students)
        return self._following

    def _was_there(self):
        """Return whether a node of the student has ever run: even one that ends immediately leaves a log."""
        return self._students or set(os.listdir(os.environ['ROS_LOG_DIR'])) - {
            f'{name[1:]}.log' for name in ('/master', *self._own())}

    def _own(self):
        return {NODE, STIMULI, self._simulator, '/rosout'}

    def _look_at_names(self):
        """Note what the student's nodes publish, subscribe and serve, and who pretends to be the simulator."""
        try:
            published, subscribed, served = rosgraph.Master(NODE).getSystemState()
        except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
            return
        own = self._own()
        self._following = any(name == '/clock' and set(nodes) - own for name, nodes in subscribed)
        for names, role in ((published, 'publishes'), (subscribed, 'subscribes'), (served, 'serves')):
            for name, nodes in names:
                others = set(nodes) - own
                self._students |= others
                if others and name not in OF_EVERY_NODE:
                    self.observed.connections.add((name, role))
                if others and role == 'publishes' and name in FAKES:
                    self.observed.events.append(Event(self.observed.seconds, FAKES[name], (name,), min(others)))


def _done(stimuli):
    return stimuli is None or stimuli.exit_code() is not None


OF_EVERY_NODE = '/clock', '/rosout'
FAKES = {'/turtle1/pose': 'fake_pose', '/turtle1/color_sensor': 'fake_pose', '/odom': 'fake_pose',
         '/clock': 'fake_clock'}


def _executable(package, name):
    found = roslib.packages.find_node(package, name)
    if not found:
        raise SessionError(f'package {package} has no executable {name}; build the workspace with ./run build')
    return found[0]
