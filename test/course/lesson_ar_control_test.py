#!/usr/bin/env python3
"""ar_control_node.py prints the markers that a tracker publishes, and drives the robot."""
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers

from lesson_case import LessonCase, rospy, run

FRAME = 'camera_optical_frame'


class LessonArControl(LessonCase):
    turtle = False

    def setUp(self):
        """Publish the message of a tracker."""
        super().setUp()
        if rospy.has_param('ar_control'):
            rospy.delete_param('ar_control')  # a node that was killed leaves its parameters
        self.publisher = rospy.Publisher('ar_pose_marker', AlvarMarkers, queue_size=10)
        self.addCleanup(self.publisher.unregister)

    def see(self, marker_id, x, y, z):
        """Publish a marker at a position [m] in the optical frame."""
        self.until(lambda: self.publisher.get_num_connections() > 0, 'a subscriber of /ar_pose_marker')
        marker = AlvarMarker(id=marker_id)
        marker.header.frame_id = FRAME
        position = marker.pose.pose.position
        position.x, position.y, position.z = x, y, z
        marker.pose.pose.orientation.w = 1.0
        message = AlvarMarkers(markers=[marker])
        message.header.frame_id = FRAME
        message.header.stamp = rospy.Time.now()
        self.publisher.publish(message)

    def test_prints_a_marker(self):
        """Its id, its position, and the distance: 3 m, of 1, 2 and 2 m."""
        program = self.start('ar_control_node.py')
        line = 'Detected marker with ID 7 at x: 1.000 y: -2.000 z: 2.000 m, distance: 3.000 m'

        def printed():
            self.see(7, 1.0, -2.0, 2.0)  # again and again: the connection may still be that of the node before
            return line in program.output()
        self.until(printed, lambda: f'{line!r} in {program.output()!r}')
        self.assertEqual([], self.commands)

    def test_drives_forward(self):
        """_mode:=forward publishes a constant velocity, and a stop at Ctrl-C."""
        program = self.start('ar_control_node.py', '_mode:=forward', '_linear:=0.3', '_rate:=10')
        self.until(lambda: len(self.commands) > 5, 'commands on /cmd_vel')
        self.assertEqual({(0.3, 0.0)}, {(twist.linear.x, twist.angular.z) for twist in self.commands[:5]})
        program.ctrl_c()
        self.until_ended(program)
        self.until(lambda: self.commands[-1].linear.x == 0.0, 'a stop')

    def test_follows_a_marker(self):
        """_mode:=follow drives towards a marker that is far ahead, and stops when it is not seen."""
        self.start('ar_control_node.py', '_mode:=follow', '_marker_id:=7', '_distance:=0.5')

        def drives():
            self.see(7, 0.0, 0.0, 2.0)
            return self.commands and self.commands[-1].linear.x > 0.05
        self.until(drives, 'a velocity towards the marker')
        self.until(lambda: self.commands[-1].linear.x == 0.0, 'a stop without a marker')


if __name__ == '__main__':
    run(LessonArControl)
