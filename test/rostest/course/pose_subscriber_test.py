#!/usr/bin/env python3
"""pose_subscriber.py: its output and its rate."""
import re

from rosgraph_msgs.msg import Log

from rostest_support.common import Collected, run, until
from rostest_support.course import CourseCase

LINE = r'Turtle pose: x:(-?\d+\.\d{6}), y:(-?\d+\.\d{6})'
RATE_TOLERANCE = 0.1  # of a rate: a line may come late, and the next one then on time


class PoseSubscriberTest(CourseCase):

    def lines(self):
        """Return the Collected log of which there is a line of the node already."""
        log = Collected('/rosout', Log)
        until(lambda: self.printed(log), 'a printed pose')
        return log

    @staticmethod
    def printed(log):
        """Return (time [s], x, y as printed) of each pose in the log."""
        found = [(entry, re.fullmatch(LINE, entry.msg)) for entry in list(log.messages)]
        return [(entry.header.stamp.to_sec(), *match.groups()) for entry, match in found if match]

    def test_pose_subscriber_prints_every_pose(self):
        """Position after position, six digits each, none left out."""
        log, poses = self.lines(), self.poses()
        self.jump(2.5, 7.25)
        self.driver()(x=1.0, turn=2.0)
        first = poses.index(lambda pose: pose.linear_velocity > 0.0, 'the turtle driving')
        driven = [(f'{pose.x:.6f}', f'{pose.y:.6f}') for pose in poses.some(first, 40)]
        self.assertEqual(40, len(set(driven)))
        until(lambda: driven[-1] in [line[1:] for line in self.printed(log)], f'{driven[-1]} printed')
        lines = [line[1:] for line in self.printed(log)]
        begin = lines.index(driven[0])
        self.assertEqual(driven, lines[begin:begin + 40])
        self.assertIn(('2.500000', '7.250000'), lines)

    def test_pose_subscriber_rate(self):
        """~rate: so many lines a second and no more."""
        log = self.lines()
        until(lambda: len(self.printed(log)) > 15, '15 lines')
        times = [line[0] for line in self.printed(log)]
        rate = (len(times) - 1) / (times[-1] - times[0])
        self.assertLess(rate, 5.0 * (1.0 + RATE_TOLERANCE))


if __name__ == '__main__':
    run(PoseSubscriberTest)
