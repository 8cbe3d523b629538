"""The bench of the Gymnasium environments: steps per second of one core, many in one process.

A step is one of the world (turtle 16 ms, Robotont 1/120 s) with command, observation and reward. Actions are random.
"""
import time

import gymnasium

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


def measure(task):
    """The measurement of a task."""
    def run(_subject, scale):
        envs = gymnasium.make_vec(f'{NAMESPACE}/{task}-v0', num_envs=TOGETHER)
        envs.reset(seed=0)
        envs.action_space.seed(0)
        actions = [envs.action_space.sample() for _ in range(ACTIONS)]
        steps, begun = 0, time.process_time()
        while time.process_time() - begun < scale.window / 2.5:
            for action in actions:
                envs.step(action)
            steps += TOGETHER * ACTIONS
        return {f'{task}_together': [steps / (time.process_time() - begun)]}
    return run


MEASUREMENTS = {task: Measurement(measure(task), WORDS[task], in_process=True) for task in TASKS}
FIGURES = tuple(Figure(f'{WORDS[task]}, {TOGETHER} together', f'{task}_together', 'steps/s of a core', median,
                       Target('at_least', 100_000.0)) for task in TASKS)
