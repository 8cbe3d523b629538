"""The steps of the demo in which a robot drives by its sensors: distances of its depth camera, and a marker.

Each controller is the one that the page of its step prints.

Threads: rospy calls the recorders' callbacks in its own threads; they only append, and publish a velocity.
"""
import math
import os
import statistics

import cv2
import numpy as np
import rospy
import yaml
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from robotont_laserscan_to_distance.msg import LaserScanSplit
from std_msgs.msg import String

from course_grader.demo.core import track_metrics
from course_grader.demo.course import Measurement, at_most, near
from course_grader.demo.course_markers import POSE_RATE, START_TIMEOUT, map_of, world_plan
from course_grader.demo.harness import Recorder
from kinematic_core.worlds.frames import CAMERA_X
from plain_support import course, write_whole
from turtle_robotont.driver import pose_of

GOAL, GAIN, FLAT = 0.5, 0.8, 0.03  # [m] from the box, [1/s], [m] tolerance of the goal
LONGEST, LOWEST, HIGHEST = 12.0, 0.4, 0.7  # [s], [m], [m] of the plots: the end of the way
RESTS = 10.0  # [s] after which the robot must stand in front of the box
PACE, BACK, SWING = 0.2, 12, 0.2  # [m/s], number of turns, [m] of the largest swing around the goal
GATE = 0.15  # [m] beside the middle of a gate
BEHIND = 0.6  # [m] behind the marker
AIMED = 0.05  # [rad] beside the marker
MOVED = 1.5, 0.4  # [m] to where the marker moves
RATE = 3.0  # simulated seconds per wall-clock second
DISTANCES = 'roslaunch', 'robotont_laserscan_to_distance', 'distance_from_depth_image.launch'
TRACKER = 'roslaunch', 'turtle_robotont', 'camera_ar_track.launch', 'source:=simulator', 'marker_size:=9'
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 480, 320, 58, 44, 18, 46  # [px] of the picture; margins around the axes
PAPER, GRID, INK, LINE, GOAL_LINE = (250, 252, 252), (232, 230, 228), (52, 44, 40), (196, 96, 22), (40, 32, 176)  # BGR
FONT = cv2.FONT_HERSHEY_SIMPLEX


class Drive:
    """A simulated Robotont in a world, which ``control(message)`` of a sensor drives: it returns (x, y, yaw rate).

    A context manager; inside, ``track`` are the true poses, ``commands`` the published velocities.
    """

    def __init__(self, harness, world, sensor, topic, message_type, control):
        """``world`` and ``sensor`` are the commands that start the simulator and the sensor's nodes."""
        self._harness, self._control, self.commands = harness, control, []
        self._simulator = harness.start(*world, f'rate:={RATE:g}')
        harness.start(*sensor)
        self._world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
        self._poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
        self._publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        self._sensor = Recorder(topic, message_type, self._drive)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for recorder in (self._sensor, self._poses, self._world):
            recorder.end()
        self._publisher.unregister()
        self._harness.end_nodes()
        rospy.set_param('use_sim_time', False)

    def _drive(self, message):
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.angular.z = command = self._control(message)
        self._publisher.publish(twist)
        self.commands.append(command)

    def until(self, condition, trouble):
        """Wait for a condition, once there are a world, a pose and a measurement; raise DemoError(trouble)."""
        self._harness.until(lambda: self._world.entries and self._poses.entries and self.commands and condition(),
                            trouble, START_TIMEOUT, self._simulator)

    @property
    def track(self):
        """Return the true poses so far."""
        return list(self._poses.entries)

    @property
    def plan(self):
        """Return the current FloorPlan."""
        return world_plan(self._world.entries[-1])


def _bangbang(harness, control):
    """Return the Drive with a box ahead."""
    return Drive(harness, ('roslaunch', 'robotont_gazebo', 'world_bangbang.launch'), DISTANCES, 'scan_to_distance',
                 LaserScanSplit, control)


def _from_box(plan, track):
    """Return the distances [m] from the camera to the box."""
    return [plan.boxes[0].x - plan.boxes[0].length / 2.0 - pose.x - CAMERA_X for pose in track]


def _plot(title, distances):
    """Return a plot of the distances [m] from the camera to the box over the simulated time."""
    return over_time(title, [number / POSE_RATE for number in range(len(distances))], distances, GOAL, LONGEST,
                     (LOWEST, HIGHEST))


def bang_bang(harness):
    with _bangbang(harness, lambda seen: (PACE if seen.center_min > GOAL else -PACE, 0.0, 0.0)) as drive:
        def turns():
            ways = [command[0] for command in list(drive.commands)]
            return sum(before != after for before, after in zip(ways, ways[1:]))
        drive.until(lambda: turns() >= BACK, 'the robot does not drive back and forth')
        plan, track = drive.plan, drive.track
    distances = _from_box(plan, track)
    harness.keep(_plot('Bang-bang: distance to the box', distances))
    there = next(number for number, distance in enumerate(distances) if distance < GOAL)
    return [Measurement(f'drove to the box, and turned back {BACK} times', True),
            at_most(f'swings around {GOAL} m by', max(abs(distance - GOAL) for distance in distances[there:]), SWING,
                    'm')]


def p_controller(harness):
    errors = []

    def control(seen):
        error = seen.center_min - GOAL
        if math.isfinite(error):
            errors.append(error)
        return GAIN * errors[-1] if errors else 0.0, 0.0, 0.0
    with _bangbang(harness, control) as drive:
        drive.until(lambda: errors and abs(errors[-1]) < FLAT / 2.0 and len(drive.track) > RESTS * POSE_RATE,
                    'the robot does not come to the box')
        plan, track = drive.plan, drive.track
    distances = _from_box(plan, track)
    harness.keep(_plot('P controller: distance to the box', distances))
    speeds = [math.hypot(after.x - before.x, after.y - before.y) for before, after in zip(track, track[1:])]
    return [Measurement(f'drove {track_metrics.path_length(track):.2f} m, slower and slower',
                        speeds.index(max(speeds)) < len(speeds) / 2),
            near('distance from the camera to the box', distances[-1], GOAL, FLAT, 'm')]


def between_posts(harness):
    exercise = course.exercises(course.installed())['between_posts']
    path = os.path.join(harness.output, 'posts.yaml')
    with open(exercise, encoding='utf-8') as file:
        write_whole(path, yaml.safe_dump(yaml.safe_load(file)['world']))
    world = 'roslaunch', 'robotont_gazebo', 'gazebo.launch', f'world:={path}'
    with Drive(harness, world, DISTANCES, 'scan_to_distance', LaserScanSplit,
               lambda seen: (PACE, seen.left_min - seen.right_min, 0.0)) as drive:
        drive.until(lambda: drive.plan, 'there is no world')
        gates = {x: statistics.mean(post.y for post in drive.plan.cylinders if post.x == x)
                 for x in sorted({post.x for post in drive.plan.cylinders})}
        drive.until(lambda: drive.track[-1].x > max(gates) + GATE, 'the robot does not reach the last gate')
        plan, track = drive.plan, drive.track
    harness.keep(map_of(plan, track, 'Between posts'))
    return [near(f'passed the gate at x = {x:g} m at y =', min(track, key=lambda pose: abs(pose.x - x)).y, y, GATE, 'm')
            for x, y in gates.items()]


def moved_marker(harness):
    seen = []

    def control(message):
        for marker in message.markers:
            at = marker.pose.pose.position
            seen.append((at.x, math.atan2(at.y, at.x)))
            return at.x - BEHIND, 0.0, 1.5 * seen[-1][1]
        return 0.0, 0.0, 0.0

    def there():
        return bool(seen) and abs(seen[-1][0] - BEHIND) < FLAT / 2.0 and abs(seen[-1][1]) < AIMED / 2.0
    world = 'roslaunch', 'robotont_gazebo', 'gazebo.launch', 'world:=ar'
    with Drive(harness, world, TRACKER, 'ar_pose_marker', AlvarMarkers, control) as drive:
        drive.until(there, 'the robot does not come to the marker')
        first = drive.track[-1]
        from robotont_gazebo.srv import MoveMarker  # the original has none
        harness.call('robotont_gazebo/move_marker', MoveMarker, 'marker1', *MOVED, 0.0)
        drive.until(lambda: not there(), 'the tracker does not see that the marker has moved')
        drive.until(there, 'the robot does not follow the marker')
        plan, track = drive.plan, drive.track
    harness.keep(map_of(plan, track, 'A marker that moves'))
    last = track[-1]
    camera = last.x + CAMERA_X * math.cos(last.theta), last.y + CAMERA_X * math.sin(last.theta)
    bearing = math.remainder(math.atan2(MOVED[1] - camera[1], MOVED[0] - camera[0]) - last.theta, math.tau)
    return [Measurement(f'came to the marker, and {math.dist((first.x, first.y), (last.x, last.y)):.2f} m after it',
                        True),
            near('distance from the camera to the marker', math.dist(camera, MOVED), BEHIND, FLAT, 'm'),
            near('the marker is ahead, at an angle of', bearing, 0.0, AIMED, 'rad')]


def over_time(title, times, values, goal, longest, between):
    """Return a plot (HEIGHT, WIDTH, 3) uint8 BGR of distances [m] over times [s], with a line at the goal.

    The axes go to ``longest`` [s] and ``between`` two distances [m], so that two plots can be compared.
    """
    low, high = between
    image = np.full((HEIGHT, WIDTH, 3), PAPER, np.uint8)
    axes = image[TOP - 1:HEIGHT - BOTTOM + 2]  # nothing is drawn above and below

    def pixels(seconds, metres):
        columns = LEFT + np.asarray(seconds, float) * (WIDTH - LEFT - RIGHT) / longest
        rows = HEIGHT - BOTTOM - (np.asarray(metres, float) - low) * (HEIGHT - TOP - BOTTOM) / (high - low)
        return np.stack(np.broadcast_arrays(columns, rows), -1).round().astype(np.int32)

    def line(seconds, metres, colour, width):
        cv2.polylines(axes, [pixels(seconds, metres) - [0, TOP - 1]], False, colour, width, cv2.LINE_AA)

    def text(words, column, row, size=0.5, colour=INK):
        cv2.putText(image, words, (int(column), int(row)), FONT, size, colour, 1, cv2.LINE_AA)
    for second in range(0, int(longest) + 1, 2):
        line([second, second], between, INK if second == 0 else GRID, 1)
        text(f'{second}', pixels(second, low)[0] - 6, HEIGHT - BOTTOM + 20)
    for metre in np.arange(low, high + 0.01, 0.1):
        line([0.0, longest], [metre, metre], INK if metre == low else GRID, 1)
        text(f'{metre:.1f}', 24, pixels(0.0, metre)[1] + 5)
    line([0.0, longest], [goal, goal], GOAL_LINE, 1)
    text('goal', WIDTH - RIGHT - 40, pixels(0.0, goal)[1] - 6, colour=GOAL_LINE)
    line(times, values, LINE, 2)
    text(title, LEFT, 28, 0.7)
    text('m', 6, TOP + 6)
    text('time [s]', WIDTH - RIGHT - 66, HEIGHT - 8)
    return image


PLAYS = bang_bang, p_controller, between_posts, moved_marker
