#!/usr/bin/env python3
"""Lessons 8, 9 and 11: print the AR markers that a camera sees, and drive a Robotont forward or after a marker."""
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

from turtle_robotont.driving.following import Follower, Settings
from turtle_robotont.driving.shapes import InvalidInput
from turtle_robotont.driving.vehicle import Limits
from turtle_robotont.markers.sightings import AXES, sighting
from turtle_robotont.params import check_params, number, one_of, true_or_false, whole


class ArControl:

    def __init__(self, follower):
        self.follower = follower
        self.axes = rospy.get_param('~frame_axes', 'auto')
        self.log_rate = rospy.get_param('~log_rate', 0.0)   # messages printed per second, at most; 0: all
        self.printed = -math.inf                            # when the last message was printed [s]
        rospy.Subscriber('ar_pose_marker', AlvarMarkers, self.on_markers)
        rospy.loginfo('Subscribing to %s', rospy.resolve_name('ar_pose_marker'))
        rospy.Timer(rospy.Duration(5.0), self.warn, oneshot=True)   # calls warn once, after 5 s

    def on_markers(self, message):
        seen, lines = [], []
        for marker in message.markers:
            p = marker.pose.pose.position
            try:
                seen.append(sighting(marker.id, (p.x, p.y, p.z), marker.header.frame_id or message.header.frame_id,
                                     self.axes))
                lines.append(f'Detected marker with ID {marker.id} at x: {p.x:.3f} y: {p.y:.3f} z: {p.z:.3f} m, '
                             f'distance: {math.hypot(p.x, p.y, p.z):.3f} m')
            except InvalidInput as error:
                rospy.logwarn_throttle(10.0, f'{error}; ignored. Does the tracker know the transform to its frame?')
        self.follower.see(seen)
        now = rospy.get_time()
        if self.log_rate == 0.0 or now - self.printed >= 1.0 / self.log_rate:
            self.printed = now
            for line in lines or ['No AR markers detected.']:
                rospy.loginfo(line)

    def warn(self, event):
        if self.printed < 0.0:
            rospy.logwarn('No markers on %s for 5 s. To start camera and tracker, type: roslaunch turtle_robotont '
                          'camera_ar_track.launch', rospy.resolve_name('ar_pose_marker'))

    def drive(self, mode):
        """Publish velocities until the node ends."""
        self.publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        rospy.on_shutdown(lambda: self.publisher.publish(Twist()))   # all zeros: the robot stops
        if mode == 'forward':
            self.forward()
        else:
            self.follow()

    def forward(self):
        """Drive with a constant velocity."""
        velocity = Twist()
        velocity.linear.x = rospy.get_param('~linear', 0.2)
        velocity.linear.y = rospy.get_param('~lateral', 0.0)
        velocity.angular.z = rospy.get_param('~angular', 0.0)
        rate = rospy.Rate(rospy.get_param('~rate', 1.0))
        while not rospy.is_shutdown():
            self.publisher.publish(velocity)
            rospy.loginfo('Publish velocity command[%0.2f m/s, %0.2f rad/s]', velocity.linear.x, velocity.angular.z)
            rate.sleep()

    def follow(self):
        """Send the commands of the Follower, which keeps a distance from the marker."""
        rate = rospy.Rate(rospy.get_param('~rate', 10.0))
        before, status = rospy.get_time(), ''
        while not rospy.is_shutdown():
            now = rospy.get_time()
            command = self.follower.step(max(0.0, now - before))
            before = now
            if command is not None:   # None: the marker is lost, and other nodes may drive
                velocity = Twist()
                velocity.linear.x, velocity.linear.y, velocity.angular.z = command
                self.publisher.publish(velocity)
            if self.follower.status != status:
                status = self.follower.status
                rospy.loginfo(status[0].upper() + status[1:])
            rate.sleep()


def main():
    rospy.init_node('ar_control')
    check_params(mode=one_of('print', 'forward', 'follow'), frame_axes=one_of(*AXES),
                 marker_id=whole(0), log_rate=number(0.0, 1000.0, 'Hz'), rate=number(0.1, 100.0, 'Hz'),
                 linear=number(-1.0, 1.0, 'm/s'), lateral=number(-1.0, 1.0, 'm/s'), angular=number(-3.0, 3.0, 'rad/s'),
                 distance=number(0.1, 20.0, 'm'), strafe=true_or_false(), lost_after=number(0.1, 5.0, 's'),
                 speed=number(0.05, 10.0, 'm/s'), turn_speed=number(0.1, 10.0, 'rad/s'))
    mode = rospy.get_param('~mode', 'print')
    limits = Limits(rospy.get_param('~speed', 0.5), rospy.get_param('~turn_speed', 1.0))   # at most [m/s], [rad/s]
    settings = Settings(rospy.get_param('~distance', 0.5),      # to keep from the marker [m]
                        rospy.get_param('~strafe', False),      # True: move sideways instead of turning
                        rospy.get_param('~lost_after', 0.5),    # [s]
                        limits)
    node = ArControl(Follower(rospy.get_param('~marker_id', 1), settings))
    if mode != 'print':
        node.drive(mode)
    rospy.spin()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
