#!/usr/bin/env python3
"""How the turtle moves on cmd_vel: distances count steps of 16 ms, so a slow machine changes nothing."""
import math

from rosgraph_msgs.msg import Log

from rostest_support.common import BACKGROUND, DT, MIDDLE, NodeLog, SimulatorCase, run, until

STEPS = 63  # a command lasts: the 63rd step is the last within 1 s of it (62.5 steps)
STEP_TOLERANCE = 1.0  # [steps] the first step after a command may come at once or 16 ms later


class DrivingTest(SimulatorCase):

    def drive(self, **velocity):
        """Give one command in the middle of the arena, wait until its effect is over; return the poses of that time."""
        poses = self.poses()
        self.driver()(**velocity)
        poses.next(lambda pose: pose.linear_velocity or pose.angular_velocity, 'a turtle that moves')
        poses.next(lambda pose: not pose.linear_velocity and not pose.angular_velocity, 'a turtle that stands')
        return poses.messages

    def steps(self, amount, speed):
        """Assert that an amount [m or rad] at a speed [1/s] took as many steps as a command lasts."""
        self.assertAlmostEqual(STEPS, amount / (speed * DT), delta=STEP_TOLERANCE)

    def test_turtlesim_drives_sideways(self):
        """linear.y counts: the turtle is holonomic."""
        heading = 0.5
        self.jump(MIDDLE, MIDDLE, heading)
        poses = self.drive(y=1.5)
        way = math.hypot(poses[-1].x - MIDDLE, poses[-1].y - MIDDLE)
        self.steps(way, 1.5)
        self.assert_pose(poses[-1], MIDDLE - math.sin(heading) * way, MIDDLE + math.cos(heading) * way, heading)

    def test_turtlesim_wall(self):
        """Each step warns in turtlesim's words, with y given downwards: below the arena it is more than its size."""
        log = NodeLog('/turtlesim')
        self.driver()(x=-100.0, y=-100.0)
        # the fourth step: 5.544444 + 6.4 m downwards, and -0.855556 m to the left
        log.wait(Log.WARN, r'Oh no! I hit the wall! \(Clamping from \[x=-0\.85555[56], y=11\.94444[45]\]\)')
        until(lambda: self.pose().linear_velocity == 0.0, 'a turtle that stands')
        self.assert_pose(self.pose(), 0.0, 0.0, 0.0)
        # one line a step: 63 steps of which the first three met no wall
        until(lambda: len(log.texts(Log.WARN)) >= STEPS - 3 - STEP_TOLERANCE, f'{STEPS - 3} warnings')
        self.assertLessEqual(len(log.texts(Log.WARN)), STEPS - 3 + STEP_TOLERANCE)

    def test_turtlesim_color_sensor(self):
        """color_sensor reads the background, then the line of the pen."""
        self.assertEqual(BACKGROUND, self.color())
        self.call('turtle1/set_pen', 255, 128, 0, 5, 0)
        self.driver()(x=0.5)  # 0.36 px a step: the turtle stands on its own line
        until(lambda: self.color() == (255, 128, 0), 'the colour of the pen under the turtle')


if __name__ == '__main__':
    run(DrivingTest)
