"""sim_ros.parent_link: the private connection of a simulator to the program that has started it."""
import json
import socket
import threading

import pytest

from kinematic_core.timing.pacing import Pacer
from rostest_support.waiting import until
from sim_ros.parent_link import ParentLink


class Parent:
    """The other end of a ParentLink, and a simulator that makes the steps of its Pacer."""

    def __init__(self, **takes):
        self.connection, its = socket.socketpair()
        self.connection.settimeout(10.0)
        self.lines = self.connection.makefile('rb')
        self.link, self.pacer = ParentLink(its, **takes), Pacer(0.016, paused=True)
        self.link.serve(self.pacer)
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while True:
            if self.pacer.wait(0.01) is not None:
                self.link.moved(self.pacer.steps, {'turtle1': (1.0, 2.0, 0.5), 'turtle2': (3.0, 4.0, 0.0)})
                self.link.stepped(self.pacer.steps, 0, '')

    def send(self, **message):
        self.connection.sendall(json.dumps(message).encode() + b'\n')

    def received(self):
        return json.loads(self.lines.readline())


@pytest.fixture(name='parent')
def a_parent():
    made = Parent()
    assert made.received() == {'ready': True}
    return made


def test_steps_are_made_and_answered(parent):
    parent.send(step=0)
    assert parent.received() == {'made': True}
    parent.send(step=2)
    assert parent.received() == {'made': True, 'steps': 2, 'late': 0, 'busy': ''}


def test_a_parent_that_follows_is_told_every_step(parent):
    parent.send(follow=True)
    parent.send(step=2)
    assert [parent.received() for _ in range(3)] == [
        {'steps': 1, 'late': 0, 'busy': ''}, {'steps': 2, 'late': 0, 'busy': ''},
        {'made': True, 'steps': 2, 'late': 0, 'busy': ''}]


def test_poses_come_of_the_vehicles_that_are_watched(parent):
    parent.send(watch={'turtle2': 2, 'turtle3': 1}, reacts=True)
    parent.send(step=3)
    assert [parent.received() for _ in range(2)] == [
        {'steps': 2, 'poses': {'turtle2': [3.0, 4.0, 0.0]}}, {'made': True, 'steps': 3, 'late': 0, 'busy': ''}]
    assert not parent.link.answers  # after the third step
    parent.send(step=1)
    assert ['poses' in parent.received() for _ in range(2)] == [True, False]  # then the step is over
    assert parent.link.answers


def test_time_continues_when_the_parent_says_so(parent):
    assert parent.pacer.paused
    parent.send(resume=True)
    assert parent.received()['steps'] == 1
    assert not parent.pacer.paused


def test_commands_carries_and_moves_go_to_the_simulator():
    driven, carried, moved = [], [], []
    parent = Parent(drive=lambda *velocities: driven.append(velocities), carry=lambda *pose: carried.append(pose),
                    move=lambda *panel: moved.append(panel))
    parent.send(drive=[1.5, -0.5])
    parent.send(carry=[1.0, 2.0, 0.5])
    parent.send(move=['board', 3.0, 4.0, 0.0])
    until(lambda: moved)
    assert (driven, carried, moved) == ([(1.5, -0.5)], [(1.0, 2.0, 0.5)], [('board', 3.0, 4.0, 0.0)])


def test_a_simulator_that_cannot_carry_goes_on(parent):
    parent.send(carry=[1.0, 2.0, 0.5])
    parent.send(every=12)
    until(lambda: parent.link.every == 12)


def test_a_parent_that_is_gone_stops_nothing(parent):
    parent.lines.close()
    parent.connection.close()
    parent.link.stepped(1, 0, '')
    parent.link.moved(1, {})
