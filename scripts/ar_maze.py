#!/usr/bin/env python3
"""The course's maze: a Robotont finds AR markers one after the other by camera and tracker alone, and ends."""
import rospy

from kinematic_ros import nodes, params, reachability
from turtle_robotont import node_params
from turtle_robotont.ar_control import MarkerDriver, MarkerListener
from turtle_robotont.driver import DriveError, run
from turtle_robotont.sightings import AXES
from turtle_robotont.tour import State, Tour


def main():
    nodes.init_node('ar_maze')
    axes = params.text('~frame_axes', 'auto', choices=AXES)
    log_rate = params.number('~log_rate', 1.0, minimum=0.0, maximum=1000.0, unit='Hz')
    markers = node_params.marker_ids('~markers', [1, 2, 3, 4, 5])
    settings = node_params.follow_settings(distance=1.0)
    search_speed = params.number('~search_speed', 1.0, minimum=-3.0, maximum=3.0, unit='rad/s')
    rate = params.number('~rate', 20.0, minimum=2.0, maximum=100.0, unit='Hz')
    params.log_effective()
    tour = Tour(markers, settings, search_speed)
    driver = MarkerDriver(tour, rate, lambda: tour.finished and rospy.signal_shutdown(tour.state.value))
    MarkerListener(axes, log_rate, driver.see)
    reachability.watch()
    rospy.spin()
    if tour.state is not State.DONE:
        raise DriveError(tour.status if tour.finished else f'ended while {tour.status}')


if __name__ == '__main__':
    run(main)
