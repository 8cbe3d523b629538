"""Following one AR marker at a distance: ``see`` what the tracker says, ``step(dt)`` says what to do. ROS-free.

The marker may be where it was for ``lost_after``; then the robot is told once to stop, and nothing more until the
marker is seen again, so that others can drive it. Neither a clock nor a pose of the robot is needed.
"""
import enum
import math
from typing import NamedTuple

from turtle_robotont.vehicle import ROBOT, STOP, Command, Limits

GAIN = 1.2  # [1/s] speed for each metre off; a tracker at 8 Hz answers after 0.2 s, which this leaves room for
TURN_GAIN = 1.5  # [1/s] turning speed for each radian off
TURN_FIRST = 0.6  # [rad] further aside than this the robot only turns
CLOSE_ENOUGH = 0.01  # [m] or [rad] off: not worth moving
ACCELERATION, TURN_ACCELERATION = ROBOT.acceleration, ROBOT.turn_deceleration  # [m/s^2], [rad/s^2]


class State(enum.Enum):
    """What a Follower is doing."""

    WAITING = 'waiting for it to be seen'
    FOLLOWING = 'following'
    LOST = 'lost'


class Settings(NamedTuple):
    """How to follow: distance [m] to keep; strafe: sideways instead of turning; lost_after [s]; top speeds."""

    distance: float = 0.5
    strafe: bool = False
    lost_after: float = 0.5
    limits: Limits = ROBOT.limits


class Follower:
    """Follows the marker with one id; ``state`` and ``status``, a text, say what it is doing."""

    def __init__(self, marker_id, settings=None):
        self.marker_id, self.settings = marker_id, settings or Settings()
        self.state = State.WAITING
        self.sighting = None  # the last one of the marker
        self._unseen = self._unheard = 0.0  # [s] since then, and since the tracker said anything
        self._command = STOP

    def see(self, sightings):
        """Take all Sightings of one message, which may be none; of two with the id that it follows the nearest."""
        self._unheard = 0.0
        mine = [sighting for sighting in sightings if sighting.id == self.marker_id]
        if mine:
            self.sighting, self._unseen = min(mine, key=lambda sighting: sighting.distance), 0.0
            self.state = State.FOLLOWING

    def step(self, dt):
        """Return the Command after dt [s] more, or None when there is nothing to say."""
        self._unseen += dt
        self._unheard += dt
        if self.state is not State.FOLLOWING:
            return None
        if self._unseen > self.settings.lost_after:
            self.state, self._command = State.LOST, STOP
            return STOP
        self._command = self.settings.limits.apply(_gently(self._command, self._wanted(), dt))
        return self._command

    @property
    def status(self):
        """Return what it is doing as a text."""
        if self.state is State.LOST:
            why = 'the tracker is silent' if self._unheard > self.settings.lost_after else 'not in view'
            return f'marker {self.marker_id} lost for {self.settings.lost_after:g} s ({why}): stopped'
        if self.state is State.WAITING:
            return f'waiting for marker {self.marker_id}'
        return f'following marker {self.marker_id} at {self.settings.distance:g} m'

    def _wanted(self):
        """Return the Command that leads to the place in front of the marker."""
        seen, settings = self.sighting, self.settings
        if settings.strafe:
            return Command(GAIN * _worth(seen.ahead - settings.distance), 0.0, GAIN * _worth(seen.left))
        facing = max(0.0, 1.0 - abs(seen.bearing) / TURN_FIRST)
        return Command(GAIN * facing * _worth(seen.distance - settings.distance), TURN_GAIN * _worth(seen.bearing))


def _worth(error):
    return error if abs(error) > CLOSE_ENOUGH else 0.0


def _gently(now, wanted, dt):
    """Return the Command on the way from ``now`` to ``wanted`` that is reached within dt [s]."""
    dx, dy = wanted.linear - now.linear, wanted.lateral - now.lateral
    share = min(1.0, ACCELERATION * dt / max(math.hypot(dx, dy), 1e-9))
    turn = max(-TURN_ACCELERATION * dt, min(TURN_ACCELERATION * dt, wanted.angular - now.angular))
    return Command(now.linear + share * dx, now.angular + turn, now.lateral + share * dy)
