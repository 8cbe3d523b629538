"""Send the frame carrot1 beside turtle1: two metres to its left, or on a circle around it."""
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

from rospy_support import nodes
from rospy_support.parameters import Table
from turtle_follower.core.following import moving_carrot

PARAMETERS = Table()
RATE = 10.0  # [Hz]
FIXED = 0.0, 2.0  # [m] ahead of and to the left of turtle1


def send(place):
    """Send the frame at the rate until the shutdown; ``place``: a function of the time [s] that returns (x, y) [m]."""
    broadcaster, rate = tf2_ros.TransformBroadcaster(), rospy.Rate(RATE)
    message = TransformStamped(child_frame_id='carrot1')
    message.header.frame_id, message.transform.rotation.w = 'turtle1', 1.0
    while not rospy.is_shutdown():
        message.header.stamp = rospy.Time.now()
        place_now = place(message.header.stamp.to_sec())
        message.transform.translation.x, message.transform.translation.y = place_now
        broadcaster.sendTransform(message)
        rate.sleep()


def fixed(name='fixed_tf2_broadcaster'):
    """Run the node whose carrot stays beside turtle1."""
    nodes.init_node(name, PARAMETERS)
    send(lambda _: FIXED)


def moving(name='dynamic_tf2_broadcaster'):
    """Run the node whose carrot goes round turtle1."""
    nodes.init_node(name, PARAMETERS)
    send(moving_carrot)
