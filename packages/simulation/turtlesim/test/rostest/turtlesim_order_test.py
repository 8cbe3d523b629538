#!/usr/bin/env python3
"""The order of answers and poses of the simulator; turtlesim_startup_test.py has that of its start and its log.

All of it is the original's order. A service call is made here over a socket of its own, so that what comes when is seen
by one thread and not ordered by those of rospy.
"""
import select
import struct
import threading

import rosgraph
import rospy
from sim_ros.srv import Step
from std_srvs.srv import Trigger
from turtlesim.msg import Color, Pose
from turtlesim.srv import SetPen, TeleportAbsolute

from rostest_support import tcpros
from rostest_support.common import DEADLINE, SimulatorCase, proxy, run, until

ROUNDS = 20


def uri():
    """Return the URI of the simulator."""
    return rosgraph.Master(rospy.get_name()).lookupNode('/turtlesim')


def subscribe(topic, kind):
    """Return the connection of a subscriber, of which a first message has come."""
    connection = tcpros.subscribe(uri(), topic, kind)
    tcpros.receive_block(connection)
    return connection


def service(name, kind):
    """Return a persistent Caller."""
    return tcpros.Caller(tcpros.tcpros_address(uri()), name, kind)


def ready(connection):
    """Return whether there is something to read."""
    return bool(select.select([connection], [], [], 0)[0])


def x_of(pose):
    """Return the x [m] of a serialized Pose."""
    return struct.unpack('<5f', pose)[0]


class OrderTest(SimulatorCase):

    def next_pose(self, connection):
        """Skip queued poses, and return the next one: the simulator has just made a step."""
        while ready(connection):
            tcpros.receive_block(connection)
        return tcpros.receive_block(connection)

    def test_turtlesim_order_of_answer_and_pose(self):
        """A call is answered before the poses of that step, which show a teleport's effect; the next takes a step."""
        poses, jump = subscribe('/turtle1/pose', Pose), service('/turtle1/teleport_absolute', TeleportAbsolute)
        for number in range(ROUNDS):
            x = 1.0 + 0.25 * number
            self.next_pose(poses)
            self.assertEqual((True, b''), jump.call(x, 5.0, 0.0))
            seen = []
            while x not in seen:
                seen.append(x_of(tcpros.receive_block(poses)))
        self.next_pose(poses)
        for number in range(ROUNDS):
            jump.call(0.25 * number, 2.0, 0.0)
        seen = [x_of(tcpros.receive_block(poses)) for _ in range(ROUNDS - 1)]
        self.assertLessEqual({0.25 * number for number in range(ROUNDS - 2)}, set(seen), 'two calls in one step')

    def test_turtlesim_answer_first(self):
        """No pose that shows a teleport's effect is there before the answer to the call."""
        poses, jump = subscribe('/turtle1/pose', Pose), service('/turtle1/teleport_absolute', TeleportAbsolute)
        for number in range(ROUNDS):
            x = 1.0 + 0.25 * number
            jump.send(x, 5.0, 0.0)
            while x_of(tcpros.receive_block(poses)) != x:
                pass
            self.assertTrue(ready(jump.socket), 'a pose came before the answer')
            jump.answer()

    def test_turtlesim_calls_of_many_share_a_step(self):
        """Calls that came between two steps are all answered in one, each with its effect before the next pose."""
        poses = subscribe('/turtle1/pose', Pose)
        callers = [service('/turtle1/set_pen', SetPen) for _ in range(8)]
        between = []
        for _ in range(ROUNDS):
            self.next_pose(poses)
            for number, caller in enumerate(callers):
                caller.send(number, 0, 0, 3, 0)
            steps, waiting = 0, {caller.socket: caller for caller in callers}
            while waiting:
                there, _, _ = select.select([poses, *waiting], [], [], DEADLINE)
                for each in set(there) & set(waiting):
                    self.assertEqual((True, b''), waiting.pop(each).answer())
                if waiting and poses in there:
                    tcpros.receive_block(poses)
                    steps += 1
            between.append(steps)
        # at a step that begins while the calls are being sent, some are answered in the one after
        self.assertEqual(0, sorted(between)[ROUNDS // 2], between)

    def test_turtlesim_order_of_topics(self):
        """In each step the turtles publish in alphabetical order of their names, each its pose, then its colour."""
        for name in ('berta', 'anna'):
            self.call('spawn', 2.0, 2.0, 0.0, name)
        names = ['anna', 'berta', 'turtle1']
        topics = [(f'/{name}/{topic}', kind) for name in names for topic, kind in (('pose', Pose),
                                                                                  ('color_sensor', Color))]
        connections = [subscribe(*topic) for topic in topics]
        proxy('/turtlesim/pause', Trigger)()
        for each in connections:
            while ready(each):
                tcpros.receive_block(each)
        step = service('/turtlesim/step', Step)
        for _ in range(ROUNDS):
            step.send(1)
            there = []
            while len(there) < len(connections):  # the later first: arrivals between two polls are seen in the next one
                there = [place for place in range(len(connections) - 1, -1, -1) if ready(connections[place])]
                expected = list(range(len(there) - 1, -1, -1))
                self.assertEqual(expected, there, [topics[place] for place in there])
            step.answer()
            for each in connections:
                tcpros.receive_block(each)

    def test_turtlesim_kill_of_a_turtle_that_is_called(self):
        """A kill and calls of that turtle at once: each call is answered, well or with an error that names it."""
        for _ in range(5):
            self.call('spawn', 2.0, 2.0, 0.0, 'anna')
            callers = [service('/anna/set_pen', SetPen) for _ in range(4)]
            answers = []

            def call(caller, answers=answers):
                try:
                    while True:
                        well, text = caller.call(1, 0, 0, 3, 0)
                        answers.append((well, text.decode()))
                        if not well:
                            return
                except OSError:
                    answers.append((False, 'anna: closed'))
            threads = [threading.Thread(target=call, args=(caller,), daemon=True) for caller in callers]
            for thread in threads:
                thread.start()
            self.call('kill', 'anna')
            until(lambda: not any(thread.is_alive() for thread in threads), 'an answer to each call')  # noqa: B023
            self.assertEqual({(False, True)}, {(well, 'anna' in text) for well, text in answers if not well})
        self.assertEqual({'turtle1'}, self.turtles())


if __name__ == '__main__':
    run(OrderTest)
