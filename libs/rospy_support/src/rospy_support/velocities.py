"""Velocities of the core as messages."""
from geometry_msgs.msg import Twist

from kinematic_core.worlds.planar import Twist2D


def to_twist(command: Twist2D) -> Twist:
    """Return the geometry_msgs/Twist of a velocity in the plane; what is not in the plane is 0."""
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = command.linear_x, command.linear_y, command.angular_z
    return message
