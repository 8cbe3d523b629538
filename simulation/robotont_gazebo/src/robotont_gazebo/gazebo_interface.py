"""Services and topics of Gazebo itself, in the namespace ``gazebo``: poses of models, reset, pause.

Threading contract: services are answered between two steps, in the thread that steps; messages on
``gazebo/set_model_state`` arrive in one of rospy's threads. The lock of the RecordedWorld guards the world.
"""
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
from std_srvs.srv import Empty, EmptyResponse

from kinematic_core.worlds.planar import Pose2D
from plain_support import InvalidInput
from robotont_gazebo.core import models
from rospy_support.rotations import to_quaternion, yaw_of
from rospy_support.topics import LatestPublisher


class GazeboInterface:
    """Services and topics of Gazebo on a RecordedWorld with a RobotWorld."""

    def __init__(self, clock, shared, put, reset):
        """Register everything.

        ``put(name, pose, request)`` moves a model, ``reset(request)`` moves all models back to their start; both are
        called with the lock held, and may raise InvalidInput.
        """
        self._shared, self._put, self._reset = shared, put, reset
        self._states = LatestPublisher('gazebo/model_states', ModelStates)
        services = clock.services
        services.add('gazebo/set_model_state', SetModelState, self._set_state)
        services.add('gazebo/get_model_state', GetModelState, self._get_state)
        services.add('gazebo/get_world_properties', GetWorldProperties, self._get_properties)
        for name in ('gazebo/reset_world', 'gazebo/reset_simulation'):
            services.add(name, Empty, self._reset_all)
        rospy.Service('gazebo/pause_physics', Empty, lambda _: self._done(clock.pause()))
        rospy.Service('gazebo/unpause_physics', Empty, lambda _: self._done(clock.resume()))
        rospy.Subscriber('gazebo/set_model_state', ModelState, self._set_by_message, queue_size=10)

    def publish(self):
        """Publish the states of all models; the caller must hold the lock."""
        if self._states.wanted():
            world = self._shared.world
            states = models.states(world)
            self._states.publish(ModelStates(models.names(world), *zip(*map(_pose_and_twist, states))))

    def _set_state(self, request):
        try:
            self._place(request.model_state, request)
        except InvalidInput as refusal:
            rospy.logwarn('Refused a service call: %s', refusal)
            return SetModelStateResponse(False, str(refusal))
        return SetModelStateResponse(True, '')

    def _set_by_message(self, message):
        try:
            self._place(message, message)
        except InvalidInput as refusal:
            rospy.logwarn('Ignored a message on %s: %s', rospy.resolve_name('gazebo/set_model_state'), refusal)

    def _place(self, wanted, request):
        orientation = wanted.pose.orientation
        yaw = yaw_of(orientation) if any((orientation.x, orientation.y, orientation.z, orientation.w)) else 0.0
        pose = Pose2D(wanted.pose.position.x, wanted.pose.position.y, yaw)
        with self._shared.lock:
            self._put(wanted.model_name, models.in_world(self._shared.world, pose, wanted.reference_frame), request)

    def _get_state(self, request):
        response = GetModelStateResponse()
        response.header.stamp, response.header.frame_id = rospy.Time.now(), request.relative_entity_name
        try:
            with self._shared.lock:
                found = models.state(self._shared.world, request.model_name, request.relative_entity_name)
        except InvalidInput as refusal:
            response.status_message = str(refusal)
            return response
        response.pose, response.twist = _pose_and_twist(found)
        response.success = True
        return response

    def _get_properties(self, _):
        with self._shared.lock:
            world = self._shared.world
            return GetWorldPropertiesResponse(world.time, models.names(world), True, True, '')

    def _reset_all(self, request):
        with self._shared.change():
            self._reset(request)
        return EmptyResponse()

    @staticmethod
    def _done(answer):
        if not answer.success:
            raise rospy.ServiceException(answer.message)
        return EmptyResponse()


def _pose_and_twist(state):
    """Return the Pose and the Twist of a models.State."""
    pose, twist = Pose(), Twist()
    pose.position.x, pose.position.y, pose.position.z = state.pose.x, state.pose.y, state.z
    pose.orientation = to_quaternion(0.0, 0.0, state.pose.yaw)
    twist.linear.x, twist.linear.y, twist.angular.z = state.twist
    return pose, twist
