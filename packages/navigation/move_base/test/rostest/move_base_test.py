#!/usr/bin/env python3
"""move_base in the minimaze: goals, plans and refusals."""
import math

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PolygonStamped, PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from std_srvs.srv import Empty

from rospy_support.rotations import to_quaternion
from rostest_support.common import DEADLINE, proxy, run, until
from rostest_support.robotont import RobotontCase, stands

TOLERANCE = 0.1  # [m, rad]
PATIENCE = 60.0  # [s] for a goal, on a loaded machine
START = -2.0, 0.0, 0.0
PLANNER = '/move_base/TrajectoryPlannerROS'


def pose(x, y, yaw=0.0, frame='map'):
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation = to_quaternion(0.0, 0.0, yaw)
    return message


class MoveBaseTest(RobotontCase):

    def setUp(self):
        self.client = actionlib.SimpleActionClient('move_base', MoveBaseAction)
        self.assertTrue(self.client.wait_for_server(rospy.Duration(DEADLINE)))
        self.addCleanup(self.client.cancel_all_goals)
        self.set_pose(*START)
        until(lambda: math.dist(self.odometry()[:2], START[:2]) < 0.01, 'the robot at its start')

    def send(self, target):
        """Send a goal; return (its state, the text of its status) when it is done."""
        self.client.send_goal(MoveBaseGoal(target))
        self.assertTrue(self.client.wait_for_result(rospy.Duration(PATIENCE)), self.truth())
        return self.client.get_state(), self.client.get_goal_status_text()

    def assert_stands(self):
        truth = self.collected('~ground_truth', Odometry)
        truth.next(stands, 'a robot that stands')

    def test_goal_is_reached_around_a_corner(self):
        goal = -0.4, 1.6, 2.0
        self.assertEqual((GoalStatus.SUCCEEDED, 'Goal reached.'), self.send(pose(*goal)))
        self.assert_at(self.truth(), *goal, tolerance=TOLERANCE)
        self.assert_stands()
        for topic, kind in (('NavfnROS/plan', Path), ('TrajectoryPlannerROS/global_plan', Path),
                            ('TrajectoryPlannerROS/local_plan', Path), ('current_goal', PoseStamped),
                            ('global_costmap/costmap', OccupancyGrid), ('local_costmap/costmap', OccupancyGrid),
                            ('global_costmap/footprint', PolygonStamped)):
            self.message(f'move_base/{topic}', kind)

    def test_impossible_goals_are_given_up_with_a_reason(self):
        for target, reason in ((pose(-1.0, 0.0), 'is in an obstacle'), (pose(math.nan, 0.0), 'contains NaN'),
                               (pose(0.0, 0.0, frame='nowhere'), 'cannot be transformed to map'),
                               (pose(0.0, 0.0, frame=''), 'names no frame')):
            state, text = self.send(target)
            self.assertEqual(GoalStatus.ABORTED, state, text)
            self.assertIn(reason, text)
        self.assert_at(self.truth(), *START)

    def test_cancelled_goal_stops_the_robot(self):
        self.client.send_goal(MoveBaseGoal(pose(0.0, 2.0)))
        self.collected('~ground_truth', Odometry).next(lambda message: not stands(message), 'a robot that moves')
        self.client.cancel_goal()
        self.client.wait_for_result(rospy.Duration(DEADLINE))
        self.assertEqual(GoalStatus.PREEMPTED, self.client.get_state())
        self.assert_stands()

    def test_goal_of_rviz_in_another_frame_is_relative_to_it(self):
        """From the robot at (-2, 0), 0.4 m to the left."""
        publisher = rospy.Publisher('move_base_simple/goal', PoseStamped, queue_size=1)
        self.addCleanup(publisher.unregister)
        until(lambda: publisher.get_num_connections(), 'a subscriber')
        publisher.publish(pose(0.0, 0.4, 0.5, 'base_footprint'))
        until(lambda: math.dist(self.truth()[:2], (-2.0, 0.4)) < TOLERANCE, lambda: f'at the goal: {self.truth()}',
              PATIENCE)

    def test_plan_without_driving(self):
        plan = proxy('move_base/make_plan', GetPlan)(pose(-2.0, 0.0), pose(2.0, 2.0), 0.0).plan
        ends = [plan.poses[index].pose.position for index in (0, -1)]
        self.assertEqual([(-2.0, 0.0), (2.0, 2.0)], [(end.x, end.y) for end in ends])
        self.assertGreater(len(plan.poses), 100)  # 9 m, 5 cm or a little more each
        self.assertEqual([], proxy('move_base/make_plan', GetPlan)(pose(-2.0, 0.0), pose(-1.0, 0.0), 0.0).plan.poses)
        proxy('move_base/clear_costmaps', Empty)()
        self.assert_at(self.truth(), *START)

    def test_tolerances_can_be_changed_while_it_runs(self):
        client = Client(PLANNER, timeout=DEADLINE)
        self.addCleanup(client.update_configuration, {'xy_goal_tolerance': 0.05, 'yaw_goal_tolerance': 0.05})
        client.update_configuration({'xy_goal_tolerance': 0.5, 'yaw_goal_tolerance': 3.5})
        self.assertEqual(GoalStatus.SUCCEEDED, self.send(pose(-2.0, 0.7, 3.0))[0])
        self.assertGreater(math.dist(self.truth()[:2], (-2.0, 0.7)), 0.25)
        self.assertEqual(0.5, rospy.get_param(f'{PLANNER}/xy_goal_tolerance'))

if __name__ == '__main__':
    run(MoveBaseTest)
