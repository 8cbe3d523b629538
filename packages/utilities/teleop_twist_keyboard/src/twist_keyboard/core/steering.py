"""The effect of each key on the velocity."""
import re
from typing import List, NamedTuple

FASTER, SLOWER = 1.1, 0.9  # a key changes a speed by 10 %
HELP_AFTER = 15  # changes of speed, which push the help off the screen


class Velocity(NamedTuple):
    """A velocity in the robot's frame, or a direction, as parts of the speeds: x forward, y to the left, z up [m/s];
    turn to the left [rad/s].
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    turn: float = 0.0


STILL = Velocity()
DIRECTIONS = {
    'u': Velocity(1, turn=1), 'i': Velocity(1), 'o': Velocity(1, turn=-1),
    'j': Velocity(turn=1), 'l': Velocity(turn=-1),
    'm': Velocity(-1, turn=-1), ',': Velocity(-1), '.': Velocity(-1, turn=1),
    'U': Velocity(1, 1), 'I': Velocity(1), 'O': Velocity(1, -1),
    'J': Velocity(0, 1), 'L': Velocity(0, -1),
    'M': Velocity(-1, 1), '<': Velocity(-1), '>': Velocity(-1, -1),
    't': Velocity(z=1), 'b': Velocity(z=-1),
}
SPEEDS = {  # key: (factor of the speed, factor of the turn speed)
    'q': (FASTER, FASTER), 'z': (SLOWER, SLOWER),
    'w': (FASTER, 1.0), 'x': (SLOWER, 1.0),
    'e': (1.0, FASTER), 'c': (1.0, SLOWER),
}
QUIT = '\x03'  # Ctrl-C, where the terminal sends it as a byte
_KEY = re.compile(r'\x1b(?:\[[0-?]*[ -/]*[@-~]|O.)|.', re.DOTALL)

HELP = """
Drive a robot with this terminal; it must have the focus.

   u    i    o      forward and left,  forward,   forward and right
   j    k    l      turn left,         stop,      turn right
   m    ,    .      backward and left, backward,  backward and right

With Shift (or caps lock) a robot that can move sideways does so instead of turning:

   U    I    O
   J    K    L
   M    <    >

t, b : up, down
q, z : both speeds 10 % higher, lower
w, x : only the speed
e, c : only the turn speed
any other key : stop
Ctrl-C : end
"""


def keys_in(text: str) -> List[str]:
    """Return the keys in the text from a terminal; a sequence, such as the one of an arrow key, is one key."""
    return _KEY.findall(text)


class Steering:
    """The velocity that the keys have chosen."""

    def __init__(self, speed: float, turn: float, speed_limit: float, turn_limit: float) -> None:
        """``speed``, ``speed_limit`` [m/s]; ``turn``, ``turn_limit`` [rad/s]."""
        self.direction = STILL
        self._speed, self._turn = speed, turn
        self._speed_limit, self._turn_limit = speed_limit, turn_limit
        self._changes = 0

    @property
    def velocity(self) -> Velocity:
        """Return the velocity to send."""
        x, y, z, turn = self.direction
        return Velocity(x * self._speed, y * self._speed, z * self._speed, turn * self._turn)

    @property
    def speeds(self) -> str:
        """Return the line that says how fast a key makes the robot."""
        return f'currently:\tspeed {self._speed}\tturn {self._turn} '

    def press(self, key: str) -> List[str]:
        """Change direction or speeds by a key; return the lines to print."""
        if key not in SPEEDS:
            self.direction = DIRECTIONS.get(key, STILL)
            return []
        factor, turn_factor = SPEEDS[key]
        self._speed = min(self._speed_limit, self._speed * factor)
        self._turn = min(self._turn_limit, self._turn * turn_factor)
        self._changes += 1
        return [*(['Linear speed limit reached!'] if self._speed == self._speed_limit else []),
                *(['Angular speed limit reached!'] if self._turn == self._turn_limit else []),
                self.speeds, *([HELP] if self._changes % HELP_AFTER == 0 else [])]
