"""The worlds of turtlesim and of the Robotont as fast as they run: probes without ROS (see probing.py).

Commands are part of the time, as in a node. Turtles drive circles with their pens on; the robot drives about in the
maze with AR markers, into its walls as well.
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
from kinematic_core.worlds.turtle_world import TurtleWorld
from probing import say
from sim_scene.renderer import Renderer
from sim_scene.worlds import load_world
from turtlesim.core.drawn_world import DrawnWorld
from unit_support.maze_drive import WORLDS

COMMAND_EVERY = 50  # steps of turtles: 0.8 s, inside the watchdog's second
COUNTS = (1, 100)  # turtles
START = Pose2D(-2.0, 0.0, 0.0)
COMMAND_STEPS, SCAN_STEPS, PICTURE_STEPS = 12, 3, 4
MARKER_SIZE = 0.28  # [m]
TRACKED = 4  # the tracker gets every fourth image: 7.5 Hz of 30; its node's default is at most 8


def ticks_per_second(world, step, count, seconds):
    """Return the turtle ticks per second of ``count`` turtles, over at least ``seconds`` of step() of ``world``."""
    for number in range(count - 1):
        world.spawn(1.5 + 0.8 * (number % 10), 1.5 + 0.8 * (number // 10 % 10), 0.7 * number)
    steps, begun, elapsed = 0, time.perf_counter(), 0.0
    while elapsed < seconds:
        for number, name in enumerate(sorted(world.turtles)):  # circles of 0.5 to 1 m radius, each a little different
            world.command(name, 1.0 + 0.01 * (number % 100), 0.0, 2.0)
        for _ in range(COMMAND_EVERY):
            step()
        steps += COMMAND_EVERY
        elapsed = time.perf_counter() - begun
    if not all(math.hypot(turtle.linear_x, turtle.linear_y) for turtle in world.turtles.values()):
        raise RuntimeError('a turtle does not move, so the figures would be too good')
    return count * steps / elapsed


def ticks(seconds):
    """Report each figure, measured for this time."""
    found = {}
    for count in COUNTS:
        world = TurtleWorld()
        found[f'core_{count}'] = ticks_per_second(world, world.step, count, seconds)
        drawn = DrawnWorld()
        found[f'canvas_{count}'] = ticks_per_second(drawn.world, drawn.step, count, seconds)
    say(**found)


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
