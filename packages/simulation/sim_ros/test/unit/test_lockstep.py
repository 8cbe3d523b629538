"""sim_ros.lockstep: when a step may begin. Threads, connections and wall time are fakes here."""
import itertools
import socket
import types

import pytest
import rospy

from kinematic_core.timing.idle_threads import Gone
from sim_ros import lockstep
from sim_ros.lockstep import (
    ENOUGH,
    FIRST_PAUSE,
    JOINING,
    MAX_PAUSE,
    MOST_SETTLING,
    NOTICED,
    SETTLING,
    STARVED,
    WORK,
    Lockstep,
    _Settling,
)

TIMEOUT, STEP = 2.0, 0.016  # [s]


class Wall:
    """Wall time: each reading takes a microsecond."""

    def __init__(self):
        self.now = 50.0

    def monotonic(self):
        self.now += 1e-6
        return self.now

    def sleep(self, seconds):
        self.now += seconds


class Process:
    """The threads of a process: ``busy_until`` [s] they run, from then on they sleep."""

    def __init__(self, wall):
        self.wall, self.busy_until, self.worked, self.gone, self.closed = wall, 0.0, 0, False, False
        self.cores = 0.0  # share of a core that it has got from the start on

    def ran(self):
        if self.gone:
            raise Gone
        return 5 + 1_000_000 * self.worked + int(1e9 * self.cores * self.wall.now)

    def sleeps(self, ran=-1):
        if self.gone:
            raise Gone
        return self.wall.now >= self.busy_until

    def close(self):
        self.closed = True


class Connection:
    def __init__(self, name):
        self.endpoint_id = name


class Publisher:
    """/clock with its subscribers; ``impl`` as rospy has it."""

    def __init__(self):
        self.impl = self
        self.connections = []


@pytest.fixture
def scene(monkeypatch):
    return Scene(monkeypatch)


class Scene:
    """A Lockstep with fakes around it."""

    def __init__(self, monkeypatch):
        self.wall = Wall()
        self.own, self.master = Process(self.wall), Process(self.wall)
        self.processes, self.publisher = {}, Publisher()
        monkeypatch.setattr(lockstep, 'time', self.wall)
        monkeypatch.setattr(lockstep, 'ProcessThreads', lambda *_, **__: self.own)
        monkeypatch.setattr(lockstep, '_watch_master', lambda: self.master)
        monkeypatch.setattr(lockstep, '_watch', lambda connection: self.processes[connection.endpoint_id])
        self.registrations = []
        monkeypatch.setattr(lockstep, '_registrations', lambda: list(self.registrations))
        monkeypatch.setattr(rospy, 'is_shutdown', lambda: False)
        self.parameters = {}
        monkeypatch.setattr(rospy, 'has_param', self.parameters.__contains__)
        monkeypatch.setattr(rospy, 'set_param', self.parameters.__setitem__)
        self.machine_is_busy = False
        self.lockstep = Lockstep(self.publisher, TIMEOUT, STEP)
        monkeypatch.setattr(self.lockstep, '_machine', types.SimpleNamespace(is_busy=lambda: self.machine_is_busy))
        self.wait()  # the master settles

    def node(self, name):
        connection = Connection(name)
        self.processes[name] = Process(self.wall)
        self.publisher.connections.append(connection)
        return self.processes[name]

    def wait(self):
        """Return (whether all were idle in time, how long [s] it took)."""
        begin = self.wall.now
        return self.lockstep.wait(), self.wall.now - begin


def test_without_nodes_a_step_begins_at_once(scene):
    idle, took = scene.wait()
    assert idle and took < 1e-4


def test_a_step_waits_for_every_node_and_for_the_simulator_itself(scene):
    one, two = scene.node('/one'), scene.node('/two')
    for process, other in itertools.permutations((one, two, scene.own), 2):
        process.busy_until, other.busy_until = scene.wall.now + 0.2, scene.wall.now + 0.1
        idle, took = scene.wait()
        assert idle and 0.2 <= took < 0.2 + 2.0 * MAX_PAUSE
    assert scene.lockstep.late == 0


@pytest.mark.parametrize('own', [False, True])
def test_neither_a_node_nor_the_simulator_may_run_while_all_are_looked_at(scene, monkeypatch, own):
    counts = iter([1, 2, 3, 3, 3])  # before and after the first check; it has run before the second
    monkeypatch.setattr(scene.own if own else scene.node('/one'), 'ran', lambda: next(counts))
    assert scene.wait()[0]
    assert next(counts, None) is None


@pytest.mark.parametrize('busy, looks', [(False, 1), (True, 2)])
def test_on_a_busy_machine_two_looks_must_see_the_same(scene, monkeypatch, busy, looks):
    seen = []
    monkeypatch.setattr(scene.own, 'sleeps', lambda ran: seen.append(0) or True)
    scene.machine_is_busy = busy
    assert scene.wait()[0]
    assert len(seen) == looks


@pytest.mark.parametrize('busy', [False, True])
def test_the_threads_of_a_node_are_looked_at_once_after_two_equal_run_times(scene, monkeypatch, busy):
    node, seen = scene.node('/one'), []
    monkeypatch.setattr(node, 'sleeps', lambda: seen.append(0) or True)
    scene.machine_is_busy = busy
    assert scene.wait()[0]
    assert len(seen) == 1


def test_on_a_busy_machine_what_comes_late_is_waited_for(scene, monkeypatch):
    node = scene.node('/one')
    runs = iter([1, 1, 2, 3, 3, 3])  # at two polls, and after the look at its threads; then it has run
    monkeypatch.setattr(node, 'ran', lambda: next(runs))
    scene.machine_is_busy = True
    assert scene.wait()[0]
    assert next(runs, None) is None


def test_the_threads_of_processes_that_still_work_are_not_looked_at(scene, monkeypatch):
    """To look at 50 threads of five nodes took 0.3 ms, eight times in a wait."""
    node, looks = scene.node('/one'), []
    end = scene.wall.now + 0.1
    monkeypatch.setattr(node, 'ran', lambda: int(1e9 * min(scene.wall.now, end)))
    monkeypatch.setattr(node, 'sleeps', lambda: looks.append(0) or scene.wall.now >= end)
    assert scene.wait()[0]
    assert len(looks) == 1


def test_the_first_pause_becomes_as_long_as_the_nodes_take(scene, monkeypatch):
    node, pauses = scene.node('/one'), []
    sleep = scene.wall.sleep
    monkeypatch.setattr(scene.wall, 'sleep', lambda seconds: pauses.append(seconds) or sleep(seconds))
    taken = 4.0 * FIRST_PAUSE
    for _ in range(100):
        pauses.clear()
        end = scene.wall.now + taken
        monkeypatch.setattr(node, 'ran', lambda end=end: int(1e9 * min(scene.wall.now, end)))
        assert scene.wait()[0]
    assert len(pauses) <= ENOUGH + 1 and 0.7 * taken < pauses[0] < 1.5 * taken
    for _ in range(100):  # the node has nothing to do any more
        pauses.clear()
        assert scene.wait()[0]
    assert pauses[0] == FIRST_PAUSE


JOINED = [['/turtle1/cmd_vel', ['/one']]]


@pytest.mark.parametrize('first, then, poll, needed', [
    ([], [JOINED, [], []], 0.1, JOINING),
    ([], [JOINED, [], []], 0.01, JOINING),
    ([JOINED, [], []], [JOINED, JOINED, []], 0.1, 0.1 + SETTLING),
    ([JOINED, [], []], [JOINED, JOINED, []], 0.01, 0.01 + SETTLING),
    ([JOINED, [], []], [[], [], []], 0.01, 0.01 + SETTLING),
])
def test_a_registration_is_given_time_to_settle_once(scene, monkeypatch, first, then, poll, needed):
    monkeypatch.setattr(lockstep, 'master_poll', poll)
    scene.master.worked, scene.registrations = 1, first
    assert scene.wait()[0]
    scene.master.worked, scene.registrations = 2, then
    idle, took = scene.wait()
    assert idle and needed <= took < needed + 3.0 * MAX_PAUSE
    assert scene.wait()[1] < 1e-4


def test_a_master_that_polls_settles_all_the_same(scene, monkeypatch):
    monkeypatch.setattr(scene.master, 'ran', lambda: 1_000_000 + 60_000 * int(scene.wall.now / 0.1))
    scene.registrations = [JOINED, [], []]
    idle, took = scene.wait()
    assert idle and JOINING <= took < JOINING + 3.0 * MAX_PAUSE


def test_polls_that_run_as_long_as_work_hold_nobody_up_for_ever():
    """On a slow machine each poll of a node ran for more than was taken for a poll: each wait lasted to its limit."""
    settling = _Settling()
    settling.start(0.0, JOINING)
    ticks = (tick for tick in range(10_000) if settling.observe({'/poller': 2 * WORK * tick}, 1e-3 * tick)
             or settling.is_over(1e-3 * tick))
    assert 1e-3 * next(ticks) == pytest.approx(MOST_SETTLING * JOINING, abs=1e-3)


def test_a_master_that_only_answers_holds_nobody_up(scene):
    for _ in range(3):
        scene.master.worked += 1
        assert scene.wait() == (True, pytest.approx(0.0, abs=1e-3))


def test_a_master_that_polls_is_not_even_asked(scene, monkeypatch):
    monkeypatch.setattr(lockstep, '_registrations', lambda: pytest.fail('asked'))
    scene.master.worked += 0.05  # 50 us
    assert scene.wait()[0]


def test_a_node_that_never_rests_is_named_counted_and_gets_real_time_from_then_on(scene):
    hog, good = scene.node('/hog'), scene.node('/good')
    hog.busy_until, hog.cores = scene.wall.now + 1e6, 0.9
    idle, took = scene.wait()
    assert not idle and TIMEOUT <= took < TIMEOUT + 2.0 * MAX_PAUSE
    assert (scene.lockstep.late, scene.lockstep.busy) == (1, '/hog')
    idle, took = scene.wait()
    assert not idle and STEP <= took < STEP + 2.0 * MAX_PAUSE
    assert scene.lockstep.late == 2
    hog.busy_until = hog.cores = 0.0
    assert scene.wait()[0]
    assert (scene.lockstep.late, scene.lockstep.busy) == (2, '')
    good.busy_until = scene.wall.now + 1.5
    assert scene.wait()[0]  # the whole timeout again


@pytest.mark.parametrize('cores, expected', [(0.6, TIMEOUT), (0.4, 2.5), (0.0, STARVED * TIMEOUT)])
def test_a_node_that_waits_for_a_core_gets_more_time(scene, cores, expected):
    node = scene.node('/one')
    node.busy_until, node.cores = scene.wall.now + 1e6, cores  # 0.4 of a core: half of TIMEOUT after 2.5 s
    idle, took = scene.wait()
    assert not idle and expected <= took < expected + 2.0 * NOTICED
    assert scene.lockstep.starved == (cores == 0.0)


def test_the_imports_of_a_node_that_joins_meanwhile_do_not_count(scene, monkeypatch):
    """They took 5 s of processor time; both nodes get no core for 2 * TIMEOUT, which is no node's fault."""
    start, sleep = scene.wall.now, scene.wall.sleep
    scene.node('/first').busy_until = start + 2.0 * TIMEOUT

    def sleep_until_it_joins(seconds):
        sleep(seconds)
        if scene.wall.now > start + 1.0 and '/second' not in scene.processes:
            scene.node('/second').worked = 5000  # ms
            scene.processes['/second'].busy_until = start + 2.0 * TIMEOUT
    monkeypatch.setattr(lockstep.time, 'sleep', sleep_until_it_joins)
    assert scene.wait()[0] and scene.lockstep.late == 0


def test_the_simulator_itself_can_be_what_is_busy(scene):
    scene.own.busy_until, scene.own.cores = scene.wall.now + 1e6, 1.0
    assert not scene.wait()[0]
    assert 'the simulator itself' in scene.lockstep.busy


def test_a_node_that_ends_is_not_waited_for(scene):
    node = scene.node('/one')
    assert scene.wait()[0]
    node.gone = True
    assert scene.wait()[0]
    scene.publisher.connections.clear()
    assert scene.wait()[0]


def test_files_of_a_node_that_leaves_are_closed(scene):
    node = scene.node('/one')
    scene.wait()
    scene.publisher.connections = []
    scene.wait()
    assert node.closed


def test_a_master_that_ends_is_not_waited_for_and_a_new_one_is(scene):
    scene.master.gone = True
    assert scene.wait()[0]
    scene.master = Process(scene.wall)
    scene.lockstep.watch_master()
    scene.master.busy_until = scene.wall.now + 0.3
    assert scene.wait()[1] >= 0.3


def test_a_shutdown_ends_the_wait(scene, monkeypatch):
    scene.node('/hog').busy_until = scene.wall.now + 1e6
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: True)
    assert scene.wait() == (True, pytest.approx(0.0, abs=1e-3))
    assert scene.lockstep.late == 0


@pytest.mark.parametrize('late, asked', [(0, 1), (2, 3)])
def test_a_node_that_answers_late_is_asked_again(monkeypatch, late, asked):
    node = Late(late)
    monkeypatch.setattr(lockstep, '_proxy', lambda uri: node)
    monkeypatch.setattr(rospy, 'get_name', lambda: '/simulator')
    assert lockstep._pid('http://localhost:1') == 42
    assert node.asked == asked


def test_a_node_that_never_answers_is_not_asked_for_ever(monkeypatch):
    node = Late(1000)
    monkeypatch.setattr(lockstep, '_proxy', lambda uri: node)
    monkeypatch.setattr(rospy, 'get_name', lambda: '/simulator')
    with pytest.raises(socket.timeout):
        lockstep._pid('http://localhost:1')
    assert node.asked == lockstep.TRIES


class Late:
    """A node whose first answers come too late."""

    def __init__(self, late):
        self.late, self.asked = late, 0

    def getPid(self, caller):
        self.asked += 1
        if self.asked <= self.late:
            raise socket.timeout
        return 1, '', 42


def test_an_answer_of_the_master_that_is_too_long_to_read_does_not_end_the_simulator(monkeypatch):
    def refuse(_caller):
        raise ValueError('max payload length exceeded')
    monkeypatch.setattr(lockstep, '_proxy', lambda _uri: types.SimpleNamespace(getSystemState=refuse))
    assert lockstep._registrations() is None
