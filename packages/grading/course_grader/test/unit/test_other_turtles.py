"""Checks of other turtles than turtle1: where one is spawned, and whether it follows."""
import pytest

from course_grader.rules import exercise, scoring
from course_grader.rules.observation import Observed, Sample

DT = 0.016  # [s]


def judged(observed, **check):
    """Return the Reason for one check."""
    content = {'title': 'T', 'time': '10 s', 'checks': [{'points': 100, **check}]}
    reason, = scoring.decide(exercise.parse(content), observed).reasons
    return reason


def line(start, speed, seconds=5.0, late=0.0):
    """Return the Samples of a turtle that drives along x from ``start`` [m] at ``speed`` [m/s] on y = 2."""
    return [Sample(late + number * DT, start + speed * number * DT, 2.0, 0.0) for number in range(int(seconds / DT))]


@pytest.mark.parametrize('turtles, points, seen', [
    ({'turtle2': line(2.0, 1.0)}, 100, 'it starts at x = 2.00, y = 2.00'),
    ({'turtle2': line(2.1, 0.0)}, 0, 'it starts at x = 2.10, y = 2.00'),  # 5 cm are allowed
    ({}, 0, 'there is no turtle2'), ({'turtle2': []}, 0, 'there is no turtle2'),
])
def test_where_a_turtle_is_spawned(turtles, points, seen):
    reason = judged(Observed(turtles=turtles), check='spawns', turtle='turtle2', x='2 m', y='2 m')
    assert (reason.points, reason.seen) == (points, seen)


@pytest.mark.parametrize('leader, track, points, seen', [
    (line(5.0, -0.5), line(5.08, -0.5), 100, 'at the end it is 0.08 m away'),  # 10 cm are allowed
    (line(5.0, -0.5), line(5.0, -0.4), 0, 'at the end it is 0.50 m away'),  # 0.1 m/s slower for 5 s
    (line(2.5, 0.0), line(2.5, 0.0, 1.0) + line(0.0, 0.0, 1.0, 1.0) + line(2.5, 0.0, 3.0, 2.0), 0, 'it jumps'),
    (line(2.5, 0.0), [], 0, 'there is no turtle2'), ([], line(2.5, 0.0), 0, 'there is no turtle2'),
])
def test_whether_a_turtle_follows(leader, track, points, seen):
    observed = Observed(track=leader, turtles={'turtle2': track})
    reason = judged(observed, check='follows', turtle='turtle2')
    assert (reason.points, reason.seen) == (points, seen)

