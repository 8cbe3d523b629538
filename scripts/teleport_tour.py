#!/usr/bin/env python3
"""Lesson 7, the last challenge: four positions by the service teleport_absolute, the path between them in black."""
import math
import sys

import rospy
from turtlesim.msg import Pose
from turtlesim.srv import SetPen, TeleportAbsolute

from turtle_robotont.params import check_params, list_of, number, point, ros_name, whole


def main():
    rospy.init_node('teleport_tour')
    check_params(positions=list_of(point(0.0, 11.0889), '[[2, 2], [9, 2]]'), pause=number(0.0, 60.0, 's'),
                 color=list_of(whole(0, 255), '[0, 0, 0]', 3, 3), width=whole(0, 255, 'px'), turtle=ros_name('turtle1'))
    positions = rospy.get_param('~positions', [[2.0, 2.0], [9.0, 2.0], [9.0, 9.0], [2.0, 9.0]])  # [m]
    red, green, blue = rospy.get_param('~color', [0, 0, 0])
    width = rospy.get_param('~width', 3)         # of the path [px]
    pause = rospy.get_param('~pause', 0.5)       # between two positions [s]
    turtle = rospy.get_param('~turtle', 'turtle1')

    pose = rospy.wait_for_message(f'{turtle}/pose', Pose, timeout=10.0)
    set_pen = rospy.ServiceProxy(f'{turtle}/set_pen', SetPen)
    teleport = rospy.ServiceProxy(f'{turtle}/teleport_absolute', TeleportAbsolute)
    set_pen(red, green, blue, width, 0)
    last_x, last_y = pose.x, pose.y
    for x, y in positions:
        if rospy.is_shutdown():   # Ctrl-C
            return
        theta = math.atan2(y - last_y, x - last_x)   # the direction of the jump
        rospy.loginfo('Goto => x: %.2f y: %.2f theta: %.2f', x, y, theta)
        teleport(x, y, theta)
        last_x, last_y = x, y
        rospy.sleep(pause)
    rospy.loginfo('Visited all %d positions', len(positions))


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
    except (rospy.ROSException, rospy.ServiceException) as error:
        rospy.logfatal('%s. Is the simulator running, and does the turtle exist? (rostopic list)', error)
        sys.exit(1)
