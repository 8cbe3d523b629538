"""Reads the parameters, transforms, other turtles and other robots that the checks of an exercise need.

Threads: callbacks only append to a list.
"""
import contextlib
import functools
import xmlrpc.client

import rosgraph
import rospy
from tf2_msgs.msg import TFMessage

from course_grader.attempt.guard import of_the_program
from course_grader.rules.observation import Sample, Transform
from course_grader.rules.rules_state import Follows, HasParameter, HasTransform, Spawns
from rospy_support.rotations import yaw_of

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
