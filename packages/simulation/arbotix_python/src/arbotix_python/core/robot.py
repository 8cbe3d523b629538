"""A base and joints that follow their commands at once or at a limited speed. No ROS."""
import math
from typing import Any, Dict, List, Mapping, Tuple

from kinematic_core.worlds.planar import Pose2D, Twist2D, advance

FASTEST_JOINT = 684.0  # [deg/s] of the servo AX-12 at 12 V, 114 rpm
WIDEST = 150.0  # [deg] from the middle of the servo AX-12
TIMEOUT = 0.5  # [s] after the last command until the base stops
BASE, TRAJECTORY = 'diff_controller', 'follow_controller'  # types of controllers


class Base:
    """A differential base: it has the velocity of its last command until ``timeout`` [s] after it."""

    def __init__(self, timeout: float = TIMEOUT) -> None:
        self.pose, self.twist = Pose2D(0.0, 0.0, 0.0), Twist2D(0.0, 0.0, 0.0)
        self._timeout, self._left = timeout, 0.0

    def command(self, linear: float, angular: float) -> None:
        """Drive with these velocities [m/s, rad/s] from now on."""
        self.twist, self._left = Twist2D(linear, 0.0, angular), self._timeout

    def step(self, dt: float) -> None:
        """Let ``dt`` [s] pass."""
        driven = min(dt, self._left)
        self.pose = advance(self.pose, self.twist, driven)
        self._left -= driven
        if not self._left:
            self.twist = Twist2D(0.0, 0.0, 0.0)


class Joint:
    """A servo: it turns to its goal at its highest speed, within its range."""

    def __init__(self, settings: Mapping[str, Any]) -> None:
        """Read ``min_angle``, ``max_angle`` [deg] and ``max_speed`` [deg/s]; raise ValueError."""
        low, high, speed = (_number(settings, *each) for each in (
            ('min_angle', -WIDEST), ('max_angle', WIDEST), ('max_speed', FASTEST_JOINT)))
        if low > high or speed <= 0.0:
            raise ValueError(f'min_angle {low:g}, max_angle {high:g}, max_speed {speed:g}: the first angle must not be '
                             'above the second one, and the speed must be positive')
        self._low, self._high, self._speed = math.radians(low), math.radians(high), math.radians(speed)
        self.angle = self.goal = min(max(0.0, self._low), self._high)
        self.speed = 0.0

    def command(self, angle: float) -> bool:
        """Take a goal [rad], limited to the range; return whether it was within."""
        self.goal = min(max(angle, self._low), self._high)
        return self.goal == angle

    def step(self, dt: float) -> None:
        """Let ``dt`` [s] pass."""
        change = min(max(self.goal - self.angle, -self._speed * dt), self._speed * dt)
        self.angle, self.speed = self.angle + change, change / dt


def _number(settings: Mapping[str, Any], name: str, default: float) -> float:
    value = settings.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f'{name} is {value!r}, must be a number')
    return float(value)


def split(controllers: Mapping[str, Any]) -> Tuple[Dict[str, Mapping[str, Any]], List[str]]:
    """Return the controllers of bases, and the names of the others; raise ValueError for what is no table."""
    for name, settings in controllers.items():
        if not isinstance(settings, dict):
            raise ValueError(f'the controller {name} is {settings!r}, must be a table with a type')
    bases = {name: settings for name, settings in controllers.items() if settings.get('type') == BASE}
    return bases, sorted(set(controllers) - set(bases))
