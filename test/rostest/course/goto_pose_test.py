#!/usr/bin/env python3
"""The service turtle1/gotoPose: called as the course does, its three modes, bad goals, several goals at once."""
import math
import subprocess

import rospy
import rosservice
from rosgraph_msgs.msg import Log
from turtlesim.srv import TeleportAbsolute

from rostest_support.common import DEADLINE, MIDDLE, NodeLog, nightly, proxy, run, until
from rostest_support.course import BackgroundCall, CourseCase, stands

SERVICE = '/turtle1/gotoPose'
TOP_SPEED = 2.0  # [m/s] of the server by default
BAD_GOALS = [  # x, y, theta, words in the error
    ((math.nan, 5.0, 0.0), ['x is nan', 'finite']),
    ((11.2, 5.0, 0.0), ['x is 11.2 m', '0 to 11.0889']),
]


class GotoPoseTest(CourseCase):

    def setUp(self):
        super().setUp()
        rospy.wait_for_service(SERVICE, DEADLINE)

    def rosservice_call(self, *arguments):
        """Run rosservice call; return its output."""
        done = subprocess.run(['rosservice', 'call', SERVICE, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=2.0 * DEADLINE, check=False)
        self.assertEqual(0, done.returncode, done.stdout)
        return done.stdout.decode()

    def refusal(self, *values):
        """Call gotoPose, which must fail; return the text of the failure."""
        with self.assertRaises(rospy.ServiceException, msg=str(values)) as failure:
            proxy(SERVICE, TeleportAbsolute)(*values)
        return str(failure.exception)

    def test_goto_pose_by_rosservice(self):
        """rosservice call /turtle1/gotoPose 1.5 2.5 3.14 answers when the turtle stands there."""
        self.assertEqual('turtlesim/TeleportAbsolute', rosservice.get_service_type(SERVICE))
        poses = self.poses()
        self.assertEqual('\n', self.rosservice_call('1.5', '2.5', '3.14'))
        self.assertTrue(stands(self.pose()), 'still driving when the call was answered')
        self.assert_at(self.pose(), 1.5, 2.5, 3.14)
        self.assert_driven(poses.messages, TOP_SPEED)

    def test_goto_pose_teleport(self):
        """~mode teleport: the turtle is there at once."""
        poses, commands = self.poses(), self.commands()
        proxy(SERVICE, TeleportAbsolute)(1.5, 2.5, 3.0)
        self.assert_pose(self.pose(), 1.5, 2.5, 3.0)
        self.assertEqual({MIDDLE, 1.5}, {pose.x for pose in poses.messages})
        self.assertEqual([], commands.messages)

    def test_goto_pose_log(self):
        """~mode log: only a line, as in the course's first server."""
        log = NodeLog('/log/goto_pose_server')
        before = self.pose()
        proxy('/log/turtle1/gotoPose', TeleportAbsolute)(1.5, 2.5, 3.14)
        log.wait(Log.INFO, r'Service => x: 1\.5 y: 2\.5 theta: 3\.14')
        self.assertEqual(before, self.pose())

    def assert_refuses_bad_goals(self):
        before, commands = self.pose(), self.commands()
        for goal, texts in BAD_GOALS:
            with self.subTest(goal=goal):
                refusal = self.refusal(*goal)
                for text in texts:
                    self.assertIn(text, refusal)
        self.assertEqual(before, self.pose())
        self.assertEqual([], commands.messages)

    def test_goto_pose_bad_goals(self):
        """The call fails with value and range; the turtle does not move, and the next goal is served."""
        self.assert_refuses_bad_goals()
        proxy(SERVICE, TeleportAbsolute)(6.0, 5.5, 0.0)
        self.assert_at(self.pose(), 6.0, 5.5, 0.0)

    def test_goto_pose_bad_goals_teleport(self):
        """The same in mode teleport."""
        self.assert_refuses_bad_goals()
        proxy(SERVICE, TeleportAbsolute)(6.0, 5.5, 0.0)
        self.assert_pose(self.pose(), 6.0, 5.5, 0.0)

    def test_goto_pose_newest_goal_wins(self):
        """A goal takes over from the one that is driven to, which fails at once as preempted."""
        poses = self.poses()
        older = BackgroundCall(SERVICE, TeleportAbsolute, 10.5, MIDDLE, 0.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle on its way to the older goal')
        newer = BackgroundCall(SERVICE, TeleportAbsolute, 4.0, 3.0, 1.0)
        older.ended()
        self.assertTrue(newer.is_alive(), 'the older call was answered only after the newer one')
        self.assertRegex(older.error, 'preempted: a newer goal')
        newer.ended()
        self.assertEqual('', newer.error)
        self.assert_at(self.pose(), 4.0, 3.0, 1.0)
        self.assertLess(max(pose.x for pose in poses.messages), 10.0)

    @nightly
    def test_goto_pose_many_goals_at_once(self):
        """Of twenty goals at once each is reached or fails as preempted, and the turtle stands at one that was reached.

        A goal that comes when the turtle has arrived, as on a busy machine, takes over from none.
        """
        goals = [(5.5 + 2.0 * math.cos(number), 5.5 + 2.0 * math.sin(number), 0.1 * number) for number in range(20)]
        calls = [BackgroundCall(SERVICE, TeleportAbsolute, *goal) for goal in goals]
        until(lambda: not any(call.is_alive() for call in calls), 'an answer to every call')
        arrived = [goal for goal, call in zip(goals, calls) if call.answer is not None]
        self.assertTrue(0 < len(arrived) < 10, [call.error for call in calls])
        pose = self.pose()
        self.assert_at(pose, *min(arrived, key=lambda goal: math.dist(goal[:2], (pose.x, pose.y))))
        self.assertTrue(stands(pose))
        for call in calls:
            self.assertTrue(call.answer is not None or 'preempted' in call.error, call.error)


if __name__ == '__main__':
    run(GotoPoseTest)
