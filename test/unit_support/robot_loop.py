"""An omnidirectional robot on ideal odometry, with the delay and the acceleration that a real base has."""
import collections
import math

from kinematic_core.worlds.planar import Twist2D
from turtle_robotont.driving.vehicle import STOP, VehicleState
from turtle_robotont.markers.sightings import Sighting

STEP = 0.01  # [s] of the simulation
ODOMETRY_STEPS = 3  # steps between two messages of odometry: 33 Hz
ACCELERATION, TURN_ACCELERATION = 2.0, 8.0  # [m/s^2], [rad/s^2] of the base
TIME_LIMIT = 120.0  # [s] that no drive of these tests takes


class Robot:
    """A body that follows commands ``delay`` steps late; x, y [m], theta [rad] in odom."""

    def __init__(self, start=(0.0, 0.0, 0.0), delay=5):
        self.x, self.y, self.theta = start
        self.velocity, self.time = STOP, 0.0
        self._on_the_way = collections.deque([STOP] * delay)
        self._wanted = STOP

    @property
    def pose(self):
        """Return the pose by odometry."""
        return VehicleState(self.x, self.y, self.theta, math.hypot(self.velocity.linear_x, self.velocity.linear_y),
                            self.velocity.angular_z)

    def command(self, command):
        """Take a velocity, which counts from now on."""
        self._wanted = command

    def step(self):
        """Move on by STEP."""
        self._on_the_way.append(self._wanted)
        wanted = self._on_the_way.popleft()
        limits = Twist2D(ACCELERATION * STEP, ACCELERATION * STEP, TURN_ACCELERATION * STEP)
        self.velocity = Twist2D(*(now + max(-limit, min(limit, goal - now))
                                  for now, goal, limit in zip(self.velocity, wanted, limits)))
        heading = self.theta + self.velocity.angular_z * STEP / 2.0
        ahead, left = self.velocity.linear_x * STEP, self.velocity.linear_y * STEP
        self.x += ahead * math.cos(heading) - left * math.sin(heading)
        self.y += ahead * math.sin(heading) + left * math.cos(heading)
        self.theta += self.velocity.angular_z * STEP
        self.time += STEP

    def seen_from(self, x, y):
        """Return where a point of odom lies: (ahead, left) [m] of the robot."""
        dx, dy = x - self.x, y - self.y
        return (dx * math.cos(self.theta) + dy * math.sin(self.theta),
                dy * math.cos(self.theta) - dx * math.sin(self.theta))


def drive(robot, drive, disturb=lambda robot: None):
    """Let a Drive drive the robot to its end, ``disturb(robot)`` before each step; return (track, commands)."""
    track, commands = [robot.pose], []
    while not drive.finished:
        assert robot.time < TIME_LIMIT, drive.state
        commands.append(drive.step(robot.pose, ODOMETRY_STEPS * STEP))
        robot.command(commands[-1])
        for _ in range(ODOMETRY_STEPS):
            disturb(robot)
            robot.step()
        track.append(robot.pose)
    for _ in range(30):
        robot.command(STOP)
        robot.step()
        track.append(robot.pose)
    return track, commands


def path_deviation(track, corners):
    """Return the largest distance [m] of a track from the lines that join the corners one after the other."""
    def off(pose, a, b):
        length = math.dist((a.x, a.y), (b.x, b.y))
        if length == 0.0:
            return math.dist((pose.x, pose.y), (a.x, a.y))
        along = ((pose.x - a.x) * (b.x - a.x) + (pose.y - a.y) * (b.y - a.y)) / length
        share = max(0.0, min(length, along)) / length
        return math.hypot(a.x + share * (b.x - a.x) - pose.x, a.y + share * (b.y - a.y) - pose.y)
    return max(min(off(pose, a, b) for a, b in zip(corners, corners[1:])) for pose in track)


class Camera:
    """A tracker on a robot: ``period`` steps between pictures, ``delay`` steps from a picture to its message."""

    def __init__(self, robot, markers, period=12, delay=10):
        self.robot, self.markers, self.period, self.delay = robot, markers, period, delay
        self._coming, self._steps = [], 0

    def step(self):
        """Return the Sightings of a message that arrives now, or None."""
        if self._steps % self.period == 0:
            seen = [Sighting(number, *self.robot.seen_from(*place), 0.0) for number, place in self.markers.items()]
            self._coming.append((self._steps + self.delay, [one for one in seen if abs(one.bearing) < 0.7]))
        self._steps += 1
        if self._coming and self._coming[0][0] < self._steps:
            return self._coming.pop(0)[1]
        return None
