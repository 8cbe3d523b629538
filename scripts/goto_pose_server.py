#!/usr/bin/env python3
"""Lesson 6, a service of your own: turtle1/gotoPose drives the turtle to a pose, and answers when it is there."""
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose
from turtlesim.srv import TeleportAbsolute, TeleportAbsoluteResponse

from turtle_robotont.params import check_params, number, one_of, ros_name

ARENA = 11.0889  # side of the arena [m]
GAIN = 4.0       # speed for each metre, or radian, that is left [1/s]
NEAR = 0.01      # close enough [m or rad]


class GotoPoseServer:

    def __init__(self):
        turtle = rospy.get_param('~turtle', 'turtle1')
        self.mode = rospy.get_param('~mode', 'drive')
        self.speed = rospy.get_param('~speed', 2.0)            # at most [m/s]
        self.turn_speed = rospy.get_param('~turn_speed', 5.0)  # at most [rad/s]
        self.goal = None                                       # the newest goal
        self.publisher = rospy.Publisher(f'{turtle}/cmd_vel', Twist, queue_size=10)
        self.teleport = rospy.ServiceProxy(f'{turtle}/teleport_absolute', TeleportAbsolute)
        rospy.on_shutdown(self.stop)
        self.pose = rospy.wait_for_message(f'{turtle}/pose', Pose)
        rospy.Subscriber(f'{turtle}/pose', Pose, self.store_pose)
        rospy.Service(f'{turtle}/gotoPose', TeleportAbsolute, self.goto_pose)
        rospy.loginfo('Ready to command gotoPose service.')

    def store_pose(self, pose):
        self.pose = pose

    def stop(self):
        self.goal = None
        self.publisher.publish(Twist())   # all zeros

    def goto_pose(self, goal):
        rospy.loginfo('Service => x: %g y: %g theta: %g', goal.x, goal.y, goal.theta)
        if not (0.0 <= goal.x <= ARENA and 0.0 <= goal.y <= ARENA and math.isfinite(goal.theta)):
            raise rospy.ServiceException(f'x is {goal.x:g} m, y is {goal.y:g} m, theta is {goal.theta:g} rad; x and y '
                                         f'must be 0 to {ARENA} m, and all must be finite')
        self.goal = goal
        if self.mode == 'drive':
            self.drive_to(goal)
        elif self.mode == 'teleport':
            self.teleport(goal.x, goal.y, goal.theta)
        return TeleportAbsoluteResponse()

    def drive_to(self, goal):
        """Publish velocities until the turtle is at the goal; give up when another call brings a newer goal."""
        start, rate = rospy.get_time(), rospy.Rate(50)
        while self.goal is goal:
            distance = math.hypot(goal.x - self.pose.x, goal.y - self.pose.y)
            direction = math.atan2(goal.y - self.pose.y, goal.x - self.pose.x) if distance > NEAR else goal.theta
            turn = math.remainder(direction - self.pose.theta, 2.0 * math.pi)  # the shorter way round, -pi to pi
            velocity = Twist()
            if distance <= NEAR and abs(turn) <= NEAR:
                self.publisher.publish(velocity)
                rospy.loginfo('Drive to (%.2f, %.2f): done in %.1f s', goal.x, goal.y, rospy.get_time() - start)
                return
            velocity.angular.z = max(-self.turn_speed, min(self.turn_speed, GAIN * turn))
            if distance > NEAR and abs(turn) < 0.3:   # it faces the goal: drive
                velocity.linear.x = min(self.speed, GAIN * distance)
            self.publisher.publish(velocity)
            rate.sleep()
        raise rospy.ServiceException('preempted: a newer goal took over, or the node ended')


if __name__ == '__main__':
    rospy.init_node('goto_pose_server')
    check_params(mode=one_of('drive', 'teleport', 'log'), speed=number(0.05, 10.0, 'm/s'),
                 turn_speed=number(0.1, 10.0, 'rad/s'), turtle=ros_name('turtle1'))
    GotoPoseServer()
    rospy.spin()
