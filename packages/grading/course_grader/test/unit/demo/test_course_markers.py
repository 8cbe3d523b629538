"""course_grader.demo.course_markers: the verdict on a tracker's messages, and the contact sheet."""
import types

import cv2
import numpy as np
import pytest

from course_grader.demo.course_markers import compared, sequence_measurements, sheet
from course_grader.demo.harness import DemoError, DemoHarness

TRUTH = {77: {'markers': [{'id': 1, 'position': [0.0, 0.0, 2.0], 'distance_m': 2.0, 'ignore': False},
                          {'id': 3, 'position': [0.0, 1.0, 0.0], 'distance_m': 1.0, 'ignore': True},
                          {'id': 4, 'position': [1.0, 0.0, 0.0], 'distance_m': 1.0, 'ignore': False}]}}


def message(stamp, **positions):
    """Return what compared() needs of an AlvarMarkers: markers by name, m1=(x, y, z)."""
    def marker(name, xyz):
        position = types.SimpleNamespace(**dict(zip('xyz', xyz)))
        pose = types.SimpleNamespace(pose=types.SimpleNamespace(position=position))
        return types.SimpleNamespace(id=int(name[1:]), pose=pose)
    return types.SimpleNamespace(header=types.SimpleNamespace(stamp=stamp),
                                 markers=[marker(*one) for one in positions.items()])


def test_markers_are_compared_with_the_frame_of_their_picture():
    messages = [message(5, m1=(0.0, 0.0, 2.02), m4=(1.0, 0.0, 0.0), m2=(0.0, 0.0, 1.0)),
                message(6, m1=(9.0, 9.0, 9.0)),  # its picture was not seen
                message(7, m3=(0.0, 1.5, 0.0))]  # covered in part: may be found or not
    seen = compared(messages, {5: 77, 7: 77, 8: 77}, TRUTH)
    assert (seen['shown'], seen['asked'], seen['found'], seen['phantoms']) == (2, 4, 2, 1)
    assert sorted(seen['errors']) == pytest.approx([0.0, 0.01])


@pytest.mark.parametrize('change, bad', [
    ({}, []),
    ({'shown': 3}, ['3 images']),
    ({'found': 90}, ['90 of 100 markers']),
    ({'phantoms': 1}, ['1 markers reported that are not visible']),
    ({'errors': [0.03] * 100}, ['median position error 3.000 %']),
    ({'shown': 0, 'asked': 0, 'found': 0, 'errors': []}, ['0 images', '0 of 0', 'median position error inf']),
])
def test_checks_fail_for_what_is_wrong(change, bad):
    right = {'shown': 50, 'asked': 100, 'found': 100, 'phantoms': 0, 'errors': [0.001] * 100}
    checks = sequence_measurements(**{**right, **change})
    wrong = [check.text for check in checks if not check.good]
    assert len(wrong) == len(bad) and all(text in found for text, found in zip(bad, wrong))


@pytest.mark.parametrize('count', [1, 3, 5, 40])
def test_sheet_has_up_to_six_pictures(count):
    pictures = [np.full((720, 1280, 3), number, np.uint8) for number in range(count)]
    made = sheet(pictures)
    assert made.shape[1] == 1920 and made.shape[0] == 360 * min(2, -(-count // 3))
    assert (made[0, 0] == 0).all() and (count < 40 or made[-1, -1, 0] > 30)


def test_sheet_of_nothing_is_refused():
    with pytest.raises(DemoError, match='no image'):
        sheet([])


def test_pictures_that_a_step_keeps_are_saved_under_its_name_once(tmp_path):
    harness = DemoHarness(str(tmp_path))
    for grey in (10, 200):
        harness.keep(np.full((4, 6, 3), grey, np.uint8))
    assert harness.kept('2_maze') == [str(tmp_path / '2_maze.png'), str(tmp_path / '2_maze_2.png')]
    assert [cv2.imread(str(path)).mean() for path in sorted(tmp_path.iterdir())] == [10.0, 200.0]
    assert harness.kept('3_other') == []


def test_picture_that_cannot_be_written_is_named(tmp_path):
    harness = DemoHarness(str(tmp_path / 'missing'))
    harness.keep(np.zeros((4, 6, 3), np.uint8))
    with pytest.raises(DemoError, match=r'missing/1_a\.png cannot be written'):
        harness.kept('1_a')
