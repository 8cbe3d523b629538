"""draw_square's driving, against turtlesim's motion with the delay that topics have."""
import math

import pytest
from geometry_msgs.msg import Twist, Vector3

from kinematic_core.worlds.planar import STILL, Twist2D
from turtlesim.draw_square import SPEED, TURN_SPEED, SquareDriver, approach, square_corners, to_twist

DT = 0.016  # [s]
MIDDLE = 5.54444456  # [m]
SIDE = 2.0  # [m]
CORNER_TOLERANCE = 0.01  # [m] 1 cm, a tenth of turtlesim's own draw_square
PATH_TOLERANCE = 0.01  # [m]
LAP = 25.0  # [s] takes 20


class Turtle:
    """A turtle that obeys each command some steps late."""

    def __init__(self, x=MIDDLE, y=MIDDLE, theta=0.0, delay=2):
        self.pose = (x, y, theta)
        self.path = [self.pose]
        self._commands = [STILL] * delay

    def drive(self, driver, seconds):
        """Let the driver drive until it is finished or the time is over; return how long that took, s."""
        for step in range(round(seconds / DT)):
            if driver.finished:
                return step * DT
            self._commands.append(driver.step(*self.pose))
            self._step(self._commands.pop(0))
        return seconds

    def _step(self, command):
        speed = command.linear_x
        assert abs(speed) <= SPEED and command.linear_y == 0.0 and abs(command.angular_z) <= TURN_SPEED
        x, y, theta = self.pose
        theta = (theta + command.angular_z * DT + math.pi) % (2 * math.pi) - math.pi
        self.pose = (x + math.cos(theta) * speed * DT, y + math.sin(theta) * speed * DT, theta)
        self.path.append(self.pose)

    def closest(self, corner):
        return min(math.dist(corner, pose[:2]) for pose in self.path)


def test_corners_go_round_counter_clockwise_from_the_first_pose():
    assert square_corners(1.0, 2.0, 0.0, 2.0) == [(1, 2), (3, 2), (3, 4), (1, 4)]
    upward = square_corners(1.0, 2.0, math.pi / 2, 2.0)
    assert [(round(x, 9), round(y, 9)) for x, y in upward] == [(1, 2), (1, 4), (-1, 4), (-1, 2)]


@pytest.mark.parametrize('error,speed', [(10.0, 1.0), (-0.1, -0.4), (1e-6, 0.05)])  # 4/s times the error
def test_speed_falls_with_the_error_and_never_to_zero(error, speed):
    assert approach(error, 1.0) == pytest.approx(speed)


@pytest.mark.parametrize('delay', [0, 1, 2, 6])
def test_a_lap_meets_every_corner_and_ends_as_it_began(delay):
    turtle = Turtle(delay=delay)
    driver = SquareDriver(*turtle.pose, SIDE, laps=1)
    assert turtle.drive(driver, LAP) < LAP, 'it did not end'
    corners = [(MIDDLE, MIDDLE), (MIDDLE + 2, MIDDLE), (MIDDLE + 2, MIDDLE + 2), (MIDDLE, MIDDLE + 2)]
    for corner in corners:
        assert turtle.closest(corner) < CORNER_TOLERANCE
    assert turtle.pose == pytest.approx((MIDDLE, MIDDLE, 0.0), abs=CORNER_TOLERANCE)
    for x, y, _ in turtle.path:  # distance from the square's outline
        assert abs(max(abs(x - MIDDLE - 1), abs(y - MIDDLE - 1)) - 1) < PATH_TOLERANCE
    assert driver.visited == 4 and not driver.corners_left


@pytest.mark.parametrize('side,theta', [(0.1, 0.0), (5.5, 0.0), (2.0, 2.0), (2.0, -3.1), (2.0, 3.14159)])
def test_other_sides_and_headings(side, theta):
    turtle = Turtle(theta=theta)
    driver = SquareDriver(*turtle.pose, side, laps=1)
    assert turtle.drive(driver, 50.0) < 50.0
    for corner in driver.corners:
        assert turtle.closest(corner) < CORNER_TOLERANCE
    assert math.remainder(turtle.pose[2] - theta, 2 * math.pi) == pytest.approx(0.0, abs=0.01)


def test_without_laps_it_goes_on_for_ever_and_does_not_drift():
    turtle = Turtle()
    driver = SquareDriver(*turtle.pose, SIDE)
    turtle.drive(driver, 20 * LAP)
    assert driver.visited >= 80 and not driver.finished and driver.corners_left == math.inf
    turtle.path.clear()
    turtle.drive(driver, LAP)
    for corner in driver.corners:
        assert turtle.closest(corner) < CORNER_TOLERANCE


@pytest.mark.parametrize('elsewhere', [(1.0, 9.0, 2.0), (MIDDLE + 2.5, MIDDLE, 0.0), (MIDDLE + 1.9, MIDDLE + 0.5, 0.0),
                                       (MIDDLE + 1.0, MIDDLE, -3.0)])
def test_a_turtle_that_was_moved_finds_back(elsewhere):
    turtle = Turtle()
    driver = SquareDriver(*turtle.pose, SIDE, laps=1)
    turtle.drive(driver, 1.0)
    assert driver.visited == 0
    turtle.pose = elsewhere
    assert turtle.drive(driver, 60.0) < 60.0
    for corner in driver.corners:
        assert turtle.closest(corner) < CORNER_TOLERANCE


def test_each_component_of_a_velocity_has_its_field():
    assert to_twist(Twist2D(linear_x=1.0, linear_y=-2.0, angular_z=3.0)) == \
        Twist(Vector3(1.0, -2.0, 0.0), Vector3(0.0, 0.0, 3.0))
