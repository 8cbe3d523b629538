"""Episodes of one task side by side: the worlds are stepped one by one; everything else is computed for all at once.

Rows of all arrays are episodes. An observation has, in this order,

=============  ==========================================================================================
the goal       ahead and to the left of the vehicle [m]
the pose       x, y [m], heading [rad, -pi to pi] in the world's frame
the ranges     [m] from the middle of the vehicle to the nearest wall, if the task has rays; FARTHEST: none
=============  ==========================================================================================

The reward of a step is the distance [m] by which it brought the vehicle nearer to the goal, plus REWARD if the goal is
reached, minus REWARD if a wall is touched. Both end the episode; the time limit truncates it.
"""
from typing import List, Tuple

import numpy as np

from kinematic_core.environments.tasks import Episode, Task
from kinematic_core.worlds.floor_plan import FloorPlan
from kinematic_core.worlds.rays import FARTHEST, FIRST_ANGLE, LAST_ANGLE

REWARD = 10.0
POSE = 5  # columns of an observation without ranges


class Episodes:
    """``number`` episodes of ``task``; public: ``poses`` (N, 3), ``seeds`` (N,), ``reached`` (N,), ``plans``."""

    def __init__(self, task: Task, number: int) -> None:
        """Start all with the seed 0; ``start`` starts another episode."""
        self.task = task
        self.poses = np.zeros((number, 3))
        self.seeds = np.zeros(number, np.int64)
        self.reached = np.zeros(number, bool)
        self.plans: List[FloorPlan] = []
        self._fastest = np.array(task.fastest)
        self._last_step = round(task.time_limit / task.dt)
        self._steps = np.zeros(number, np.int64)
        self._goals, self._distances = np.zeros((number, 2)), np.zeros(number)
        self._angles = np.linspace(FIRST_ANGLE, LAST_ANGLE, task.rays, endpoint=False)
        self._ranges = np.zeros((number, task.rays))
        first = task.begin(0)
        self._drives = [first.drive] * number
        self.plans = [first.plan] * number
        self._boxes = np.repeat(_boxes(first)[None], number, axis=0)
        for index in range(number):
            self.start(index, 0)

    def start(self, index: int, seed: int) -> None:
        """Start a new episode in row ``index``."""
        episode = self.task.begin(seed)
        self._drives[index], self.plans[index] = episode.drive, episode.plan
        self.poses[index], self._goals[index], self._boxes[index] = episode.start, episode.goal, _boxes(episode)
        self.seeds[index], self._steps[index], self.reached[index] = seed, 0, False
        rows = np.array([index])
        self._distances[rows] = np.hypot(*(self._goals[rows] - self.poses[rows, :2]).T)
        self._measure(rows)

    def step(self, actions: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Make a step with the actions (N, commands), -1 to 1; return rewards, terminations and truncations (N,)."""
        commands = (np.clip(actions, -1.0, 1.0) * self._fastest).tolist()
        states = np.array([drive(*command) for drive, command in zip(self._drives, commands)])
        self.poses, touching = states[:, :3], states[:, 3] > 0.0
        self._steps += 1
        distances = np.hypot(self._goals[:, 0] - states[:, 0], self._goals[:, 1] - states[:, 1])
        self.reached = distances <= self.task.reached
        rewards = self._distances - distances + REWARD * self.reached - REWARD * touching
        self._distances = distances
        self._measure(np.flatnonzero(self._steps % self.task.ray_steps == 0))
        return rewards, self.reached | touching, self._steps >= self._last_step

    def observations(self) -> np.ndarray:
        """Return the observations (N, POSE + rays), float32."""
        found = np.empty((len(self.poses), POSE + self.task.rays), np.float32)
        x, y, heading = self.poses.T
        to_x, to_y = self._goals[:, 0] - x, self._goals[:, 1] - y
        cos, sin = np.cos(heading), np.sin(heading)
        found[:, 0], found[:, 1] = cos * to_x + sin * to_y, cos * to_y - sin * to_x
        found[:, 2:POSE], found[:, POSE:] = self.poses, self._ranges
        return found

    def _measure(self, rows: np.ndarray) -> None:
        if self.task.rays and rows.size:
            self._ranges[rows] = np.minimum(box_ranges(self._boxes[rows], self.poses[rows], self._angles), FARTHEST)


def box_ranges(boxes: np.ndarray, poses: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the distance (N, rays) [m] from poses (N, 3) to the first box of the same row along each ray; inf: none.

    ``boxes`` (N, boxes, 5): x, y, yaw, half length, half width; ``angles`` (rays,) count from the heading. Each pair of
    sides lets a ray be inside for an interval of distances; it hits the box where both intervals overlap.
    """
    box_x, box_y, box_yaw, half_length, half_width = np.moveaxis(boxes, 2, 0)[..., None]  # (N, boxes, 1) each
    x, y, yaw = poses.T[:, :, None, None]
    cos, sin = np.cos(box_yaw), np.sin(box_yaw)
    along, across = cos * (x - box_x) + sin * (y - box_y), cos * (y - box_y) - sin * (x - box_x)
    direction = yaw - box_yaw + angles  # (N, boxes, rays)
    enters, leaves = np.full(direction.shape, 0.0), np.full(direction.shape, np.inf)
    with np.errstate(divide='ignore', invalid='ignore'):  # a ray along a side: its interval is infinite or empty
        for position, half, component in ((along, half_length, np.cos(direction)),
                                          (across, half_width, np.sin(direction))):
            inverse, offset = 1.0 / np.abs(component), -position * np.copysign(1.0, component)
            np.maximum(enters, (offset - half) * inverse, out=enters)
            np.minimum(leaves, (offset + half) * inverse, out=leaves)
        found: np.ndarray = np.where(enters <= leaves, enters, np.inf).min(axis=1)
    return found


def _boxes(episode: Episode) -> np.ndarray:
    return np.array([(box.x, box.y, box.yaw, box.length / 2.0, box.width / 2.0) for box in episode.plan.boxes],
                    float).reshape(-1, 5)
