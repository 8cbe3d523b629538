"""course_grader.rules.rules_navigation: maps, poses and goals against the true world."""
import math

import numpy as np
import pytest

from course_grader.rules.observation import Destination, Observed, Sample
from course_grader.rules.rules_navigation import Localises, Maps, Navigates
from kinematic_core.worlds.floor_plan import Box, FloorPlan, Panel
from kinematic_core.worlds.frames import LIDAR_Z
from kinematic_core.worlds.robot_world import DT, ROBOT_RADIUS
from navigation_core.maps.grid_map import FREE, OCCUPIED, UNKNOWN, GridMap
from navigation_core.maps.scores import true_map
from navigation_core.poses import Pose

SIDES = [('west', -2.0, 0.0, 0.1, 4.1), ('east', 2.0, 0.0, 0.1, 4.1), ('south', 0.0, -2.0, 4.1, 0.1),
         ('north', 0.0, 2.0, 4.1, 0.1), ('middle', 0.0, 0.5, 0.1, 2.9)]  # name, x, y, length, width: open at y < -0.95
ROOM = FloorPlan(tuple(Box(name, x, y, 0.0, length, width, 0.5) for name, x, y, length, width in SIDES))
GOALS = Navigates([(1.0, 1.0, 0.0), (1.0, -1.5, 0.0)], tolerance=0.1, turn=0.1, rest=1.0, detour=1.5)


def driven(*corners, speed=0.5, rest=1.5):
    """Return what is observed of a robot that drives straight from one corner (x, y) to the next, and rests there."""
    observed, t = Observed(plan=ROOM), 0.0
    for start, end in zip(corners, (*corners[1:], corners[-1])):
        steps = math.ceil(math.dist(start, end) / speed / DT)
        for step in range(steps + round(rest / DT)):
            part = min(1.0, step / max(1, steps))
            x, y = (a + part * (b - a) for a, b in zip(start, end))
            observed.track.append(Sample(t, x, y, 0.0))
            t += DT
    return observed


AROUND = (-1.0, 1.0), (-1.0, -1.4), (1.0, -1.4), (1.0, 1.0), (1.0, -1.5)


def test_poses_that_are_reached_one_after_the_other_count():
    result = GOALS.judge(driven(*AROUND))
    assert result.share == 1.0 and '2 of 2 reached' in result.seen


@pytest.mark.parametrize('corners, how, said', [
    (AROUND[:-1], {}, '1 of 2 reached; goal 2 (1, -1.5, 0 degrees): the robot came as near as 0.10 m'),
    ((AROUND[0], AROUND[2], AROUND[4], AROUND[3]), {}, '1 of 2 reached'),  # in the other order
    (AROUND, {'rest': 0.5}, '0 of 2 reached'),
    ((AROUND[0], (-1.0, -1.4), (-1.0, 1.0), *AROUND[1:]), {}, 'is 2.'),  # there and back first
    ((AROUND[0], (-1.0, -2.0 + 0.05 + ROBOT_RADIUS), *AROUND[1:]), {}, 'touches something 1 times'),
    ((AROUND[0],), {}, 'move_base got no goal')])
def test_what_is_missed_loses_more_than_half(corners, how, said):
    result = GOALS.judge(driven(*corners, **how))
    assert result.share < 0.5 and said in result.seen, result.seen


def test_a_panel_is_touched_only_where_it_is_at_that_time():
    panel = Panel('board', 1, -1.0, 0.0, 0.0, 0.4)  # on the way; the robot is there after 3 s
    for moved, touches in ((1.0, 0), (6.0, 1)):
        observed = driven(*AROUND)
        observed.plan = ROOM._replace(panels=(panel,))
        observed.moved.append((moved, observed.plan.with_panel('board', -1.5, 1.5, 0.0)))
        assert (f'touches something {touches} times' in GOALS.judge(observed).seen) == bool(touches)


def test_what_move_base_says_of_a_goal_is_told():
    observed = driven(AROUND[0])
    observed.destinations += [Destination(1.0, '', 1.0, 1.0, 0.0, 'ABORTED', 'it names no frame')]
    assert "in the frame '' is ABORTED: it names no frame" in GOALS.judge(observed).seen


def test_the_pose_in_the_map_is_compared_with_the_true_one_when_it_counts():
    observed = driven((-1.0, 1.0), rest=60.0)
    observed.carried.append(30.0)
    wrong = {*range(10), *range(30, 40)}  # [s]: at first, and when it was carried away
    observed.believed += [Sample(t, -1.0 + (1.0 if t in wrong else 0.05), 1.0, 0.0) for t in range(60)]
    assert Localises(within=10.0).judge(observed).share == 1.0
    late = Localises(within=8.0).judge(observed)
    assert late.share < 0.5 and '95 % of it within 1.00 m' in late.seen
    del observed.believed[38:]  # as if it ended 8 s after it was carried away
    assert 'ended too early' in Localises(within=10.0).judge(observed).seen
    observed.believed.clear()
    assert 'no transform from map to odom' in Localises().judge(observed).seen


def a_map():
    """Return the map of a robot that has been everywhere: its frame is not the world's."""
    truth = true_map(ROOM.outlines(LIDAR_Z), 0.05)
    rows, columns = np.indices(truth.cells.shape)
    x, y = truth.to_world(columns, rows)
    outside = (np.maximum(abs(x), abs(y)) > 2.05) & (truth.cells != OCCUPIED)
    cells = np.where(outside, UNKNOWN, truth.cells)
    return GridMap(cells, 0.05, Pose(truth.origin.x + 0.3, truth.origin.y - 0.2, 0.0))


def test_a_map_is_moved_to_the_walls_and_compared_with_them():
    observed = driven((-1.0, 1.0))
    observed.map = a_map()
    assert Maps(iou=0.9).judge(observed).share == 1.0
    half = observed.map.cells.copy()
    half[:, half.shape[1] // 2 + 2:] = UNKNOWN
    observed.map = GridMap(half, 0.05, observed.map.origin)
    result = Maps(iou=0.9).judge(observed)
    assert result.share < 0.5 and 'IoU 0.' in result.seen
    observed.map = GridMap(np.full((9, 9), FREE), 0.05)
    assert Maps().judge(observed).seen == 'the map has no occupied cell'
    observed.map = None
    assert Maps().judge(observed).seen == 'there is no map on /map'
