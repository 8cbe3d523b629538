"""Simulated seconds per second of processor time: the Robotont's world alone, with scanner, with camera and tracker.

A probe without ROS (see probing.py). The robot drives about in the maze with AR markers, into its walls as well;
commanding it ten times a second is part of the time, as in a node.
"""
import itertools
import math
import os
import time

os.environ['OMP_NUM_THREADS'] = os.environ['OPENBLAS_NUM_THREADS'] = '1'  # before numpy is loaded

import cv2

from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from kinematic_core.worlds.frames import CAMERA_X, CAMERA_Z, LIDAR_X, LIDAR_Z, ahead
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.rays import LaserScanner
from kinematic_core.worlds.robot_world import DT, RobotWorld
from probing import say
from sim_scene.renderer import Renderer
from sim_scene.worlds import load_world
from unit_support.maze_drive import WORLDS

START = Pose2D(-2.0, 0.0, 0.0)
COMMAND_STEPS, SCAN_STEPS, PICTURE_STEPS = 12, 3, 4
MARKER_SIZE = 0.28  # [m]
TRACKED = 4  # the tracker gets every fourth image: 7.5 Hz of 30; its node's default is at most 8


def times_real_time(plan, seconds, every, sense):
    """Return simulated time per CPU time, over at least ``seconds``; call ``sense(pose)`` every ``every`` steps."""
    world = RobotWorld(plan, START)
    steps = 0
    begun = time.process_time()
    while True:
        for _ in range(10):
            angle = world.time / 3.0
            world.command(0.5 * math.cos(angle), 0.2, 0.6 * math.sin(angle / 2.0))
            for _ in range(COMMAND_STEPS):
                world.step()
                steps += 1
                if sense and steps % every == 0:
                    sense(world.pose)
        elapsed = time.process_time() - begun
        if elapsed >= seconds:
            if world.pose[:2] == START[:2]:
                raise RuntimeError('the robot has not moved, so the figures would be too good')
            return steps * DT / elapsed


def camera_at(pose):
    """Return the (x, y, z, yaw) of the camera of a robot with this pose."""
    return (*ahead(pose, CAMERA_X), CAMERA_Z, pose.yaw)


def real_time(seconds):
    """Report each figure, measured for this time."""
    cv2.setNumThreads(1)
    plan, _ = load_world('minimaze_ar', WORLDS)
    scanner, renderer = LaserScanner(plan, LIDAR_Z), Renderer(plan, 640, 480)
    lens, tracker = Camera(renderer.camera.matrix()), Tracker(Detector(MARKER_SIZE))
    pictures = itertools.count(1)

    def track(pose, every=1):
        picture = renderer.render(camera_at(pose))
        if next(pictures) % every == 0:
            tracker.update(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), lens)
    track(START)
    say(kinematics=times_real_time(plan, seconds, 1, None),
        scanner=times_real_time(plan, seconds, SCAN_STEPS,
                                lambda pose: scanner.scan(*ahead(pose, LIDAR_X), pose.yaw)),
        tracker=times_real_time(plan, seconds, PICTURE_STEPS, lambda pose: track(pose, TRACKED)),
        tracker_each=times_real_time(plan, seconds, PICTURE_STEPS, track))
