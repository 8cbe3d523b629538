#!/usr/bin/env python3
"""The course's robot node: prints the AR markers that the tracker sees, and drives a Robotont."""
import rospy

from kinematic_core.worlds.planar import Twist2D
from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Computed, Integer, Number, Table, Text
from turtle_robotont.driving.following import Follower
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.ar_control import Forward, MarkerDriver, MarkerListener

RATES = {'forward': 1.0, 'follow': 10.0}  # [Hz] the course's, and one that a robot follows smoothly
PARAMETERS = Table(
    Text('~mode', 'print', ('print', *RATES)), node_params.FRAME_AXES, node_params.log_rate(0.0),
    Number('~rate', Computed(', '.join(f'{mode} {rate}' for mode, rate in RATES.items())), 0.1, 100.0, 'Hz'),
    Number('~linear', 0.2, -1.0, 1.0, 'm/s'), Number('~lateral', 0.0, -1.0, 1.0, 'm/s'),
    Number('~angular', 0.0, -3.0, 3.0, 'rad/s'), Integer('~marker_id', 1, 0), node_params.following(distance=0.5))


def main():
    nodes.init_node('ar_control', PARAMETERS)
    mode, axes, log_rate = PARAMETERS.read('~mode', '~frame_axes', '~log_rate')
    if mode == 'print':
        parameters.log_effective()
        nodes.end_when_unread()
        MarkerListener(axes, log_rate)
    else:
        rate = PARAMETERS['~rate'].read(RATES[mode])
        behaviour = forward() if mode == 'forward' else follower()
        parameters.log_effective()
        MarkerListener(axes, log_rate, MarkerDriver(behaviour, rate).see)
    reachability.watch()
    rospy.spin()


def forward():
    linear, lateral, angular = PARAMETERS.read('~linear', '~lateral', '~angular')
    return Forward(Twist2D(linear_x=linear, linear_y=lateral, angular_z=angular))


def follower():
    return Follower(PARAMETERS['~marker_id'].read(), node_params.follow_settings(PARAMETERS))


if __name__ == '__main__':
    nodes.run(main)
