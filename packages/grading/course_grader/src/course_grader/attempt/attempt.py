"""One attempt at a grading, in a process of its own: a simulation, the student's program, and an observer.

Everything runs in simulated time, which is paused until the program has registered with the master (or ended), so that
a slow start costs nothing. In lockstep no step starts before the nodes have finished the last one: the result does not
depend on the machine, and the simulator runs as fast as the nodes become idle. This holds for the observer, too: it
polls every PERIOD, and reads what is printed before the next step starts. A program that uses the wall clock, or never
sleeps, is observed in real time instead. Steps, time and poses come through a private connection (simulator_link.py).

Master and simulator are forked before this process has a second thread; only the Sandbox starts the student's program.
The process is discarded at the end: nothing is shut down in order.

Threads: the main thread watches; the stimuli and rospy's callbacks run in their own and only append to lists.
"""
import http.client
import math
import os
import time
import traceback
import xmlrpc.client

import rosgraph
import rospy

from course_grader.attempt import beside, machine_check, map_file, static_analysis
from course_grader.attempt.faults import AttemptError, MachineError, ProgramFault, TooSlow
from course_grader.attempt.forked import POLL
from course_grader.attempt.graph import Graph
from course_grader.attempt.guard import Guard
from course_grader.attempt.load import Flood, Load, Pace
from course_grader.attempt.machine_check import MachineCheck
from course_grader.attempt.recording_reader import RecordingReader
from course_grader.attempt.simulation import Simulation, steps_for
from course_grader.attempt.state import NavigationReader, StateReader
from course_grader.attempt.stimuli import Stimuli
from course_grader.isolation import levels, network, sandbox, student_files, view
from course_grader.isolation.limits import CPU_ALLOWANCE
from course_grader.isolation.sourced import Sourced
from course_grader.rules import judging, scoring, symptoms
from course_grader.rules.observation import Observed, Problem
from course_grader.supervision import policy
from course_grader.supervision.job import Attempted
from kinematic_core.timing.idle_threads import Machine
from kinematic_core.timing.pacing import BEGIN
from kinematic_core.timing.stall_free_timer import ActiveTimer
from kinematic_core.worlds import world_format
from plain_support import course
from rospy_support import rospy_internals, servers
from sim_ros import lockstep

PERIOD = 1.0  # [s] of simulated time between two polls of the master and the score
IDLE_START, BUSY_IDLE_START = 10.0, 40.0  # [s] of wall time for an idle program to register with the master; while the
                                          # machine is busy, when even the kernel delivers what it waits for late
MAX_START = 60.0  # [s] of its processor time, the same for a busy program, such as one that still imports
IDLE_STARTED = 0.4  # [s] of idle time after which a launch file or script counts as started
MAX_COMPLETION = 15.0  # [s] of wall time for that
END_TIMEOUT = 3.0  # [s] of wall time for a program to end after its nodes
AFTER_END = 2.5  # [s] of simulated time that is observed after the program has ended
SETTLED = 3.0  # [s] of simulated time without motion after which a full score is final
SLACK = 20.0  # [s] of wall time on top of the exercise's own time: the hard limit in real time
DISCONNECTED = (rospy.ROSException, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException, OSError,
                ValueError)  # from calls of master and simulator; ValueError: an answer of more than 20 MB


def prepare(job):
    """Import what this Job needs beyond this module; a process that forks attempts does it once for all of them."""
    beside.prepare(job.exercise.beside)
    course.repository()  # once: rospack searches for it


def run(job):
    """Grade a Job once; return the Attempted. Raise OSError if its folder cannot be used.

    The attempt owns this process: its folder and environment become those of the Job.
    """
    os.chdir(job.folder)
    if job.exercise.of_map:
        return map_file.grade(job)
    try:
        attempt = _prepared(job)
    except sandbox.CommandError as error:
        failed = scoring.Verdict(scoring.FAILED, 0.0, [], [str(error)])
        return Attempted(symptoms.advise(job.exercise, Observed(), failed), Observed())
    try:
        verdict = attempt.run()
    except (sandbox.IsolationError, MachineError) as error:
        attempt.student = None
        verdict = _undecided(str(error))
    except AttemptError as error:
        attempt.observed.kept_up = not isinstance(error, TooSlow)
        verdict = _undecided(str(error))
    except Exception as error:  # of any kind: if it happens again, the program is the cause
        if isinstance(error, OSError) and str(error.filename or '').startswith(job.output):
            raise
        traceback.print_exc()
        verdict = _undecided(f'the grader itself failed: {type(error).__name__}: {error}')
    return attempt.attempted(verdict)


def _undecided(reason):
    return scoring.Verdict(scoring.UNDECIDED, 0.0, [], [reason])


def _prepared(job):
    """Return the Attempt at a Job, in its environment; raise CommandError if its command cannot be run."""
    command, remarks = sandbox.runnable(job.command)
    packages = job.packages or _package(command)
    sourced = job.sourced if not job.packages and job.sourced.concern(command) else Sourced()
    unusable = next(filter(None, map(student_files.unusable_packages, sourced.folders() or filter(
        None, [packages]))), None)
    if unusable and os.path.basename(command[0]) in sandbox.FIND_PACKAGES:
        raise sandbox.CommandError(unusable)
    job = job._replace(isolation=_isolation(job, command, packages, sourced))
    if unusable:  # the program is a file, which needs no package to be found
        remarks, packages, sourced = [*remarks, unusable], None, Sourced()
    _set_environment(sourced.environment(policy.environment(os.environ, packages)))
    chosen = policy_of(command, job.real_time)
    return Attempt(job, static_analysis.resolved(command), chosen, remarks)


def _package(command):
    """Return the package that contains the file of a command, or None, also for a package of this repository."""
    package = sandbox.package_of(command)
    return None if package and view.below(str(course.repository()), [os.path.realpath(package)]) else package


def _isolation(job, command, packages, sourced):
    """Return the Isolation of a Job with the program's own files; raise CommandError if one links elsewhere."""
    limits = job.isolation.limits
    if not limits.cpu:
        limits = limits._replace(cpu=math.ceil(job.exercise.time + CPU_ALLOWANCE))
    own = job.isolation.own or [*sourced.folders(), *sourced.built()] or view.own_files(
        command, packages, view.never_shown(str(course.repository())))
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


class Attempt:
    """One observation of a program."""

    def __init__(self, job, command, chosen, remarks):
        """``command`` can be started; ``chosen``: the Policy for it; ``remarks`` on it, as texts."""
        self._deadline = time.monotonic() + job.limit
        self._job, self.exercise, self._command, self._policy = job, job.exercise, command, chosen
        self.remarks = [*remarks, *chosen.remarks]
        self.student = None
        self.finished = False
        self.observed = Observed(plan=world_format.parse(self.exercise.world), solution=list(job.solution))
        self.observed.add_robots(self.exercise.robots)
        self._polled_at = 0.0
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
        machine_check.allow_files()
        machine_check.check_space(self._job.output)
        with sandbox.Sandbox(self._job.output, os.environ, self._job.mark, self._job.isolation,
                             [self._job.output]) as box:
            _set_environment(box.environment)
            self._guard = Guard(box.user)
            self._machine = MachineCheck(self._job, box, self._deadline)
            self._simulation = Simulation(self._job, self._policy.lockstep)
            self._simulation.start(box, self._guard)
            servers.protect()
            rospy_internals.poll_for_registration()
            rospy.init_node(self._simulation.node[1:], argv=[], disable_signals=True,
                            disable_rostime=True)  # time: SimulatorLink
            try:
                self._observe(box)
            except ProgramFault as fault:
                self.observed.problem = fault.problem
            finally:
                self._simulation.keep_record()
        self.finished = True
        return scoring.decide(self.exercise, self.observed)

    def _observe(self, box):
        """Observe the program from before its start to its end. Raise ProgramFault if it cannot be started."""
        self._graph = Graph(self.exercise, self._simulation.master, self._simulation.master_log,
                            self._simulation.names(), self.observed)
        reader = RecordingReader(self._simulation.record, self._simulation.dt, self.observed)
        self._simulation.link.listen()
        tried = self._machine.first_trial()
        self._simulation.begin()
        if tried:
            self._machine.judge(tried)
        self._machine.program_starts()
        student = self.student = self._start_program(box, reader)
        self.observed.lines = student.lines
        try:
            self._follow(reader, student)
        except ProgramFault as fault:
            self.observed.problem = fault.problem
        except DISCONNECTED:
            self.observed.problem = (self._simulation.overloaded() or self.observed.problem
                                     or self._simulation.ended_by_program())
            if self.observed.problem is None:
                raise
        self._machine.blame(student, self.observed.problem)
        self.observed.lines = list(student.lines)  # what it says when it is ended does not count
        if student.dropped:
            self.remarks.append(f'the program printed {len(student.lines) + student.dropped} lines; only the first '
                                f'{len(student.lines)} count')
        reader.close()

    def _start_program(self, box, reader):
        try:
            return sandbox.Student(box, self._command, reader.read)
        except sandbox.CommandError as error:
            raise ProgramFault(Problem(str(error))) from None
        except OSError as error:
            raise sandbox.IsolationError(f'the program could not be started: {error}') from None

    def _follow(self, reader, student):
        """Start time when the program has started, and watch until the end. Raise ProgramFault."""
        load = Load(student, self._simulation.processes())
        try:
            self._wait_for_nodes(student)
        finally:
            self.observed.start = reader.read()
        first, link = BEGIN / 1e9 + reader.dt, self._simulation.link  # tick 0 is the first step
        self._late_before = link.late  # steps that are no fault of the program
        self._state = StateReader(self.exercise, self.observed, first, link, reader.dt)
        self._navigation = NavigationReader(self.exercise, self.observed, first, link)
        stimuli = Stimuli(self.exercise, self._job.seed, first + self.observed.start, self.observed, link)
        stimuli.start()
        if not self._policy.lockstep:
            link.resume()
        pace, flood = Pace(), Flood(self._simulation.processes()[0])
        try:
            self._watch(reader, student, stimuli, pace)
        except ProgramFault as fault:  # what it has filled is the cause of what cannot be read any more
            self.observed.problem = self._simulation.overloaded() or fault.problem
        self._conclude(reader, pace, flood, load)

    def _wait_for_nodes(self, student):
        """Keep time (nearly) paused until a node has started, or, with several processes, all of them."""
        idle, machine = sandbox.ProgramIdleTimer(student), Machine()
        while (not self._graph.has_nodes() and not self._graph.had_nodes() and student.exit_code() is None
               and idle.poll() < (BUSY_IDLE_START if machine.is_busy() else IDLE_START)
               and student.cpu() < MAX_START and not self._is_late()):
            self._simulation.link.step(0)  # tells a new node the time; no step: their number depends on the machine
            problem = self._simulation.overloaded()
            if problem:
                raise ProgramFault(problem)
            time.sleep(POLL)
        waiting, idle = ActiveTimer(), sandbox.ProgramIdleTimer(student)
        while (self._policy.lockstep and student.has_children() and student.exit_code() is None
               and idle.poll() < IDLE_STARTED and waiting.elapsed() < MAX_COMPLETION):
            time.sleep(POLL)

    def _watch(self, reader, student, stimuli, pace):
        """Watch the run until the time is over, or the verdict can no longer change. Raise ProgramFault."""
        while reader.now < self.exercise.time:
            self._simulation.check_runs()
            if self._policy.lockstep:
                seconds = min(PERIOD, self.exercise.time - reader.now)
                self._simulation.link.step(steps_for(seconds, reader.dt), self._deadline)
            else:
                pace.sleep()
            self._read_lateness()
            reader.read()
            if self._has_ended(student, reader.now) > AFTER_END and stimuli.done():
                return
            if self.busy or self._is_late() or pace.elapsed() > self.exercise.time + SLACK:
                self.observed.kept_up = False
                return
            problem = self.observed.problem = (
                self._guard.refused() or self._simulation.overloaded() or self.observed.problem)
            if problem or reader.now >= self._polled_at + PERIOD:
                self._polled_at = reader.now
                self._poll(student)
                self._machine.check_disk()
                if problem or self._settled(stimuli):
                    return

    def _conclude(self, reader, pace, flood, load):
        """Record how the run ended, and what was wrong with the program."""
        self._state.read()
        self._navigation.read()
        self.flooded = flood.seen()
        self.observed.timed_out = reader.now >= self.exercise.time
        self.observed.problem = self._guard.refused() or self.observed.problem or self._never_started()
        if not self._policy.lockstep and (
                pace.is_behind(reader.now, self._policy.slowest_pace)
                or pace.stalled() and scoring.decide(self.exercise, self.observed).score < 100.0):
            self.observed.kept_up = False
        if not self.observed.kept_up and self.observed.problem is None:
            self.observed.problem = load.problem(self._is_late())

    def _never_started(self):
        """Return the Problem if the program did nothing at all although it had the time, or None."""
        if not self.observed.kept_up or self._graph.had_nodes() or (
                self.observed.events or self.observed.commands or any(self.observed.turtles.values())):
            return None
        return Problem('the program never started a node; does it call rospy.init_node?')

    def _is_late(self):
        return time.monotonic() > self._deadline

    def _poll(self, student):
        """Record the state, and the names if the master has logged any since the last poll."""
        followed = self._graph.following
        self._graph.update()
        self._state.read()
        self._navigation.read()
        if self._policy.lockstep and followed and not self._graph.following:
            self._wait_for_the_end(student)

    def _wait_for_the_end(self, student):
        """Wait for a program whose nodes have just ended: rospy's shutdown joins its threads in wall time."""
        waiting = ActiveTimer()
        while student.exit_code() is None and not self._graph.following and waiting.elapsed() < END_TIMEOUT:
            time.sleep(POLL)
            self._graph.read()

    def _has_ended(self, student, now):
        """Return how long ago [s] the program ended, a negative number while it runs; record its end."""
        observed = self.observed
        if observed.ended_at is None and student.exit_code() is not None:
            student.drain()
            observed.ended_at, observed.exit_code = now, student.exit_code()
            observed.problem = observed.problem or student.problem()
        return -1.0 if observed.ended_at is None else now - observed.ended_at

    def _settled(self, stimuli):
        """Return whether the verdict is final."""
        if judging.shortcuts(self.observed, self.exercise.allows):
            return True
        return (stimuli.done() and len(self.observed.track) > 0 and self.observed.all_stand() > SETTLED
                and scoring.decide(self.exercise, self.observed).score >= 100.0)

    def _read_lateness(self):
        """Record whether steps were made although nodes were busy; all that follow /clock are the program's."""
        link = self._simulation.link
        if link.late > self._late_before:
            self.observed.kept_up = False
            self.busy = '' if link.busy == lockstep.NOBODY else link.busy or self.busy


def _set_environment(environment):
    os.environ.clear()
    os.environ.update(environment)
