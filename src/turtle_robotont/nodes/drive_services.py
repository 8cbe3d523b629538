"""The services of a self-driving turtle: gotoPose, drive_to and draw_shape.

Threads: rospy runs every call in its own thread; they share the TurtleDriver, in which the newest goal replaces others.
"""
import math

import rospy
from turtlesim.srv import TeleportAbsolute, TeleportAbsoluteResponse

from kinematic_core.validation import InvalidInput
from kinematic_core.worlds.angles import wrap_angle
from turtle_robotont.driving import drawing
from turtle_robotont.driving.control import TOLERANCE, GoTo, State, require_goal
from turtle_robotont.driving.shapes import DEFAULT_SIZE, distance
from turtle_robotont.nodes import turtle_tasks
from turtle_robotont.nodes.driver import DriveError
from turtle_robotont.nodes.node_params import FASTEST, SLOWEST
from turtle_robotont.srv import DrawShape, DrawShapeResponse, DriveTo, DriveToRequest, DriveToResponse

MODES = ('drive', 'teleport', 'log')
FINEST, COARSEST = 0.002, 1.0  # [m] smallest and largest tolerance in a request


class DriveServices:
    """Serves ``<turtle>/gotoPose``, ``<turtle>/drive_to`` and ``<turtle>/draw_shape``."""

    def __init__(self, driver, mode, limits, corners):
        """``mode``: what gotoPose does, one of MODES; ``corners``: those of draw_shape if the request has none."""
        self._driver, self._mode, self._limits, self._corners = driver, mode, limits, corners
        turtle = driver.turtle
        self._services = [rospy.Service(f'{turtle}/gotoPose', TeleportAbsolute, self._goto_pose),
                          rospy.Service(f'{turtle}/drive_to', DriveTo, self._drive_to),
                          rospy.Service(f'{turtle}/draw_shape', DrawShape, self._draw_shape)]
        rospy.loginfo('Ready to command gotoPose service.')

    def _goto_pose(self, request):
        """Answer when the turtle has arrived. The call fails if the drive fails, as the answer has no field for it."""
        rospy.loginfo('Service => x: %g y: %g theta: %g', request.x, request.y, request.theta)
        if self._mode == 'drive':
            answer = self._drive_to(DriveToRequest(request.x, request.y, request.theta, True, 0.0, 0.0))
            if not answer.arrived:
                raise rospy.ServiceException(answer.reason)
        elif self._mode == 'teleport':
            self._teleport(request)
        return TeleportAbsoluteResponse()

    def _teleport(self, request):
        try:
            goal = require_goal(request.x, request.y, request.theta)
            self._driver.cancel('the turtle was teleported')
            turtle_tasks.teleport(self._driver, goal)
        except (InvalidInput, DriveError) as error:
            raise rospy.ServiceException(str(error)) from None

    def _drive_to(self, request):
        answer = DriveToResponse(position_error=math.nan, heading_error=math.nan)
        try:
            goal = require_goal(request.x, request.y, request.theta if request.use_heading else None)
            limits = self._limits_for(request.speed)
            tolerance = TOLERANCE._replace(position=_asked('tolerance', request.tolerance, FINEST, COARSEST, 'm',
                                                           TOLERANCE.position))
            drive = GoTo(self._driver.ready(), goal, limits, tolerance)
            answer.elapsed = self._driver.drive(drive).elapsed
            answer.arrived, answer.reason = drive.state is State.ARRIVED, drive.reason
            pose = self._driver.pose()
            answer.position_error = distance(pose, goal)
            answer.heading_error = 0.0 if goal.theta is None else abs(wrap_angle(goal.theta - pose.theta))
        except (InvalidInput, DriveError) as error:
            answer.reason = answer.reason or str(error)
        self._log(f'Drive to ({request.x:.2f}, {request.y:.2f})', answer.arrived, answer)
        return answer

    def _draw_shape(self, request):
        answer = DrawShapeResponse(corner_error=math.nan, closing_error=math.nan)
        try:
            corners = [[point.x, point.y] for point in request.corners] or self._corners
            plan = drawing.plan(request.shape, self._driver.ready(), request.size or DEFAULT_SIZE, corners,
                                self._limits_for(request.speed))
            result = self._driver.drive(plan.drive)
            answer.elapsed = result.elapsed
            answer.drawn, answer.reason = plan.drive.state is State.ARRIVED, plan.drive.reason
            if result.track:
                answer.corner_error, answer.closing_error = plan.errors(result.track)
        except (InvalidInput, DriveError) as error:
            answer.reason = str(error)
        self._log(f'Draw {request.shape}', answer.drawn, answer)
        return answer

    def _limits_for(self, speed):
        return self._limits._replace(speed=_asked('speed', speed, SLOWEST, FASTEST, 'm/s', self._limits.speed))

    @staticmethod
    def _log(what, done, answer):
        if done:
            rospy.loginfo('%s: done in %.1f s', what, answer.elapsed)
        else:
            rospy.logwarn('%s: %s', what, answer.reason)


def _asked(name, value, lowest, highest, unit, default):
    """Return a value of a request, the default for 0; raise InvalidInput unless it lies in lowest .. highest."""
    if value == 0.0:
        return default
    if not lowest <= value <= highest:
        raise InvalidInput(f'{name} is {value:g} {unit}; it must be {lowest:g} to {highest:g} {unit}, or 0 for '
                           f'{default:g}')
    return value
