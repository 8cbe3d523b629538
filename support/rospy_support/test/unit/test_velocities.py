"""rospy_support.velocities: each component of a velocity lands in the field of its name."""
from geometry_msgs.msg import Twist, Vector3

from kinematic_core.worlds.planar import Twist2D
from rospy_support.velocities import to_twist


def test_each_component_has_its_field():
    assert to_twist(Twist2D(linear_x=1.0, linear_y=-2.0, angular_z=3.0)) == \
        Twist(Vector3(1.0, -2.0, 0.0), Vector3(0.0, 0.0, 3.0))
