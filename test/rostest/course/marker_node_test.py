#!/usr/bin/env python3
"""ar_control_node.py: output, ignored markers, the warning without messages, driving and stopping."""
import math
import re
import signal
import time

from geometry_msgs.msg import Twist, Vector3

from kinematic_core.timing.stall_free_timer import ActiveTimer
from rostest_support.common import release, run, until
from rostest_support.course import STOP
from rostest_support.robot import RobotCase

NODE = 'ar_control_node.py'
LINE = r'Detected marker with ID (\d+) at x: (\S+) y: (\S+) z: (\S+) m, distance: (\S+) m'
PERIOD_TOLERANCE = 0.2  # [s] of 1 s
LOST_TOLERANCE = 0.5  # [s] by which a loaded machine may be late
MARKERS_PERIOD = 0.1  # [s]
STILL = 1e-3  # [m, rad] that a robot at rest may move
REST = 30  # [messages of odometry] 1 s: longer than a stop while the marker is lost


class ArControlTest(RobotCase):

    def printed(self, process):
        """Return the lines about markers, (id, x, y, z, distance) or 'none'."""
        return [match.groups() if match.group(1) else 'none'
                for match in re.finditer(LINE + r'|No AR markers detected\.', process.output())]

    def test_ar_control_prints(self):
        """Every message: a line for each marker with its position, or that there is none. Nothing is driven."""
        process, track, velocities = self.start(NODE), self.tracker(), self.velocities()
        track({})
        track({5: (1.0, 2.0, -2.0), 300: (0.25, -0.5, 0.0)})
        track({1: (3.0, 0.0, 4.0)})
        expected = ['none', ('5', '1.000', '2.000', '-2.000', '3.000'), ('300', '0.250', '-0.500', '0.000', '0.559'),
                    ('1', '3.000', '0.000', '4.000', '5.000')]
        until(lambda: len(self.printed(process)) >= 4, lambda: f'4 lines in {process.output()}')
        self.assertEqual(expected, self.printed(process))
        for _ in range(20):
            track({})
        until(lambda: len(self.printed(process)) == 24, lambda: f'24 lines in {process.output()}')
        self.assertEqual(0, velocities.subscriber.get_num_connections(), 'it only listens')

    @release
    def test_ar_control_log_rate(self):
        """~log_rate: so many messages a second are printed, with all of their markers."""
        process = self.start(NODE, '_log_rate:=2.0')
        track, begin = self.tracker(), time.monotonic()
        while time.monotonic() - begin < 2.0:
            track({1: (1.0, 0.0, 0.0), 2: (1.0, 0.0, 0.0)})
            time.sleep(MARKERS_PERIOD)
        until(lambda: len(self.printed(process)) in (6, 8, 10), lambda: f'3 to 5 messages printed: {process.output()}')
        ids = [line[0] for line in self.printed(process)]
        self.assertEqual(['1', '2'] * (len(ids) // 2), ids)

    def test_ar_control_bad_poses(self):
        """Poses that no marker can have: one warning with marker and value; the others are printed."""
        process, track = self.start(NODE), self.tracker()
        for _ in range(5):
            track({1: (math.nan, 0.0, 0.0), 2: (1.0, 0.0, 0.0), 3: (1e253, 0.0, 0.0)})
        until(lambda: len(self.printed(process)) == 5, lambda: f'5 lines in {process.output()}')
        self.assertEqual({'2'}, {line[0] for line in self.printed(process)})
        warnings = re.findall(r'\[WARN\].*', process.output())
        self.assertEqual(1, len(warnings), warnings)
        self.assertRegex(warnings[0], r'Marker 1 at x nan.*ignored')

    def test_ar_control_silence(self):
        """No message for 5 s: which topic, and what to type."""
        said = self.start(NODE).wait_for_output(r'\[WARN\].*').group()
        self.assertIn('No markers on /ar_pose_marker for 5 s', said)
        self.assertIn('camera_ar_track.launch', said)

    def test_ar_control_forward(self):
        """The course's publisher: one Twist a second and a line for each; a stop at Ctrl-C."""
        velocities = self.velocities()
        process = self.start(NODE, '_mode:=forward', '_linear:=0.3', '_angular:=-0.25')
        velocities.more(1)
        self.assertAlmostEqual(1.0, 1.0 / velocities.rate(4, span=1), delta=PERIOD_TOLERANCE)
        self.assertEqual([Twist(Vector3(0.3, 0.0, 0.0), Vector3(0.0, 0.0, -0.25))] * 4, velocities.messages[:4])
        self.assertIn('Publish velocity command[0.30 m/s, -0.25 rad/s]', process.output())
        process.process.send_signal(signal.SIGINT)
        self.ended(process)
        until(lambda: velocities.messages[-1] == STOP, 'a last Twist of zeros')
        self.assertEqual(1, velocities.messages.count(STOP))


class FollowTest(RobotCase):

    def follow(self, *arguments):
        """Start the node; return (process, velocities, the function that publishes markers)."""
        velocities = self.velocities()
        process = self.start(NODE, '_mode:=follow', '_marker_id:=4', '_log_rate:=0.1', *arguments)
        return process, velocities, self.tracker()

    def drive(self, velocities, track, ahead=2.0):
        """Publish the marker until the node drives the robot."""
        def driven():
            track({4: (ahead, 0.0, 0.0), 1: (0.5, 0.5, 0.0)})
            time.sleep(MARKERS_PERIOD)
            return velocities.messages and velocities.messages[-1].linear.x > 0.4
        until(driven, 'the robot told to drive at 0.4 m/s')

    def stopped(self, velocities, keep_on=lambda: None):
        """Wait for the stop; assert that it comes once, at 0.5 s, and nothing after it."""
        timer, driving = ActiveTimer(), len(velocities.messages)

        def done():
            keep_on()
            timer.elapsed()
            return velocities.messages[-1] == STOP
        until(done, 'a Twist of zeros')
        self.assertLess(timer.waited, 0.5 + LOST_TOLERANCE)
        for _ in range(8):
            keep_on()
            time.sleep(MARKERS_PERIOD)
        self.assertEqual(1, velocities.messages[driving:].count(STOP), 'others may drive now')
        self.assertEqual(STOP, velocities.messages[-1])

    def test_ar_control_follow(self):
        """Nothing before the marker is seen, then towards it; axes of an optical frame by its name."""
        process, velocities, track = self.follow('_strafe:=true')
        track({1: (2.0, 0.0, 0.0)}, 'camera_color_optical_frame')
        process.wait_for_output('Waiting for marker 4')
        self.assertEqual([], velocities.messages)

        def strafed():
            track({4: (-0.4, 0.0, 0.5)}, 'camera_color_optical_frame')  # 0.4 m to the left, 0.5 m ahead: there
            time.sleep(MARKERS_PERIOD)
            return velocities.messages and velocities.messages[-1].linear.y > 0.4
        until(strafed, 'the robot told to move to the left')
        last = velocities.messages[-1]
        self.assertEqual((0.0, 0.0), (last.linear.x, last.angular.z))

    def test_ar_control_marker_lost(self):
        """The marker is not visible: the robot stops once, and continues when the marker is back."""
        process, velocities, track = self.follow()
        self.drive(velocities, track)
        self.stopped(velocities, lambda: (track({1: (0.5, 0.5, 0.0)}), time.sleep(MARKERS_PERIOD)))
        process.wait_for_output(r'Marker 4 lost for 0\.5 s: stopped')
        self.drive(velocities, track)

    def test_ar_control_tracker_silent(self):
        """No message comes any more: one stop."""
        process, velocities, track = self.follow()
        self.drive(velocities, track)
        self.stopped(velocities)
        process.wait_for_output(r'Marker 4 lost for 0\.5 s: stopped')

    def test_ar_control_closed_loop(self):
        """A robot that obeys: it ends at the distance, facing the marker, and never nearer."""
        robot = self.robot(places={4: (2.0, 0.8)})
        self.start(NODE, '_mode:=follow', '_marker_id:=4', '_distance:=0.6', '_log_rate:=0.1')
        until(lambda: robot.track and robot.track[-1][0] > 0.5
              and math.dist(robot.track[-REST], robot.track[-1]) < STILL, 'a robot that came near and stands')
        distances = [math.hypot(2.0 - x, 0.8 - y) for x, y, _ in robot.track]
        self.assertAlmostEqual(0.6, distances[-1], delta=0.03)
        self.assertGreater(min(distances), 0.55)
        x, y, theta = robot.track[-1]
        self.assertAlmostEqual(theta, math.atan2(0.8 - y, 2.0 - x), delta=0.03)


if __name__ == '__main__':
    run(ArControlTest, FollowTest)
