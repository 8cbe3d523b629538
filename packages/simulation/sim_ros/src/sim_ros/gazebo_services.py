"""The services and topics of Gazebo that each simulator has: poses of models, reset, pause.

Threading contract: services are answered between two steps, in the thread that steps; messages on ``set_model_state``
arrive in one of rospy's threads. The lock of the RecordedWorld guards the world.
"""
from __future__ import annotations

from typing import Any, Callable

import rospy
from gazebo_msgs.msg import ModelState, ModelStates
from gazebo_msgs.srv import (
    GetModelState,
    GetModelStateResponse,
    GetWorldProperties,
    GetWorldPropertiesResponse,
    SetModelState,
    SetModelStateResponse,
)
from geometry_msgs.msg import Pose, Twist
from std_srvs.srv import Empty, EmptyResponse, TriggerResponse

from kinematic_core.worlds.models import Models, State
from kinematic_core.worlds.planar import Pose2D
from plain_support import InvalidInput
from rospy_support.rotations import to_quaternion, yaw_of
from rospy_support.topics import LatestPublisher
from sim_ros.clock import SimulatorClock
from sim_ros.recording import RecordedWorld


class GazeboServices:
    """The services and topics on the world of a RecordedWorld."""

    def __init__(self, prefix: str, clock: SimulatorClock, shared: RecordedWorld, models: Models,
                 place: Callable[[str, Pose2D, str, Any], object], reset: Callable[[Any], object]) -> None:
        """Register everything, with names that begin with ``prefix``.

        ``models``: a kinematic_core.worlds.models.Models; ``place(name, pose, frame, request)`` moves one, or raises
        InvalidInput; ``reset(request)`` moves all back to their start.
        """
        self._prefix, self._shared, self._models, self._place_model = prefix, shared, models, place
        self._states = LatestPublisher(f'{prefix}model_states', ModelStates)

        def reset_all(request: Any) -> EmptyResponse:
            reset(request)
            return EmptyResponse()
        for name, kind, handler in (
                ('set_model_state', SetModelState, self._set_state),
                ('get_model_state', GetModelState, self._get_state),
                ('get_world_properties', GetWorldProperties, self._get_properties),
                ('reset_world', Empty, reset_all), ('reset_simulation', Empty, reset_all)):
            clock.services.add(prefix + name, kind, handler)
        for name, change in (('pause_physics', clock.pause), ('unpause_physics', clock.resume)):
            rospy.Service(prefix + name, Empty, clock.unless_owned(_without_answer(change)))
        rospy.Subscriber(f'{prefix}set_model_state', ModelState, self._set_by_message, queue_size=10)

    def publish(self) -> None:
        """Publish the states of all models; the caller must hold the lock."""
        if self._states.wanted():
            states = self._models.states()
            self._states.publish(ModelStates(self._models.names(), *zip(*map(pose_and_twist, states))))

    def _set_state(self, request: Any) -> SetModelStateResponse:
        try:
            self._place(request.model_state, request)
        except InvalidInput as refusal:
            rospy.logwarn('Refused a service call: %s', refusal)
            return SetModelStateResponse(False, str(refusal))
        return SetModelStateResponse(True, '')

    def _set_by_message(self, message: ModelState) -> None:
        try:
            self._place(message, message)
        except InvalidInput as refusal:
            rospy.logwarn('Ignored a message on %s: %s', rospy.resolve_name(f'{self._prefix}set_model_state'), refusal)

    def _place(self, state: ModelState, request: Any) -> None:
        self._place_model(state.model_name, flat(state.pose), state.reference_frame, request)

    def _get_state(self, request: Any) -> GetModelStateResponse:
        response = GetModelStateResponse()
        response.header.stamp, response.header.frame_id = rospy.Time.now(), request.relative_entity_name
        try:
            with self._shared.lock:
                found = self._models.state(request.model_name, request.relative_entity_name)
        except InvalidInput as refusal:
            response.status_message = str(refusal)
            return response
        response.pose, response.twist = pose_and_twist(found)
        response.success = True
        return response

    def _get_properties(self, _: Any) -> GetWorldPropertiesResponse:
        with self._shared.lock:
            return GetWorldPropertiesResponse(self._shared.world.time, self._models.names(), True, True, '')


def _without_answer(change: Callable[[], TriggerResponse]) -> Callable[[Any], EmptyResponse]:
    """Return the handler of an Empty service; it fails where ``change()`` answers that it did not succeed."""
    def handle(_: Any) -> EmptyResponse:
        answer = change()
        if not answer.success:
            raise rospy.ServiceException(answer.message)
        return EmptyResponse()
    return handle


def flat(pose: Pose) -> Pose2D:
    """Return the Pose2D of a Pose; an orientation that is not set is the heading 0."""
    orientation = pose.orientation
    yaw = yaw_of(orientation) if any((orientation.x, orientation.y, orientation.z, orientation.w)) else 0.0
    return Pose2D(pose.position.x, pose.position.y, yaw)


def pose_and_twist(state: State) -> tuple[Pose, Twist]:
    """Return the Pose and the Twist of a kinematic_core.worlds.models.State."""
    pose, twist = Pose(), Twist()
    pose.position.x, pose.position.y, pose.position.z = state.pose.x, state.pose.y, state.z
    pose.orientation = to_quaternion(0.0, 0.0, state.pose.yaw)
    twist.linear.x, twist.linear.y, twist.angular.z = state.twist
    return pose, twist
