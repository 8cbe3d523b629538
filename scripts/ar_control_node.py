#!/usr/bin/env python3
"""Lessons 8, 9 and 11: print the AR markers that a camera sees, and drive a Robotont forward or after a marker."""
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

from turtle_robotont.params import check_params, number, one_of, true_or_false, whole

GAIN, TURN_GAIN = 1.2, 1.5   # speed for each metre, turn speed for each radian that is left [1/s]
FARTHEST = 100.0             # no camera sees a marker from here [m]


def limited(value, limit):
    return max(-limit, min(limit, value))


class ArControl:

    def __init__(self):
        self.marker_id = rospy.get_param('~marker_id', 1)
        self.frame_axes = rospy.get_param('~frame_axes', 'auto')
        self.log_rate = rospy.get_param('~log_rate', 0.0)   # messages printed per second, at most; 0: all
        self.ahead = self.left = 0.0                        # where the marker was seen [m]
        self.seen = self.printed = -math.inf                # and when [s]; when the last message was printed [s]
        self.status = ''
        rospy.Subscriber('ar_pose_marker', AlvarMarkers, self.on_markers)
        rospy.loginfo('Subscribing to %s', rospy.resolve_name('ar_pose_marker'))
        rospy.Timer(rospy.Duration(5.0), self.warn, oneshot=True)   # calls warn once, after 5 s

    def on_markers(self, message):
        now, lines = rospy.get_time(), []
        for marker in message.markers:
            p = marker.pose.pose.position
            distance = math.hypot(p.x, p.y, p.z)
            if not distance < FARTHEST:   # also true if it is NaN, not a number
                rospy.logwarn_throttle(10.0, f'Marker {marker.id} at x {p.x:g} y {p.y:g} z {p.z:g} m is ignored.')
                continue
            lines.append(f'Detected marker with ID {marker.id} at x: {p.x:.3f} y: {p.y:.3f} z: {p.z:.3f} m, '
                         f'distance: {distance:.3f} m')
            if marker.id == self.marker_id:
                frame = marker.header.frame_id or message.header.frame_id
                if self.frame_axes == 'optical' or self.frame_axes == 'auto' and 'optical' in frame:
                    self.ahead, self.left = p.z, -p.x    # x points to the right, y down, z ahead
                else:
                    self.ahead, self.left = p.x, p.y     # x points ahead, y to the left, z up
                self.seen = now
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
        """Keep a distance from the marker; stop once when it is lost, so that other nodes can drive then."""
        wanted = rospy.get_param('~distance', 0.5)          # [m]
        strafe = rospy.get_param('~strafe', False)          # True: move sideways instead of turning
        lost_after = rospy.get_param('~lost_after', 0.5)    # [s]
        speed = rospy.get_param('~speed', 0.5)              # at most [m/s]
        turn_speed = rospy.get_param('~turn_speed', 1.0)    # at most [rad/s]
        rate = rospy.Rate(rospy.get_param('~rate', 10.0))
        self.say(f'Waiting for marker {self.marker_id}')
        while not rospy.is_shutdown():
            velocity = Twist()
            if rospy.get_time() - self.seen < lost_after:
                self.say(f'Following marker {self.marker_id} at {wanted:g} m')
                bearing = math.atan2(self.left, self.ahead)
                if strafe:
                    velocity.linear.x = limited(GAIN * (self.ahead - wanted), speed)
                    velocity.linear.y = limited(GAIN * self.left, speed)
                else:
                    velocity.angular.z = limited(TURN_GAIN * bearing, turn_speed)
                    if abs(bearing) < 0.6:   # it faces the marker: drive
                        velocity.linear.x = limited(GAIN * (math.hypot(self.ahead, self.left) - wanted), speed)
                self.publisher.publish(velocity)
            elif self.status.startswith('Following'):
                self.say(f'Marker {self.marker_id} lost for {lost_after:g} s: stopped')
                self.publisher.publish(velocity)
            rate.sleep()

    def say(self, status):
        if status != self.status:
            rospy.loginfo(status)
        self.status = status


def main():
    rospy.init_node('ar_control')
    check_params(mode=one_of('print', 'forward', 'follow'), frame_axes=one_of('auto', 'body', 'optical'),
                 marker_id=whole(0), log_rate=number(0.0, 1000.0, 'Hz'), rate=number(0.1, 100.0, 'Hz'),
                 linear=number(-1.0, 1.0, 'm/s'), lateral=number(-1.0, 1.0, 'm/s'), angular=number(-3.0, 3.0, 'rad/s'),
                 distance=number(0.1, 20.0, 'm'), strafe=true_or_false(), lost_after=number(0.1, 5.0, 's'),
                 speed=number(0.05, 10.0, 'm/s'), turn_speed=number(0.1, 10.0, 'rad/s'))
    mode = rospy.get_param('~mode', 'print')
    node = ArControl()
    if mode != 'print':
        node.drive(mode)
    rospy.spin()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
