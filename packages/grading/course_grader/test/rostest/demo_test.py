#!/usr/bin/env python3
"""demo.py: its exit code reports the measurements. It has a master and a simulator of its own.

The test of README.md (test/pages) plays all steps.
"""
import glob
import os
import re

import cv2

from rostest_support.common import run
from rostest_support.course import CourseCase

DEMO_DEADLINE = 58.0  # [s] a step takes 10


class DemoTest(CourseCase):
    simulator = None

    def play(self, words, code, **programs):
        """Play steps, with these programs (name: shell script) in front of all others; return what demo.py printed."""
        self.output, programs_folder = self.temporary_directory(), self.temporary_directory()
        for name, script in programs.items():
            path = os.path.join(programs_folder, name)
            with open(path, 'w') as file:
                file.write(f'#!/bin/sh\n{script}\n')
            os.chmod(path, 0o755)
        process = self.start('demo.py', '--output', self.output, *words.split(','),
                             PATH=f'{programs_folder}{os.pathsep}{os.environ["PATH"]}')
        return self.ended(process, code, DEMO_DEADLINE)

    def test_demo_step(self):
        """A step that passes: exit code 0, the measurements, and a picture."""
        said = self.play('gotoPose', 0)
        self.assertRegex(said, r'✓ distance to the goal when the service answers 0\.0\d\d m')
        self.assertRegex(said, r'x 1\.\d\d\d m, y 2\.\d\d\d m, heading -?3\.1\d\d rad')
        self.assertRegex(said, r'✓ 1 of 1 steps passed')
        self.assertEqual(['6_gotopose.png'], [os.path.basename(path) for path in glob.glob(f'{self.output}/*.png')])

    def test_demo_steps_by_number(self):
        """The numbers of the course; a step that changes the background leaves no trace in later pictures."""
        said = self.play('14,5', 0)
        self.assertEqual(['5', '5', '14'], re.findall(r'^ +(\d+)\. ', said, re.MULTILINE))
        said = self.play('Parameters,Action', 0)
        colours = {name: tuple(map(int, cv2.imread(f'{self.output}/{name}.png')[5, 5][::-1]))
                   for name in ('14_parameters', '18_action')}
        self.assertEqual({'14_parameters': (40, 90, 60), '18_action': (69, 86, 255)}, colours)

    def test_demo_step_without_effect(self):
        """A rosservice that says nothing wrong but does nothing: measured, so exit code 1."""
        said = self.play('gotoPose', 1, rosservice='exit 0')
        self.assertRegex(said, r'✗ distance to the goal when the service answers 5\.0\d\d m')
        self.assertRegex(said, r'✗ 0 of 1 steps passed')
        self.assertIn('Failed: gotoPose', said)

    def test_demo_simulator_dies(self):
        """The simulator ends in the middle of a step: exit code 1 and a text, not a traceback."""
        said = self.play('gotoPose', 1, rosservice='exec rosnode kill /turtlesim')
        self.assertRegex(said, r'✗ 0 of 1 steps passed')

    def test_demo_no_simulator(self):
        """A simulator that does not start: exit code 1, the missing part, and the file with details."""
        said = self.play('gotoPose', 1, roslaunch='echo out of order; exit 7')
        self.assertRegex(said, r'the simulator publishes no pose: it has ended; roslaunch printed: out of order')
        self.assertTrue(re.search(r'Output of the nodes: \S+/log', said), said)

    def test_demo_unknown_word(self):
        """Exit code 2 and the titles that there are, at once."""
        said = self.play('volcano', 2)
        self.assertRegex(said, r'no step has such a number, nor such a word in its title; '
                               r'the steps are: 1 First publisher, .*7 Black tour')


if __name__ == '__main__':
    run(DemoTest)
