#!/usr/bin/env python3
"""Many at once: spawns, kills, resets and commands from several threads."""
import os
import threading

import rospy
from turtlesim.msg import Pose

from rostest_support.common import MIDDLE, Collected, SimulatorCase, node_api, run, until

TURTLES = 100
THREADS = 8
STORM_DEADLINE = 60.0  # [s] 100 spawns take 3 s on an idle machine
SPARE_SOCKETS = 10  # that ROS may keep for a while


def in_threads(function, arguments):
    """Call a function with each of the arguments, THREADS at a time; return the results, exceptions among them."""
    arguments, results = list(arguments), []

    def work():
        while arguments:
            try:
                argument = arguments.pop()
            except IndexError:
                return
            try:
                results.append(function(argument))
            except rospy.ServiceException as failure:
                results.append(failure)
    threads = [threading.Thread(target=work, daemon=True) for _ in range(THREADS)]
    for thread in threads:
        thread.start()
    until(lambda: not any(thread.is_alive() for thread in threads), 'an end of the storm', STORM_DEADLINE)
    return results


class StormTest(SimulatorCase):

    def open_sockets(self):
        """Return how many sockets the simulator has open."""
        folder = f'/proc/{node_api("/turtlesim").getPid("/test")[2]}/fd'
        return sum(os.readlink(f'{folder}/{file}').startswith('socket') for file in os.listdir(folder)
                   if os.path.islink(f'{folder}/{file}'))

    def spawn(self, name):
        return self.call('spawn', 2.0, 3.0, 1.0, name).name

    def test_turtlesim_spawn_storm(self):
        """A hundred turtles spawned at once are all there, each with a name of its own, and all answer."""
        names = in_threads(self.spawn, [''] * (TURTLES // 2) + [f'anna{number}' for number in range(TURTLES // 2)])
        expected = {f'turtle{number}' for number in range(2, TURTLES // 2 + 2)}
        expected |= {f'anna{number}' for number in range(TURTLES // 2)}
        self.assertEqual(sorted(expected), sorted(map(str, names)))
        self.assertEqual(expected | {'turtle1'}, self.turtles())
        for name in (f'turtle{TURTLES // 2 + 1}', 'anna0', 'anna49'):
            self.assert_pose(self.pose(name), 2.0, 3.0, 1.0)
            self.call(f'{name}/teleport_absolute', 4.0, 4.0, 0.0)
            self.assert_pose(self.pose(name), 4.0, 4.0, 0.0)
        self.assert_pose(self.pose(), MIDDLE, MIDDLE, 0.0)

    def test_turtlesim_spawn_and_kill_at_once(self):
        """Spawns and kills of one name from several threads: world and topics agree on the turtles."""
        results = in_threads(lambda number: self.call('kill', 'anna') if number % 2 else self.spawn('anna'), range(150))
        refusals = [str(result) for result in results if isinstance(result, rospy.ServiceException)]
        self.assertLess(len(refusals), len(results), 'nothing worked')
        expected = ('already exists', 'does not exist')
        self.assertEqual([], [text for text in refusals if not any(words in text for words in expected)])
        if 'anna' in self.turtles():
            self.call('kill', 'anna')
        until(lambda: self.turtles() == {'turtle1'}, 'turtle1 alone')
        self.spawn('anna')
        self.assert_pose(self.pose('anna'), 2.0, 3.0, 1.0)

    def test_turtlesim_kill_storm(self):
        """Turtles killed from several threads, each twice, are gone without a trace; turtle1 notices nothing."""
        before = self.state()
        sockets = self.open_sockets()
        for _ in range(2):
            names = in_threads(self.spawn, [''] * 30)
            subscribers = [Collected(f'/{name}/pose', Pose) for name in names[:10]]
            until(lambda: all(subscriber.messages for subscriber in subscribers), 'poses')  # noqa: B023
            results = in_threads(lambda name: self.call('kill', name), names * 2)
            self.assertEqual(len(names), sum(isinstance(result, rospy.ServiceException) for result in results))
            for subscriber in subscribers:
                subscriber.subscriber.unregister()
        until(lambda: self.turtles() == {'turtle1'}, 'turtle1 alone')
        self.assert_unchanged(before)
        until(lambda: self.open_sockets() <= sockets + SPARE_SOCKETS, f'no more sockets than before, {sockets}')

    def test_turtlesim_mixed_storm(self):
        """spawn, kill, reset, clear, pens, teleports and commands all at once: the simulator lives and is whole."""
        drive = self.driver()

        def anything(number):
            name = f'anna{number % 5}'
            (lambda: self.spawn(name), lambda: self.call('kill', name), lambda: self.call('clear'),
             lambda: drive(x=1.0, turn=1.0), lambda: self.call('turtle1/set_pen', number, 0, 0, 3, 0),
             lambda: self.call('turtle1/teleport_absolute', number / 20.0, 5.0, 0.0),
             lambda: self.call('reset'))[number % 7]()
        in_threads(anything, range(200))
        self.call('reset')
        until(lambda: self.turtles() == {'turtle1'}, 'turtle1 alone')
        self.assert_pose(self.pose(), MIDDLE, MIDDLE, 0.0)
        self.assertEqual('turtle2', self.spawn(''))
        self.assert_pose(self.pose('turtle2'), 2.0, 3.0, 1.0)


if __name__ == '__main__':
    run(StormTest)
