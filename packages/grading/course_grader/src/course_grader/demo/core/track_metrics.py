"""Measure a vehicle's track with pure functions, so that a result is judged without trusting any node.

A track is a sequence of VehicleStates (or messages turtlesim/Pose, which have the same fields) in the order of time.
A turtle's positions lie in 0 .. ARENA_SIZE, y up.
"""
import math
import statistics
from typing import List, Sequence, Tuple

from turtle_robotont.driving.accuracy import Track
from turtle_robotont.driving.shapes import HasPose, HasPosition, distance, wrap_angle
from turtle_robotont.driving.vehicle import TURTLE_STEP, VehicleState

JUMP = 0.25  # [m] in one step: a teleport, as a turtle would need 15 m/s
STANDING = 1e-4  # [m or rad] by which a turtle that stands still may move


def rate(times: Sequence[float]) -> float:
    """Return the rate [Hz] of times [s] from the median of their gaps, which ignores late ones; 0 without gaps."""
    gaps = [later - earlier for earlier, later in zip(times, times[1:])]
    return 1.0 / statistics.median(gaps) if gaps else 0.0


def path_length(track: Track) -> float:
    """Return the length [m] of the path."""
    return sum(distance(a, b) for a, b in zip(track, track[1:]))


def turned(track: Track) -> float:
    """Return the total turn [rad], counter-clockwise positive, full turns counted."""
    return sum(wrap_angle(b.theta - a.theta) for a, b in zip(track, track[1:]))


def curvature(track: Track) -> float:
    """Return the mean curvature [1/m] of the path, positive to the left; 0 for a turtle that did not move."""
    length = path_length(track)
    return turned(track) / length if length > STANDING else 0.0


def jumps(track: Track, limit: float = JUMP) -> List[VehicleState]:
    """Return the poses that the turtle reached by a jump of more than ``limit`` [m]: teleports."""
    return [b for a, b in zip(track, track[1:]) if distance(a, b) > limit]


def top_speed(track: Track) -> float:
    """Return the highest speed [m/s] that the poses report."""
    return max((pose.linear_velocity for pose in track), default=0.0)


def stands_still(track: Track, seconds: float = 0.2) -> bool:
    """Return whether the turtle stood still during the last ``seconds`` of the track."""
    count = max(2, math.ceil(seconds / TURTLE_STEP))
    last = track[-count:]
    return len(last) == count and all(
        distance(last[0], pose) < STANDING and abs(wrap_angle(pose.theta - last[0].theta)) < STANDING for pose in last)


def goal_error(track: Track, goal: HasPose) -> Tuple[float, float]:
    """Return (distance [m], heading error [rad]) left to a goal at the end of the track."""
    return distance(track[-1], goal), abs(wrap_angle(track[-1].theta - goal.theta))


def closing_error(track: Track) -> float:
    """Return the distance [m] between the start and the end of the track."""
    return distance(track[0], track[-1]) if track else math.inf


def path_deviation(track: Track, corners: Sequence[HasPosition]) -> float:
    """Return the largest distance [m] of the track from the lines that join the corners one after the other."""
    return max(min(_distance_to_line(pose, a, b) for a, b in zip(corners, corners[1:])) for pose in track)


def _distance_to_line(point: HasPosition, a: HasPosition, b: HasPosition) -> float:
    length = distance(a, b)
    if length == 0.0:
        return distance(point, a)
    along = ((point.x - a.x) * (b.x - a.x) + (point.y - a.y) * (b.y - a.y)) / length
    along = max(0.0, min(length, along))
    return math.hypot(a.x + along / length * (b.x - a.x) - point.x, a.y + along / length * (b.y - a.y) - point.y)
