"""The Gymnasium environments: gymnasium's own check, the scripted policies, many episodes side by side.

recording_test.py compares them with the recordings of the simulators.
"""
import math
import pathlib
import re
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

import kinematic_core.environments as environments
from kinematic_core.environments.episodes import POSE, REWARD, box_ranges
from kinematic_core.environments.policies import POLICIES
from kinematic_core.environments.tasks import TASKS, gap_plan
from kinematic_core.worlds.rays import RayCaster
from kinematic_core.worlds.turtle_world import ARENA_SIZE, START, random_start
from plain_support import InvalidInput

pytestmark = pytest.mark.slow

each_task = pytest.mark.parametrize('task', TASKS)
SEEDS = 40
ROUNDING = 1e-9  # [m] of a range
FLOAT32 = 2e-6  # [m or rad] of an observation of a few metres


def make(task):
    return gymnasium.make(f'{environments.NAMESPACE}/{task}-v0').unwrapped


def make_vec(task, number):
    return gymnasium.make_vec(f'{environments.NAMESPACE}/{task}-v0', num_envs=number)


def still(env):
    return np.zeros(env.action_space.shape, np.float32)


@each_task
def test_gymnasium_has_no_objection(task):
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        check_env(make(task))


@each_task
def test_scripted_policy_reaches_every_goal(task):
    envs = make_vec(task, SEEDS)
    observations, _ = envs.reset(seed=0)
    reached, over = np.zeros(SEEDS, bool), np.zeros(SEEDS, bool)
    while not over.all():
        observations, _, terminated, truncated, infos = envs.step(POLICIES[task](observations))
        reached |= infos['is_success'] & ~over
        over |= terminated | truncated
    assert reached.all(), f'seeds {np.flatnonzero(~reached)}'


@each_task
def test_vector_equals_single_environments_also_beyond_their_ends(task, monkeypatch):
    monkeypatch.setitem(TASKS, task, TASKS[task]._replace(time_limit=0.5))
    envs, singles = make_vec(task, 3), SyncVectorEnv([lambda: make(task)] * 3)
    assert np.array_equal(envs.reset(seed=5)[0], singles.reset(seed=5)[0])
    numbers = np.random.default_rng(1)
    ended = np.zeros(3, int)
    for _ in range(200):
        actions = numbers.uniform(-1.0, 1.0, envs.action_space.shape).astype(np.float32)
        ours, theirs = envs.step(actions), singles.step(actions)
        for one, other in zip(ours[:4], theirs[:4]):
            assert np.array_equal(one, other)
        assert np.array_equal(ours[4]['seed'], theirs[4]['seed'])
        ended += ours[3]
    assert ended.min() >= 2


@each_task
def test_same_seed_gives_the_same_episode_and_another_one_another(task):
    env = make(task)
    first, other, again = (env.reset(seed=seed)[0] for seed in (3, 4, 3))
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    drawn = [env.reset()[1]['seed'] for _ in range(3)]
    assert len(set(drawn)) == 3
    env.reset(seed=3)
    assert [env.reset()[1]['seed'] for _ in range(3)] == drawn


def test_turtle_starts_where_the_simulator_puts_it():
    env = make('TurtleGoal')
    for seed, start in ((0, START), (7, random_start(7))):
        env.reset(seed=seed)
        assert env.pose == pytest.approx(start, abs=FLOAT32)


def test_observation_shows_goal_pose_and_reward():
    env = make('RobotontGoal')
    observation, _ = env.reset(seed=1)
    goal = observation[:2].astype(float)  # at the origin, facing +x: the goal's own position
    observation, reward, *_ = env.step(np.array([0.0, 0.0, 1.0]))
    # one step at 1 rad/s turns by 1/120 rad and brings it no nearer
    assert observation[2:POSE] == pytest.approx([0.0, 0.0, 1.0 / 120.0], abs=FLOAT32) and reward == 0.0
    turned = complex(*goal) * complex(math.cos(1.0 / 120.0), -math.sin(1.0 / 120.0))
    assert observation[:2] == pytest.approx([turned.real, turned.imag], abs=FLOAT32)
    env.reset(seed=1)
    away = -goal / np.abs(goal).max()
    _, reward, *_ = env.step(np.array([*away, 0.0]))
    # straight away from the goal for 1/120 s, 0.5 m/s in the faster of the two directions
    assert reward == pytest.approx(-0.5 / 120.0 * float(np.hypot(*away)), abs=FLOAT32)


def test_touching_a_wall_ends_the_episode_without_success():
    env = make('RobotontBetweenWalls')
    env.reset(seed=1)
    terminated, steps = False, 0
    while not terminated:
        _, reward, terminated, truncated, info = env.step(np.array([0.0, 1.0, 0.0]))
        steps += 1
    # the wall is 2 m to the left, the robot's radius is 0.18 m; (2 - 0.18) / (0.5 / 120) = 436.8 steps
    assert steps == 437 and not truncated and not info['is_success']
    assert reward == pytest.approx(-REWARD, abs=0.01)  # [m] of a step


@each_task
def test_time_limit_truncates(task):
    env = make(task)
    env.reset(seed=2)
    steps = 1
    while True:
        _, _, terminated, truncated, _ = env.step(still(env))
        if terminated or truncated:
            break
        steps += 1
    assert truncated and not terminated
    assert steps == round(TASKS[task].time_limit / TASKS[task].dt)


@each_task
def test_actions_are_clipped_and_nan_is_refused(task):
    env = make(task)
    poses = []
    for value in (1.0, 5.0):
        env.reset(seed=3)
        env.step(np.full(env.action_space.shape, value))
        poses.append(env.pose)
    assert poses[0] == poses[1]
    with pytest.raises(InvalidInput, match='nan'):
        env.step(np.full(env.action_space.shape, math.nan))


def test_ranges_are_those_of_the_ray_caster():
    numbers = np.random.default_rng(4)
    angles = np.linspace(-math.pi, math.pi, 16, endpoint=False)
    plans = [gap_plan(gap) for gap in numbers.uniform(-1.2, 1.2, 30)]
    yaws = (*numbers.uniform(-3.0, 3.0, 20), *[0.0] * 10)  # at 0 there are rays along the sides
    poses = np.array([(*numbers.uniform((-0.9, -1.9), (1.8, 1.9)), yaw) for yaw in yaws])
    boxes = np.array([[(box.x, box.y, box.yaw, box.length / 2.0, box.width / 2.0) for box in plan.boxes]
                      for plan in plans])
    found = box_ranges(boxes, poses, angles)
    assert np.isinf(found).any() and np.isfinite(found).mean() > 0.5
    for row, (plan, pose) in enumerate(zip(plans, poses)):
        assert found[row] == pytest.approx(RayCaster(plan, 0.2, angles).ranges(*pose), abs=ROUNDING)


def test_walls_leave_a_gap_and_no_other_way():
    for gap in (-1.2, 0.0, 0.7):
        plan = gap_plan(gap)
        plan.check()
        assert plan.overlaps() == []
        caster = RayCaster(plan, 0.2, np.array([0.0, math.pi / 2.0, -math.pi / 2.0]))
        ahead, left, right = caster.ranges(2.0, gap, 0.0)  # in the middle of the gap, 0.8 m wide
        assert math.isinf(ahead) and (left, right) == pytest.approx((0.4, 0.4), abs=ROUNDING)


def test_goals_of_the_turtle_are_inside_the_arena():
    for seed in range(50):
        episode = TASKS['TurtleGoal'].begin(seed)
        assert all(2.0 <= value <= ARENA_SIZE - 2.0 for value in episode.goal)
        assert math.dist(episode.goal, episode.start[:2]) >= 0.5


def test_page_names_every_task_with_its_figures():
    page = (pathlib.Path(__file__).resolve().parents[5] / 'docs' / 'environments.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| `kinematic_core/(\w+)-v0` \|.*\| ([\d.]+) m \| (\d+) s \|$', page, re.MULTILINE)
    assert {name: (float(reached), float(limit)) for name, reached, limit in rows} == {
        name: (task.reached, task.time_limit) for name, task in TASKS.items()}
    assert all(f'{name}-v0' in environments.__doc__ for name in TASKS)
