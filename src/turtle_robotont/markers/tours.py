"""Drive from one AR marker to the next, using only the camera: turn until it is seen, face it, approach it. ROS-free.

``see`` takes the tracker's messages, ``step(dt)`` returns commands, as those of the Follower, which does the approach.
"""
import enum
import math
from typing import List, NamedTuple, Optional, Sequence

from turtle_robotont.driving.following import TURN_GAIN, Follower, Settings
from turtle_robotont.driving.following import State as Following
from turtle_robotont.driving.vehicle import STOP, Twist2D
from turtle_robotont.markers.sightings import Sighting

FRESH = 0.3  # [s] a marker seen within this time is in view: two messages of a tracker at 8 Hz
AHEAD = 0.2  # [rad] from the marker's direction: small enough to drive while turning the rest
FACING = 0.05  # [rad] at smaller bearings the robot faces the marker
NEAR = 0.05  # [m] a marker counts as reached within this of the distance
MAX_TURNS = 2.0  # full turns without seeing the marker, after which the tour gives up


class State(enum.Enum):
    """The state of a Tour."""

    SEARCHING = 'turning to find'
    FACING = 'turning towards'
    APPROACHING = 'approaching'
    DONE = 'done'
    FAILED = 'failed'


class Visit(NamedTuple):
    """A marker that was reached, and the distance [m] at which it was."""

    marker_id: int
    distance: float


class Tour:
    """Visits markers one after the other; ``state``, the text ``status`` and ``reached`` tell the progress."""

    def __init__(self, markers: Sequence[int], settings: Optional[Settings] = None, search_speed: float = 1.0) -> None:
        """``markers``: their ids in order; ``search_speed`` [rad/s], positive: to the left."""
        self._remaining = list(markers)
        self._settings = settings or Settings(distance=1.0)
        self._search_speed = search_speed
        self.reached: List[Visit] = []
        self._unheard = math.inf  # [s] since the tracker sent any message
        self._start_search(search_speed)

    @property
    def finished(self) -> bool:
        """Return whether it has ended, successfully or not."""
        return self.state in (State.DONE, State.FAILED)

    @property
    def marker_id(self) -> int:
        """Return the id of the marker that it is heading for, the last one at the end."""
        return self._remaining[0] if self._remaining else self.reached[-1].marker_id

    @property
    def status(self) -> str:
        """Return a text about the state."""
        if self.state is State.DONE:
            return 'visited the markers ' + ', '.join(f'{visit.marker_id} ({visit.distance:.2f} m)'
                                                      for visit in self.reached)
        if self.state is State.FAILED:
            return (f'marker {self.marker_id} was not found in {MAX_TURNS:g} turns; check that it is there and lit, '
                    'and ~marker_size of the tracker')
        if self._silent:
            return 'waiting: the tracker publishes nothing'
        return f'{self.state.value} marker {self.marker_id}'

    def see(self, sightings: Sequence[Sighting]) -> None:
        """Process all Sightings of one message, if any."""
        self._unheard = 0.0
        self._follower.see(sightings)
        if self._follower.marker_id in [sighting.id for sighting in sightings]:
            self._unseen = 0.0

    def step(self, dt: float) -> Twist2D:
        """Return the command after another ``dt`` [s]."""
        self._unheard += dt
        self._unseen += dt
        if self.finished or self._silent:
            return STOP
        seen = self._follower.sighting
        if self.state is State.SEARCHING or seen is None:
            return self._search(dt)
        if self.state is State.FACING:
            return self._face(seen.bearing)
        return self._approach(seen, dt)

    @property
    def _silent(self) -> bool:
        return self._unheard > self._settings.lost_after

    def _start_search(self, angular_z: float) -> None:
        self.state = State.SEARCHING
        self._follower = Follower(self._remaining[0], self._settings)
        self._search_angular_z = angular_z  # [rad/s]
        self._unseen, self._turned = math.inf, 0.0  # [s] since the marker was seen, [rad] turned since the start

    def _search_again(self, bearing: float) -> Twist2D:
        """Search towards the side on which the marker was last seen."""
        self._start_search(math.copysign(self._search_speed, bearing))
        return STOP

    def _search(self, dt: float) -> Twist2D:
        if self._unseen < FRESH:
            self.state = State.FACING
            return STOP
        command = self._settings.limits.apply(Twist2D(angular_z=self._search_angular_z))
        self._turned += abs(command.angular_z) * dt
        if self._turned > MAX_TURNS * 2.0 * math.pi:
            self.state = State.FAILED
            return STOP
        return command

    def _face(self, bearing: float) -> Twist2D:
        if self._unseen > self._settings.lost_after:
            return self._search_again(bearing)
        if abs(bearing) < AHEAD:
            self.state = State.APPROACHING
        return self._settings.limits.apply(Twist2D(angular_z=TURN_GAIN * bearing))

    def _approach(self, seen: Sighting, dt: float) -> Twist2D:
        command = self._follower.step(dt)
        if self._follower.state is Following.LOST or command is None:
            return self._search_again(seen.bearing)
        if abs(seen.distance - self._settings.distance) > NEAR or abs(seen.bearing) > FACING:
            return command
        self.reached.append(Visit(self._remaining.pop(0), seen.distance))
        if self._remaining:
            self._start_search(self._search_speed)
        else:
            self.state = State.DONE
        return STOP
