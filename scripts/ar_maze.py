#!/usr/bin/env python3
"""The course's maze: a Robotont finds AR markers one after the other by camera and tracker alone, and ends."""
import rospy

from rospy_support import nodes, parameters, reachability
from turtle_robotont.markers.sightings import AXES
from turtle_robotont.markers.tours import State, Tour
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.ar_control import MarkerDriver, MarkerListener
from turtle_robotont.nodes.driver import DriveError, run


def main():
    nodes.init_node('ar_maze')
    axes = parameters.text('~frame_axes', 'auto', choices=AXES)
    log_rate = parameters.number('~log_rate', 1.0, minimum=0.0, maximum=1000.0, unit='Hz')
    markers = node_params.marker_ids('~markers', [1, 2, 3, 4, 5])
    settings = node_params.follow_settings(distance=1.0)
    search_speed = parameters.number('~search_speed', 1.0, minimum=-3.0, maximum=3.0, unit='rad/s')
    rate = parameters.number('~rate', 20.0, minimum=2.0, maximum=100.0, unit='Hz')
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
