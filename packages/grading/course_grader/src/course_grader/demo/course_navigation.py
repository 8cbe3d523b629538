"""The step of the demo that makes a map and drives to goals on it, as steps 25 to 28 do by the page.

Threads: rospy calls the recorders' callbacks in its own threads; they only append.
"""
import math

import actionlib
import cv2
import numpy as np
import rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry
from std_msgs.msg import String

from course_grader.demo.course import Measurement, at_most
from course_grader.demo.course_markers import START_TIMEOUT, map_of, world_plan
from course_grader.demo.harness import DemoError, Recorder
from kinematic_core.worlds.floor_plan import corners
from kinematic_core.worlds.frames import LIDAR_Z
from navigation_core.maps import scores
from navigation_core.ros import grids
from rospy_support.rotations import to_quaternion
from turtle_robotont.driver import pose_of

RATE = 3.0  # simulated seconds per wall-clock second
GOALS = (-2.0, 2.0, 0.0), (0.0, 2.0, -math.pi / 2.0)  # x, y [m], heading [rad]
GOAL_TIMEOUT = 150.0  # [s] of wall time for one of them, also on a loaded machine
REACHED = 0.2  # [m] from a goal; move_base's tolerance is 0.1, and the map is not exact either
RIGHT = 0.9  # share of the occupied cells that lie at a true wall, while the map is being made
PIXELS = 4  # for each cell of the map in its picture


def map_and_goals(harness):
    simulator = harness.start('roslaunch', 'robotont_gazebo', 'world_minimaze.launch', 'model:=robotont_gazebo_lidar',
                              f'rate:={RATE:g}')
    world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
    poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
    maps = Recorder('map', OccupancyGrid, lambda message: message)
    try:
        harness.until(lambda: world.entries and poses.entries, 'the robotont_gazebo of this repository does not start',
                      START_TIMEOUT, simulator)
        harness.start('roslaunch', 'robotont_demos', 'gmapping.launch')
        driving = harness.start('roslaunch', 'robotont_navigation', 'move_base.launch')
        client = actionlib.ActionClient('move_base', MoveBaseAction)
        harness.until(lambda: 'odom received!' in driving.output(), 'move_base is not ready', START_TIMEOUT, driving)
        if not client.wait_for_server(rospy.Duration(START_TIMEOUT)):
            raise DemoError('there is no action move_base')
        measured = [_driven(harness, client, goal, poses) for goal in GOALS]
    finally:
        for recorder in (world, poses, maps):
            recorder.end()
        harness.end_nodes()
        rospy.set_param('use_sim_time', False)
    plan, track, grid = world_plan(world.entries[-1]), list(poses.entries), grids.from_message(maps.entries[-1])
    harness.keep(map_of(plan, track, 'Goals'))
    harness.keep(_picture(grid))
    walls = [corners(box) for box in plan.boxes if box.height > LIDAR_Z]
    right = scores.scores(grid, walls, (track[0].x, track[0].y)).right
    return [*measured, Measurement(f'a map of {grid.width} x {grid.height} cells, of whose walls {right:.0%} are true '
                                   f'(expected {RIGHT:.0%})', right >= RIGHT)]


def _driven(harness, client, goal, poses):
    """Send a goal and wait until move_base has reached it; return the Measurement of the distance."""
    target = MoveBaseGoal()
    target.target_pose.header.frame_id = 'map'
    # gmapping's map begins as the odometry's frame, which is the world's here
    target.target_pose.pose.position.x, target.target_pose.pose.position.y = goal[:2]
    target.target_pose.pose.orientation = to_quaternion(0.0, 0.0, goal[2])
    handle = client.send_goal(target)
    harness.until(lambda: handle.get_comm_state() == actionlib.CommState.DONE, 'move_base does not reach its goal',
                  GOAL_TIMEOUT)
    last = poses.entries[-1]
    return at_most(f'goal ({goal[0]:g}, {goal[1]:g}): {handle.get_goal_status_text()} Its distance is',
                   math.hypot(last.x - goal[0], last.y - goal[1]), REACHED, 'm')


def _picture(grid):
    """Return the seen part of a map, (height, width, 3) uint8 BGR: free cells white, walls black, unknown ones grey."""
    rows, columns = np.nonzero(grid.cells >= 0)
    cells = grid.cells[rows.min():rows.max() + 1, columns.min():columns.max() + 1][::-1]
    grey = np.where(cells < 0, 205, np.where(cells > 50, 0, 254)).astype(np.uint8)
    return cv2.cvtColor(cv2.resize(grey, None, fx=PIXELS, fy=PIXELS, interpolation=cv2.INTER_NEAREST),
                        cv2.COLOR_GRAY2BGR)


PLAYS = (map_and_goals,)
