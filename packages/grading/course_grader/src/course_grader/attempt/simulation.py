"""The simulation that a program meets: a master, a simulator, and the nodes beside it, forked from this process.

Start it before this process has a second thread. It is not shut down in order: the sandbox ends its processes.
"""
import contextlib
import importlib
import json
import math
import os
import time
import uuid

import psutil
import rosgraph
import rospkg
import rospy
import yaml

from course_grader.attempt import beside, forked, graph
from course_grader.attempt.faults import AttemptError, ProgramFault, TooSlow
from course_grader.attempt.forked import POLL
from course_grader.attempt.simulator_link import SimulatorLink
from course_grader.isolation.limits import MEGABYTE
from course_grader.rules import random_stimuli
from course_grader.rules.observation import Problem
from course_grader.supervision.job import MASTER_LOG, RECORD, SIMULATOR_LOG
from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.recorder import ACTIVE
from kinematic_core.worlds import robot_world, turtle_world
from kinematic_core.worlds.planar import Pose2D

SIMULATORS = {'turtlesim': ('/turtlesim', turtle_world.DT), 'robotont': ('/robotont_gazebo', robot_world.DT),
              'robots': ('/gazebo', robot_world.GAZEBO_DT)}  # of an exercise, or one with several robots
DESCRIPTION = 'robotont_description.urdf'  # module with describe(); the original package does not have it
MODEL = 'robotont_gazebo_lidar'  # of several robots in one world
START_TIMEOUT = 20.0  # [s] of wall time for master and simulator to start
SHUTDOWN_TIMEOUT = 3.0  # [s] of wall time for a simulator to shut down
WARM_UP = 2.0  # [s] of simulated time in which the nodes beside the simulator get map, transforms and scans
WORLD = 'world.yaml'
MAX_LOG = 16 * MEGABYTE  # [bytes] of the master's or the simulator's log; those of the samples have less than 30 kB
MAX_SERVER_MEMORY = 512 * MEGABYTE  # [bytes] of master or simulator; at the start 60 MB
MAX_SERVER_THREADS = 1_000  # of master or simulator, which have one for each connection; those of the samples have 40


class Simulation:
    """Master, simulator, and the nodes beside it; the simulation is paused at first."""

    def __init__(self, job, lockstep):
        """``lockstep``: whether the simulator waits for the nodes."""
        self._job, self._exercise, self._lockstep = job, job.exercise, lockstep
        self._kind = 'robots' if job.exercise.robots else job.exercise.simulator
        self._simulator_name, self.dt = SIMULATORS[self._kind]
        self.node = f'/grader_{uuid.uuid4().hex[:12]}'  # the name of the grader's node
        self.record = os.path.join(job.output, RECORD)
        self.master_log = os.path.join(job.output, MASTER_LOG)
        self._simulator_log = os.path.join(job.output, SIMULATOR_LOG)
        self._beside = {}  # {name: Forked} of the nodes beside the simulator

    def start(self, box, guard):
        """Start all, to end with the Sandbox ``box``; the Guard trusts them. Raise AttemptError."""
        self._start_master(box, guard)
        self._start_simulator(box, guard)
        self._start_beside(box, guard)

    def _start_master(self, box, guard):
        try:
            self._master_process, uri = forked.start_master(self.master_log, START_TIMEOUT, guard.admits)
        except TimeoutError as error:
            raise TooSlow(str(error)) from None
        box.keep(self._master_process)
        guard.trust(self._master_process.pid)
        os.environ['ROS_MASTER_URI'] = box.environment['ROS_MASTER_URI'] = uri
        self.master = rosgraph.Master(self.node)  # over one connection, in the main thread only

    def _start_simulator(self, box, guard):
        for old in (self.record, self.record + ACTIVE):  # of an earlier grading
            with contextlib.suppress(FileNotFoundError):
                os.remove(old)
        self.master.setParam('/use_sim_time', True)
        try:
            arguments = self._arguments(box.environment['TMPDIR'])
            more = [self._described()] if self._exercise.robots else []
            self._simulator, connection = forked.start_simulator(self._kind, arguments, self._simulator_log, *more)
        except ImportError as error:
            raise AttemptError(f'the simulator for {self._exercise.simulator} is missing ({error}): type ./run build. '
                               'Where ROS has a package of that name itself, its simulator takes the place of the one '
                               'here, but cannot be stepped as a grading needs') from None
        self.link = SimulatorLink(connection, self.dt)
        box.keep(self._simulator)
        guard.trust(self._simulator.pid)

    def _described(self):
        """Return [(name, URDF, Pose2D)] of several robots, and set the prefixes of their frames. Raise ImportError."""
        urdf = importlib.import_module(DESCRIPTION)
        folder = os.path.join(rospkg.RosPack().get_path('robotont_description'), 'urdf')
        for name in self._exercise.robots:
            self.master.setParam(f'/{name}/tf_prefix', name)
        return [(name, urdf.describe(MODEL, f'{name}/', folder), Pose2D(start['x'], start['y'], start['theta']))
                for name, start in random_stimuli.robots(self._exercise, self._job.seed).items()]

    def _arguments(self, folder):
        """Return the private parameters of the exercise's simulator; ``folder``: for a file of its world."""
        start = random_stimuli.start(self._exercise, self._job.seed)
        common = ['_rate:=1', '_clock:=true', '_paused:=true', f'_lockstep:={str(self._lockstep).lower()}',
                  f'_record:={json.dumps(self.record, ensure_ascii=False)}']  # YAML: a folder may be called "Team #1"
        if self._exercise.simulator == 'turtlesim':
            limits = (0.0, turtle_world.ARENA_SIZE), (0.0, turtle_world.ARENA_SIZE), (-math.pi, math.pi)
            numbers = ', '.join(_decimal(start[axis], *ends) for axis, ends in zip(('x', 'y', 'theta'), limits))
            return [*common, '_window:=false', f'_start:=[{numbers}]']
        if self._exercise.world or self._exercise.robots:
            path = os.path.join(folder, WORLD)
            with open(path, 'w', encoding='utf-8') as file:
                yaml.safe_dump(self._exercise.world, file)  # not JSON: its 1e-09 is a text in YAML 1.1
            common.append(path if self._exercise.robots else f'_world:={path}')
        if self._exercise.robots:
            return [*common, f'_seed:={self._job.seed}']
        model = 'lidar' if self._exercise.beside else 'basic'
        if self._exercise.beside:
            common.append(f'_lockstep_wait:={beside.PATIENCE:g}')
        common += [f'_odom_{key}:={value:.9f}' for key, value in self._exercise.odometry.items()]
        return [*common, f'_seed:={self._job.seed}', f'_model:=robotont_gazebo_{model}', f'_x:={start["x"]:.4f}',
                f'_y:={start["y"]:.4f}', f'_yaw:={start["theta"]:.4f}']

    def _start_beside(self, box, guard):
        if not self._exercise.beside:
            return
        try:
            self._beside = beside.start(self._exercise, random_stimuli.start(self._exercise, self._job.seed),
                                        box.environment['TMPDIR'], self._job.output, self.master)
        except ImportError as error:
            raise AttemptError(f'a node of this exercise is missing ({error}): type ./run build. Where ROS has a '
                               'package of that name itself, its node takes the place of the one here, but cannot be '
                               'started as a grading needs') from None
        for process in self._beside.values():
            box.keep(process)
            guard.trust(process.pid)

    def names(self):
        """Return the names of the grading's own nodes."""
        return {self.node, self._simulator_name, *self._beside}

    def processes(self):
        """Return the process ids of simulator and master."""
        return self._simulator.pid, self._master_process.pid

    def begin(self):
        """Wait until the simulator is ready, let time begin, and let the nodes beside it become ready."""
        self._wait_for_start(lambda: self.link.ready)
        every = beside.STEPS if self._beside else 1
        self.link.tell_time(every)
        self.link.step(every)
        if self._beside:
            self._warm_up()

    def _wait_for_start(self, condition, timeout=START_TIMEOUT):
        """Wait until the simulator has started; raise AttemptError if it ends, or takes too long."""
        end = time.monotonic() + timeout
        while not condition():
            code = self._simulator.poll()
            if code is not None:
                raise AttemptError(f'the simulator ended immediately with exit code {code}, see {SIMULATOR_LOG}'
                                   f'{_last_line(self._simulator_log)}')
            if time.monotonic() > end:
                raise TooSlow(f'the simulator did not start within {timeout:g} s')
            time.sleep(POLL)

    def _warm_up(self):
        beside.publish_mount()
        try:
            threads = [ProcessThreads(process.pid) for process in self._beside.values()]
            self._wait_for_start(lambda: set(self._beside) <= graph.subscribers(self.master, '/clock')
                                 and all(each.sleeps() for each in threads), self._job.limit)
        except Gone:
            ended = next((name for name, process in self._beside.items() if process.poll() is not None), '/node')
            log = os.path.join(self._job.output, f'{ended[1:]}.txt')
            raise AttemptError(f'{ended} ended immediately, see {ended[1:]}.txt{_last_line(log)}') from None
        if self._lockstep:
            self.link.step(steps_for(WARM_UP, self.dt))
        else:
            self.link.resume()
            time.sleep(WARM_UP)

    def check_runs(self):
        """Raise ProgramFault if the program ended master, simulator or a node; AttemptError if one crashed."""
        if self._simulator.poll() is not None or self._master_process.poll() is not None:
            problem = self.ended_by_program()
            if problem:
                raise ProgramFault(problem)
            raise AttemptError(f'the simulator ended with exit code {self._simulator.poll()}')
        ended = next((name for name, process in self._beside.items() if process.poll() is not None), None)
        if ended is None:
            return
        code = self._beside[ended].poll()
        if code:
            raise AttemptError(f'{ended} ended with exit code {code}; see {ended[1:]}.txt')
        raise ProgramFault(Problem(f'the program ended {ended}, by rosnode kill or by a node of the same name: choose '
                                   'another name, and do not start what runs already'))

    def ended_by_program(self):
        """Return the Problem if a call, or a node of the same name, ended simulator, grader or master, or None."""
        if (self._master_process.poll() is None
                and self._simulator.wait(SHUTDOWN_TIMEOUT) != 0  # it runs, has crashed, or was killed
                and not rospy.is_shutdown() and self._master_process.poll() is None):
            return None
        return Problem('the program ended the simulator or the grader, by rosnode kill or by a node of the same name '
                       f'({self._simulator_name}): choose another name, and start no simulator or roscore, as both '
                       'are running')

    def overloaded(self):
        """Return the Problem if log, memory or threads of simulator or master grew without bound, or None."""
        return (_overloaded('simulator', self._simulator.pid, self._simulator_log)
                or _overloaded('master', self._master_process.pid, self.master_log))

    def keep_record(self):
        """Give the recording its name, also if the simulator did not end in order."""
        with contextlib.suppress(FileNotFoundError):
            os.rename(self.record + ACTIVE, self.record)


def _overloaded(name, pid, log):
    """Return the Problem if a program made a server need too much, or None."""
    with contextlib.suppress(OSError, psutil.Error):
        server = psutil.Process(pid)
        for what, size, limit in (('memory', server.memory_info().rss, MAX_SERVER_MEMORY),
                                  ('log', os.path.getsize(log), MAX_LOG)):
            if size > limit:
                return Problem(f'the program filled the {what} of the {name}: {size / MEGABYTE:.0f} MB, at most '
                               f'{limit / MEGABYTE:.0f} MB, by what it sends, calls or registers')
        threads = server.num_threads()
        if threads > MAX_SERVER_THREADS:
            return Problem(f'the program opened too many connections to the {name}, which needs {threads} threads for '
                           f'them, at most {MAX_SERVER_THREADS}')
    return None


def steps_for(seconds, dt):
    """Return how many steps of ``dt`` [s] make up a time [s], at least one."""
    return max(1, math.ceil(seconds / dt - 1e-6))


def _decimal(value, low, high):
    """Return a number within limits, with four decimals, which are within them, too."""
    return f'{min(max(round(value, 4), math.ceil(low * 1e4) / 1e4), math.floor(high * 1e4) / 1e4):.4f}'


def _last_line(path):
    """Return ': ' and the last line of a log, or ''."""
    with contextlib.suppress(OSError, IndexError), open(path, encoding='utf-8', errors='replace') as file:
        return ': ' + [line.strip() for line in file if line.strip()][-1]
    return ''
