#!/usr/bin/env python3
"""Lesson 11: a Robotont finds its way through a maze, from AR marker to AR marker, using only camera and tracker."""
import sys

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

from turtle_robotont.driving.following import Settings
from turtle_robotont.driving.shapes import InvalidInput
from turtle_robotont.driving.vehicle import Limits
from turtle_robotont.markers.sightings import AXES, sighting
from turtle_robotont.markers.tours import State, Tour
from turtle_robotont.params import check_params, list_of, number, one_of, true_or_false, whole


class ArMaze:

    def __init__(self, tour):
        self.tour = tour
        self.axes = rospy.get_param('~frame_axes', 'auto')
        self.log_rate = rospy.get_param('~log_rate', 1.0)    # messages printed per second, at most; 0: all
        self.printed = 0.0                                   # when the last message was printed [s]
        self.publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        rospy.on_shutdown(lambda: self.publisher.publish(Twist()))   # all zeros: the robot stops
        rospy.Subscriber('ar_pose_marker', AlvarMarkers, self.on_markers)

    def on_markers(self, message):
        seen = []
        for marker in message.markers:
            p = marker.pose.pose.position
            try:
                seen.append(sighting(marker.id, (p.x, p.y, p.z), marker.header.frame_id or message.header.frame_id,
                                     self.axes))
            except InvalidInput as error:
                rospy.logwarn_throttle(10.0, f'{error}; ignored. Does the tracker know the transform to its frame?')
        self.tour.see(seen)
        if not self.log_rate or rospy.get_time() - self.printed >= 1.0 / self.log_rate:
            self.printed = rospy.get_time()
            for marker in seen:
                rospy.loginfo('Detected marker with ID %d, distance: %.3f m', marker.id, marker.distance)
            if not seen:
                rospy.loginfo('No AR markers detected.')

    def drive(self):
        """Visit the markers one after the other."""
        rate = rospy.Rate(rospy.get_param('~rate', 20.0))
        before, status = rospy.get_time(), ''
        while not self.tour.finished and not rospy.is_shutdown():
            rate.sleep()
            now = rospy.get_time()
            command = self.tour.step(min(max(0.0, now - before), 0.15))   # at most 0.15 s, even if the clock jumps
            before = now
            velocity = Twist()
            velocity.linear.x, velocity.linear.y, velocity.angular.z = command
            self.publisher.publish(velocity)
            if self.tour.status != status:
                status = self.tour.status
                rospy.loginfo(status[0].upper() + status[1:])


def main():
    rospy.init_node('ar_maze')
    check_params(markers=list_of(whole(0), '[1, 2]'), distance=number(0.1, 20.0, 'm'), strafe=true_or_false(),
                 lost_after=number(0.1, 5.0, 's'), speed=number(0.05, 10.0, 'm/s'),
                 turn_speed=number(0.1, 10.0, 'rad/s'), search_speed=number(-3.0, 3.0, 'rad/s'),
                 rate=number(2.0, 100.0, 'Hz'), frame_axes=one_of(*AXES), log_rate=number(0.0, 1000.0, 'Hz'))
    limits = Limits(rospy.get_param('~speed', 0.5), rospy.get_param('~turn_speed', 1.0))   # [m/s], [rad/s]
    settings = Settings(rospy.get_param('~distance', 1.0),      # at which a marker counts as reached [m]
                        rospy.get_param('~strafe', False),      # True: move sideways instead of turning
                        rospy.get_param('~lost_after', 0.5),    # [s]
                        limits)
    tour = Tour(rospy.get_param('~markers', [1, 2, 3, 4, 5]), settings, rospy.get_param('~search_speed', 1.0))
    ArMaze(tour).drive()
    if tour.state is not State.DONE:
        rospy.logfatal('%s', tour.status if tour.finished else f'ended while {tour.status}')
        sys.exit(1)


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
