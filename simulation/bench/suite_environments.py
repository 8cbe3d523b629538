"""The bench of the Gymnasium environments: steps per second of one core, for many in one process and for one alone.

A step is one of the world (turtle 16 ms, Robotont 1/120 s) with command, observation and reward. Actions are random;
an episode that ends is reset.
"""
import time

import gymnasium
import numpy as np

from figures import Figure, Target, median
from kinematic_core.environments import NAMESPACE
from kinematic_core.environments.tasks import TASKS
from session import FULL, QUICK, Measurement

NEEDS_NODE = False
TOGETHER = 256  # environments
ACTIONS = 64  # different ones, one after the other
WORDS = {'TurtleGoal': 'turtle to a goal', 'RobotontGoal': 'Robotont to a goal',
         'RobotontBetweenWalls': 'Robotont between walls, 16 rays'}

__all__ = ['FIGURES', 'FULL', 'MEASUREMENTS', 'NEEDS_NODE', 'QUICK']


def steps_per_second(env, number, seconds, over):
    """Steps a second of processor time of ``number`` environments; ``over(result)``: whether to reset them."""
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(ACTIONS)]
    steps, begun = 0, time.process_time()
    while time.process_time() - begun < seconds:
        for action in actions:
            if over(env.step(action)):
                env.reset()
        steps += number * ACTIONS
    return steps / (time.process_time() - begun)


def measure(task):
    """The measurement of a task."""
    def run(_subject, scale):
        name, seconds = f'{NAMESPACE}/{task}-v0', scale.window / 2.5
        envs, env = gymnasium.make_vec(name, num_envs=TOGETHER), gymnasium.make(name)
        return {f'{task}_together': [steps_per_second(envs, TOGETHER, seconds, lambda result: False)],
                f'{task}_alone': [steps_per_second(env, 1, seconds, lambda result: np.any(result[2:4]))]}
    return run


MEASUREMENTS = {task: Measurement(measure(task), WORDS[task], in_process=True) for task in TASKS}

FIGURES = tuple(figure for task in TASKS for figure in (
    Figure(f'{WORDS[task]}, {TOGETHER} together', f'{task}_together', 'steps/s of a core', median,
           Target('at_least', 100_000.0)),
    Figure(f'{WORDS[task]}, alone', f'{task}_alone', 'steps/s of a core')))
