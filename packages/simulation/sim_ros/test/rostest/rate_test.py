#!/usr/bin/env python3
"""How often a topic comes by the wall clock: parameters ~topic, ~hz and ~hzerror [Hz], for SECONDS.

As rostest's hztest, but a machine that stands still now and then does not matter.
"""
import unittest

import rospy
import rostopic

from rostest_support.common import Collected, run, until

SECONDS = 4.0
SPAN = 0.5  # [s] over which a rate is taken


class RateTest(unittest.TestCase):

    def test_rate(self):
        """The rate is the one that is asked for."""
        topic, rate, tolerance = (rospy.get_param(f'~{name}') for name in ('topic', 'hz', 'hzerror'))
        kind = until(lambda: rostopic.get_topic_class(topic)[0], f'somebody on {topic}')
        collected = Collected(topic, kind)
        collected.more(1)
        self.assertAlmostEqual(rate, collected.rate(round(SECONDS * rate), round(SPAN * rate)), delta=tolerance)


if __name__ == '__main__':
    run(RateTest)
