"""turtle3 drives round a circle and says where it is as points in the frame world.

Threading contract: poses arrive in rospy's threads; the main thread drives.
"""
import rospy
from geometry_msgs.msg import PointStamped, Twist
from turtlesim.msg import Pose

from kinematic_core.worlds.planar import Twist2D
from rospy_support import nodes
from rospy_support.parameters import Table
from rospy_support.topics import LatestPublisher
from rospy_support.velocities import to_twist
from turtle_follower.follower import START, spawn

PARAMETERS = Table()
TURTLE = 'turtle3'
RATE = 10.0  # [Hz] of the velocities
CIRCLE = Twist2D(linear_x=1.0, angular_z=1.0)


class PointPublisher:
    """Publishes each pose of the turtle as a point. rospy must be initialised."""

    def __init__(self, frame):
        """``frame``: that of the points."""
        self._frame = frame
        self._publisher = LatestPublisher('turtle_point_stamped', PointStamped)
        rospy.Subscriber(f'/{TURTLE}/pose', Pose, self._publish, tcp_nodelay=True)

    def _publish(self, pose):
        message = PointStamped()
        message.header.stamp, message.header.frame_id = rospy.Time.now(), self._frame
        message.point.x, message.point.y = pose.x, pose.y
        self._publisher.publish(message)


def main(name='turtle_tf2_msg_broadcaster', frame='world'):
    """Spawn turtle3, drive it, and publish its points in ``frame``."""
    nodes.init_node(name, PARAMETERS)
    spawn(TURTLE, START)
    PointPublisher(frame)
    publisher, rate = LatestPublisher(f'{TURTLE}/cmd_vel', Twist), rospy.Rate(RATE)
    rospy.on_shutdown(lambda: publisher.publish(Twist()))
    while not rospy.is_shutdown():
        publisher.publish(to_twist(CIRCLE))
        rate.sleep()
