#!/usr/bin/env python3
"""Lesson 5, a service call: the colour and width of the turtle's pen, by the service turtle1/set_pen."""
import sys

import rospy
from turtlesim.srv import SetPen

from turtle_robotont.params import check_params, true_or_false, whole


def main():
    rospy.init_node('set_pen')
    check_params(r=whole(0, 255), g=whole(0, 255), b=whole(0, 255), width=whole(0, 255, 'px'), off=true_or_false())
    r = rospy.get_param('~r', 0)             # red, green and blue of the pen
    g = rospy.get_param('~g', 0)
    b = rospy.get_param('~b', 255)
    width = rospy.get_param('~width', 5)     # [px]
    off = rospy.get_param('~off', False)     # True: lift the pen

    rospy.wait_for_service('turtle1/set_pen', timeout=10.0)
    set_pen = rospy.ServiceProxy('turtle1/set_pen', SetPen)
    set_pen(r, g, b, width, off)
    rospy.loginfo('Pen off' if off else f'Pen set to r: {r} g: {g} b: {b}, {width} px wide')


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
    except (rospy.ROSException, rospy.ServiceException) as error:
        rospy.logfatal('%s cannot be called: %s; is the simulator running? (rosservice list)',
                       rospy.resolve_name('turtle1/set_pen'), error)
        sys.exit(1)
