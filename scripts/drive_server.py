#!/usr/bin/env python3
"""Two services whose answers say how the drive went: turtle1/drive_to and turtle1/draw_shape. See lesson 6."""
import math

import rospy
from turtle_robotont.srv import DrawShape, DrawShapeResponse, DriveTo, DriveToResponse

from turtle_robotont.driver import DriveError, Driver
from turtle_robotont.driving import drawing, shapes
from turtle_robotont.driving.control import TOLERANCE, GoTo, State, require_goal
from turtle_robotont.driving.vehicle import Limits
from turtle_robotont.params import check_params, list_of, number, point, ros_name

SPEEDS = 0.05, 10.0      # slowest and fastest [m/s]
TOLERANCES = 0.002, 1.0  # finest and coarsest [m]


class DriveServer:

    def __init__(self, turtle):
        self.speed = rospy.get_param('~speed', 2.0)             # [m/s] unless the request says otherwise
        self.turn_speed = rospy.get_param('~turn_speed', 5.0)   # at most [rad/s]
        self.corners = rospy.get_param('~corners', shapes.DEFAULT_CORNERS)  # [m] of a request without corners
        self.driver = Driver(turtle)
        rospy.Service(f'{turtle}/drive_to', DriveTo, self.drive_to)
        rospy.Service(f'{turtle}/draw_shape', DrawShape, self.draw_shape)
        rospy.loginfo('Ready: %s/drive_to and %s/draw_shape', turtle, turtle)

    def drive_to(self, request):
        answer = DriveToResponse(position_error=math.nan, heading_error=math.nan)
        try:
            goal = require_goal(request.x, request.y, request.theta if request.use_heading else None)
            nearness = allowed_or_default('tolerance', request.tolerance, TOLERANCES, 'm', TOLERANCE.position)
            drive = GoTo(self.driver.ready(), goal, self.limits(request.speed), TOLERANCE._replace(position=nearness))
            _, answer.elapsed = self.driver.drive(drive)
            answer.arrived, answer.reason = drive.state is State.ARRIVED, drive.reason
            pose = self.driver.pose()
            answer.position_error = shapes.distance(pose, goal)
            answer.heading_error = 0.0 if goal.theta is None else abs(shapes.wrap_angle(goal.theta - pose.theta))
        except (DriveError, shapes.InvalidInput, rospy.ROSInterruptException) as error:
            answer.reason = answer.reason or str(error)
        self.log(f'Drive to ({request.x:.2f}, {request.y:.2f})', answer.arrived, answer)
        return answer

    def draw_shape(self, request):
        answer = DrawShapeResponse(corner_error=math.nan, closing_error=math.nan)
        try:
            corners = [[corner.x, corner.y] for corner in request.corners] or self.corners
            plan = drawing.plan(request.shape, self.driver.ready(), request.size or shapes.DEFAULT_SIZE, corners,
                                self.limits(request.speed))
            track, answer.elapsed = self.driver.drive(plan.drive)
            answer.drawn, answer.reason = plan.drive.state is State.ARRIVED, plan.drive.reason
            if track:
                answer.corner_error, answer.closing_error = plan.errors(track)
        except (DriveError, shapes.InvalidInput, rospy.ROSInterruptException) as error:
            answer.reason = str(error)
        self.log(f'Draw {request.shape}', answer.drawn, answer)
        return answer

    def limits(self, speed):
        return Limits(allowed_or_default('speed', speed, SPEEDS, 'm/s', self.speed), self.turn_speed)

    def log(self, what, done, answer):
        if done:
            rospy.loginfo('%s: done in %.1f s', what, answer.elapsed)
        else:
            rospy.logwarn('%s: %s', what, answer.reason)


def allowed_or_default(name, value, allowed, unit, default):
    """Return a value of a request, the default for 0; raise InvalidInput unless it is allowed."""
    low, high = allowed
    if value and not low <= value <= high:
        raise shapes.InvalidInput(f'{name} is {value:g} {unit}; it must be {low:g} to {high:g} {unit}, or 0 for '
                                  f'{default:g}')
    return value or default


if __name__ == '__main__':
    rospy.init_node('drive_server')
    check_params(speed=number(*SPEEDS, 'm/s'), turn_speed=number(0.1, 10.0, 'rad/s'), turtle=ros_name('turtle1'),
                 corners=list_of(point(0.0, shapes.ARENA_SIZE), '[[4, 4], [7, 4], [7, 7]]', 2))
    DriveServer(rospy.get_param('~turtle', 'turtle1'))
    rospy.spin()
