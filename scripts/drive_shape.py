#!/usr/bin/env python3
"""Lessons 4 and 10, the special challenge: draw a square, or another shape, using only topics. A turtle or a robot."""
import sys

import rospy

from turtle_robotont.driver import DriveError, Driver
from turtle_robotont.driving import drawing, shapes
from turtle_robotont.driving.control import State
from turtle_robotont.driving.vehicle import Limits
from turtle_robotont.params import check_params, list_of, number, one_of, point, ros_name, true_or_false


def main():
    rospy.init_node('drive_shape')
    check_params(robot=true_or_false(), shape=one_of(*shapes.SHAPES),
                 size=number(shapes.SMALLEST, shapes.ARENA_SIZE, 'm'),
                 corners=list_of(point(), '[[4, 4], [7, 4], [7, 7]]', 2), strafe=true_or_false(),
                 speed=number(0.05, 10.0, 'm/s'), turn_speed=number(0.1, 10.0, 'rad/s'), turtle=ros_name('turtle1'))
    robot = rospy.get_param('~robot', False)        # True: drive a robot with odometry, not a turtle
    shape = rospy.get_param('~shape', 'square')
    size = rospy.get_param('~size', shapes.ROBOT_SIZE if robot else shapes.DEFAULT_SIZE)            # of a side [m]
    corners = rospy.get_param('~corners', shapes.ROBOT_CORNERS if robot else shapes.DEFAULT_CORNERS)  # [m]
    strafe = rospy.get_param('~strafe', False)      # True: move sideways instead of turning

    driver = Driver('' if robot else rospy.get_param('~turtle', 'turtle1'))
    limits = Limits(rospy.get_param('~speed', driver.vehicle.limits.speed),              # at most [m/s]
                    rospy.get_param('~turn_speed', driver.vehicle.limits.turn_speed))    # at most [rad/s]
    plan = drawing.plan(shape, driver.ready(), size, corners, limits, driver.vehicle, strafe)
    rospy.loginfo('Drawing: %s, starting at (%.2f, %.2f)', shape, *plan.start)
    track, elapsed = driver.drive(plan.drive)
    if plan.drive.state is not State.ARRIVED:
        raise DriveError(f'did not arrive within {elapsed:.1f} s: {plan.drive.reason}')
    worst, gap = plan.errors(track)
    rospy.loginfo('Drawn in %.1f s: largest error %.3f m, gap at the end %.3f m', elapsed, worst, gap)


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
    except (DriveError, shapes.InvalidInput) as error:
        rospy.logfatal('%s', error)
        sys.exit(1)
