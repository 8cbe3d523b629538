"""A turtle of the simulated world that obeys a Drive, with the delay that topics have."""
import collections

import pytest

from kinematic_core.worlds.turtle_world import DT, TurtleWorld
from turtle_robotont.driving.control import STOP

TIME_LIMIT = 120.0  # [s] of turtle time that no drive of these tests takes


class Loop:
    """Closes the loop between a Drive and one turtle of a TurtleWorld.

    ``delay``: after so many further poses a command shows; ``missed``: so many poses are lost before each one seen.
    """

    def __init__(self, start=(5.5, 5.5, 0.0), delay=2, missed=0):
        self.world = TurtleWorld()
        self.world.kill('turtle1')
        self.world.spawn(*start, 'turtle1')
        self.delay, self.missed = delay, missed
        self.track, self.commands, self.states = [], [], []
        self.time = 0.0

    @property
    def pose(self):
        """Return the turtle's pose."""
        return self.world.turtles['turtle1'].pose()

    def run(self, drive, disturb=lambda loop: None):
        """Drive to the end and three poses beyond; ``disturb(loop)`` is called before every step of the world."""
        on_the_way = collections.deque([STOP] * self.delay)
        while not drive.finished:
            assert self.time < TIME_LIMIT
            for _ in range(1 + self.missed):
                disturb(self)
                self._step()
            self.commands.append(drive.step(self.pose, DT * (1 + self.missed)))
            self.states.append(drive.state)
            on_the_way.append(self.commands[-1])
            self._command(on_the_way.popleft())
        for command in (*on_the_way, STOP, STOP, STOP):
            self._command(command)
            self._step()
        return self

    def _step(self):
        self.world.step()
        self.time += DT
        self.track.append(self.pose)

    def _command(self, command):
        self.world.command('turtle1', command.linear_x, command.linear_y, command.angular_z)


@pytest.fixture
def loop():
    """The class Loop, to be made with a start, delay and missed poses."""
    return Loop
