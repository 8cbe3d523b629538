"""A small room with a wall in it, and scans of it, for the tests of mapping and localisation."""
import math

import numpy as np

from kinematic_core.worlds.floor_plan import Box, FloorPlan, corners
from kinematic_core.worlds.rays import RayCaster
from navigation_core.poses import Pose
from navigation_core.scans import usable

BOXES = [Box(f'wall{number}', x, y, 0.0, length, width, 0.5) for number, (x, y, length, width) in enumerate((
    (0.0, 1.55, 4.1, 0.1), (0.0, -1.55, 4.1, 0.1), (2.05, 0.0, 0.1, 3.2), (-2.05, 0.0, 0.1, 3.2),
    (0.5, 0.75, 0.1, 1.5)))]  # a room of 4 m x 3 m; the last one reaches into it
WALLS = [corners(box) for box in BOXES]
START = Pose(-1.2, -0.6, 0.0)
INCREMENT = math.radians(1.0)


def scan_at(pose, random=None, degrees=360, noise=0.01):
    """Return the Scan of a scanner in the middle of a robot at ``pose``, 1 degree apart; ``noise`` [m]."""
    angles = INCREMENT * np.arange(-(degrees // 2), (degrees + 1) // 2)
    ranges = RayCaster(FloorPlan(tuple(BOXES)), 0.2, angles).ranges(*pose)
    if random is not None:
        ranges = ranges + random.normal(0.0, noise, len(ranges))
    return usable(ranges, angles[0], INCREMENT, 0.05, 10.0, 8.0, Pose())


def tour(steps=60):
    """Yield the poses of a drive around the end of the wall and back, turning."""
    places = np.array([START[:2], (0.5, -0.8), (1.3, 0.5), (0.5, -0.8), START[:2]])
    lengths = np.cumsum([0.0, *np.hypot(*np.diff(places, axis=0).T)])
    for index, way in enumerate(np.linspace(0.0, lengths[-1], steps)):
        yield Pose(float(np.interp(way, lengths, places[:, 0])), float(np.interp(way, lengths, places[:, 1])),
                   (0.1 * index + math.pi) % (2.0 * math.pi) - math.pi)


def noisy(odometry, last, pose, random, deviation=0.02):
    """Return the odometry's next pose: the true step with an error of this standard deviation [m, rad]."""
    step = last.step_to(pose)
    x, y, yaw = random.normal(0.0, deviation, 3)
    return odometry.then(Pose(step.x + x, step.y + y, step.yaw + yaw))
