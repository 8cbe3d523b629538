"""Scripted policies that solve the tasks: functions of an observation, or of a batch of them, that return the action.

They show what the numbers of an observation mean, and are a baseline for learned policies.
"""
import numpy as np

from kinematic_core.environments.tasks import WALL_X

SLOW_DOWN = 0.3  # [m] distance from the goal at which a policy starts to brake
IN_FRONT = 0.6  # [m] before the walls, where the robot stops until it is in front of the gap
ALIGNED = 0.1  # [m] sideways that count as in front of the gap


def turtle_goal(observation: np.ndarray) -> np.ndarray:
    """Turn towards the goal, and drive as fast as that direction allows."""
    ahead, left = observation[..., 0], observation[..., 1]
    bearing = np.arctan2(left, ahead)
    speed = np.minimum(1.0, np.hypot(ahead, left) / SLOW_DOWN) * np.maximum(0.0, np.cos(bearing))
    return np.stack([speed, np.clip(2.0 * bearing, -1.0, 1.0)], axis=-1)


def robotont_goal(observation: np.ndarray) -> np.ndarray:
    """Drive straight to the goal, sideways if necessary."""
    ahead, left = observation[..., 0], observation[..., 1]
    distance = np.maximum(np.hypot(ahead, left), 1e-9)
    speed = np.minimum(1.0, distance / SLOW_DOWN) / distance
    return np.stack([ahead * speed, left * speed, np.zeros_like(ahead)], axis=-1)


def robotont_between_walls(observation: np.ndarray) -> np.ndarray:
    """Drive to the goal, but only sideways while the walls are near and the goal is not straight ahead."""
    action = robotont_goal(observation)
    waits = (np.abs(observation[..., 1]) > ALIGNED) & (np.abs(observation[..., 2] - WALL_X) < IN_FRONT)
    action[..., 0] = np.where(waits, 0.0, action[..., 0])
    action[..., 1] = np.where(waits, np.sign(observation[..., 1]), action[..., 1])
    return action


POLICIES = {'TurtleGoal': turtle_goal, 'RobotontGoal': robotont_goal, 'RobotontBetweenWalls': robotont_between_walls}
