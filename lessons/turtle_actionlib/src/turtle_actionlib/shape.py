"""turtle_shape: the action that draws a regular polygon with turtle1, and a client of it.

Threading contract: poses arrive in rospy's threads and are stored; a goal is executed in the thread of its
SimpleActionServer, which takes the newest pose and publishes.
"""
import threading
import time

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

from kinematic_core.validation import InvalidInput, require_sane
from kinematic_core.worlds.planar import STILL, Pose2D
from rospy_support import actions, nodes
from rospy_support.parameters import Table
from rospy_support.topics import LatestPublisher
from rospy_support.velocities import to_twist
from turtle_actionlib.core.polygon_drive import Polygon, PolygonDrive
from turtle_actionlib.msg import ShapeAction, ShapeGoal, ShapeResult

PARAMETERS = Table()
ACTION = 'turtle_shape'
POSES, VELOCITIES = '/turtle1/pose', '/turtle1/cmd_vel'
LONGEST_SILENCE = 3.0  # [s of wall time] without a pose; then the simulator has gone
POLL = 0.05  # [s] between two looks for a cancelled goal
LONGEST_STAND = 3.0  # [s of ROS time] without getting on; then it drives against a wall
LEAST_MOTION = 1e-6  # [m or rad] between two poses; one that gets on moves by more, until it is within the tolerance
EDGES, RADIUS, PATIENCE = 5, 1.3, 40.0  # of the client's goal; [m], [s]


class ShapeServer:
    """Executes goals. rospy must be initialised."""

    def __init__(self):
        self._pose, self._news = None, threading.Condition()
        self._publisher = LatestPublisher(VELOCITIES, Twist)
        self._driving = False
        rospy.Subscriber(POSES, Pose, self._take, queue_size=1, tcp_nodelay=True)
        rospy.on_shutdown(self._stop)
        actions.serve(ShapeAction, self._execute)

    def _take(self, pose):
        with self._news:
            self._pose = pose
            self._news.notify()

    def _execute(self, goal, server):
        try:
            polygon = Polygon(goal.edges, goal.radius)
        except ValueError as error:
            raise actions.Refused(str(error)) from None
        drive, progress = PolygonDrive(polygon), Progress()
        try:
            while True:
                pose = self._next(server)
                velocity = drive.step(pose)
                if velocity is None:
                    return ShapeResult(polygon.interior_angle, polygon.apothem)
                if not progress.made(pose, rospy.get_time()):
                    raise actions.Refused(f'the turtle does not get on at x = {pose.x:.2f}, y = {pose.y:.2f}: is there '
                                          'a wall? Start farther from it, or with a smaller radius')
                self._driving = True
                self._publisher.publish(to_twist(velocity))
        finally:
            self._stop()

    def _next(self, server):
        """Return the next pose."""
        begin = time.monotonic()
        with self._news:
            self._pose = None
            while self._pose is None:
                actions.check(server)
                if time.monotonic() - begin > LONGEST_SILENCE:
                    raise actions.Refused(f'no pose on {POSES} for {LONGEST_SILENCE:g} s: is the simulator running? '
                                          'rosrun turtlesim turtlesim_node')
                self._news.wait(POLL)
            pose = self._pose
        try:
            require_sane('pose', x=pose.x, y=pose.y, theta=pose.theta)
        except InvalidInput as error:
            raise actions.Refused(f'a message on {POSES} is invalid: {error}') from None
        return Pose2D(pose.x, pose.y, pose.theta)

    def _stop(self):
        """Stop the turtle if this node has moved it."""
        if self._driving:
            self._driving = False
            self._publisher.publish(to_twist(STILL))


class Progress:
    """Notices that the turtle no longer gets on."""

    def __init__(self):
        self._pose, self._since = None, 0.0

    def made(self, pose, now):
        """Return whether the turtle has moved within LONGEST_STAND; ``now`` [s]."""
        last = self._pose
        if last is None or now < self._since or max(abs(a - b) for a, b in zip(pose, last)) > LEAST_MOTION:
            self._pose, self._since = pose, now
        return now - self._since <= LONGEST_STAND


def main():
    """Run the server."""
    nodes.init_node(ACTION, PARAMETERS)
    ShapeServer()
    rospy.spin()


def client():
    """Let the turtle draw a pentagon."""
    nodes.init_node('test_shape', PARAMETERS)
    actions.report(actions.run_goal(ACTION, ShapeAction, ShapeGoal(EDGES, RADIUS), PATIENCE))
