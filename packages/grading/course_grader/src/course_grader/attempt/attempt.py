"""One attempt at a grading, in a process of its own: a master, the simulator, the student's program, and an observer.

Everything runs in simulated time, which is paused until the program has registered with the master (or ended), so that
a slow start costs nothing. In lockstep no step starts before the nodes have finished the last one: the result does not
depend on the machine, and the simulator runs as fast as the nodes become idle. This holds for the observer, too: it
polls every PERIOD, and reads what is printed before the next step starts. A program that uses the wall clock, or never
sleeps, is observed in real time instead. Steps, time and poses come through a private connection (simulator_link.py).

Master and simulator are forked before this process has a second thread; only the Sandbox starts the student's program.
The process is discarded at the end: nothing is shut down in order.

Threads: the main thread watches; the stimuli and rospy's callbacks run in their own and only append to lists.
"""
import contextlib
import http.client
import json
import math
import os
import re
import resource
import shutil
import time
import traceback
import uuid
import xmlrpc.client

import psutil
import rosgraph
import rospy
import yaml

from course_grader.attempt import beside, forked, map_file, robots, static_analysis
from course_grader.attempt.guard import Guard
from course_grader.attempt.navigation_reader import NavigationReader
from course_grader.attempt.recording_reader import RecordingReader
from course_grader.attempt.simulator_link import SimulatorLink
from course_grader.attempt.state import StateReader
from course_grader.attempt.stimuli import Stimuli
from course_grader.isolation import levels, network, sandbox, student_files, trial, view
from course_grader.isolation.limits import CPU_ALLOWANCE, MANY_BUSY, MEGABYTE
from course_grader.isolation.sourced import Sourced
from course_grader.rules import judging, random_stimuli, scoring, symptoms
from course_grader.rules.observation import Event, Observed
from course_grader.supervision import policy
from course_grader.supervision.job import MASTER_LOG, RECORD, SIMULATOR_LOG, Attempted
from kinematic_core.timing.idle_threads import Gone, Machine, ProcessThreads
from kinematic_core.timing.pacing import BEGIN
from kinematic_core.timing.recorder import ACTIVE
from kinematic_core.timing.stall_free_timer import ActiveTimer
from kinematic_core.worlds import robot_world, turtle_world, world_format
from plain_support import processes
from rospy_support import rospy_internals, servers
from sim_ros import lockstep

SIMULATORS = {'turtlesim': ('/turtlesim', turtle_world.DT), 'robotont': ('/robotont_gazebo', robot_world.DT),
              'robots': ('/gazebo', robot_world.GAZEBO_DT)}  # of an exercise, or one with several robots
OF_EVERY_NODE = '/clock', '/rosout'  # topics
ROLES = {'PUB': 'publishes', 'SUB': 'subscribes', 'SERVICE': 'serves'}  # of a node for a name, as in the master's log
FAKES = {'/turtle1/pose': 'fake_pose', '/turtle1/color_sensor': 'fake_pose', '/odom': 'fake_pose',
         '/clock': 'fake_clock'}  # topic: kind of the event when the program publishes on it
POLL = 0.02  # [s] of wall time
PERIOD = 1.0  # [s] of simulated time between two polls of the master and the score
SHUTDOWN_TIMEOUT = 3.0  # [s] of wall time for a simulator to shut down, or a program to end after its nodes
START_TIMEOUT = 20.0  # [s] of wall time for master and simulator to start
IDLE_START, BUSY_IDLE_START = 10.0, 40.0  # [s] of wall time for an idle program to register with the master; while the
                                          # machine is busy, when even the kernel delivers what it waits for late
MAX_START = 60.0  # [s] of its processor time, the same for a busy program, such as one that still imports
IDLE_STARTED = 0.4  # [s] of idle time after which a launch file or script counts as started
MAX_COMPLETION = 15.0  # [s] of wall time for that
AFTER_END = 2.5  # [s] of simulated time that is observed after the program has ended
SETTLED = 3.0  # [s] of simulated time without motion after which a full score is final
HOG_CORES = 1.3  # cores that a program may use while the simulation cannot keep up; a busy loop takes one
UNMEASURED = 1.0  # [s] of processor time that may be older: it is polled from time to time
LEAST_SHARE = 0.2  # of the wall time, below which a simulator was not kept busy, but got no core
FLOODED_SHARE = 0.5  # busy share of a simulator, of the time for which it has a core; undisturbed 0.05
MAX_STALL = 0.25  # [s] for which the machine may stall in real time
WARM_UP = 2.0  # [s] of simulated time in which the nodes beside the simulator get map, transforms and scans
WORLD = 'world.yaml'
LAG = 0.1  # [s] of simulated time by which a recording may lag
SLACK = 20.0  # [s] of wall time on top of the exercise's own time: the hard limit in real time
BUSY_SHARE = 0.5  # of the wall time, of a run that met its limit: the processor time of the program itself
SERVER_SHARE = 0.3  # of the wall time, of a run that met its limit: more processor time of master, simulator and grader
                    # is due to what the program sends them; an honest program's run takes 0.05 of it
MAX_LOG = 16 * MEGABYTE  # [bytes] of the master's or the simulator's log; those of the samples have less than 30 kB
MAX_SERVER_MEMORY = 512 * MEGABYTE  # [bytes] of master or simulator; at the start 60 MB
LEAST_DISK, FULL_DISK = 8 * MEGABYTE, MEGABYTE // 4  # [bytes] free for the recording, which has up to 2 MB, and logs:
                                                     # before a grading, and below which it cannot go on
FULL = 'the disk of {} is full: make room there, or choose another folder with --output'
MANY_FILES = 512  # at a time; the samples, master and simulator have up to 60
TRIAL_TIME = 30.0  # [s] of wall time for a program that only imports, which takes 0.5 s
TRACEBACK = 30  # last lines of the output in which an exception is looked for
KILLED = -9, 137  # exit codes of SIGKILL
MODEST_MEMORY = 512.0  # [MB] up to which a program is not the cause if the machine has none left; samples have 150
MAX_SERVER_THREADS = 1_000  # of master or simulator, which have one for each connection; those of the samples have 40


class AttemptError(RuntimeError):
    """The grading failed for a reason that is not the student's; the text says why."""


class MachineError(AttemptError):
    """The machine lacks what a program needs; the program is no cause."""


class TooSlow(AttemptError):
    """The machine was too slow to begin a grading."""


def prepare(job):
    """Import what this Job needs beyond this module; a process that forks attempts does it once for all of them."""
    beside.prepare(job.exercise.beside)


def run(job):
    """Grade a Job once; return the Attempted. Raise OSError if its folder cannot be used.

    The attempt owns this process: its folder and environment become those of the Job.
    """
    os.chdir(job.folder)
    if job.exercise.of_map:
        return map_file.grade(job)
    try:
        command, remarks = sandbox.runnable(job.command)
        packages = job.packages or _package(command)
        sourced = job.sourced if not job.packages and job.sourced.concern(command) else Sourced()
        unusable = next(filter(None, map(student_files.unusable_packages, sourced.folders() or filter(
            None, [packages]))), '')
        if unusable and os.path.basename(command[0]) in sandbox.FIND_PACKAGES:
            raise sandbox.CommandError(unusable)
        job = job._replace(isolation=_isolation(job, command, packages, sourced))
        if unusable:  # the program is a file, which needs no package to be found
            remarks, packages, sourced = [*remarks, unusable], None, Sourced()
        _set_environment(sourced.environment(policy.environment(os.environ, packages)))
        chosen = policy_of(command, job.real_time)
        command = static_analysis.resolved(command)
    except sandbox.CommandError as error:
        failed = scoring.Verdict(scoring.FAILED, 0.0, [], [str(error)])
        return Attempted(symptoms.advise(job.exercise, Observed(), failed), Observed())
    attempt = Attempt(job, command, chosen, remarks)
    try:
        verdict = attempt.run()
    except (sandbox.IsolationError, MachineError) as error:
        attempt.student = None
        verdict = scoring.Verdict(scoring.UNDECIDED, 0.0, [], [str(error)])
    except AttemptError as error:
        attempt.observed.kept_up = not isinstance(error, TooSlow)
        verdict = scoring.Verdict(scoring.UNDECIDED, 0.0, [], [str(error)])
    except Exception as error:  # of any kind: if it happens again, the program is the cause
        if isinstance(error, OSError) and str(error.filename or '').startswith(job.output):
            raise
        traceback.print_exc()
        message = f'the grader itself failed: {type(error).__name__}: {error}'
        verdict = scoring.Verdict(scoring.UNDECIDED, 0.0, [], [message])
    return attempt.attempted(verdict)


def _package(command):
    """Return the package that contains the file of a command, or None, also for a package of this repository."""
    package = sandbox.package_of(command)
    return None if package and view.below(view.REPOSITORY, [os.path.realpath(package)]) else package


def _isolation(job, command, packages, sourced):
    """Return the Isolation of a Job with the program's own files; raise CommandError if one links elsewhere."""
    limits = job.isolation.limits
    if not limits.cpu:
        limits = limits._replace(cpu=math.ceil(job.exercise.time + CPU_ALLOWANCE))
    own = job.isolation.own or [*sourced.folders(), *sourced.built()] or view.own_files(
        command, packages, view.never_shown(view.REPOSITORY))
    escaped = view.escaping(command, own)
    if escaped:
        raise sandbox.CommandError(f'{escaped} is a link to a file of somebody else: hand in the file itself')
    return job.isolation._replace(limits=limits, own=tuple(own))


def policy_of(command, real_time):
    """Return the Policy for a command; raise CommandError if it starts its own simulator."""
    own = static_analysis.simulators(command)
    if own:
        raise sandbox.CommandError(f'the launch file starts its own simulator ({", ".join(own)}), but the '
                                   'grader has already started one: remove that node from the launch file')
    return policy.decide(static_analysis.wall_clock_call(command), static_analysis.compiled(command), real_time)


def hogs(used, wall):
    """Return whether a program that used ``used`` [s] of processor time in ``wall`` [s] slowed the simulation down."""
    return used > HOG_CORES * wall + UNMEASURED


def steps_for(seconds, dt):
    """Return how many steps of ``dt`` [s] make up a time [s], at least one."""
    return max(1, math.ceil(seconds / dt - 1e-6))


class Attempt:
    """One observation of a program."""

    def __init__(self, job, command, chosen, remarks):
        """``command`` can be started; ``chosen``: the Policy for it; ``remarks`` on it, as texts."""
        self._deadline = time.monotonic() + job.limit
        self._job, self.exercise, self._command, self._policy = job, job.exercise, command, chosen
        self.remarks = [*remarks, *chosen.remarks]
        self._kind = 'robots' if self.exercise.robots else self.exercise.simulator
        self._simulator, self._dt = SIMULATORS[self._kind]
        self._beside = {}  # {name: Forked} of the nodes beside the simulator
        self._record = os.path.join(job.output, RECORD)
        self._master_log = os.path.join(job.output, MASTER_LOG)
        self._simulator_log = os.path.join(job.output, SIMULATOR_LOG)
        self._node = f'/grader_{uuid.uuid4().hex[:12]}'
        self.student = None
        self.finished = False
        self.observed = Observed(plan=world_format.parse(self.exercise.world), solution=list(job.solution))
        self.observed.add_robots(self.exercise.robots)
        self._fakes = {**FAKES, **dict.fromkeys(beside.topics(self.exercise.beside), 'fake_result'),
                       **dict.fromkeys(robots.topics(self.exercise.robots), 'fake_pose')}
        self._polled_at = 0.0
        self._log_size = -1  # [bytes] of the master's log when the names were last read
        self._students = set()  # names of nodes that were seen
        self._following = False  # whether one of them follows /clock
        self.busy = ''  # the nodes that never slept, so that lockstep continued without them
        self.flooded = False  # the simulator was busy with what the nodes sent it

    def attempted(self, verdict):
        self.observed.source = static_analysis.source(self._command)
        verdict = symptoms.advise(self.exercise, self.observed, verdict)
        return Attempted(verdict, self.observed, tuple(self.remarks), self._policy.lockstep, self.busy, self.flooded,
                         broken=self.student is not None and not self.finished)

    def run(self):
        """Observe; return the Verdict. Raise AttemptError."""
        if self._job.isolation.level == levels.NAMESPACE:
            network.enter_own()
        _allow_files()
        if shutil.disk_usage(self._job.output).free < LEAST_DISK:
            raise MachineError(f'{FULL.format(self._job.output)}. A grading needs {LEAST_DISK / MEGABYTE:.0f} MB')
        with sandbox.Sandbox(self._job.output, os.environ, self._job.mark, self._job.isolation,
                             [self._job.output]) as box:
            self._box = box
            _set_environment(box.environment)
            self._guard = Guard(box.user)
            self._start_master(box)
            self._guard.trust(self._master_process.pid)
            simulator = self._start_simulator(box)
            self._guard.trust(simulator.pid)
            self._start_beside(box)
            servers.protect()
            rospy_internals.poll_for_registration()
            rospy.init_node(self._node[1:], argv=[], disable_signals=True, disable_rostime=True)  # time: SimulatorLink
            try:
                self._observe(box, simulator)
            finally:
                with contextlib.suppress(FileNotFoundError):
                    os.rename(self._record + ACTIVE, self._record)
        self.finished = True
        return scoring.decide(self.exercise, self.observed)

    def _start_master(self, box):
        """Start a master, which ends with the sandbox."""
        try:
            self._master_process, uri = forked.start_master(self._master_log, START_TIMEOUT, self._guard.admits)
        except TimeoutError as error:
            raise TooSlow(str(error)) from None
        box.keep(self._master_process)
        os.environ['ROS_MASTER_URI'] = box.environment['ROS_MASTER_URI'] = uri
        self._master = rosgraph.Master(self._node)  # over one connection, in the main thread only

    def _start_simulator(self, box):
        """Start the exercise's simulator, paused."""
        for old in (self._record, self._record + ACTIVE):  # of an earlier grading
            with contextlib.suppress(FileNotFoundError):
                os.remove(old)
        self._master.setParam('/use_sim_time', True)
        try:
            arguments = self._simulator_arguments(box.environment['TMPDIR'])
            more = [robots.described(self.exercise, self._job.seed, self._master)] if self.exercise.robots else []
            simulator, connection = forked.start_simulator(self._kind, arguments, self._simulator_log, *more)
            self._link = SimulatorLink(connection, self._dt)
        except ImportError as error:
            raise AttemptError(f'the simulator for {self.exercise.simulator} is missing ({error}): type ./run build. '
                               'Where ROS has a package of that name itself, its simulator takes the place of the one '
                               'here, but cannot be stepped as a grading needs') from None
        box.keep(simulator)
        return simulator

    def _start_beside(self, box):
        if not self.exercise.beside:
            return
        try:
            self._beside = beside.start(self.exercise, random_stimuli.start(self.exercise, self._job.seed),
                                        box.environment['TMPDIR'], self._job.output, self._master)
        except ImportError as error:
            raise AttemptError(f'a node of this exercise is missing ({error}): type ./run build. Where ROS has a '
                               'package of that name itself, its node takes the place of the one here, but cannot be '
                               'started as a grading needs') from None
        for process in self._beside.values():
            box.keep(process)
            self._guard.trust(process.pid)

    def _warm_up(self, simulator):
        """Let the nodes beside the simulator become ready, before the program starts."""
        if not self._beside:
            return
        beside.publish_mount()
        try:
            threads = [ProcessThreads(process.pid) for process in self._beside.values()]
            self._until(lambda: set(self._beside) <= _subscribers(self._master, '/clock')
                        and all(each.sleeps() for each in threads), simulator, 'simulator', self._job.limit)
        except Gone:
            ended = next((name for name, process in self._beside.items() if process.poll() is not None), '/node')
            log = os.path.join(self._job.output, f'{ended[1:]}.txt')
            raise AttemptError(f'{ended} ended immediately, see {ended[1:]}.txt{_last_line(log)}') from None
        if self._policy.lockstep:
            self._link.step(steps_for(WARM_UP, self._dt))
        else:
            self._link.resume()
            time.sleep(WARM_UP)

    def _simulator_arguments(self, folder):
        """Return the private parameters of the exercise's simulator; ``folder``: for a file of its world."""
        start = random_stimuli.start(self.exercise, self._job.seed)
        common = ['_rate:=1', '_clock:=true', '_paused:=true', f'_lockstep:={str(self._policy.lockstep).lower()}',
                  f'_record:={json.dumps(self._record, ensure_ascii=False)}']  # YAML: a folder may be called "Team #1"
        if self.exercise.simulator == 'turtlesim':
            limits = (0.0, turtle_world.ARENA_SIZE), (0.0, turtle_world.ARENA_SIZE), (-math.pi, math.pi)
            numbers = ', '.join(_decimal(start[axis], *ends) for axis, ends in zip(('x', 'y', 'theta'), limits))
            return [*common, '_window:=false', f'_start:=[{numbers}]']
        if self.exercise.world or self.exercise.robots:
            path = os.path.join(folder, WORLD)
            with open(path, 'w', encoding='utf-8') as file:
                yaml.safe_dump(self.exercise.world, file)  # not JSON: its 1e-09 is a text in YAML 1.1
            common.append(path if self.exercise.robots else f'_world:={path}')
        if self.exercise.robots:
            return [*common, f'_seed:={self._job.seed}']
        model = 'lidar' if self.exercise.beside else 'basic'
        if self.exercise.beside:
            common.append(f'_lockstep_wait:={beside.PATIENCE:g}')
        common += [f'_odom_{key}:={value:.9f}' for key, value in self.exercise.odometry.items()]
        return [*common, f'_seed:={self._job.seed}', f'_model:=robotont_gazebo_{model}', f'_x:={start["x"]:.4f}',
                f'_y:={start["y"]:.4f}', f'_yaw:={start["theta"]:.4f}']

    def _observe(self, box, simulator):
        reader = RecordingReader(self._record, self._dt, self.observed)
        self._link.listen()
        tried = None if self._job.tried or box.user is None else self._start_trial(box, trial.first_modules())
        self._until(lambda: self._link.ready, simulator, 'simulator')
        every = beside.STEPS if self._beside else 1
        self._link.tell_time(every)
        self._link.step(every)  # time begins
        self._warm_up(simulator)
        if tried:
            self._judge_trial(box, tried)
        self._kills_before = _kills_for_memory()
        try:
            student = self.student = sandbox.Student(box, self._command, reader.read)
        except sandbox.CommandError as error:
            self.observed.trouble = str(error)
            return
        except OSError as error:
            raise sandbox.IsolationError(f'the program could not be started: {error}') from None
        self.observed.lines = student.lines
        try:
            self._follow(reader, student, simulator)
        except (rospy.ROSException, rosgraph.MasterException, xmlrpc.client.Error,
                http.client.HTTPException, OSError, ValueError):  # ValueError: an answer of more than 20 MB
            self._check_servers(simulator)
            if not self.observed.trouble and not self._ended_by_student(simulator):
                raise
        self._blame_machine(box, student)
        self.observed.lines = list(student.lines)  # what it says when it is ended does not count
        if student.dropped:
            self.remarks.append(f'the program printed {len(student.lines) + student.dropped} lines; only the first '
                                f'{len(student.lines)} count')
        reader.close()

    def _start_trial(self, box, modules, limits=None):
        """Start a program of the grader that tries what others need, as their user; return it as a Student."""
        try:
            return sandbox.Student(box, trial.command(modules, limits), lambda: 0.0)
        except (sandbox.CommandError, OSError) as error:
            raise MachineError(f'no program can be started here: {error}') from None

    def _judge_trial(self, box, tried):
        """Raise MachineError if a trial fails."""
        waiting = ActiveTimer()
        while tried.exit_code() is None and waiting.elapsed() < TRIAL_TIME and not self._is_late():
            time.sleep(POLL)
        code = tried.exit_code()
        tried.end()
        if code:
            tried.drain()
            raise MachineError(trial.cause(tried.last_output(), box.user, box.seen()))

    def _blame_machine(self, box, student):
        """Raise MachineError if what has ended a program would end every other one here, too."""
        if not self.observed.trouble or student.exceeded_limit():
            return
        modules, scarce = trial.suspected('\n'.join(
            [self.observed.trouble, *(line.text for line in list(student.lines)[-TRACEBACK:])]))
        if modules or scarce:
            student.end()  # what it has taken is free again
            self._judge_trial(box, self._start_trial(box, modules, self._job.isolation.limits if scarce else None))
        if (student.exit_code() in KILLED and _kills_for_memory() > self._kills_before
                and student.memory() < MODEST_MEMORY):
            raise MachineError('this machine has no memory left: its kernel ended the program, which used '
                               f'{student.memory():.0f} MB. End other programs, or grade fewer at a time with --jobs')

    def _check_disk(self):
        """Raise MachineError if the disk of the results is full, unless the program has filled it."""
        if shutil.disk_usage(self._job.output).free >= FULL_DISK:
            return
        written = self._box.disk_used() if self._job.isolation.level != levels.NAMESPACE else 0.0
        if written * MEGABYTE < LEAST_DISK:
            raise MachineError(FULL.format(self._job.output))
        self.observed.trouble = f'the program filled the disk: it has written {written:.0f} MB'

    def _follow(self, reader, student, simulator):
        """Start time when the program has started, and watch until the end."""
        self._spent_before = self._spent(student, simulator)
        self._wait_for_student(student, simulator)
        self.observed.start = reader.read()
        if self.observed.trouble:
            return
        zero = BEGIN / 1e9 + self.observed.start + reader.dt  # tick 0 is the first step
        self._late_before = self._link.late  # steps that are no fault of the program
        self._state = StateReader(self.exercise, self.observed, BEGIN / 1e9 + reader.dt, self._link, reader.dt)
        self._navigation = NavigationReader(self.exercise, self.observed, BEGIN / 1e9 + reader.dt, self._link)
        stimuli = Stimuli(self.exercise, self._job.seed, zero, self.observed, self._link)
        stimuli.start()
        if not self._policy.lockstep:
            self._link.resume()
        self._watch(reader, student, simulator, stimuli)

    def _runs(self, simulator):
        """Return True while simulator and master run, and what is beside them; False if the program ended one.

        Raise AttemptError if one ended by itself.
        """
        if simulator.poll() is None and self._master_process.poll() is None:
            ended = next((name for name, process in self._beside.items() if process.poll() is not None), '')
            if ended and self._beside[ended].poll():
                raise AttemptError(f'{ended} ended with exit code {self._beside[ended].poll()}; see {ended[1:]}.txt')
            if ended:
                self.observed.trouble = (f'the program ended {ended}, by rosnode kill or by a node of the same name: '
                                         'choose another name, and do not start what runs already')
            return not ended
        if self._ended_by_student(simulator):
            return False
        raise AttemptError(f'the simulator ended with exit code {simulator.poll()}')

    def _ended_by_student(self, simulator):
        """Return whether a call, or a node of the same name, ended simulator, grader or master; record it."""
        if (self._master_process.poll() is None
                and simulator.wait(SHUTDOWN_TIMEOUT) != 0  # it runs, has crashed, or was killed
                and not rospy.is_shutdown() and self._master_process.poll() is None):
            return False
        self.observed.trouble = (
            'the program ended the simulator or the grader, by rosnode kill or by a node of the same name '
            f'({self._simulator}): choose another name, and start no simulator or roscore, as both are running')
        return True

    def _wait_for_student(self, student, simulator):
        """Keep time (nearly) paused until a node has started, or, with several processes, all of them."""
        idle, machine = sandbox.ProgramIdleTimer(student), Machine()
        while (not self._student_is_there() and not self._was_there() and student.exit_code() is None
               and idle.poll() < (BUSY_IDLE_START if machine.is_busy() else IDLE_START)
               and student.cpu() < MAX_START and not self._is_late() and not self.observed.trouble):
            self._link.step(0)  # lets a new node know the time; no step, as their number would depend on the machine
            self._check_servers(simulator)
            time.sleep(POLL)
        waiting, idle = ActiveTimer(), sandbox.ProgramIdleTimer(student)
        while (self._policy.lockstep and student.has_children() and student.exit_code() is None
               and idle.poll() < IDLE_STARTED and waiting.elapsed() < MAX_COMPLETION):
            time.sleep(POLL)

    def _watch(self, reader, student, simulator, stimuli):
        """Watch the run until the time is over, or the verdict can no longer change."""
        watching, began, stood = ActiveTimer(), time.monotonic(), 0.0
        before_all, before_used = processes.thread_times(simulator.pid), _cpu_time(simulator.pid)
        while reader.now < self.exercise.time and self._runs(simulator):
            before = time.monotonic()
            if self._policy.lockstep:
                self._link.step(steps_for(min(PERIOD, self.exercise.time - reader.now), reader.dt), self._deadline)
            else:
                time.sleep(POLL)
                stood = max(stood, time.monotonic() - before - POLL)
            self._read_lateness()
            reader.read()
            if self._has_ended(student, reader.now) > AFTER_END and stimuli.done():
                break
            if self.busy or self._is_late() or watching.elapsed() > self.exercise.time + SLACK:
                self.observed.kept_up = False
                break
            self._check_servers(simulator)
            self.observed.trouble = self._guard.refused() or self.observed.trouble
            if reader.now >= self._polled_at + PERIOD:
                self._polled_at = reader.now
                self._poll(student)
                self._check_disk()
                if self._settled(stimuli):
                    break
        self._state.read()
        self._navigation.read()
        self.observed.trouble = self._guard.refused() or self.observed.trouble
        self.flooded = _flooded(before_all, processes.thread_times(simulator.pid), time.monotonic() - began,
                                _cpu_time(simulator.pid) - before_used)
        self.observed.timed_out = reader.now >= self.exercise.time
        if self.observed.kept_up and not (self._was_there() or self.observed.trouble or self.observed.events
                                          or self.observed.commands or any(self.observed.turtles.values())):
            self.observed.trouble = 'the program never started a node; does it call rospy.init_node?'
        if not self._policy.lockstep:
            self._note_pace(watching, stood, reader.now)
        spent = self._spent(student, simulator)  # since its start, which may have taken all the time
        self._note_hog(*(after - before for before, after in zip(self._spent_before, spent)), student.greedy())

    def _spent(self, student, simulator):
        """Return the processor times [s] of the program, and of master, simulator and grader, and the time [s]."""
        servers = sum(map(_cpu_time, (simulator.pid, self._master_process.pid, os.getpid())))
        return student.cpu(), servers, time.monotonic()

    def _is_late(self):
        return time.monotonic() > self._deadline

    def _check_servers(self, simulator):
        """Record that the program made a log, the memory or the threads of master or simulator grow without bound."""
        for name, log, pid in (('master', self._master_log, self._master_process.pid),
                               ('simulator', self._simulator_log, simulator.pid)):
            with contextlib.suppress(OSError, psutil.Error):
                server = psutil.Process(pid)
                threads = server.num_threads()
                if threads > MAX_SERVER_THREADS:
                    self.observed.trouble = (f'the program opened too many connections to the {name}, which needs '
                                             f'{threads} threads for them, at most {MAX_SERVER_THREADS}')
                for what, size, limit in ((f'log of the {name}', os.path.getsize(log), MAX_LOG),
                                          (f'memory of the {name}', server.memory_info().rss, MAX_SERVER_MEMORY)):
                    if size > limit:
                        self.observed.trouble = (f'the program filled the {what}: {size / MEGABYTE:.0f} MB, at most '
                                                 f'{limit / MEGABYTE:.0f} MB, by what it sends, calls or registers')

    def _poll(self, student):
        """Record the state, and the names if the master has logged any since the last poll."""
        followed, log_size = self._following, os.path.getsize(self._master_log)
        if log_size != self._log_size:
            self._read_names()
        self._log_size = log_size
        self._state.read()
        self._navigation.read()
        if self._policy.lockstep and followed and not self._following:
            self._wait_for_the_end(student)

    def _wait_for_the_end(self, student):
        """Wait for a program whose nodes have just ended: rospy's shutdown joins its threads in wall time."""
        waiting = ActiveTimer()
        while student.exit_code() is None and not self._following and waiting.elapsed() < SHUTDOWN_TIMEOUT:
            time.sleep(POLL)
            self._read_names()

    def _note_hog(self, used, served, wall, greedy=False):
        """Record whether a program slowed the simulation down: ``used`` [s] of processor time in ``wall`` [s].

        ``served`` [s]: processor time of master, simulator and grader; ``greedy``: it kept many threads busy.
        """
        if self.observed.kept_up or self.observed.trouble:
            return
        if hogs(used, wall) or self._is_late() and used > BUSY_SHARE * wall:
            self.observed.trouble = (f'the program took {used:.0f} s of processor time in {wall:.0f} s, so that '
                                     'nothing was left for the simulation')
        elif greedy:
            self.observed.trouble = (f'the program kept {MANY_BUSY} or more threads busy at a time: since then it got '
                                     'only what the rest of the machine leaves')
        elif self._is_late() and served > SERVER_SHARE * wall:
            self.observed.trouble = (f'the program kept master, simulator and grader busy, for {served:.0f} s of '
                                     f'processor time in {wall:.0f} s, by what it sends, prints, calls or registers')

    def _note_pace(self, watching, stood, now):
        """Record whether a run of ``now`` [s] kept real time, without a gap."""
        missing = watching.elapsed() + watching.lost - now
        if missing > (1.0 - self._policy.slowest_pace) * now + LAG:
            self.observed.kept_up = False
        elif stood > MAX_STALL and scoring.decide(self.exercise, self.observed).score < 100.0:
            self.observed.kept_up = False  # commands were late

    def _has_ended(self, student, now):
        """Return how long ago [s] the program ended, a negative number while it runs; record its end."""
        observed = self.observed
        if observed.ended_at is None and student.exit_code() is not None:
            student.drain()
            observed.ended_at, observed.exit_code = now, student.exit_code()
            observed.trouble = observed.trouble or student.trouble()
        return -1.0 if observed.ended_at is None else now - observed.ended_at

    def _settled(self, stimuli):
        """Return whether the verdict is final."""
        if judging.shortcuts(self.observed, self.exercise.allows) or self.observed.trouble:
            return True
        return (stimuli.done() and len(self.observed.track) > 0 and self.observed.all_stand() > SETTLED
                and scoring.decide(self.exercise, self.observed).score >= 100.0)

    def _read_lateness(self):
        """Record whether steps were made although nodes were busy; all that follow /clock are the program's."""
        if self._link.late > self._late_before:
            self.observed.kept_up = False
            self.busy = '' if self._link.busy == lockstep.NOBODY else self._link.busy or self.busy

    def _until(self, condition, process, what, timeout=START_TIMEOUT):
        end = time.monotonic() + timeout
        while not condition():
            if process.poll() is not None:
                log = os.path.join(self._job.output, f'{what}.txt')
                raise AttemptError(f'the {what} ended immediately with exit code {process.poll()}, see {what}.txt'
                                   f'{_last_line(log)}')
            if time.monotonic() > end:
                raise TooSlow(f'the {what} did not start within {timeout:g} s')
            time.sleep(POLL)

    def _student_is_there(self):
        """Return whether a node of the student is running."""
        self._students = {node for kind in self._names() for _, users in kind for node in users} - self._own()
        self._following = bool(self._students)
        return self._following or bool(self.observed.trouble)

    def _names(self):
        """Return what the nodes publish, subscribe and serve; record that it is too much to be read."""
        try:
            return self._master.getSystemState()
        except ValueError:  # xmlrpc.client reads answers of at most 20 MB
            self.observed.trouble = ('the program registered so many or so long names that the state of the master '
                                     'cannot be read: it has more than 20 MB')
            return [], [], []

    def _was_there(self):
        """Return whether a node of the student has ever run: the master logs even one that ends immediately."""
        return self._students or any(node not in self._own() for _, _, node in forked.registrations(self._master_log))

    def _own(self):
        return {self._node, self._simulator, *self._beside}

    def _read_names(self):
        """Record what the student's nodes publish, subscribe and serve, and which pretend to be the simulator."""
        try:
            published, subscribed, served = self._names()
            self.observed.types.update(self._master.getTopicTypes())
        except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
            return
        own = self._own()
        self._following = any(name == '/clock' and set(nodes) - own for name, nodes in subscribed)
        for kind, name, node in forked.registrations(self._master_log):  # also of names that were there between polls
            if node not in own and name not in OF_EVERY_NODE:
                self.observed.connections.add((name, ROLES[kind]))
            if kind == 'PUB' and name in self._fakes and node not in own:
                self.observed.events.append(Event(self.observed.seconds, self._fakes[name], (name,), node))
        for names, role in zip((published, subscribed, served), ROLES.values()):
            for name, nodes in names:
                others = set(nodes) - own
                if set(nodes) & own:
                    self.observed.others.add((name, role))
                self._students |= others


def _flooded(before, after, seconds, used=0.0):
    """Return whether a process was busy for most of the time for which it had a core, between two thread_times().

    ``used`` [s]: its processor time including ended threads; each call of a service creates one.
    """
    spent = [[now - then for now, then in zip(times, before.get(thread, (0.0, 0.0)))]
             for thread, times in after.items()]
    if spent:
        _, waited = max(spent)  # its main thread, or the busiest one
        spent.append([used, waited])
    return any(ran > max(FLOODED_SHARE * (seconds - waited), LEAST_SHARE * seconds) for ran, waited in spent)


def _decimal(value, low, high):
    """Return a number within limits, with four decimals, which are within them, too."""
    return f'{min(max(round(value, 4), math.ceil(low * 1e4) / 1e4), math.floor(high * 1e4) / 1e4):.4f}'


def _allow_files():
    """Let this process and all that it starts open MANY_FILES; raise MachineError if that is not allowed."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = math.inf if hard == resource.RLIM_INFINITY else hard
    if most < MANY_FILES:
        raise MachineError(f'a process may open only {most} files here, and a grading needs {MANY_FILES}; ulimit -Hn '
                           'shows the limit, and /etc/security/limits.conf (nofile) sets it')
    if soft != resource.RLIM_INFINITY and soft < MANY_FILES:
        resource.setrlimit(resource.RLIMIT_NOFILE, (MANY_FILES, hard))


def _kills_for_memory():
    """Return how many processes the kernel has ended since it started because no memory was left."""
    with contextlib.suppress(OSError, IndexError, ValueError), open('/proc/vmstat', encoding='ascii') as file:
        return int(re.findall(r'^oom_kill (\d+)$', file.read(), re.MULTILINE)[0])
    return 0


def _last_line(path):
    """Return ': ' and the last line of a log, or ''."""
    with contextlib.suppress(OSError, IndexError), open(path, encoding='utf-8', errors='replace') as file:
        return ': ' + [line.strip() for line in file if line.strip()][-1]
    return ''


def _subscribers(master, topic):
    return {node for name, users in master.getSystemState()[1] if name == topic for node in users}


def _cpu_time(pid):
    """Return the processor time [s] of a process, 0 if it has ended."""
    try:
        return processes.cpu_time(pid)
    except OSError:
        return 0.0


def _set_environment(environment):
    os.environ.clear()
    os.environ.update(environment)
