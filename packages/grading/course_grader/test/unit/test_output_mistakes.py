"""course_grader.rules.output_mistakes: output that differs from the expected lines."""

import pytest

from course_grader.rules import exercise, output_mistakes
from course_grader.rules.observation import Observed, OutputLine, ShownMarkers
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle

SHOWN = [ShownMarkers(0.0, {21: (0.512, 0.113, 1.774), 35: (-0.304, 0.221, 2.531)}), ShownMarkers(1.5, {}),
         ShownMarkers(3.0, {47: (0.701, -0.408, 0.902)})]


@pytest.mark.parametrize('text, advice', [
    ('{pose.y:.3f} {pose.x:.3f}', 'swapped'), ('x {pose.x:.0f} y {pose.y:.0f}', 'whole numbers'),
    ('5.54 5.54', 'always the same'), ('x {pose.x:.3f} theta {pose.theta:.3f}', 'theta'),
    ('{pose.y:.3f}, {pose.theta:.3f}', 'theta'), ('x = {pose.x:.3f}, y = {pose.x:.3f}', 'printed twice'),
    ('{pose.y:.3f} {pose.y:.3f}', 'printed twice'), ('{pose.x:.3f} {pose.y:.3f}', None), ('hello', None)])
def test_poses(text, advice):
    turtle = GradedTurtle(2.0, 7.0).drive(4.0, 1.0, 0.7, say=lambda pose: text.format(pose=pose))
    said = output_mistakes.found(exercise.load(EXERCISES['print_poses']), turtle.observed, ['prints_poses'])
    assert advice in said['prints_poses'][0] if advice else said == {'prints_poses': []}


@pytest.mark.parametrize('xs, advice', [([5.0, 7.0, 9.0, 10.5], True), ([5.0] * 9 + [7.0] * 2, False), ([], False)])
def test_lines_that_are_printed_too_rarely(xs, advice):
    lines = [OutputLine(0.1 * number, f'x = {x}', 'DEBUG' if x < 6 else 'INFO' if x < 8 else 'WARN' if x < 10 else
                        'ERROR') for number, x in enumerate(xs)]
    said = output_mistakes.found(exercise.load(EXERCISES['log_levels']), Observed(lines=lines), ['prints'])
    assert ('only 1 of 3 lines are printed for "debug message below 6 m"' in str(said)) == advice


@pytest.mark.parametrize('exit_code, count, y', [(None, 1, 7.0), (0, 1, 7.0), (None, 10, 7.0), (0, 1, 2.0)])
def test_few_poses(exit_code, count, y):
    turtle = GradedTurtle(2.0, y)
    turtle.drive(0.1 * count, 1.0, 0.7, say=lambda pose: f'{pose.x:.3f} {pose.y:.3f}').drive(4.0, 1.0, 0.7)
    turtle.observed.exit_code = exit_code
    said = output_mistakes.found(exercise.load(EXERCISES['print_poses']), turtle.observed, ['prints_poses'])
    assert f'only {count} poses are printed' in said['prints_poses'][0]


@pytest.mark.parametrize('name, text, advice', [
    ('print_marker_x', '{at[2]:.3f}', 'it prints z of each marker'),
    ('print_marker_x', '{at[1]:.3f}', 'it prints y of each marker'),
    ('print_marker_x', '{marker}', 'it prints id of each marker'), ('print_marker_x', '{at[0]:.3f}', None),
    ('print_marker_ids', '{at[0]:.3f}', 'it prints x of each marker'),
    ('print_marker_ids', '{number}', 'it counts the markers'), ('print_marker_ids', '{number_from_1}', 'it counts the'),
    ('print_marker_ids', '{marker}', None), ('print_marker_ids', 'a marker', None)])
def test_markers(name, text, advice):
    lines = [OutputLine(shown.t + 0.05, text.format(marker=marker, at=at, number=number, number_from_1=1 + number))
             for shown in SHOWN for number, (marker, at) in enumerate(shown.markers.items())]
    said = output_mistakes.found(exercise.load(EXERCISES[name]), Observed(shown=SHOWN, lines=lines),
                                 ['prints_markers'])
    assert advice in said['prints_markers'][0] if advice else said == {'prints_markers': []}


def test_distances_that_are_printed_as_whole_numbers():
    lines = [OutputLine(0.1 * number, f'marker {20 + number % 2} is at x = 0') for number in range(9)]
    said = output_mistakes.found(exercise.load(EXERCISES['print_marker_x']), Observed(
        shown=SHOWN, lines=lines, source='marker.pose.pose.position.x'), ['prints_markers'])
    assert said['prints_markers'][0].startswith('x is printed as a whole number: print metres')
