"""Gymnasium environments of the turtle and of the Robotont, stepped by the same worlds as the simulators.

``import kinematic_core.environments`` registers them; ``gymnasium.make`` makes one, ``gymnasium.make_vec`` many::

    env = gymnasium.make('kinematic_core/RobotontGoal-v0')
    envs = gymnasium.make_vec('kinematic_core/RobotontGoal-v0', num_envs=64)

=========================  ============================================================================
id (kinematic_core/...)    task
=========================  ============================================================================
TurtleGoal-v0              drive turtle1 to a random position
RobotontGoal-v0            drive a Robotont to a random position in the empty world
RobotontBetweenWalls-v0    drive a Robotont through a random gap between two walls, without touching them
=========================  ============================================================================

Needs gymnasium: ``pip install ./packages/support/plain_support './packages/simulation/kinematic_core[gymnasium]'``.
docs/environments.md describes actions, observations and rewards.
"""
import gymnasium

from kinematic_core.environments.tasks import TASKS

NAMESPACE = 'kinematic_core'

for _name in TASKS:
    gymnasium.register(f'{NAMESPACE}/{_name}-v0', entry_point='kinematic_core.environments.envs:TaskEnv',
                       vector_entry_point='kinematic_core.environments.envs:TaskVectorEnv', kwargs={'task': _name})
