"""draw_square: drive turtle1 around a square, controlled by its poses.

The corners are computed once, from the first pose. The turtle drives to each of them from its present position, so that
errors do not add up from lap to lap.

Threading contract: a callback stores the newest pose; the main thread takes it, decides and publishes.
"""
from __future__ import annotations

import math
import threading
import time

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.planar import STILL, Twist2D
from plain_support import InvalidInput, require_sane
from rospy_support import nodes, parameters
from rospy_support.parameters import Integer, Number, Table
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from turtlesim.msg import Pose

SPEED = 1.0  # [m/s] along the sides, turtlesim's
TURN_SPEED = 1.0  # [rad/s] at the corners, at most
GAIN = 4.0  # [1/s] of distance and heading; stable with poses up to 0.2 s late
CREEP = 0.05  # [m/s or rad/s] slowest approach, so that it ends
DISTANCE_TOLERANCE = 0.002  # [m] along the side, where the turtle stops
HEADING_TOLERANCE = 0.002  # [rad] 4 mm at the end of a side of 2 m, before steering
CORNER_TOLERANCE = 0.02  # [m] beyond it, the turtle drives to the corner again
LOOK_AHEAD = 0.2  # [m] shortest distance to steer by, because the direction of a nearby point is arbitrary

LARGEST_SIDE = 5.5  # [m] from the middle of the arena, where reset puts the turtle, to its edge
PARAMETERS = Table(Number('~side', 2.0, 0.1, LARGEST_SIDE, 'm'),  # 2 m: turtlesim's
                   Integer('~laps', 0, 0))

POSE_TIMEOUT = 5.0  # [s] without a pose before a warning
WARNING_PERIOD = 5.0  # [s] between two equal warnings
RETRY_PERIOD = 1.0  # [s]


class SquareDriver:
    """Computes, from each pose, the command to drive round a square counter-clockwise.

    It starts in a corner, with a side straight ahead. Units: m, rad; x to the right, y up, theta counter-clockwise.
    """

    def __init__(self, x: float, y: float, theta: float, side: float, laps: int = 0) -> None:
        """Place the square at the pose (x, y, theta); ``laps``: 0 means forever."""
        self.corners = square_corners(x, y, theta, side)  # in driving order, the first one the start
        self.visited = 0  # corners reached so far
        self.finished = False
        self._corners_to_visit = 4 * laps if laps else math.inf
        self._start_heading = theta
        self._act = self._turn

    @property
    def corners_left(self) -> float:
        """Return how many corners are left; inf if it drives forever."""
        return self._corners_to_visit - self.visited

    @property
    def target(self) -> tuple[float, float]:
        return self.corners[(self.visited + 1) % 4]

    def step(self, x: float, y: float, theta: float) -> Twist2D:
        ahead, left = in_turtle_frame(x, y, theta, *self.target)
        heading_error = math.atan2(left, ahead)
        if not self.corners_left:
            self._act, heading_error = self._finish, wrap_angle(self._start_heading - theta)
        return self._act(ahead, left, heading_error)

    def _turn(self, ahead: float, left: float, heading_error: float) -> Twist2D:
        if abs(heading_error) <= HEADING_TOLERANCE:
            self._act = self._drive
            return STILL
        return Twist2D(angular_z=approach(heading_error, TURN_SPEED))

    def _drive(self, ahead: float, left: float, heading_error: float) -> Twist2D:
        if ahead <= DISTANCE_TOLERANCE:
            self._act = self._turn
            if math.hypot(ahead, left) <= CORNER_TOLERANCE:
                self.visited += 1
            return STILL
        steering = GAIN * math.atan2(left, max(ahead, LOOK_AHEAD))
        return Twist2D(linear_x=approach(ahead, SPEED), angular_z=max(-TURN_SPEED, min(steering, TURN_SPEED)))

    def _finish(self, ahead: float, left: float, heading_error: float) -> Twist2D:
        self.finished = abs(heading_error) <= HEADING_TOLERANCE
        return STILL if self.finished else Twist2D(angular_z=approach(heading_error, TURN_SPEED))


def to_twist(command: Twist2D) -> Twist:
    """Return the geometry_msgs/Twist of a Twist2D; its other components are 0."""
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = command.linear_x, command.linear_y, command.angular_z
    return message


def square_corners(x: float, y: float, theta: float, side: float) -> list[tuple[float, float]]:
    """Return the corners (x, y) of the square that starts at a pose with a side straight ahead, counter-clockwise."""
    forward = (side * math.cos(theta), side * math.sin(theta))
    left = (-forward[1], forward[0])
    return [(x, y), (x + forward[0], y + forward[1]),
            (x + forward[0] + left[0], y + forward[1] + left[1]), (x + left[0], y + left[1])]


def in_turtle_frame(x: float, y: float, theta: float, target_x: float, target_y: float) -> tuple[float, float]:
    """Return how far [m] a point lies ahead and to the left of a turtle at the pose (x, y, theta)."""
    dx, dy = target_x - x, target_y - y
    return math.cos(theta) * dx + math.sin(theta) * dy, math.cos(theta) * dy - math.sin(theta) * dx


def approach(error: float, limit: float) -> float:
    """Return the speed towards an error of 0: proportional, between CREEP and ``limit`` in size."""
    return math.copysign(max(CREEP, min(abs(GAIN * error), limit)), error)


class DrawSquareNode:
    """Drives turtle1 with a SquareDriver. rospy must be initialised."""

    def __init__(self) -> None:
        self._side, self._laps = PARAMETERS.read('~side', '~laps')
        parameters.log_effective()
        self._pose: Pose | None = None
        self._ended = False
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._news = threading.Condition(threading.RLock())  # a signal may end the node while it is held
        self._publisher = LatestPublisher('turtle1/cmd_vel', Twist)
        rospy.on_shutdown(self._end)

    def run(self) -> None:
        """Call reset, then drive until the laps are done or ROS shuts down."""
        reset_simulator()
        poses = rospy.Subscriber('turtle1/pose', Pose, self._store, queue_size=1, tcp_nodelay=True)
        driver: SquareDriver | None = None
        while not rospy.is_shutdown() and not (driver and driver.finished):
            pose = self._next_pose(poses.resolved_name)
            if pose is None:
                continue
            if driver is None:
                driver = SquareDriver(pose.x, pose.y, pose.theta, self._side, self._laps)
                _log_target(driver)
            visited = driver.visited
            self._publish(driver.step(pose.x, pose.y, pose.theta))
            if driver.visited != visited:
                rospy.loginfo('Corner reached at x=%.3f, y=%.3f', pose.x, pose.y)
                _log_target(driver)
        if driver and driver.finished:
            rospy.loginfo('Done: laps driven: %d', self._laps)

    def _store(self, pose: Pose) -> None:
        try:
            require_sane('pose', x=pose.x, y=pose.y, theta=pose.theta)
        except InvalidInput as refusal:
            self._throttle.warn('pose', 'Ignored a message on turtle1/pose: %s', refusal)
            return
        with self._news:
            self._pose = pose
            self._news.notify()

    def _next_pose(self, topic: str) -> Pose | None:
        """Return the next pose; None if there is none for a while or ROS shuts down."""
        with self._news:
            if not self._news.wait_for(lambda: self._pose or self._ended, timeout=POSE_TIMEOUT):
                rospy.logwarn('No pose on %s for %g s. Is the simulator running? rosrun turtlesim turtlesim_node',
                              topic, POSE_TIMEOUT)
            pose, self._pose = self._pose, None
            return None if self._ended else pose

    def _publish(self, command: Twist2D) -> None:
        with self._news:
            if not self._ended:
                self._publisher.publish(to_twist(command))

    def _end(self) -> None:
        """Stop the turtle once, so that others can take over, and wake the main thread."""
        with self._news:
            self._publish(STILL)
            self._ended = True
            self._news.notify()


def reset_simulator() -> None:
    """Call the simulator's service ``reset`` until it succeeds."""
    name, throttle = rospy.resolve_name('reset'), WallThrottle(WARNING_PERIOD)
    while not rospy.is_shutdown():
        try:
            rospy.wait_for_service('reset', timeout=RETRY_PERIOD)
            rospy.ServiceProxy('reset', Empty)()
            return
        except rospy.ROSInterruptException:
            raise
        except rospy.ServiceException as failure:
            throttle.warn('failed', '%s failed; calling it again: %s', name, failure)
            time.sleep(RETRY_PERIOD)
        except rospy.ROSException:
            if throttle.due('waiting'):
                rospy.loginfo('Waiting for the service %s. Start the simulator: rosrun turtlesim turtlesim_node', name)


def _log_target(driver: SquareDriver) -> None:
    if driver.corners_left:
        rospy.loginfo('Driving to the corner at x=%.3f, y=%.3f', *driver.target)


def main() -> None:
    nodes.init_node('draw_square', PARAMETERS)
    DrawSquareNode().run()
