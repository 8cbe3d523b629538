#!/usr/bin/env python3
"""The course's robot node: prints the AR markers that the tracker sees, and drives a Robotont."""
import rospy

from kinematic_core.worlds.planar import Twist2D
from rospy_support import nodes, parameters, reachability
from turtle_robotont.driving.following import Follower
from turtle_robotont.markers.sightings import AXES
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.ar_control import Forward, MarkerDriver, MarkerListener

RATES = {'forward': 1.0, 'follow': 10.0}  # [Hz] the course's, and one that a robot follows smoothly


def main():
    nodes.init_node('ar_control')
    mode = parameters.text('~mode', 'print', choices=('print', 'forward', 'follow'))
    axes = parameters.text('~frame_axes', 'auto', choices=AXES)
    log_rate = parameters.number('~log_rate', 0.0, minimum=0.0, maximum=1000.0, unit='Hz')
    if mode == 'print':
        parameters.log_effective()
        nodes.end_when_unread()
        MarkerListener(axes, log_rate)
    else:
        rate = parameters.number('~rate', RATES[mode], minimum=0.1, maximum=100.0, unit='Hz')
        behaviour = forward() if mode == 'forward' else follower()
        parameters.log_effective()
        MarkerListener(axes, log_rate, MarkerDriver(behaviour, rate).see)
    reachability.watch()
    rospy.spin()


def forward():
    return Forward(Twist2D(linear_x=parameters.number('~linear', 0.2, minimum=-1.0, maximum=1.0, unit='m/s'),
                           linear_y=parameters.number('~lateral', 0.0, minimum=-1.0, maximum=1.0, unit='m/s'),
                           angular_z=parameters.number('~angular', 0.0, minimum=-3.0, maximum=3.0, unit='rad/s')))


def follower():
    marker_id = parameters.integer('~marker_id', 1, minimum=0)
    return Follower(marker_id, node_params.follow_settings(distance=0.5))


if __name__ == '__main__':
    nodes.run(main)
