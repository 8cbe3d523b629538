"""From one AR marker to the next by camera alone: turn until it is seen, face it, go up to it. ROS-free.

``see`` what the tracker says, ``step(dt)`` says what to do, as with the Follower that does the going.
"""
import enum
import math

from turtle_robotont.follow import TURN_GAIN, Follower, Settings
from turtle_robotont.follow import State as Following
from turtle_robotont.vehicle import STOP, Command

FRESH = 0.3  # [s] a marker seen that long ago is in view: two messages of a tracker at 8 Hz
AHEAD = 0.2  # [rad] off the marker is enough ahead to drive while turning the rest
FACING = 0.05  # [rad] off counts as facing the marker
NEAR = 0.05  # [m] off the distance counts as there
MOST_TURNS = 2.0  # full turns without seeing the marker: it cannot be seen from here


class State(enum.Enum):
    """What a Tour is doing."""

    SEARCHING = 'turning to find'
    FACING = 'turning towards'
    APPROACHING = 'going up to'
    DONE = 'done'
    FAILED = 'failed'


class Tour:
    """Goes up to markers one after the other; ``state``, ``status`` (a text) and ``reached`` say how far it is."""

    def __init__(self, markers, settings=None, search_speed=1.0):
        """``markers``: their ids in order; ``search_speed`` [rad/s], positive: to the left."""
        self._rest = list(markers)
        self._settings = settings or Settings(distance=1.0)
        self._search_speed = search_speed
        self.reached = []  # (id, distance [m]) of each marker that it has been at
        self._unheard = math.inf  # [s] since the tracker said anything
        self._start_search(search_speed)

    @property
    def finished(self):
        """Return whether it has ended, well or not."""
        return self.state in (State.DONE, State.FAILED)

    @property
    def marker_id(self):
        """Return the id of the marker that it is after, the last one at the end."""
        return self._rest[0] if self._rest else self.reached[-1][0]

    @property
    def status(self):
        """Return what it is doing as a text."""
        if self.state is State.DONE:
            return 'been at the markers ' + ', '.join(f'{marker} ({distance:.2f} m)'
                                                      for marker, distance in self.reached)
        if self.state is State.FAILED:
            return (f'marker {self.marker_id} was not seen in {MOST_TURNS:g} turns; is it there, is it lit, is '
                    '~marker_size of the tracker right?')
        if self._silent:
            return 'waiting: the tracker is silent'
        return f'{self.state.value} marker {self.marker_id}'

    def see(self, sightings):
        """Take all Sightings of one message, which may be none."""
        self._unheard = 0.0
        self._follower.see(sightings)
        if self._follower.marker_id in [sighting.id for sighting in sightings]:
            self._unseen = 0.0

    def step(self, dt):
        """Return the Command after dt [s] more."""
        self._unheard += dt
        self._unseen += dt
        if self.finished or self._silent:
            return STOP
        if self.state is State.SEARCHING:
            return self._search(dt)
        if self.state is State.FACING:
            return self._face()
        return self._approach(dt)

    @property
    def _silent(self):
        return self._unheard > self._settings.lost_after

    @property
    def _bearing(self):
        return self._follower.sighting.bearing

    def _start_search(self, speed):
        self.state = State.SEARCHING
        self._follower = Follower(self._rest[0], self._settings)
        self._unseen, self._turned, self._turning = math.inf, 0.0, speed

    def _search(self, dt):
        if self._unseen < FRESH:
            self.state = State.FACING
            return STOP
        command = self._settings.limits.apply(Command(0.0, self._turning))
        self._turned += abs(command.angular) * dt
        if self._turned > MOST_TURNS * 2.0 * math.pi:
            self.state = State.FAILED
            return STOP
        return command

    def _face(self):
        if self._unseen > self._settings.lost_after:
            self._start_search(math.copysign(self._search_speed, self._bearing))
            return STOP
        if abs(self._bearing) < AHEAD:
            self.state = State.APPROACHING
        return self._settings.limits.apply(Command(0.0, TURN_GAIN * self._bearing))

    def _approach(self, dt):
        command = self._follower.step(dt)
        if self._follower.state is Following.LOST:
            self._start_search(math.copysign(self._search_speed, self._bearing))
            return STOP
        distance = self._follower.sighting.distance
        if abs(distance - self._settings.distance) > NEAR or abs(self._bearing) > FACING:
            return command
        self.reached.append((self._rest.pop(0), distance))
        if self._rest:
            self._start_search(self._search_speed)
        else:
            self.state = State.DONE
        return STOP
