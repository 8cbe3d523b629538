"""Tests of navigation_core.localisation: tracking, a carried robot, global localisation, how many particles suffice."""
import math

import numpy as np
import pytest

from navigation_core.localisation import motion, sensor
from navigation_core.localisation.kld import entropy_limit
from navigation_core.localisation.particle_filter import ParticleFilter, Settings
from navigation_core.localisation.sensor import MeasuredMap, SensorModel, cast
from navigation_core.maps.grid_map import GridMap
from navigation_core.maps.scores import true_map
from navigation_core.poses import Pose
from unit_support.room import START, WALLS, noisy, scan_at, tour

TRUTH = true_map(WALLS)
GRID = GridMap(TRUTH.cells[2::5, 2::5], 0.05, TRUTH.origin)
INSIDE = GridMap(np.where((np.indices(GRID.cells.shape)[0] - GRID.height / 2) ** 2 < 33 ** 2, GRID.cells, -1), 0.05,
                 GRID.origin)
MEASURED = MeasuredMap(INSIDE, 2.0)
SPREAD = np.diag([0.1, 0.1, 0.1]) ** 2


def errors_of(filter_, poses, seed=3):
    """Return the errors [m] of the estimates of a filter on a drive."""
    random, odometry, last, errors = np.random.default_rng(seed), Pose(), None, []
    for pose in poses:
        after = noisy(odometry, last, pose, random, 0.01) if last else odometry
        filter_.update(odometry.step_to(after), scan_at(pose, random))
        odometry, last = after, pose
        found = filter_.estimate().pose
        errors.append(math.hypot(found.x - pose.x, found.y - pose.y))
    return errors


@pytest.mark.parametrize('model', sensor.MODELS)
def test_a_robot_is_followed(model):
    tracked = ParticleFilter(MEASURED, Settings(max_particles=500, motion='omni-corrected'), SensorModel(model), 1)
    tracked.place(START, SPREAD)
    errors = errors_of(tracked, tour(30))
    assert np.median(errors) < 0.06 and max(errors) < 0.2  # [m]
    assert 100 <= len(tracked.particles) <= 500 and tracked.weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize('alphas', [(0.001, 0.1), (0.0, 0.0)])
def test_a_carried_robot_is_found_with_recovery_alone(alphas):
    settings = Settings(max_particles=500, motion='omni-corrected', recovery_slow=alphas[0], recovery_fast=alphas[1])
    lost = ParticleFilter(MEASURED, settings, SensorModel(), 1)
    lost.place(Pose(1.3, 0.5, 2.0), SPREAD)  # the robot is at START
    errors_of(lost, list(tour(30))[13:17])  # around (1.3, 0.5), where the filter is right
    found = min(errors_of(lost, [START.then(Pose(0.02 * step, 0.0, 0.3 * step)) for step in range(15)])[-3:])
    assert (found < 0.2) == (alphas[0] > 0.0), found


def test_a_robot_anywhere_is_found():
    lost = ParticleFilter(MEASURED, Settings(max_particles=500, motion='omni-corrected'), SensorModel(), 2)
    lost.spread()
    assert errors_of(lost, [START.then(Pose(0.02 * step, 0.0, 0.2 * step)) for step in range(6)])[-1] < 0.15  # [m]


def test_the_first_scan_does_not_find_a_robot_that_may_be_anywhere():
    """Random poses that fit the scan were searched for at once, so that a robot was found although it stood."""
    lost = ParticleFilter(MEASURED, Settings(max_particles=500, motion='omni-corrected'), SensorModel(), 2)
    for _ in range(2):
        lost.spread()
        lost.update(Pose(), scan_at(START, np.random.default_rng(3)))
        assert lost.particles[:, :2].std(axis=0).min() > 0.5  # [m]; the room is 4 m x 3 m


def test_a_new_start_does_not_depend_on_the_scans_before():
    filters = [ParticleFilter(MEASURED, Settings(max_particles=500), SensorModel(), 2) for _ in range(2)]
    filters[0].update(Pose(), scan_at(START, np.random.default_rng(3)))
    for one in filters:
        one.spread()
    assert np.array_equal(filters[0].particles, filters[1].particles)


@pytest.mark.parametrize('model', motion.MODELS)
def test_particles_move_as_the_odometry_on_average(model):
    random = np.random.default_rng(0)
    particles = np.tile([1.0, 2.0, math.pi / 2], (4000, 1))
    after = motion.moved(particles, Pose(0.5, 0.2, 0.3), (0.1,) * 5, model, random)
    assert np.median(after, axis=0) == pytest.approx([1.0 - 0.2, 2.5, math.pi / 2 + 0.3], abs=0.03)
    assert after[:, :2].std() > 0.01
    exact = motion.moved(particles, Pose(0.5, 0.2, 0.3), (0.0,) * 5, model, random)
    assert exact == pytest.approx(np.tile([0.8, 2.5, math.pi / 2 + 0.3], (4000, 1)))


def test_rays_end_at_the_walls():
    """From (0, -1) the room ends 2 m ahead, 2 m behind and 0.5 m to the right."""
    lengths = cast(MEASURED, np.zeros((1, 1)), np.full((1, 1), -1.0), np.array([[0.0, math.pi, -math.pi / 2]]), 30.0)
    assert lengths.ravel() == pytest.approx([2.0, 2.0, 0.5], abs=0.08)


def test_more_bins_need_more_particles():
    """Fox's limit by hand, for 2 bins: share 2/9; 1 / (2 * 0.05) * (1 - 0.2222 + 0.4714 * 2.3263) ** 3 = 66.0."""
    assert entropy_limit(np.array([1, 2, 50]), 0.05, 2.3263).tolist() == [66, 66, 750]


def test_a_map_without_a_free_cell_is_refused():
    with pytest.raises(ValueError, match='no cell of it is free'):
        MeasuredMap(GridMap.unknown(3, 3, 0.05), 2.0)
