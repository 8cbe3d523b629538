#!/usr/bin/env python3
"""Parameters that the course's nodes refuse, and nodes that find no simulator. There is none in these tests."""

from rostest_support.common import nightly, run
from rostest_support.course import CourseCase
from turtle_robotont.driving.shapes import SHAPES

AT_A_TIME = 4  # nodes
UNKNOWN = [  # an argument that a node does not have; what its text must contain
    ('velocity_publisher.py', '_liner:=2.0', ['parameter /case0/liner', 'no such parameter', '_linear:=2.0']),
    ('set_pen.py', '_colour:=red', ['parameter /case1/colour', 'It has b, g, off, r, width']),
    ('drive_shape.py', 'square', ['argument square', 'no such parameter']),
]
NO_SIMULATOR_DEADLINE = 60.0  # [s] they wait 10 s themselves
REFUSED = [  # node, argument, and the words that its error must contain beside the parameter's name
    ('velocity_publisher.py', '_linear:=fast', ["'fast'", 'a number']),
    ('pose_subscriber.py', '_rate:=-1', ['is -1', '0 to 1000 Hz']),
    ('stop_at_x.py', '_x:=11.1', ['11.1', '0 to 11.0889 m']),
    ('drive_shape.py', '_shape:=star', ["'star'", ', '.join(SHAPES)]),
    ('drive_shape.py', '_corners:=[[1,1]]', ['[[1, 1]]', 'at least 2 entries, each a pair [x, y]']),
    ('ar_control_node.py', '_mode:=fly', ["'fly'", 'print, forward, follow']),
    ('ar_maze.py', '_markers:=[1,-2]', ['-2', 'each a whole number from 0']),
    ('goto_pose_server.py', '_mode:=fly', ["'fly'", 'drive, teleport, log']),
    ('set_pen.py', '_r:=256', ['is 256', '0 to 255']),
    ('teleport_tour.py', '_positions:=[[-1,5],[2,2]]', ['[[-1, 5], [2, 2]]', 'each a pair [x, y], both a number from '
                                                        '0 to 11.0889 m']),
]
NEEDS = {'stop_at_x.py': 'turtle1/pose', 'set_pen.py': '/turtle1/set_pen cannot be called: '}


class ParametersTest(CourseCase):
    simulator = None

    @nightly
    def test_course_bad_parameters(self):
        """Exit code 2 and one line that names the parameter, its value and the allowed values."""
        for begin in range(0, len(REFUSED), AT_A_TIME):
            some = list(enumerate(REFUSED[begin:begin + AT_A_TIME], begin))
            processes = [self.start(script, f'__name:=case{number}', argument)
                         for number, (script, argument, _) in some]
            for (number, (script, argument, texts)), process in zip(some, processes):
                with self.subTest(script=script, argument=argument):
                    self.assert_refused(process, f'/case{number}/{argument[1:argument.index(":")]}', texts)

    def assert_refused(self, process, parameter, texts):
        lines = [line for line in self.ended(process, code=2).splitlines() if '[FATAL]' in line]
        self.assertEqual(1, len(lines), process.output())
        for text in [f'parameter {parameter}', *texts]:
            self.assertIn(text, lines[0])

    @nightly
    def test_course_unknown_parameters(self):
        """A misspelt parameter, a forgotten underscore or colon: exit code 2 and one line with the right name."""
        processes = [self.start(script, f'__name:=case{number}', argument)
                     for number, (script, argument, _) in enumerate(UNKNOWN)]
        for (script, argument, texts), process in zip(UNKNOWN, processes):
            with self.subTest(script=script, argument=argument):
                lines = [line for line in self.ended(process, code=2).splitlines() if '[FATAL]' in line]
                self.assertEqual(1, len(lines), process.output())
                for text in texts:
                    self.assertIn(text, lines[0])

    def test_course_without_simulator(self):
        """Exit code 1 and a line that names the missing part, within the 10 s that a node waits."""
        for script, lacking in NEEDS.items():
            process = self.start(script)
            with self.subTest(script=script):
                said = self.ended(process, code=1, deadline=NO_SIMULATOR_DEADLINE)
                self.assertRegex(said, fr'\[FATAL\].*{lacking}.*[iI]s the simulator running')


if __name__ == '__main__':
    run(ParametersTest)
