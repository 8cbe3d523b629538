"""course_grader.attempt.simulator_link: what is true in a simulator comes by a connection of the grader's own."""
import json
import queue
import socket
import threading

import pytest
import rospy

from course_grader.attempt import simulator_link
from course_grader.attempt.simulator_link import SimulatorLink
from kinematic_core.worlds import turtle_world

END = 10.0  # [s] after which a test fails


class Simulator:
    """The simulator at the other end."""

    def __init__(self, monkeypatch):
        self.times = []
        monkeypatch.setattr(simulator_link.rospy_internals, 'set_time', self.times.append)
        own, self.connection = socket.socketpair()
        self.connection.settimeout(END)
        self.lines = self.connection.makefile('rb')
        self.link = SimulatorLink(own, turtle_world.DT)
        self.link.listen()

    def send(self, **message):
        self.connection.sendall(json.dumps(message).encode() + b'\n')

    def received(self):
        return json.loads(self.lines.readline())

    def answer(self, *messages):
        """Answer the next request, from a thread of its own."""
        def run():
            self.requests = self.received()
            for message in messages:
                self.send(**message)
        threading.Thread(target=run, daemon=True).start()


@pytest.fixture(name='simulator')
def a_simulator(monkeypatch):
    return Simulator(monkeypatch)


def test_a_step_is_over_when_it_is_answered_and_sets_the_time(simulator):
    simulator.answer({'steps': 1, 'late': 0, 'busy': ''}, {'steps': 2, 'late': 3, 'busy': '/slow'}, {'made': True})
    simulator.link.step(2)
    assert simulator.requests == {'step': 2}
    assert simulator.times == [rospy.Time(1, 16_000_000), rospy.Time(1, 32_000_000)]  # 1 s and 16 ms for each step
    assert (simulator.link.late, simulator.link.busy) == (3, '/slow')


def test_time_is_told_in_every_step_as_long_as_somebody_wants_it(simulator):
    for wanted, told in (True, True), (True, True), (False, True), (False, False):
        simulator.link.follow(wanted)
        assert simulator.received() == {'follow': told}


def test_poses_go_to_those_who_watch_the_vehicle(simulator):
    seen = []
    simulator.link.watch('turtle2', lambda steps, pose: seen.append((steps, pose)))
    assert simulator.received() == {'watch': {'turtle2': 1}, 'reacts': False}
    simulator.link.watch('robotont', lambda steps, pose: None, 12, reacts=True)
    assert simulator.received() == {'watch': {'turtle2': 1, 'robotont': 12}, 'reacts': True}
    simulator.answer({'steps': 1, 'poses': {'turtle2': [1.0, 2.0, 0.5]}}, {'made': True})
    simulator.link.step(1)
    assert seen == [(1, [1.0, 2.0, 0.5])]
    assert simulator.times == []  # the step is not over yet


def test_several_listeners_of_a_vehicle_get_the_steps_that_each_wants(simulator):
    seen = []
    for every in (4, 6):
        simulator.link.watch('robotont', lambda steps, pose, every=every: seen.append((every, steps)), every)
    assert [simulator.received()['watch'] for _ in range(2)] == [{'robotont': 4}, {'robotont': 2}]
    poses = [{'steps': steps, 'poses': {'robotont': [0.0, 0.0, 0.0]}} for steps in (2, 4, 6, 12)]
    simulator.answer(*poses, {'made': True})
    simulator.link.step(12)
    assert seen == [(4, 4), (6, 6), (4, 12), (6, 12)]


def test_what_is_sent(simulator):
    simulator.link.drive(1.0, -0.5)
    simulator.link.resume()
    assert [simulator.received(), simulator.received()] == [{'drive': [1.0, -0.5]}, {'resume': True}]


def test_a_simulator_that_ends_ends_the_wait(simulator):
    def end():
        simulator.received()
        simulator.lines.close()
        simulator.connection.close()
    threading.Thread(target=end, daemon=True).start()
    with pytest.raises(ConnectionError, match='the simulator has ended'):
        simulator.link.step(1)


def test_the_robot_is_carried_and_the_nodes_get_the_time_less_often(simulator):
    simulator.link.tell_time(12)
    simulator.link.carry(1.0, -2.0, 0.5)
    assert [simulator.received() for _ in range(2)] == [{'every': 12}, {'carry': [1.0, -2.0, 0.5]}]


def test_it_says_when_a_panel_is_moved(simulator):
    told = queue.SimpleQueue()
    simulator.link.move('board', 1.0, -2.0, 0.5, told.put)
    assert simulator.received() == {'move': ['board', 1.0, -2.0, 0.5]}
    simulator.send(moved='board', steps=7)
    assert told.get(timeout=10.0) == simulator.link.time_after(7).to_sec()
