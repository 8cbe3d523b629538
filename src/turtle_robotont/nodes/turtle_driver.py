"""Drive a turtle of turtlesim."""
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

from kinematic_core.worlds.turtle_world import DT
from rospy_support.topics import LatestPublisher, Publisher
from turtle_robotont.driving.vehicle import TURTLE
from turtle_robotont.msg import DriveStatus
from turtle_robotont.nodes.driver import Driver


class TurtleDriver(Driver):
    """Drives one turtle by ``<turtle>/pose`` and ``<turtle>/cmd_vel``; publishes ``<turtle>/drive_status``."""

    def __init__(self, turtle):
        self.turtle = turtle
        super().__init__(TURTLE, LatestPublisher(f'{turtle}/cmd_vel', Twist),
                         Publisher(f'{turtle}/drive_status', DriveStatus, queue_size=10), f'{turtle}/pose')
        self._subscriber = rospy.Subscriber(f'{turtle}/pose', Pose, self._on_pose, tcp_nodelay=True)

    def _on_pose(self, pose):
        self._take(pose, DT)  # the simulator publishes a pose in every tick

    def _no_pose(self, timeout):
        return (f'no pose on {self.pose_topic} for {timeout:g} s; is the simulator running, and does the turtle '
                f'{self.turtle} exist? (rostopic list)')
