"""Convert velocities of the core to messages."""
from geometry_msgs.msg import Twist

from kinematic_core.worlds.planar import Twist2D


def to_twist(command: Twist2D) -> Twist:
    """Return the geometry_msgs/Twist of a velocity in the plane; its other components are 0."""
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = command.linear_x, command.linear_y, command.angular_z
    return message
