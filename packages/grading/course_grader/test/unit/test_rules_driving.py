"""course_grader.rules.rules_driving: paths through points, along another one, and driven again."""
import math

import pytest

from course_grader.rules.observation import Command, Observed, Sample
from course_grader.rules.rules_driving import Passes, Repeats, SamePath
from course_grader.rules.scoring import FULL
from unit_support.graded_turtle import GradedTurtle

TURN = 1.0, 0.0, math.pi / 2.0  # to the left: [s, m/s, rad/s]


@pytest.mark.parametrize('legs, share, seen', [
    ([(2.0, 1.0, 0.0), TURN, (3.0, 1.0, 0.0)], 1.0, 'it passes 2 of 2 in this order'),  # (4, 3) to (6, 3) to (6, 6)
    ([(2.0, 1.0, 0.0), TURN, (1.0, 1.0, 0.0)], 0.245, 'it passes 1 of 2 in this order, and comes as near as '),
    ([TURN, (3.0, 1.0, 0.0)], 0.0, 'it passes 0 of 2 in this order, and comes as near as 2.00 m to (6, 3) after that'),
    ([], 0.0, 'it did not move')])
def test_points_are_passed_in_their_order(legs, share, seen):
    turtle = GradedTurtle(x=4.0, y=3.0)
    for leg in legs:
        turtle.drive(*leg)
    found = Passes(through=[(6.0, 3.0), (6.0, 6.0)]).judge(turtle.observed)
    assert (found.share, found.seen[:len(seen)]) == (pytest.approx(share), seen)
    assert Passes(through=[(6.0, 6.0), (6.0, 3.0)]).judge(turtle.observed).share < 0.5


@pytest.mark.parametrize('legs, least, most, seen', [
    ([(2.0, 1.0, 0.0), TURN, (3.0, 1.0, 0.0)], 1.0, 1.0, 'of which 100% lies there'),
    ([(2.0, 1.0, 0.0), TURN, (1.0, 1.0, 0.0)], 0.2, 0.4,
     'of which 100% lies there; it follows the solution for 62% of its way, and does not reach (6.00, '),
    ([(2.0, 1.0, 0.0), TURN, (3.0, 1.0, 0.0), TURN, (2.0, 1.0, 0.0)], 0.65, 0.8, 'of which 73% lies there'),
    ([TURN, (3.0, 1.0, 0.0)], 0.0, 0.1, 'it follows the solution for 2% of its way'),  # it turns too early
    ([], 0.0, 0.0, 'it did not move')])
def test_a_path_is_that_of_the_solution(legs, least, most, seen):
    turtle = GradedTurtle(x=4.0, y=3.0)
    for leg in legs:
        turtle.drive(*leg)
    turtle.observed.solution = [(4.0, 3.0), (6.0, 3.0), (6.0, 6.0)]
    found = SamePath().judge(turtle.observed)
    assert least - 1e-3 <= found.share <= most and seen in found.seen
    turtle.observed.solution.reverse()
    assert SamePath().judge(turtle.observed).share < 0.5


@pytest.mark.parametrize('y, passes', [(0.05, True), (0.15, False), (-0.15, False)])
def test_a_point_is_passed(y, passes):
    track = [Sample(0.1 * number, 0.02 * number, y, 0.0) for number in range(100)]
    assert Passes(1.0, 0.0).judge(Observed(track=track)).share == passes


def repeated(turn=0.5, speed=0.5, seconds=4.0):
    """Return the Observed of an arc that the grader drove for 4 s, and one that the program drove after it."""
    turtle = GradedTurtle().drive(4.0, 0.5, 0.5).drive(1.0)
    turtle.observed.commands.clear()  # those were the grader's
    return turtle.drive(seconds, speed, turn).drive(0.5).observed


@pytest.mark.parametrize('observed, passes', [
    (repeated(), True), (repeated(turn=0.25, speed=0.25, seconds=8.0), True),  # the same path, slowly
    (repeated(turn=-0.5), False), (repeated(seconds=3.0), False), (repeated(speed=0.0), False),
])
def test_a_path_that_is_driven_again(observed, passes):
    assert (Repeats().judge(observed).share >= FULL) == passes


def test_nothing_is_driven_again():
    idle = Observed(track=[Sample(0.0, 1.0, 1.0, 0.0)])
    assert Repeats().judge(idle).seen == 'it sent no command'
    still = Observed(track=[Sample(0.1 * tick, 1.0, 1.0, 0.0) for tick in range(9)], commands=[Command(0.4, 0, 0, 0)])
    assert Repeats().judge(still).seen == 'it did not move'
