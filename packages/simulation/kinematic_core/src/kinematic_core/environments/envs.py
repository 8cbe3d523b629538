"""The tasks as gymnasium environments, single and vectorised; ``Episodes`` defines observations and rewards."""
import math
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from kinematic_core.environments.episodes import POSE, Episodes
from kinematic_core.environments.tasks import TASKS, Task
from kinematic_core.worlds.floor_plan import FloorPlan
from kinematic_core.worlds.rays import FARTHEST

LARGEST_SEED = 2 ** 31 - 1  # of a drawn seed; the simulators' ``~seed`` accepts it as well


class TaskEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """The environment of a task of TASKS.

    ``reset(seed=N)`` starts where a simulator with ``~seed`` N does; ``info['seed']`` is the seed of the episode,
    ``info['is_success']`` whether the goal is reached.
    """

    metadata: Dict[str, Any] = {'render_modes': []}

    def __init__(self, task: str) -> None:
        """``task`` is a name in TASKS."""
        self._episodes = Episodes(TASKS[task], 1)
        self.observation_space, self.action_space = spaces(TASKS[task])

    @property
    def pose(self) -> Tuple[float, float, float]:
        """Return x, y [m] and heading [rad] in double precision, as a recording of the simulator has them."""
        x, y, heading = self._episodes.poses[0].tolist()
        return x, y, heading

    @property
    def plan(self) -> FloorPlan:
        """Return the FloorPlan of the vehicle's world."""
        return self._episodes.plans[0]

    def reset(self, *, seed: Optional[int] = None,
              options: Optional[Dict[str, Any]] = None) -> Tuple[np.ndarray, Dict[str, Any]]:
        """Start the episode of ``seed``, or a random one. There are no options."""
        super().reset(seed=seed)
        self._episodes.start(0, episode_seed(self.np_random) if seed is None else seed)
        return self._episodes.observations()[0], self._info()

    def step(self, action: np.ndarray) -> Tuple[np.ndarray, float, bool, bool, Dict[str, Any]]:
        """Make one step of the world with a command of ``action`` (commands,), each -1 to 1 of the fastest."""
        reward, terminated, truncated = self._episodes.step(np.asarray(action)[None])
        return (self._episodes.observations()[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]),
                self._info())

    def _info(self) -> Dict[str, Any]:
        return {'seed': int(self._episodes.seeds[0]), 'is_success': bool(self._episodes.reached[0])}


class TaskVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """``num_envs`` episodes of a task of TASKS side by side in one process.

    They equal those of as many TaskEnv in a SyncVectorEnv. An episode that has ended restarts in the next step, which
    ignores its action.
    """

    metadata: Dict[str, Any] = {'render_modes': [], 'autoreset_mode': AutoresetMode.NEXT_STEP}

    def __init__(self, task: str, num_envs: int = 1) -> None:
        """``task`` is a name in TASKS."""
        self.num_envs = num_envs
        self._episodes = Episodes(TASKS[task], num_envs)
        self.single_observation_space, self.single_action_space = spaces(TASKS[task])
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._numbers = [np_random(None)[0] for _ in range(num_envs)]
        self._over = np.zeros(num_envs, bool)

    def reset(self, *, seed: Union[int, Sequence[Optional[int]], None] = None,
              options: Optional[Dict[str, Any]] = None) -> Tuple[np.ndarray, Dict[str, Any]]:
        """Start all episodes: with the seeds ``seed``, ``seed`` + 1, ..., or those in a list; None: a random seed."""
        seeds: List[Optional[int]] = [None] * self.num_envs
        if isinstance(seed, int):
            seeds = [seed + index for index in range(self.num_envs)]
        elif seed is not None:
            seeds = list(seed)
        for index, each in enumerate(seeds):
            if each is not None:
                self._numbers[index] = np_random(each)[0]
            self._episodes.start(index, episode_seed(self._numbers[index]) if each is None else each)
        self._over[:] = False
        return self._episodes.observations(), self._infos()

    def step(self, actions: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Dict[str, Any]]:
        """Make one step of all worlds with ``actions`` (num_envs, commands), each -1 to 1 of the fastest."""
        over = np.flatnonzero(self._over)
        rewards, terminated, truncated = self._episodes.step(np.asarray(actions))
        for index in over.tolist():
            self._episodes.start(index, episode_seed(self._numbers[index]))
        rewards[over], terminated[over], truncated[over] = 0.0, False, False
        self._over = terminated | truncated
        return self._episodes.observations(), rewards, terminated, truncated, self._infos()

    def _infos(self) -> Dict[str, Any]:
        everyone = np.ones(self.num_envs, bool)
        return {'seed': self._episodes.seeds.copy(), '_seed': everyone,
                'is_success': self._episodes.reached.copy(), '_is_success': everyone}


def spaces(task: Task) -> Tuple[Box, Box]:
    """Return the spaces of the observations and of the actions of one environment."""
    low = np.array([-FARTHEST] * 4 + [-math.pi] + [0.0] * task.rays, np.float32)
    high = np.array([FARTHEST] * 4 + [math.pi] + [FARTHEST] * task.rays, np.float32)
    assert len(low) == POSE + task.rays
    return Box(low, high), Box(-1.0, 1.0, (len(task.fastest),))


def episode_seed(numbers: np.random.Generator) -> int:
    """Return the seed of the next episode."""
    return int(numbers.integers(LARGEST_SEED, endpoint=True))
