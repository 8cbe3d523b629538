#!/usr/bin/env python3
"""A simulator that gets no processor time for a while: it makes up for late steps, so that no ground is lost."""
import os
import signal
import time

from rosgraph_msgs.msg import Log

from rostest_support.common import DT, NodeLog, SimulatorCase, node_api, run, until

PAUSE = 1.0  # [s] shorter than the limit for catching up
LONG_PAUSE = 6.0  # [s] longer
BEHIND = 20  # [steps] that the poses may be behind the clock, of the 62 of PAUSE


class LateTest(SimulatorCase):

    def pause(self, seconds):
        """Stop the simulator's process for a while."""
        pid = node_api('/turtlesim').getPid('/test')[2]
        end = time.monotonic() + seconds
        os.kill(pid, signal.SIGSTOP)
        try:
            until(lambda: time.monotonic() > end, 'an end of the pause', seconds + 1.0)
        finally:
            os.kill(pid, signal.SIGCONT)

    def test_turtlesim_catches_up(self):
        """After a pause the steps that are late come at once: as many in all as the clock says."""
        poses = self.poses()
        seen, begin = len(poses.messages), time.monotonic()
        for _ in range(2):
            self.pause(PAUSE)
            until(lambda: (time.monotonic() - begin) / DT - (len(poses.messages) - seen) < BEHIND,
                  'as many poses as the clock says')

    def test_turtlesim_suspended(self):
        """A pause as of a suspended machine is not made up for: a warning, and on from there."""
        log, poses = NodeLog('/turtlesim'), self.poses()
        seen = len(poses.messages)
        self.pause(LONG_PAUSE)
        log.wait(Log.WARN, r'The simulator stood still for \d+\.\d s.*')
        poses.more(30)
        self.assertLess(len(poses.messages) - seen, LONG_PAUSE / DT, 'the pause was made up for')


if __name__ == '__main__':
    run(LateTest)
