"""The steps of the demo that belong to the turtles of steps 12 to 19: services, parameters, tf, actions, bags.

Threads: rospy calls the recorders' callbacks in its own threads; they only append.
"""
import math
import os
import time

import actionlib
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty, Trigger, TriggerResponse
from turtle_actionlib.msg import ShapeAction, ShapeGoal
from turtlesim.msg import Pose

from course_grader.demo.core import track_metrics
from course_grader.demo.course import Measurement, at_most, near
from course_grader.demo.harness import EXACT, STEP_TIMEOUT, DemoError, Recorder
from plain_support import write_whole

BACKGROUND = (40, 90, 60)
BEHIND = 0.6  # [m] between turtle2 and turtle1 after a while: it comes closer and closer
AWAY = (1.5, 0.8, 2.5)  # [m/s, rad/s, s] that turtle1 drives then
FARTHEST = 3.5  # [m] that turtle2 may lag behind: its speed is half of the distance per second
EDGES, RADIUS = 3, 0.7  # of the polygon; [m]
CLOSED = 0.1  # [m] between start and end of the polygon
DRIVE = (1.0, 0.8, 2.0)  # [m/s, rad/s, s] that is recorded
STARTED = (1.0, 0.0, 1.0)  # [m/s, rad/s, s] that a service starts
NEARLY = 0.15  # [m] of a path: commands may arrive a tick earlier or later
RATE = 10.0  # [Hz] of velocities
RED = 200  # of the background that the launch file sets
SPEEDS = {'turtle1': (2.0, 2.0), 'turtle2': (1.0, 2.0)}  # [m/s, rad/s] that the launch file sets
ROUND = 0.02  # [m] deviation from a circle
LAUNCH_FILE = f'''<launch>
  <arg name="red" default="0"/>
  <param name="/turtlesim/background_r" value="$(arg red)"/>
  <node pkg="turtle_robotont" type="velocity_publisher.py" name="first">
    <param name="linear" value="{SPEEDS['turtle1'][0]}"/>
    <param name="angular" value="{SPEEDS['turtle1'][1]}"/>
  </node>
  <node pkg="turtle_robotont" type="velocity_publisher.py" name="second">
    <param name="linear" value="{SPEEDS['turtle2'][0]}"/>
    <param name="angular" value="{SPEEDS['turtle2'][1]}"/>
    <remap from="turtle1/cmd_vel" to="turtle2/cmd_vel"/>
  </node>
</launch>
'''


def services(harness):
    turtle2 = Recorder('turtle2/pose', Pose, lambda pose: pose)
    publisher, wanted = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1), []

    def command(_):
        wanted.append(not (wanted and wanted[-1]))
        return TriggerResponse(True, 'drives' if wanted[-1] else 'stands')
    server = rospy.Service('turtle_command', Trigger, command)
    try:
        harness.typed('rosservice', 'call', '/spawn', '2', '2', '0', 'turtle2')
        harness.until(lambda: turtle2.entries, 'there is no turtle2', STEP_TIMEOUT)
        again = harness.start('rosservice', 'call', '/spawn', '3', '3', '0', 'turtle2')
        again.wait(STEP_TIMEOUT)
        harness.typed('rosservice', 'call', '/turtle_command')
        if wanted == [True]:
            _publish(publisher, *STARTED)
        harness.typed('rosservice', 'call', '/turtle_command')
    finally:
        server.shutdown()
        publisher.unregister()
        turtle2.end()
    harness.until_rest()
    return [near('turtle2 is at x =', turtle2.entries[0].x, 2.0, EXACT, 'm'),
            Measurement('a second turtle2 is refused', 'ERROR' in again.output()),
            Measurement(f'/turtle_command was called {len(wanted)} times (expected 2)', wanted == [True, False]),
            near('in between turtle1 drove', track_metrics.path_length(harness.seen.track), STARTED[0] * STARTED[2],
                 NEARLY, 'm')]


def parameters(harness):
    for name, value in zip(('r', 'g', 'b'), BACKGROUND):
        harness.typed('rosparam', 'set', f'/turtlesim/background_{name}', str(value))
    harness.typed('rosservice', 'call', '/clear')
    harness.until(lambda: harness.seen.colours[-1:] == [BACKGROUND], 'the background keeps its colour', STEP_TIMEOUT)
    return [Measurement(f'the background has the colour {BACKGROUND}', True)]


def launch_file(harness):
    path = os.path.join(harness.output, 'two_turtles.launch')
    write_whole(path, LAUNCH_FILE)
    harness.typed('rosservice', 'call', '/spawn', '2', '2', '0', 'turtle2')
    tracks = {name: Recorder(f'{name}/pose', Pose, lambda pose: pose) for name in SPEEDS}
    launch = harness.start('roslaunch', path, f'red:={RED}')
    try:
        harness.until(lambda: rospy.get_param('/turtlesim/background_r', None) == RED,
                      'the launch file does not set the background', STEP_TIMEOUT, launch)
        harness.call('clear', Empty)
        for name, (linear, angular) in SPEEDS.items():
            circle, track = math.tau * linear / angular, tracks[name]
            harness.until(lambda circle=circle, track=track: track_metrics.path_length(track.entries) > circle,
                          f'{name} does not drive', STEP_TIMEOUT, launch)
    finally:
        for track in tracks.values():
            track.end()
    launch.stop()
    return [Measurement(f'/turtlesim/background_r is {RED}', True),
            *(near(f'{name} drives a circle of radius', _radius(tracks[name].entries), linear / angular, ROUND, 'm')
              for name, (linear, angular) in SPEEDS.items())]


def follower(harness):
    poses = Recorder('turtle2/pose', Pose, lambda pose: pose)
    try:
        for turtle in ('turtle1', 'turtle2'):
            harness.start('rosrun', 'turtle_tf2', 'turtle_tf2_broadcaster.py', f'__name:={turtle}_broadcaster',
                          f'_turtle:={turtle}')
        node = harness.start('rosrun', 'turtle_tf2', 'turtle_tf2_listener.py')
        harness.until(lambda: poses.entries, 'there is no turtle2', STEP_TIMEOUT, node)
        harness.until(lambda: _apart(harness, poses) < BEHIND, 'turtle2 does not come to turtle1', STEP_TIMEOUT, node)
        near_by = _apart(harness, poses)
        publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
        harness.until(publisher.get_num_connections, 'nobody reads turtle1/cmd_vel', STEP_TIMEOUT)
        _publish(publisher, *AWAY)
        publisher.unregister()
        return [at_most('turtle2 came to turtle1, as near as', near_by, BEHIND, 'm'),
                at_most('turtle1 drove on, and turtle2 is behind it by', _apart(harness, poses), FARTHEST, 'm'),
                Measurement(f'it drove {track_metrics.path_length(poses.entries):.2f} m',
                            not track_metrics.jumps(poses.entries))]
    finally:
        poses.end()


def _apart(harness, poses):
    leader, other = harness.seen.track[-1], poses.entries[-1]
    return math.hypot(leader.x - other.x, leader.y - other.y)


def shape_action(harness):
    harness.start('rosrun', 'turtle_actionlib', 'shape_server')
    client = actionlib.ActionClient('turtle_shape', ShapeAction)
    if not client.wait_for_server(rospy.Duration(STEP_TIMEOUT)):
        raise DemoError('there is no action turtle_shape')
    goal = client.send_goal(ShapeGoal(EDGES, RADIUS))
    harness.until(lambda: goal.get_comm_state() == actionlib.CommState.DONE, 'the goal does not end', STEP_TIMEOUT)
    harness.until_rest()
    state, result = actionlib.GoalStatus.to_string(goal.get_goal_status()), goal.get_result()
    return [Measurement(f'the goal has {state}', state == 'SUCCEEDED'),
            near('interior angle', result.interior_angle if result else math.nan, math.pi / 3.0, 1e-3, 'rad'),
            at_most('gap at the end', track_metrics.closing_error(harness.seen.track), CLOSED, 'm')]


def record_and_play(harness):
    path = os.path.join(harness.output, 'drive.bag')
    recorder = harness.start('rosbag', 'record', '-O', path, '/turtle1/cmd_vel')
    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
    harness.until(lambda: publisher.get_num_connections() > 1, 'rosbag does not record', STEP_TIMEOUT, recorder)
    _publish(publisher, *DRIVE)
    harness.until_rest()
    recorder.interrupt()
    recorder.wait(STEP_TIMEOUT)
    publisher.unregister()  # not before: a connection that is closed may take the last command, the stop, with it
    driven = harness.seen.track
    harness.reset()
    harness.typed('rosbag', 'play', '--wait-for-subscribers', path)  # else it may lose the first commands
    harness.until_rest()
    again = harness.seen.track
    return [Measurement(f'recorded a drive of {track_metrics.path_length(driven):.2f} m',
                        track_metrics.path_length(driven) > DRIVE[0]),
            at_most('the drive that was played back ends farther off by',
                    math.hypot(again[-1].x - driven[-1].x, again[-1].y - driven[-1].y), NEARLY, 'm')]


def _radius(track):
    """Return half of the width of a circle [m]."""
    return (max(pose.x for pose in track) - min(pose.x for pose in track)) / 2.0


def _publish(publisher, linear, angular, seconds):
    """Publish a velocity for some seconds, then stop."""
    twist, end = Twist(), time.monotonic() + seconds
    twist.linear.x, twist.angular.z = linear, angular
    while time.monotonic() < end:
        publisher.publish(twist)
        time.sleep(1.0 / RATE)
    publisher.publish(Twist())


PLAYS = services, parameters, launch_file, follower, shape_action, record_and_play
