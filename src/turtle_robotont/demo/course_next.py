"""The steps of the demo that belong to docs/course_next.md: parameters, tf, actions, bags, and a robot that measures.

Threads: rospy calls the recorders' callbacks in its own threads; they only append, or publish a velocity.
"""
import math
import os
import time

import actionlib
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from robotont_laserscan_to_distance.msg import LaserScanSplit
from std_msgs.msg import String
from turtle_actionlib.msg import ShapeAction, ShapeGoal
from turtlesim.msg import Pose

from turtle_robotont.demo.course import Measurement, Step, at_most, near
from turtle_robotont.demo.course_markers import START_TIMEOUT, Recorder, map_of, world_plan
from turtle_robotont.demo.harness import STEP_TIMEOUT, DemoError
from turtle_robotont.driving import track_metrics
from turtle_robotont.nodes.robot_driver import pose_of

BACKGROUND = (40, 90, 60)
BEHIND = 0.3  # [m] that turtle2 stays behind turtle1: it comes nearer and nearer
EDGES, RADIUS = 3, 0.7  # of the polygon; [m]
CLOSED = 0.1  # [m] between start and end of the polygon
DRIVE = (1.0, 0.8, 2.0)  # [m/s, rad/s, s] that is recorded
REPLAYED = 0.15  # [m] that a path which is played back ends elsewhere: commands come a tick earlier or later
RATE = 10.0  # [Hz] of velocities
GOAL, GAIN, FLAT = 0.5, 0.8, 0.03  # [m] from the box, [1/s], [m] from the goal that counts as there
ROBOT_RATE = 2.0  # simulated seconds per wall-clock second


def parameters(harness):
    for name, value in zip(('r', 'g', 'b'), BACKGROUND):
        _typed(harness, 'rosparam', 'set', f'/turtlesim/background_{name}', str(value))
    _typed(harness, 'rosservice', 'call', '/clear')
    harness.until(lambda: harness.seen.colours[-1:] == [BACKGROUND], 'the background keeps its colour', STEP_TIMEOUT)
    return [Measurement(f'the background has the colour {BACKGROUND}', True)]


def follower(harness):
    poses = Recorder('turtle2/pose', Pose, lambda pose: pose)
    try:
        for turtle in ('turtle1', 'turtle2'):
            harness.start('rosrun', 'turtle_tf2', 'turtle_tf2_broadcaster.py', f'__name:={turtle}_broadcaster',
                          f'_turtle:={turtle}')
        node = harness.start('rosrun', 'turtle_tf2', 'turtle_tf2_listener.py')
        harness.until(lambda: poses.entries, 'there is no turtle2', STEP_TIMEOUT, node)
        harness.until(lambda: _apart(harness, poses) < BEHIND, 'turtle2 does not come to turtle1', STEP_TIMEOUT, node)
        return [at_most('turtle2 came to turtle1, as near as', _apart(harness, poses), BEHIND, 'm'),
                Measurement(f'it drove {track_metrics.path_length(poses.entries):.2f} m',
                            not track_metrics.jumps(poses.entries))]
    finally:
        poses.end()


def _apart(harness, poses):
    leader, other = harness.seen.track[-1], poses.entries[-1]
    return math.hypot(leader.x - other.x, leader.y - other.y)


def shape_action(harness):
    harness.start('rosrun', 'turtle_actionlib', 'shape_server')
    client = actionlib.SimpleActionClient('turtle_shape', ShapeAction)
    if not client.wait_for_server(rospy.Duration(STEP_TIMEOUT)):
        raise DemoError('there is no action turtle_shape')
    client.send_goal_and_wait(ShapeGoal(EDGES, RADIUS), rospy.Duration(STEP_TIMEOUT))
    harness.until_rest()
    state, result = actionlib.GoalStatus.to_string(client.get_state()), client.get_result()
    return [Measurement(f'the goal has {state}', state == 'SUCCEEDED'),
            near('interior angle', result.interior_angle if result else math.nan, math.pi / 3.0, 1e-3, 'rad'),
            at_most('gap at the end', track_metrics.closing_error(harness.seen.track), CLOSED, 'm')]


def record_and_play(harness):
    path = os.path.join(harness.output, 'drive.bag')
    recorder = harness.start('rosbag', 'record', '-O', path, '/turtle1/cmd_vel')
    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
    harness.until(lambda: publisher.get_num_connections() > 2, 'rosbag does not record', STEP_TIMEOUT, recorder)
    linear, angular, seconds = DRIVE
    twist, end = Twist(), time.monotonic() + seconds
    twist.linear.x, twist.angular.z = linear, angular
    while time.monotonic() < end:
        publisher.publish(twist)
        time.sleep(1.0 / RATE)
    publisher.publish(Twist())
    publisher.unregister()
    harness.until_rest()
    recorder.interrupt()
    recorder.wait(STEP_TIMEOUT)
    driven = harness.seen.track
    harness.reset()
    player = harness.start('rosbag', 'play', path)
    if player.wait(STEP_TIMEOUT) != 0:
        raise DemoError(f'rosbag play failed: {player.last_line()}')
    harness.until_rest()
    again = harness.seen.track
    return [Measurement(f'recorded a drive of {track_metrics.path_length(driven):.2f} m',
                        track_metrics.path_length(driven) > linear),
            at_most('the drive that was played back ends farther off by',
                    math.hypot(again[-1].x - driven[-1].x, again[-1].y - driven[-1].y), REPLAYED, 'm')]


def p_controller(harness):
    plan, track = run_p_controller(harness)
    harness.keep(map_of(plan, track, 'P controller'))
    speeds = [math.hypot(after.x - before.x, after.y - before.y) for before, after in zip(track, track[1:])]
    from robotont_gazebo.core.frames import CAMERA_X  # there is a plan, so this is our robotont_gazebo
    distance = plan.boxes[0].x - plan.boxes[0].length / 2.0 - track[-1].x - CAMERA_X
    return [Measurement(f'drove {track_metrics.path_length(track):.2f} m, slower and slower',
                        speeds.index(max(speeds)) < len(speeds) / 2),
            near('distance from the camera to the box', distance, GOAL, FLAT, 'm')]


def run_p_controller(harness):
    """Drive to the box of the world bangbang; return (FloorPlan, true poses)."""
    simulator = harness.start('roslaunch', 'robotont_gazebo', 'world_bangbang.launch', f'rate:={ROBOT_RATE:g}')
    harness.start('roslaunch', 'robotont_laserscan_to_distance', 'distance_from_depth_image.launch')
    world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
    poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
    publisher, errors = rospy.Publisher('cmd_vel', Twist, queue_size=1), []

    def control(distances):
        error = distances.center_min - GOAL
        if math.isfinite(error):
            errors.append(error)
            twist = Twist()
            twist.linear.x = GAIN * error
            publisher.publish(twist)
    distances = Recorder('scan_to_distance', LaserScanSplit, control)
    try:
        harness.until(lambda: world.entries and errors, 'there are no distances', START_TIMEOUT, simulator)
        harness.until(lambda: abs(errors[-1]) < FLAT / 2.0, 'the robot does not come to the box', START_TIMEOUT,
                      simulator)
    finally:
        for recorder in (distances, poses, world):
            recorder.end()
        publisher.unregister()
        harness.end_nodes()
        rospy.set_param('use_sim_time', False)
    return world_plan(world.entries[-1]), list(poses.entries)


def _typed(harness, *command):
    process = harness.start(*command)
    if process.wait(STEP_TIMEOUT) != 0:
        raise DemoError(f'{" ".join(command)} failed: {process.last_line()}')


STEPS = (
    Step('Parameters', 'Set the three parameters of the background, and clear it',
         'rosparam set /turtlesim/background_r 40; ...; rosservice call /clear', parameters),
    Step('Follower', 'Spawn turtle2, and let it follow turtle1 by tf',
         'rosrun turtle_tf2 turtle_tf2_broadcaster.py _turtle:=turtle1; ...; rosrun turtle_tf2 turtle_tf2_listener.py',
         follower),
    Step('Action', 'Send a goal to an action server: a triangle',
         'rosrun turtle_actionlib shape_server', shape_action),
    Step('Record and play', 'Record the commands of a drive, and play them back',
         'rosbag record -O drive.bag /turtle1/cmd_vel; rosbag play drive.bag', record_and_play),
    Step('P controller', 'Bring the robot to rest 0.5 m in front of a box, by its depth camera',
         f'roslaunch robotont_gazebo world_bangbang.launch rate:={ROBOT_RATE:g}; '
         'roslaunch robotont_laserscan_to_distance distance_from_depth_image.launch', p_controller, turtle=False),
)
