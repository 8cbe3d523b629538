"""The robot steps of the demo: markers in an image sequence, and a robot that drives from marker to marker.

The results are compared with the ground truth: the frames.json of the sequence, and the robot's pose in the simulator.

Threads: rospy calls the recorders' callbacks in its own threads; they only append.
"""
import contextlib
import json
import math
import os
import re
import statistics
import time
import zlib

import cv2
import numpy as np
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_msgs.msg import String

from alvar_core.marker_sequence import FRAMES, MARKERS
from course_grader.demo.core import track_metrics
from course_grader.demo.course import Measurement, at_most, near
from course_grader.demo.harness import DemoError, Recorder
from kinematic_core.worlds import overhead, world_format
from rospy_support import images
from turtle_robotont.driver import pose_of
from turtle_robotont.driving import accuracy
from turtle_robotont.driving.shapes import Point

START_TIMEOUT = 120.0  # [s] until the first message on a loaded machine; the first run renders the sequence first
POSITION_ERROR = 0.01  # median position error as share of the distance; the camera has distortion
SHEET = (3, 2)  # pictures side by side and below each other
MAZE_RATE = 3.0  # simulated seconds per wall-clock second
MAZE_TIME = 80.0  # [s] of simulated time for the maze; the wall time depends on the machine
POSE_RATE = 30.0  # [Hz] of simulated time at which the simulator publishes the robot's pose
NEAR_MARKER = 1.25  # [m] from the robot's middle; the camera, 0.1 m further back, approaches to 1 m
REST_TIME = 5.0  # [s] of simulated time in which the robot must come to rest
PICTURES_WAIT = 3.0  # [s] for a picture


def ar_markers(harness):
    node = harness.start('roslaunch', 'turtle_robotont', 'ar_control.launch')
    pictures = Recorder('usb_cam/image_raw', Image, lambda image: (image.header.stamp, zlib.crc32(image.data)))
    messages = Recorder('ar_pose_marker', AlvarMarkers, lambda message: message)
    views = Recorder('ar_track_alvar/debug_image', Image, images.bgr)
    harness.until(lambda: messages.entries and pictures.entries, 'the tracker publishes no markers',
                  START_TIMEOUT, node)
    harness.until(lambda: len(pictures.entries) > FRAMES, 'the image sequence was not shown completely',
                  START_TIMEOUT, node)
    for recorder in (pictures, messages, views):
        recorder.end()
    harness.keep(sheet(views.entries))
    folder = rospy.get_param('usb_cam/video_device')
    seen = compared(messages.entries, dict(pictures.entries), truth_of(folder))
    printed = set(map(int, re.findall(r'Detected marker with ID (\d+) ', node.output())))
    return [Measurement(f'printed the markers {sorted(printed)} (expected {list(MARKERS)})', printed == set(MARKERS)),
            *sequence_measurements(**seen)]


def truth_of(folder):
    """Return {checksum of a published image: its entry in frames.json}."""
    with open(os.path.join(folder, 'frames.json'), encoding='utf-8') as file:
        frames = json.load(file)['frames']
    pictures = (cv2.imread(os.path.join(folder, frame['file'])) for frame in frames)
    return {zlib.crc32(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB).tobytes()): frame
            for picture, frame in zip(pictures, frames)}


def compared(messages, pictures, truth):
    """Compare the tracker's messages with the ground truth; return counts, and errors as shares of the distance.

    ``pictures``: {stamp: checksum}; ``truth``: {checksum: frame}.
    """
    asked = found = phantoms = shown = 0
    errors = []
    for message in messages:
        frame = truth.get(pictures.get(message.header.stamp))
        if frame is None:
            continue
        shown += 1
        there = {marker['id']: marker for marker in frame['markers']}
        got = {marker.id: marker.pose.pose.position for marker in message.markers}
        phantoms += len(set(got) - set(there))
        plain = {marker_id for marker_id, marker in there.items() if not marker['ignore']}
        asked, found = asked + len(plain), found + len(plain & set(got))
        errors += [math.dist((got[one].x, got[one].y, got[one].z), there[one]['position']) / there[one]['distance_m']
                   for one in plain & set(got)]
    return {'shown': shown, 'asked': asked, 'found': found, 'phantoms': phantoms, 'errors': errors}


def sequence_measurements(shown, asked, found, phantoms, errors):
    """Return the Measurements of the results of ``compared``."""
    return [Measurement(f'{shown} images with known markers searched', shown > FRAMES / 4),
            Measurement(f'{found} of {asked} markers found (expected 98 %)', asked > 0 and found >= 0.98 * asked),
            Measurement(f'{phantoms} markers reported that are not visible (expected 0)', phantoms == 0),
            at_most('median position error', 100.0 * statistics.median(errors or [math.inf]), 100.0 * POSITION_ERROR,
                    '% of the distance')]


def maze(harness):
    plan, track, took, said = run_maze(harness)
    harness.keep(map_of(plan, track))
    panels = [Point(panel.x, panel.y) for panel in sorted(plan.panels, key=lambda panel: panel.marker_id)]
    return [near('the robot started at x =', track[0].x, -2.0, 0.01, 'm'),
            Measurement(f'its output: {said}', said.startswith('Visited the markers')),
            at_most(f'{len(panels)} markers visited in order, at a distance of',
                    max(accuracy.corner_misses(track[::3], panels)), NEAR_MARKER, 'm'),
            Measurement(f'drove {track_metrics.path_length(track):.1f} m and stopped',
                        track_metrics.stands_still(track)),
            at_most('duration', took, MAZE_TIME, "s of simulated time")]


def run_maze(harness):
    """Drive the robot through the maze; return (FloorPlan, true poses, simulated time [s], the node's result)."""
    simulator = harness.start('roslaunch', 'robotont_gazebo', 'world_minimaze_ar.launch', f'rate:={MAZE_RATE:g}')
    world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
    poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
    try:
        harness.until(lambda: world.entries and poses.entries, 'the robotont_gazebo of this repository does not start',
                      START_TIMEOUT, simulator)
        before = len(poses.entries)
        node = harness.start('roslaunch', 'turtle_robotont', 'ar_maze.launch', 'sim:=false')
        views = watch_maze(node)
        took = (len(poses.entries) - before) / POSE_RATE
        with contextlib.suppress(DemoError):
            last = len(poses.entries) + REST_TIME * POSE_RATE
            harness.until(lambda: track_metrics.stands_still(poses.entries) or len(poses.entries) > last,
                          'the robot does not stop', START_TIMEOUT)
    finally:
        poses.end()
        world.end()
        harness.end_nodes()
        rospy.set_param('use_sim_time', False)
    if views:
        harness.keep(sheet(views))
    said = re.findall(r'(?:Visited the markers|FATAL).*', node.output())
    return world_plan(world.entries[-1]), list(poses.entries), took, said[0] if said else node.last_line()


def watch_maze(node):
    """Wait until the tour ends; return an image of the tracker for each marker that the robot approaches."""
    views, approached = [], set()
    while node.runs() and not re.search(r'Visited the markers|FATAL', node.output()):
        for marker in set(re.findall(r'Approaching marker (\d+)', node.output())) - approached:
            approached.add(marker)
            views.append(_next_view())
        time.sleep(0.05)
    return [view for view in views if view is not None]


def _next_view():
    try:
        return images.bgr(rospy.wait_for_message('ar_track_alvar/debug_image', Image, PICTURES_WAIT))
    except rospy.ROSException:
        return None


def world_plan(text):
    """Return the FloorPlan that the simulator publishes."""
    return world_format.parse_json(text)


def map_of(plan, track, title='AR maze'):
    """Return the map with the path of the robot, BGR."""
    last = track[-1]
    path = overhead.Path([(pose.x, pose.y) for pose in track], label='the path of the robot')
    return cv2.cvtColor(overhead.draw_map(plan, [path], [(last.x, last.y, last.theta)], title), cv2.COLOR_RGB2BGR)


def sheet(pictures):
    """Return one image of up to six pictures, evenly spaced in time."""
    across, down = SHEET
    if not pictures:
        raise DemoError('the tracker published no image')
    chosen = [pictures[number * len(pictures) // min(len(pictures), across * down)]
              for number in range(min(len(pictures), across * down))]
    height, width = chosen[0].shape[:2]
    scale = min(1.0, 640.0 / width)
    size = round(width * scale), round(height * scale)
    small = [cv2.resize(picture, size, interpolation=cv2.INTER_AREA) for picture in chosen]
    small += [np.full_like(small[0], 255)] * (-len(small) % across)
    return np.vstack([np.hstack(small[begin:begin + across]) for begin in range(0, len(small), across)])


PLAYS = ar_markers, maze
