#!/usr/bin/env python3
"""ar_control_node.py prints the markers that a tracker publishes, and drives the robot."""
import math
import time

from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers

from lesson_case import LessonCase, rospy, run

FRAME = 'camera_optical_frame'  # x to the right, y down, z ahead
NONE = 'No AR markers detected.'
PERIOD = 0.1  # [s] between two messages of the tracker
QUIET = 8  # [messages] for which nothing may be sent any more


class LessonArControl(LessonCase):
    turtle = False

    def setUp(self):
        """Publish the messages of a tracker."""
        super().setUp()
        if rospy.has_param('ar_control'):
            rospy.delete_param('ar_control')  # a node that was killed leaves its parameters
        self.publisher = rospy.Publisher('ar_pose_marker', AlvarMarkers, queue_size=10)
        self.addCleanup(self.publisher.unregister)

    def see(self, *markers):
        """Publish markers (id, x, y, z) [m] in the optical frame."""
        self.until(lambda: self.publisher.get_num_connections() > 0, 'a subscriber of /ar_pose_marker')
        message = AlvarMarkers()
        message.header.frame_id, message.header.stamp = FRAME, rospy.Time.now()
        for marker_id, x, y, z in markers:
            marker = AlvarMarker(id=marker_id, header=message.header)
            position = marker.pose.pose.position
            position.x, position.y, position.z = x, y, z
            marker.pose.pose.orientation.w = 1.0
            message.markers.append(marker)
        self.publisher.publish(message)
        time.sleep(PERIOD)

    def until_commanded(self, fits, *markers):
        """Publish markers until the newest command fits."""
        def commanded():
            self.see(*markers)
            return self.commands and fits(self.commands[-1])
        self.until(commanded, lambda: f'another command than {self.commands[-1:]}')

    def test_prints_markers(self):
        """A line for each marker, with the distance 3 m of (1, -2, 2) m; impossible positions are ignored."""
        program = self.start('ar_control_node.py')
        lines = ['Detected marker with ID 7 at x: 1.000 y: -2.000 z: 2.000 m, distance: 3.000 m',
                 'Detected marker with ID 300 at x: 0.250 y: -0.500 z: 0.000 m, distance: 0.559 m', NONE]

        def printed():  # again and again: the connection may still be that of the node before
            self.see((7, 1.0, -2.0, 2.0), (300, 0.25, -0.5, 0.0), (1, math.nan, 0.0, 0.0), (2, 1e253, 0.0, 0.0))
            self.see()
            return all(program.output().count(line) > 3 for line in lines)
        self.until(printed, lambda: f'{lines!r} in {program.output()!r}')
        self.assertEqual(1, program.output().count('[WARN]'), program.output())
        self.assertIn('marker 1 at x nan, y 0, z 0 m', program.output())
        self.assertNotIn('ID 1 ', program.output())
        self.assertEqual([], self.commands)

    def test_drives_forward(self):
        """_mode:=forward publishes a constant velocity, and a stop at Ctrl-C; without a tracker there is a warning."""
        program = self.start('ar_control_node.py', '_mode:=forward', '_linear:=0.3', '_lateral:=0.1', '_rate:=10')
        self.until(lambda: len(self.commands) > 5, 'commands on /cmd_vel')
        self.assertEqual({(0.3, 0.1, 0.0)},
                         {(twist.linear.x, twist.linear.y, twist.angular.z) for twist in self.commands[:5]})
        self.until_printed(program, 'Publish velocity command[0.30 m/s, 0.00 rad/s]')
        self.until_printed(program, 'No markers on /ar_pose_marker for 5 s. To start camera and tracker, type: ')
        program.ctrl_c()
        self.until_ended(program)
        self.until(lambda: self.commands[-1].linear.x == 0.0, 'a stop')

    def test_follows_a_marker(self):
        """_mode:=follow drives towards a marker, stops once when it is not seen, and follows it again then."""
        program = self.start('ar_control_node.py', '_mode:=follow', '_marker_id:=7', '_log_rate:=0.01')
        self.see((1, 0.0, 0.0, 1.0))
        self.until_printed(program, 'Waiting for marker 7')
        self.assertEqual([], self.commands)
        self.until_commanded(lambda twist: twist.linear.x > 0.3, (7, 0.0, 0.0, 2.0), (1, 0.5, 0.0, 0.5))
        self.until_commanded(lambda twist: twist.linear.x == 0.0, (1, 0.5, 0.0, 0.5))
        sent = len(self.commands)
        for _ in range(QUIET):
            self.see((1, 0.5, 0.0, 0.5))
        self.assertEqual(sent, len(self.commands), 'other nodes may drive now')
        self.until_printed(program, 'Marker 7 lost for 0.5 s (not in view): stopped')
        self.until_commanded(lambda twist: twist.angular.z > 0.1 and twist.linear.x == 0.0, (7, -1.0, 0.0, 0.1))
        self.assertEqual(1, program.output().count('Detected marker') + program.output().count(NONE), '_log_rate')

    def test_a_slow_loop_follows(self):
        """One command a second, which is longer than _lost_after."""
        self.start('ar_control_node.py', '_mode:=follow', '_marker_id:=7', '_rate:=1', '_lost_after:=0.3',
                   '_strafe:=true')
        self.until_commanded(lambda twist: twist.linear.x > 0.3 and twist.linear.y > 0.05, (7, -0.2, 0.0, 2.0))
        self.until(lambda: self.commands[-1].linear.x == 0.0, 'a stop without a marker')


if __name__ == '__main__':
    run(LessonArControl)
