"""course_grader.formats.path_picture: the path, the part that counted, and nothing else."""
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from course_grader.formats import path_picture, report
from course_grader.rules import exercise, scoring
from course_grader.rules.observation import Event, Sample
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle

CIRCLE, SQUARE, STOP, MARKERS = (exercise.load(EXERCISES[name]) for name in (
    'publish_circle', 'square_by_teleport', 'stop_at_x', 'print_marker_ids'))


def circle(seconds=33.0):
    turtle = GradedTurtle(4.5, 3.0)
    turtle.drive(seconds, 0.5, 0.2)
    return turtle.observed


def styles(exercise_, observed):
    return [line.style for line in path_picture.drawing(exercise_, observed).lines]


def test_what_counted_lies_on_the_path():
    observed = circle()
    lines = path_picture.drawing(CIRCLE, observed).lines
    path = next(line.points for line in lines if line.style == 'path')
    counted = [line.points for line in lines if line.style == 'counted']
    assert counted
    drawn = np.zeros((path_picture.SIZE, path_picture.SIZE), np.uint8)
    cv2.polylines(drawn, [path], False, 255, 5)
    assert all(drawn[y, x] for points in counted for x, y in points)


def test_nothing_counted_of_a_scribble():
    turtle = GradedTurtle(5.5, 5.5)
    for turn in (2.0, -1.0, 3.0, -2.5, 1.0):
        turtle.drive(1.5, 1.0, turn)
    assert 'path' in styles(CIRCLE, turtle.observed) and 'counted' not in styles(CIRCLE, turtle.observed)


def test_there_is_no_picture_without_a_path(tmp_path):
    turtle = GradedTurtle()
    turtle.drive(2.0, 0.0, 0.0)
    assert path_picture.drawing(CIRCLE, turtle.observed) is None
    report.write(tmp_path, MARKERS, turtle.observed, scoring.decide(MARKERS, turtle.observed), ['a'], 1)
    assert not list(tmp_path.glob('path.*'))
    turtle.observed.track.clear()
    assert path_picture.drawing(CIRCLE, turtle.observed) is None


@pytest.mark.parametrize('end, counted', [(10.0, 1), (9.0, 0)])
def test_a_stop_counts_where_it_was_asked_for(end, counted):
    turtle = GradedTurtle(4.0, 5.0)
    turtle.drive(end - 4.0, 1.0, 0.0)
    turtle.drive(2.0, 0.0, 0.0)
    assert styles(STOP, turtle.observed).count('counted') == counted


def test_each_different_position_counts_once_and_what_was_before_a_reset_is_pale():
    observed = circle(5.0)
    end = observed.track[-1]
    observed.events.append(Event(end.t, 'reset'))
    for number, (x, y) in enumerate([(2.0, 2.0), (8.0, 2.0), (8.0, 8.0), (8.0, 8.0)], 1):
        observed.events.append(Event(end.t + number, 'teleport', (x, y, 0.0)))
        observed.track.append(Sample(end.t + number, x, y, 0.0))
    drawn = styles(SQUARE, observed)
    assert (drawn.count('counted'), drawn.count('earlier'), drawn.count('path')) == (3, 1, 1)


def test_png_and_svg_show_the_same():
    drawn = path_picture.drawing(CIRCLE, circle())
    image = cv2.imdecode(np.frombuffer(path_picture.png(drawn), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (path_picture.SIZE, path_picture.SIZE, 3)
    for name in ('path', 'counted', 'start', 'end', 'frame'):
        colour = [int(path_picture.STYLES[name][0][start:start + 2], 16) for start in (5, 3, 1)]
        assert (image == colour).all(axis=2).sum() > 20, name
    text = path_picture.svg(drawn)
    names = {element.get('class', '').split()[0] for element in ElementTree.fromstring(text).iter()
             if element.get('class')}
    assert names == {'grid', 'frame', 'counted', 'path', 'start', 'end', 'text'}
    assert len(text) < 7000  # [bytes]: a class has thousands of them
