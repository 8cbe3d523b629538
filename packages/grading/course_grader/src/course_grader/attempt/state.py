"""Reads what the checks of an exercise need: parameters, transforms, other vehicles, and the nodes of navigation.

Threads: callbacks only store; ``read`` is called in the main thread.
"""
import contextlib
import functools
import math
import xmlrpc.client

import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult
from tf2_msgs.msg import TFMessage

from course_grader.attempt.guard import of_the_grading, of_the_program
from course_grader.rules.observation import Destination, Sample, Transform
from course_grader.rules.rules_state import Follows, HasParameter, HasTransform, Spawns
from navigation_core.ros import grids
from navigation_core.ros.poses import of_transform
from rospy_support.rotations import yaw_of

MAP, ODOMETRY, ROBOT = 'map', 'odom', 'base_footprint'  # frames
MAX_AGE = 2.0  # [s] of the stamp of a transform when it arrives


class StateReader:
    """Collects what checks of parameters, transforms and other turtles need; costs nothing without them."""

    def __init__(self, exercise, observed, zero, link, dt):
        """``zero`` [s]: simulated time of the first step, ``dt`` [s]: a step.

        ``link``: the SimulatorLink, which knows the poses.
        """
        self._observed, self._zero, self._dt = observed, zero, dt
        rules = [scored.rule for scored in exercise.rules]
        self._names = {rule.name for rule in rules if isinstance(rule, HasParameter)}
        if any(isinstance(rule, HasTransform) for rule in rules):
            link.follow()
            rospy.Subscriber('/tf', TFMessage, self._on_transforms)
            rospy.Subscriber('/tf_static', TFMessage, lambda message: self._on_transforms(message, lasting=True))
        for turtle in {rule.turtle for rule in rules if isinstance(rule, (Spawns, Follows))}:
            link.watch(turtle, functools.partial(self._on_pose, observed.turtles.setdefault(turtle, [])))
        for robot, driven in list(observed.robots.items())[1:]:  # the recording has the path of the first one
            link.watch(robot, functools.partial(self._on_pose, driven.track))

    def read(self):
        """Record the values of the parameters; one that is not set keeps its last value."""
        master = rosgraph.Master(rospy.get_name())
        for name in self._names:
            with contextlib.suppress(OSError, rosgraph.MasterException, xmlrpc.client.Error, ValueError):  # too long
                self._observed.parameters[name] = master.getParam(name)

    def _on_pose(self, track, steps, pose):
        track.append(Sample((steps - 1) * self._dt, *pose))

    def _on_transforms(self, message, lasting=False):
        if not of_the_program(message):  # but the simulator's own
            return
        time = rospy.get_time()
        for one in message.transforms:
            at = one.transform.translation
            self._observed.transforms.append(
                Transform(time - self._zero, one.header.frame_id.lstrip('/'), one.child_frame_id.lstrip('/'),
                          at.x, at.y, yaw_of(one.transform.rotation),
                          lasting or abs(time - one.header.stamp.to_sec()) < MAX_AGE))


class NavigationReader:
    """Collects what checks of navigation need; costs nothing without them.

    Messages count if they come from a node of the grader's own; those of a program that runs such a node itself count
    if the grader does not run it.
    """

    def __init__(self, exercise, observed, zero, link):
        """``zero`` [s]: simulated time of the first step; ``link``: the SimulatorLink."""
        self._observed, self._zero = observed, zero
        self._transforms = {}  # {(parent, child): navigation_core.poses.Pose}
        self._places = {}  # {id of a goal: index in destinations}
        self._beside = exercise.beside
        checks = {scored.name for scored in exercise.rules}
        if self._beside or checks & {'maps', 'localises'}:
            link.follow()
        if 'maps' in checks:
            rospy.Subscriber('/map', grids.Grid, self._on_map, queue_size=1, buff_size=2 ** 24)
        if 'localises' in checks:
            for topic in ('/tf', '/tf_static'):
                rospy.Subscriber(topic, TFMessage, self._on_transforms)
        if 'move_base' in exercise.beside:
            rospy.Subscriber('/move_base/goal', MoveBaseActionGoal, self._on_goal)
            rospy.Subscriber('/move_base/result', MoveBaseActionResult, self._on_result)

    def read(self):
        """Record where the robot is believed to be."""
        base, odometry = (self._transforms.get(pair) for pair in ((MAP, ODOMETRY), (ODOMETRY, ROBOT)))
        if base is not None and odometry is not None:
            self._observed.believed.append(Sample(self._now(), *base.then(odometry)))

    def _now(self):
        return rospy.get_time() - self._zero

    def _counts(self, message, *nodes):
        """Return whether a message comes from a node that the grader runs; it may come from any if it runs none."""
        return of_the_grading(message) or not set(nodes) & set(self._beside)

    def _on_map(self, message):
        if self._counts(message, 'slam_gmapping', 'map_server'):
            try:
                self._observed.map = grids.from_message(message)
            except ValueError:
                self._observed.map = None

    def _on_transforms(self, message):
        for one in message.transforms:
            pair = one.header.frame_id.lstrip('/'), one.child_frame_id.lstrip('/')
            if pair == (ODOMETRY, ROBOT) and of_the_grading(message) or pair == (MAP, ODOMETRY) and self._counts(
                    message, 'amcl', 'slam_gmapping'):
                with contextlib.suppress(ValueError):
                    self._transforms[pair] = of_transform(one.transform)

    def _on_goal(self, message):
        target = message.goal.target_pose
        quaternion = target.pose.orientation
        length = math.hypot(math.hypot(quaternion.x, quaternion.y), math.hypot(quaternion.z, quaternion.w))
        self._places[message.goal_id.id] = len(self._observed.destinations)
        self._observed.destinations.append(Destination(
            self._now(), target.header.frame_id.lstrip('/'), target.pose.position.x, target.pose.position.y,
            yaw_of(quaternion) if 0.0 < length < math.inf else math.nan))

    def _on_result(self, message):
        index = self._places.get(message.status.goal_id.id)
        if index is not None and of_the_grading(message):
            self._observed.destinations[index] = self._observed.destinations[index]._replace(
                state=GoalStatus.to_string(message.status.status), text=message.status.text)
