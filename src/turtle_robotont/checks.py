"""Measuring what a turtle did: pure functions over its track, to judge a result without believing any node.

A track is a sequence of poses in the order of time, each with x, y [m], theta [rad], linear_velocity [m/s] and
angular_velocity [rad/s], as turtlesim/Pose has them. Positions lie in 0 .. ARENA_SIZE, y up.
"""
import math
import statistics

from kinematic_core.angles import wrap_angle
from kinematic_core.turtle_world import DT
from turtle_robotont.shapes import distance

JUMP = 0.25  # [m] further in one step than a turtle drives below 15 m/s: a teleport
RESTING = 1e-4  # [m or rad] a turtle at rest stays within this


def rate(times):
    """Return the rate [Hz] of times [s] by the median of their gaps: one that is late does not count; 0 for few."""
    gaps = [later - earlier for earlier, later in zip(times, times[1:])]
    return 1.0 / statistics.median(gaps) if gaps else 0.0


def path_length(track):
    """Return the length [m] of the way."""
    return sum(distance(a, b) for a, b in zip(track, track[1:]))


def turned(track):
    """Return by how much the turtle turned in all [rad], counter-clockwise positive, full turns counted."""
    return sum(wrap_angle(b.theta - a.theta) for a, b in zip(track, track[1:]))


def curvature(track):
    """Return the mean curvature [1/m] of the way, to the left positive; 0 for a turtle that did not move."""
    length = path_length(track)
    return turned(track) / length if length > RESTING else 0.0


def jumps(track, limit=JUMP):
    """Return the poses that the turtle reached by a jump of more than ``limit`` [m]: teleports."""
    return [b for a, b in zip(track, track[1:]) if distance(a, b) > limit]


def top_speed(track):
    """Return the highest speed [m/s] that the poses report."""
    return max((pose.linear_velocity for pose in track), default=0.0)


def rests(track, seconds=0.2):
    """Return whether the turtle stood still during the last ``seconds`` of the track."""
    count = max(2, math.ceil(seconds / DT))
    last = track[-count:]
    return len(last) == count and all(
        distance(last[0], pose) < RESTING and abs(wrap_angle(pose.theta - last[0].theta)) < RESTING for pose in last)


def stop_error(track, x):
    """Return how far from ``x`` [m] the turtle is at the end; infinite while it has not come to rest."""
    return abs(track[-1].x - x) if track and rests(track) else math.inf


def goal_error(track, goal):
    """Return (distance [m], heading error [rad]) left to a goal with x, y, theta at the end of the track."""
    return distance(track[-1], goal), abs(wrap_angle(track[-1].theta - goal.theta))


def closing_error(track):
    """Return the distance [m] between the begin and the end of the track."""
    return distance(track[0], track[-1]) if track else math.inf


def corner_misses(track, corners):
    """Return for each corner how closely [m] the turtle passed it, all corners taken in their order.

    Of all ways to assign poses to corners without going back in time the one with the least sum is taken.
    All are infinite where there is no track.
    """
    if not track:
        return [math.inf] * len(corners)
    best = [(0.0, ())] * len(track)  # over the poses so far: sum of the misses, misses
    for corner in corners:
        reached, after = (math.inf, ()), []
        for pose, (total, misses) in zip(track, best):
            miss = distance(pose, corner)
            if total + miss < reached[0]:
                reached = (total + miss, (*misses, miss))
            after.append(reached)
        best = after
    return list(best[-1][1])


def path_deviation(track, corners):
    """Return the largest distance [m] of the track from the lines that join the corners one after the other."""
    return max(min(_distance_to_line(pose, a, b) for a, b in zip(corners, corners[1:])) for pose in track)


def radius_deviation(track, centre, radius):
    """Return the largest distance [m] of the track from a circle."""
    return max(abs(distance(pose, centre) - radius) for pose in track)


def _distance_to_line(point, a, b):
    length = distance(a, b)
    if length == 0.0:
        return distance(point, a)
    along = ((point.x - a.x) * (b.x - a.x) + (point.y - a.y) * (b.y - a.y)) / length
    along = max(0.0, min(length, along))
    return math.hypot(a.x + along / length * (b.x - a.x) - point.x, a.y + along / length * (b.y - a.y) - point.y)
