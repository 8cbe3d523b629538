"""The topics and services of one turtle."""
from __future__ import annotations

from typing import Any

import rospy
from geometry_msgs.msg import Twist

from kinematic_core.worlds.turtle_world import Colour, Turtle, UnknownTurtle
from plain_support import InvalidInput
from rospy_support.rospy_internals import frame
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from sim_ros.frame_services import FrameServices
from turtlesim.msg import Color, Pose
from turtlesim.shared_world import SharedWorld
from turtlesim.srv import (
    SetPen,
    SetPenResponse,
    TeleportAbsolute,
    TeleportAbsoluteResponse,
    TeleportRelative,
    TeleportRelativeResponse,
)

WARNING_PERIOD = 1.0  # [s] between two warnings about refused velocities


class TurtleInterface:
    """Connects one turtle of a SharedWorld to ROS; the simulator's step publishes, rospy does the rest."""

    def __init__(self, name: str, shared: SharedWorld, services: FrameServices) -> None:
        """Register the topics and services of the turtle ``name``, in the same order as the original.

        ``shared`` is its SharedWorld, ``services`` the simulator's FrameServices.
        """
        self.name = name
        self._shared = shared
        self._published: Any = None
        self._pose_frame = b''
        self._refusals = WallThrottle(WARNING_PERIOD)
        self._registered: list[Any] = []
        try:
            self._keep(rospy.Subscriber(f'{name}/cmd_vel', Twist, self._command, queue_size=1, tcp_nodelay=True))
            self._pose = self._keep(LatestPublisher(f'{name}/pose', Pose))
            self._color = self._keep(LatestPublisher(f'{name}/color_sensor', Color))
            for service, kind, handler in (('set_pen', SetPen, self._set_pen),
                                           ('teleport_relative', TeleportRelative, self._teleport_relative),
                                           ('teleport_absolute', TeleportAbsolute, self._teleport_absolute)):
                self._keep(services.add(f'{name}/{service}', kind, handler))
        except Exception:
            self.shutdown()
            raise

    def _keep(self, registered: Any) -> Any:
        self._registered.append(registered)
        return registered

    def shutdown(self) -> None:
        """Unregister everything in reverse order, as the original does."""
        for registered in reversed(self._registered):
            if isinstance(registered, rospy.Service):
                registered.shutdown('the turtle is gone')
            else:
                registered.unregister()
        self._registered = []

    def publish(self, turtle: Turtle, colour: Colour) -> None:
        """Publish pose and colour (r, g, b) of the turtle after a step."""
        if self._pose.wanted():
            pose = turtle.pose()
            if pose != self._published:  # serialise the message of a standing turtle only once
                self._published, self._pose_frame = pose, frame(Pose(*pose))
            self._pose.publish_frame(self._pose_frame)
        if self._color.wanted():
            self._color.publish(*colour)

    def _command(self, twist: Twist) -> None:
        try:
            with self._shared.lock:
                velocity = twist.linear.x, twist.linear.y, twist.angular.z
                self._shared.world.command(self.name, *velocity)
                self._note(twist, 'cmd', *velocity)
        except UnknownTurtle:  # the turtle is being killed
            pass
        except InvalidInput as refusal:
            self._refusals.warn('velocity', 'Ignored a message on %s: %s', rospy.resolve_name(f'{self.name}/cmd_vel'),
                                refusal)

    def _note(self, request: Any, event: str, *values: Any) -> None:
        self._shared.note(event, *values, turtle=self.name, request=request)

    def _set_pen(self, request: Any) -> SetPenResponse:
        pen = request.r, request.g, request.b, request.width, request.off
        with self._shared.change() as world:
            world.set_pen(self.name, *pen)
            self._note(request, 'pen', *pen)
        return SetPenResponse()

    def _teleport_absolute(self, request: Any) -> TeleportAbsoluteResponse:
        with self._shared.change() as world:
            world.teleport_absolute(self.name, request.x, request.y, request.theta)
            self._note(request, 'teleport_absolute', request.x, request.y, request.theta)
        return TeleportAbsoluteResponse()

    def _teleport_relative(self, request: Any) -> TeleportRelativeResponse:
        with self._shared.change() as world:
            world.teleport_relative(self.name, request.linear, request.angular)
            self._note(request, 'teleport_relative', request.linear, request.angular)
        return TeleportRelativeResponse()
