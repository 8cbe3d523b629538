"""Follow one AR marker at a distance: ``see`` takes the tracker's messages, ``step(dt)`` returns commands. ROS-free.

When the marker is not seen, its last position counts for ``lost_after``. Then the Follower returns one command to stop,
and no more until it sees the marker again, so that other nodes can drive the robot. It needs neither a clock nor a pose
of the robot.
"""
import enum
import math
from typing import NamedTuple, Optional, Sequence

from turtle_robotont.driving.vehicle import ROBOT, STOP, Limits, Twist2D
from turtle_robotont.markers.sightings import Sighting

GAIN = 1.2  # [1/s] speed per metre of error; low enough for the delay of 0.2 s of a tracker at 8 Hz
TURN_GAIN = 1.5  # [1/s] angular velocity per radian of error
TURN_FIRST = 0.6  # [rad] at larger bearings the robot only turns
ADVISE_AFTER = 10.0  # [s] without the marker, after which the status says what to do
DEAD_BAND = 0.01  # [m] or [rad] errors below this are not corrected
ACCELERATION, TURN_ACCELERATION = ROBOT.acceleration, ROBOT.turn_deceleration  # [m/s^2], [rad/s^2]


class State(enum.Enum):
    """The state of a Follower."""

    WAITING = 'waiting for the marker'
    FOLLOWING = 'following'
    LOST = 'lost'


class Settings(NamedTuple):
    """How to follow: distance [m] to keep; strafe: sideways instead of turning; lost_after [s]; top speeds."""

    distance: float = 0.5
    strafe: bool = False
    lost_after: float = 0.5
    limits: Limits = ROBOT.limits


class Follower:
    """Follows the marker with one id; ``state`` and the text ``status`` describe its progress."""

    def __init__(self, marker_id: int, settings: Optional[Settings] = None) -> None:
        self.marker_id, self.settings = marker_id, settings or Settings()
        self.state = State.WAITING
        self.sighting: Optional[Sighting] = None  # the last Sighting of the marker
        self._unseen = self._unheard = 0.0  # [s] of steps since that sighting, and since any message of the tracker
        self._seen = self._heard = False  # since the last step
        self._command = STOP

    def see(self, sightings: Sequence[Sighting]) -> None:
        """Process all Sightings of one message, if any; of several with the followed id, the nearest counts."""
        self._heard = True
        followed = [sighting for sighting in sightings if sighting.id == self.marker_id]
        if followed:
            self.sighting, self._seen = min(followed, key=lambda sighting: sighting.distance), True
            self.state = State.FOLLOWING

    def step(self, dt: float) -> Optional[Twist2D]:
        """Return the command after another ``dt`` [s], or None if there is nothing to send.

        A marker that was seen since the step before counts as seen now, so that a slow loop follows it, too.
        """
        self._unseen = 0.0 if self._seen else self._unseen + dt
        self._unheard = 0.0 if self._heard else self._unheard + dt
        self._seen = self._heard = False
        if self.state is not State.FOLLOWING or self.sighting is None:
            return None
        if self._unseen > self.settings.lost_after:
            self.state, self._command = State.LOST, STOP
            return STOP
        target = self._target(self.sighting)
        self._command = self.settings.limits.apply(_accelerated(self._command, target, dt))
        return self._command

    @property
    def status(self) -> str:
        """Return a text about the state; if the marker stays out of view, it also says what to do."""
        if self.state is not State.FOLLOWING and self._unseen > ADVISE_AFTER >= self._unheard:
            return (f'marker {self.marker_id} has not been in view for {ADVISE_AFTER:g} s, and this node does not '
                    'search for it; turn the robot until it is (rostopic pub -r 10 /cmd_vel geometry_msgs/Twist '
                    "'{angular: {z: 0.3}}'), or use ar_maze.py, which searches")
        if self.state is State.LOST:
            why = 'the tracker publishes nothing' if self._unheard > self.settings.lost_after else 'not in view'
            return f'marker {self.marker_id} lost for {self.settings.lost_after:g} s ({why}): stopped'
        if self.state is State.WAITING:
            return f'waiting for marker {self.marker_id}'
        return f'following marker {self.marker_id} at {self.settings.distance:g} m'

    def _target(self, seen: Sighting) -> Twist2D:
        """Return the command that leads to the position in front of the marker."""
        settings = self.settings
        if settings.strafe:
            return Twist2D(GAIN * _outside_dead_band(seen.ahead - settings.distance),
                           GAIN * _outside_dead_band(seen.left))
        facing = max(0.0, 1.0 - abs(seen.bearing) / TURN_FIRST)
        return Twist2D(linear_x=GAIN * facing * _outside_dead_band(seen.distance - settings.distance),
                       angular_z=TURN_GAIN * _outside_dead_band(seen.bearing))


def _outside_dead_band(error: float) -> float:
    return error if abs(error) > DEAD_BAND else 0.0


def _accelerated(now: Twist2D, target: Twist2D, dt: float) -> Twist2D:
    """Return the command between ``now`` and ``target`` that the accelerations allow within dt [s]."""
    dx, dy = target.linear_x - now.linear_x, target.linear_y - now.linear_y
    share = min(1.0, ACCELERATION * dt / max(math.hypot(dx, dy), 1e-9))
    turn = max(-TURN_ACCELERATION * dt, min(TURN_ACCELERATION * dt, target.angular_z - now.angular_z))
    return Twist2D(now.linear_x + share * dx, now.linear_y + share * dy, now.angular_z + turn)
