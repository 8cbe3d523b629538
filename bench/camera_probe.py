"""Milliseconds of processor time a picture of the simulated camera takes: no ROS, one thread, one line of JSON.

`camera_probe.py SECONDS`: so long for each figure. The camera drives through the maze with the markers and turns as it
goes, so that no two pictures are alike; `tracker` is what following the markers in the same pictures takes.
"""

import json
import math
import pathlib
import sys
import time

import cv2

from alvar_core.camera import Camera
from alvar_core.detector import Detector
from alvar_core.tracker import Tracker
from robotont_gazebo import worlds
from robotont_gazebo.renderer import Renderer

WORLD = pathlib.Path(__file__).parents[1] / 'stand_ins' / 'robotont_gazebo' / 'worlds' / 'minimaze_ar.yaml'
SIZES = ((1280, 720), (640, 480))
EYE = 0.2155  # [m] of the camera above the floor
MARKER_SIZE = 0.28  # [m]
RATE, SPEED, TURNING = 30.0, 0.5, 0.8  # [Hz, m/s, rad/s] of the drive
WAY = ((-2.0, 0.0), (-2.0, 2.0), (0.0, 2.0), (0.0, -2.0), (2.0, -2.0), (2.0, 2.0))


def places():
    """Yield camera poses (x, y, z, yaw) [m, rad] of the drive, for ever."""
    passed = 0
    while True:
        for (x, y), (to_x, to_y) in zip(WAY, (*WAY[1:], WAY[0])):
            steps = round(math.hypot(to_x - x, to_y - y) / SPEED * RATE)
            for step in range(steps):
                share = step / steps
                yield x + share * (to_x - x), y + share * (to_y - y), EYE, passed / RATE * TURNING
                passed += 1


def median(values):
    return sorted(values)[len(values) // 2]


def measure(plan, size, seconds):
    """{name: median milliseconds of processor time} of colour, depth and tracker in pictures of `size`."""
    renderer = Renderer(plan, *size)
    tracker, camera = Tracker(Detector(MARKER_SIZE)), Camera(renderer.camera.matrix())
    took = {'colour': [], 'depth': [], 'tracker': []}
    steps = (('colour', lambda place, _: renderer.render(place)), ('depth', lambda place, _: renderer.depth(place)),
             ('tracker', lambda _, picture: tracker.update(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), camera)))
    end = time.perf_counter() + seconds
    for place in places():
        picture = None
        for name, step in steps:
            begun = time.process_time()
            made = step(place, picture)
            took[name].append(1e3 * (time.process_time() - begun))
            picture = made if picture is None else picture
        if time.perf_counter() > end:
            return {f'{name}_{size[0]}': median(values) for name, values in took.items()}


def main():
    seconds = float(sys.argv[1])
    cv2.setNumThreads(1)
    plan = worlds.read_yaml(WORLD)
    found = {}
    for size in SIZES:
        found.update(measure(plan, size, seconds))
    print(json.dumps(found), flush=True)


if __name__ == '__main__':
    main()
