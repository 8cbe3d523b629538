"""Measure how far a track is off the shape that it should draw: pure functions.

A track is a sequence of VehicleStates (or messages turtlesim/Pose, which have the same fields) in the order of time.
"""
import math
from typing import List, Sequence, Tuple

from turtle_robotont.driving.shapes import HasPosition, distance
from turtle_robotont.driving.vehicle import VehicleState

Track = Sequence[VehicleState]
_Misses = Tuple[float, Tuple[float, ...]]  # [m] the sum of the misses of some corners, and each of them


def corner_misses(track: Track, corners: Sequence[HasPosition]) -> List[float]:
    """Return for each corner the distance [m] at which the turtle passed it, visiting the corners in their order.

    Of all assignments of poses to corners that do not go back in time, the one with the smallest sum counts.
    Without a track, all distances are inf.
    """
    if not track:
        return [math.inf] * len(corners)
    best: List[_Misses] = [(0.0, ())] * len(track)  # for each pose: the best with the poses up to it
    for corner in corners:
        reached: _Misses = (math.inf, ())
        after = []
        for pose, (total, misses) in zip(track, best):
            miss = distance(pose, corner)
            if total + miss < reached[0]:
                reached = (total + miss, (*misses, miss))
            after.append(reached)
        best = after
    return list(best[-1][1])


def radius_deviation(track: Track, centre: HasPosition, radius: float) -> float:
    """Return the largest distance [m] of the track from a circle."""
    return max(abs(distance(pose, centre) - radius) for pose in track)
