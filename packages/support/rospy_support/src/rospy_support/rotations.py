"""Convert headings to quaternion messages and back, with tf.transformations.

plain_support.rotations does the same without ROS, for cores and for the tracker, which needs three conversions per
marker: between a matrix and a quaternion tf.transformations takes 7 us, that 3 to 5 us.
"""
from geometry_msgs.msg import Quaternion
from tf.transformations import euler_from_quaternion, quaternion_from_euler


def to_quaternion(*angles: float, axes: str = 'sxyz') -> Quaternion:
    """Return the Quaternion of three angles [rad]; ``axes`` as in tf.transformations; sxyz: roll, pitch, yaw."""
    return Quaternion(*quaternion_from_euler(*angles, axes=axes))


def yaw_of(quaternion: Quaternion) -> float:
    """Return the heading [rad], -pi to pi, of a Quaternion of any length above 0."""
    return float(euler_from_quaternion((quaternion.x, quaternion.y, quaternion.z, quaternion.w))[2])
