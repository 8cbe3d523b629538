"""Pace a simulator (real time, N times as fast, as fast as possible, or step by step) and publish /clock.

How to use it in a simulator::

    def main():
        init_simulator('my_simulator', PARAMETERS)  # instead of rospy.init_node; with the parameters below
        clock = SimulatorClock(STEP)         # [s]; reads the parameters below, offers the services
        clock.services.add(...)              # services that change the world: answered at the start of the next step
        ...                                  # topics
        clock.run(step)                      # calls step() until shutdown

``step()`` advances the simulated world by STEP and publishes what is new; stamps are ``rospy.Time.now()``. With /clock,
that is the simulated time at the end of the step (without, it is wall time). The message on /clock follows when step()
returns, so that a node that waits for a time finds everything that belongs to it published. A simulator must not wait
for simulated time in the thread that calls ``run``. Random numbers come from ``seeded_random()``.

Private parameters: ``~rate``, ``~clock``, ``~paused``, ``~lockstep``, ``~lockstep_wait``; services ``~pause``,
``~resume`` (std_srvs/Trigger), ``~step`` (sim_ros/Step), ``~set_rate`` (sim_ros/SetRate); topic ``~clock_status``
(sim_ros/ClockStatus, latched). A simulator that another program has started with a ParentLink refuses the services.

Lockstep (see sim_ros.lockstep): no step starts before every node of this machine that follows /clock is idle. A node
that waits in wall time (time.sleep; rospy.wait_for_message polls) counts as idle.

/use_sim_time: a simulator that publishes /clock sets it to true if it is not set; nodes that started earlier use wall
time. A launch file should set it first. When the simulator ends, it deletes the parameter if it or a launch file has
set it.

Threading contract: ``run`` is called in one thread, which also answers ``services``; ~pause, ~resume, ~step and
~set_rate run in rospy's threads.
"""
from __future__ import annotations

import math
import os
import random
import time
from typing import Any, Callable

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger, TriggerResponse

from kinematic_core.timing.pacing import Pacer, StepRequest
from plain_support.doctor import findings
from rospy_support import nodes, parameters, registration, rospy_internals
from rospy_support.parameters import Boolean, Computed, Integer, Number, Table
from rospy_support.rospy_internals import frame
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher, Publisher
from sim_ros.frame_services import MASTER_TIMEOUT, FrameServices
from sim_ros.lockstep import Lockstep
from sim_ros.msg import ClockStatus
from sim_ros.parent_link import ParentLink
from sim_ros.srv import SetRate, SetRateResponse, Step, StepResponse
from sim_ros.subscriber_backlog import LagMonitor

REAL_TIME = 1.0  # simulated seconds per second of wall time
SLOWEST, FASTEST = 0.01, 1000.0
PARAMETERS = Table(Number('~rate', REAL_TIME, SLOWEST, FASTEST, infinite='max'),
                   Boolean('~clock', Computed('true where `~rate` is not 1')), Boolean('~paused', False),
                   Boolean('~lockstep', Computed('true where `~rate` is max')),
                   Number('~lockstep_wait', 3.0, 0.0, 60.0, unit='s'), run_only=True)
SEED = Integer('~seed', 0, 0)
MAX_STEPS = 1_000_000  # of one call of ~step
CLOCK_SIZE = len(frame(Clock()))  # [bytes]
WARNING_PERIOD = 10.0  # [s] of wall time between two warnings of one kind
ANSWER_POLL = 0.5  # [s] between two checks for a shutdown while waiting for an answer
USE_SIM_TIME = '/use_sim_time'
STATUS_PERIOD = 1.0  # [s] of wall time between two messages on ~clock_status
ENOUGH = 0.9  # a smaller share of the requested rate causes a warning
WINDOW = 5  # periods in which it has to be smaller; a short stall is caught up, and needs no warning


def init_simulator(name: str, declared: Table) -> None:
    """Initialise rospy for a simulator, which must not wait for its own /clock. Call SimulatorClock next.

    ``declared`` is the parameters.Table of the simulator.
    """
    nodes.init_node(name, declared, disable_rostime=True)


def seeded_random() -> random.Random:
    """Return a random.Random of the parameter ``~seed``; the same seed gives the same numbers."""
    return random.Random(SEED.read())


class SimulatorClock:
    """Paces a simulator's steps and publishes their time."""

    def __init__(self, step: float, parent: ParentLink | None = None, paused: bool = False,
                 publishes: bool = False) -> None:
        """Read the parameters, register services and topics; ``step`` [s] is the simulated time of one step.

        ``parent``: the ParentLink to the program that owns the time; ``paused``: the command line says so, whatever
        the parameter is; ``publishes``: the default of ~clock is true, at any rate.
        """
        self._parent = parent
        rate, self._lockstep_timeout, waits = PARAMETERS.read('~rate', '~lockstep_wait', '~paused')
        paused = paused or waits
        self._publishes = PARAMETERS['~clock'].read(publishes or rate != REAL_TIME)
        lockstep = PARAMETERS['~lockstep'].read(self._publishes and rate == math.inf)
        if lockstep and not self._publishes:
            raise parameters.ParameterError(f'parameter {rospy.resolve_name("~lockstep")} is true, but without /clock '
                                            'no node follows the steps; set ~clock to true as well')
        self._pacer = Pacer(step, rate, bounded=self._bounded(rate), paused=paused)
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._status = StatusReporter(self._pacer, lockstep, self._throttle, followed=self._publishes)
        self._clock: LatestPublisher | None = None  # the publisher of /clock
        self._lockstep: Lockstep | None = None  # waits for the nodes that follow /clock
        self._lag: LagMonitor | None = None  # without lockstep: finds nodes that fall behind /clock
        self._published: dict[str, int] = {}  # {topic: number of messages} in the last step
        self._sets_sim_time = False  # /use_sim_time has to be deleted at the end
        if self._publishes:
            self._own_clock(step, lockstep)
        else:
            self._use_other_clock()
        self.services = FrameServices(self._on_call, by_name=self._lockstep is not None)
        rospy.Service('~pause', Trigger, self.unless_owned(lambda _: self.pause()))
        rospy.Service('~resume', Trigger, self.unless_owned(lambda _: self.resume()))
        rospy.Service('~step', Step, self.unless_owned(self._step_by_hand))
        rospy.Service('~set_rate', SetRate, self.unless_owned(self._set_rate))
        rospy.on_shutdown(self._pacer.close)
        registration.on_return(self._restore)
        if paused and not parent:
            rospy.loginfo('Started paused, because %s. rosservice call %s lets time run.',
                          f'{rospy.resolve_name("~paused")} is true' if waits else 'the command line says so (-u)',
                          rospy.resolve_name('~resume'))

    @property
    def paused(self) -> bool:
        """Return whether time stands still."""
        return self._pacer.paused

    def run(self, step: Callable[[], object]) -> None:
        """Call ``step()`` whenever a step is due, until shutdown."""
        self._report()
        if self._parent:
            self._parent.serve(self._pacer)
        while not rospy.is_shutdown():
            given_up = self._pacer.wait()
            if given_up is None:
                self._no_step_due()
                continue
            if self._pacer.rate == math.inf and not self._clock_wanted() and not self._pacer.paused:
                time.sleep(self._pacer.step)  # without this, years would pass before the first node follows
            if given_up and not self._lockstep:
                rospy.logwarn('The simulator stood still for %.1f s (was the machine suspended?); it continues '
                              'from here.', given_up)
            if self._clock:
                self._step_and_publish(step, self._clock)
            else:
                self._answer()
                step()
                self._report()

    def pause(self) -> TriggerResponse:
        """Stop time; return a TriggerResponse when it has stopped. Do not call it in the thread of ``run``."""
        request = self._pacer.pause()
        self._wait_until_made(request)
        if not request.made:
            return TriggerResponse(False, 'the simulator was resumed in the meantime: '
                                   + self._time_after(self._pacer.steps))
        return TriggerResponse(True, self._time_after(request.last))

    def resume(self) -> TriggerResponse:
        """Let time continue; return a TriggerResponse."""
        return TriggerResponse(True, self._time_after(self._pacer.resume()))

    def _step_and_publish(self, step: Callable[[], object], clock: LatestPublisher) -> None:
        """Make a step, then publish its time; in lockstep, before and after it, wait until all nodes are idle.

        A parent may want that in every N-th step only.
        """
        every = self._parent.every if self._parent else 1
        if self._lockstep and (self._pacer.steps - 1) % every == 0:  # the time was published after the last step
            self._wait_for_nodes(self._lockstep)
        now, calls = self._set_time(), self.services.batch
        self._answer()
        step()
        if self._pacer.steps % every:
            return
        if self._lockstep and (self.services.batch != calls or self._has_published()
                               or self._parent and self._parent.answers):
            # otherwise, chance decides whether a node handles the messages of this step or /clock first
            self._wait_for_nodes(self._lockstep)
        clock.publish(now)
        if self._lag:
            self._warn_of_lag(self._lag)
        self._report()
        if self._parent:
            late, busy = self._lateness()
            self._parent.stepped(self._pacer.steps, late, '' if self._lockstep and self._lockstep.starved else busy)

    def unless_owned(self, handler: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Return the handler of a service that controls time; it refuses if another program owns the time."""
        def refuse(_: Any) -> None:
            raise rospy.ServiceException('time belongs to the program that has started this simulator')
        return refuse if self._parent else handler

    def _restore(self) -> None:
        """Restore the registrations and parameters that a restarted master has lost."""
        if self._lockstep:
            self._lockstep.watch_master()
        if self._sets_sim_time and not rospy.has_param(USE_SIM_TIME):
            rospy.set_param(USE_SIM_TIME, True)

    def _set_time(self) -> rospy.Time:
        """Set the ROS time of this process directly, without the topic; return it."""
        now = rospy.Time(*divmod(self._pacer.nanoseconds, 1_000_000_000))
        rospy_internals.set_time(now)
        return now

    def _has_published(self) -> bool:
        """Return whether something was published to a node since the last call, besides the time."""
        before, self._published = self._published, rospy_internals.published_messages()
        return any(before.get(topic) != number for topic, number in self._published.items()
                   if topic not in ('/clock', self._status.topic))

    def _clock_wanted(self) -> bool:
        return not self._clock or self._clock.wanted()

    def _no_step_due(self) -> None:
        """Answer calls in a pause and publish the time for new subscribers, without waiting for the next step."""
        if self._pacer.paused:
            self.services.answer()
        if self._clock:
            self._clock.publish(self._set_time())
        self._report()

    def _on_call(self) -> None:
        """Wake the pacer, so that a call in a pause is answered immediately."""
        if self._pacer.paused:
            self._pacer.wake()

    def _answer(self) -> None:
        """Answer calls at the start of a step; in lockstep, chance must not decide whether a call is late."""
        self.services.answer(max(MASTER_TIMEOUT, self._lockstep_timeout) if self._lockstep else MASTER_TIMEOUT)

    def _wait_for_nodes(self, lockstep: Lockstep) -> None:
        if not lockstep.wait():
            self._throttle.warn('late', 'Lockstep: after %g s a step started although these were still busy: %s. The '
                                'result may depend on the machine; ~clock_status counts such steps.',
                                self._lockstep_timeout, lockstep.busy)

    def _warn_of_lag(self, lag: LagMonitor) -> None:
        behind = lag.lag()
        if behind:
            self._throttle.warn('behind', '%s is falling behind: %.1f s of simulated time behind /clock. The result '
                                'may depend on the machine; _lockstep:=true waits for nodes, ~clock_status counts this '
                                'in late_steps.', lag.busy, behind)

    def _report(self) -> None:
        self._status.report(*self._lateness())

    def _lateness(self) -> tuple[int, str]:
        """Return (late_steps, busy) of ClockStatus."""
        watch = self._lockstep or self._lag
        return (watch.late, watch.busy) if watch else (0, '')

    def _own_clock(self, step: float, lockstep: bool) -> None:
        """Publish /clock and set /use_sim_time, as Gazebo does, and warn of a second /clock."""
        self._clock = LatestPublisher('/clock', Clock)
        self._set_use_sim_time()
        if lockstep:
            self._lockstep = Lockstep(self._clock, self._lockstep_timeout, step, os.getppid() if self._parent else None)
        else:
            self._lag = LagMonitor(self._clock, CLOCK_SIZE, step)

    def _set_use_sim_time(self) -> None:
        """Set /use_sim_time to true if it is not set; warn if it is false, or if another node publishes /clock."""
        others = _other_clocks()
        if others:
            rospy.logwarn('%s', findings.two_clocks([*others, rospy.get_name()]))
        value = rospy.get_param(USE_SIM_TIME, None)
        if value is None or (value and nodes.launched()):
            self._sets_sim_time = True
            rospy.on_shutdown(self._unset_use_sim_time)
        if value is None:
            rospy.set_param(USE_SIM_TIME, True)
            rospy.loginfo('Set %s to true: nodes that start from now on follow /clock.', USE_SIM_TIME)
        elif not value:
            rospy.logwarn('%s is false: nodes use wall-clock time, although this simulator publishes /clock. Type: '
                          'rosparam set %s true, before the other nodes start.', USE_SIM_TIME, USE_SIM_TIME)

    def _use_other_clock(self) -> None:
        """Initialise ROS time, which disable_rostime skipped, because another node may publish /clock."""
        if not rospy_internals.follow_time():
            raise rospy.exceptions.ROSInitException('ROS time could not be initialised')
        if rospy.get_param(USE_SIM_TIME, False) and not _other_clocks():
            rospy.logwarn('%s', findings.no_clock())

    def _unset_use_sim_time(self) -> None:
        """Delete /use_sim_time, so that no later node waits forever for a /clock that is gone."""
        try:
            if not _other_clocks():
                rospy.delete_param(USE_SIM_TIME)
        except (OSError, KeyError, rosgraph.MasterException):
            pass

    def _step_by_hand(self, message: Any) -> StepResponse:
        if message.steps > MAX_STEPS:
            raise rospy.ServiceException(f'steps is {message.steps}; it must be 0 to {MAX_STEPS}')
        request = self._pacer.request(message.steps)
        self._wait_until_made(request)
        if not request.made:
            raise rospy.ServiceException('the simulator was resumed in the meantime')
        return StepResponse(request.last, self._pacer.nanoseconds_after(request.last) / 1e9)

    def _set_rate(self, message: Any) -> SetRateResponse:
        if not SLOWEST <= message.rate <= FASTEST:
            raise rospy.ServiceException(f'rate is {message.rate:g}; it must be {SLOWEST:g} to {FASTEST:g}')
        self._pacer.set_rate(message.rate, self._bounded(message.rate))
        return SetRateResponse('' if self._publishes or message.rate == REAL_TIME else
                               'other nodes use wall time: only the simulator runs at another rate. For a rate of all '
                               'nodes, start it with _clock:=true')

    def _bounded(self, rate: float) -> bool:
        """Return whether nodes that follow /clock might not keep up with late steps."""
        return self._publishes and rate > REAL_TIME

    def _wait_until_made(self, request: StepRequest) -> None:
        """Wait until the requested steps are made, or dropped because of a resume; ServiceException at the shutdown."""
        while not request.wait(ANSWER_POLL) and not rospy.is_shutdown():
            pass
        if not request.made and rospy.is_shutdown():
            raise rospy.ServiceException('the simulator is shutting down')

    def _time_after(self, steps: int) -> str:
        return f'{steps} steps done; the simulated time is {self._pacer.nanoseconds_after(steps) / 1e9:.9g} s'


class StatusReporter:
    """Publishes ``~clock_status`` every STATUS_PERIOD, and at once when something has changed. One thread uses it."""

    def __init__(self, pacer: Pacer, lockstep: bool, throttle: WallThrottle, followed: bool) -> None:
        """``pacer`` is the simulator's; ``lockstep``: whether it waits for nodes; ``throttle`` is for the warning.

        ``followed``: whether the other nodes use the simulator's time.
        """
        self._pacer = pacer
        self._lockstep = lockstep
        self._throttle = throttle
        self._followed = followed
        self._publisher = Publisher('~clock_status', ClockStatus, queue_size=10, latch=True)
        self.topic = self._publisher.resolved_name
        self._next = 0.0  # [s, monotonic] when the next message is due if nothing changes
        self._reported: tuple[bool, float, bool] | None = None  # (paused, rate, was a step late) of the last message
        self._since = time.monotonic()  # [s] of the last message
        self._steps = 0  # steps at the last message
        self._slow: list[float] = []  # the paces of the last messages, all too slow

    def report(self, late: int, busy: str) -> None:
        """Publish the status if it is due; ``late`` and ``busy``: late_steps and busy of ClockStatus."""
        now, pacer = time.monotonic(), self._pacer
        state = pacer.paused, pacer.rate, late > 0
        changed = state != self._reported
        if not changed and now < self._next:
            return
        passed = now - self._since
        pace = (pacer.steps - self._steps) * pacer.step / max(passed, 1e-9)
        if not changed and passed >= STATUS_PERIOD:
            self._check(pace)
        self._since, self._steps = now, pacer.steps
        self._next, self._reported = now + STATUS_PERIOD, state
        self._publisher.publish(pacer.steps, pacer.nanoseconds / 1e9, pacer.rate, pace, pacer.paused, self._lockstep,
                                late, busy)

    def _check(self, pace: float) -> None:
        """Warn that time passes too slowly, if ~rate asks for a rate and no node is the cause."""
        rate = self._pacer.rate
        slow = pace < ENOUGH * rate and not self._pacer.paused and not self._lockstep and rate < math.inf
        self._slow = [*self._slow, pace][-WINDOW:] if slow else []
        if len(self._slow) == WINDOW:
            self._throttle.warn('slow', 'Time passes %.1f times as fast as the wall clock, although ~rate is %g: this '
                                'machine is too slow, or too busy. %s', sum(self._slow) / WINDOW, rate,
                                'This does not change what nodes that follow /clock do.' if self._followed else
                                'Nodes wait by the wall clock, so what they drive by time becomes too short.')


def _other_clocks() -> list[str]:
    """Return the names of the other nodes that publish /clock."""
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return [node for topic, nodes in published if topic == '/clock' for node in nodes if node != rospy.get_name()]
