#!/usr/bin/env python3
"""The course's maze: a Robotont visits AR markers one after the other, using only camera and tracker."""
import rospy

from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Number, Numbers, Table
from turtle_robotont.markers.tours import State, Tour
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.ar_control import MarkerDriver, MarkerListener
from turtle_robotont.nodes.driver import DriveError, run

PARAMETERS = Table(node_params.FRAME_AXES, node_params.log_rate(1.0), Numbers('~markers', [1, 2, 3, 4, 5]),
                   node_params.following(distance=1.0), Number('~search_speed', 1.0, -3.0, 3.0, 'rad/s'),
                   Number('~rate', 20.0, 2.0, 100.0, 'Hz'))


def main():
    nodes.init_node('ar_maze', PARAMETERS)
    axes, log_rate = PARAMETERS.read('~frame_axes', '~log_rate')
    markers = node_params.marker_ids(PARAMETERS['~markers'])
    settings = node_params.follow_settings(PARAMETERS)
    search_speed, rate = PARAMETERS.read('~search_speed', '~rate')
    parameters.log_effective()
    tour = Tour(markers, settings, search_speed)
    driver = MarkerDriver(tour, rate, lambda: tour.finished and rospy.signal_shutdown(tour.state.value))
    MarkerListener(axes, log_rate, driver.see)
    reachability.watch()
    rospy.spin()
    if tour.state is not State.DONE:
        raise DriveError(tour.status if tour.finished else f'ended while {tour.status}')


if __name__ == '__main__':
    run(main)
