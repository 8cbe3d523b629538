"""The video of a course: it shows what it says, and answers are compared with that."""
import numpy as np
import pytest

from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from unit_support import course_video
from unit_support.course_video import HEIGHT, READOUT, SIZE, WIDTH


def test_a_still_camera_shows_the_wall_where_it_is(monkeypatch):
    """Without motion, positions are as exact as in any other image with a gamma."""
    still = course_video.pose(0.4)
    monkeypatch.setattr(course_video, 'pose', lambda time: still)
    camera = default_camera(WIDTH, HEIGHT)
    image, shown = course_video.frame(0, camera)
    found = {each.id: each.position for each in Detector(SIZE).detect(image, camera)}
    assert len(shown) >= 3 and set(found) >= set(shown)
    for number, pose in shown.items():
        assert np.linalg.norm(found[number] - pose[:3]) < 0.002 * np.linalg.norm(pose[:3])


def test_lower_rows_are_later(monkeypatch):
    """A camera that moves sideways at 1 m/s sees the wall's lower rows further on."""
    monkeypatch.setattr(course_video, 'pose', lambda time: (np.diag([1.0, -1.0, -1.0]), np.array([time, 0.0, 1.0])))
    camera = default_camera(WIDTH, HEIGHT)
    image, _ = course_video.frame(0, camera)
    lean = [lean_of(each.corners) for each in Detector(SIZE).detect(image, camera)]
    expected = READOUT / HEIGHT * camera.fx  # px to the right for each px down
    assert len(lean) >= 3 and np.allclose(lean, expected, atol=0.004)


def lean_of(corners):
    """Return how far the left and right sides lean: px to the right for each px down."""
    down = corners[3] + corners[2] - corners[0] - corners[1]
    return down[0] / down[1]


def test_a_video_has_its_frames(tmp_path):
    made = course_video.make(str(tmp_path), 0.2)
    assert len(course_video.frames_of(made.path)) == len(made.shown) == 6


AHEAD = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]  # a pose, 1 m away


@pytest.mark.parametrize('answers, expected', [
    ([({'3': AHEAD}, [(3, [0, 0, 1.01, *AHEAD[3:]]), (14, AHEAD)])],
     {'seen': 1, 'found': 1, 'other': 0, 'off': [1.0], 'far': [1.0], 'turned': [0.0]}),
    ([({'3': AHEAD, '14': AHEAD}, [(14, AHEAD), (99, AHEAD)])],
     {'seen': 2, 'found': 1, 'other': 1, 'off': [0.0], 'far': [0.0], 'turned': [0.0]}),
    ([({'3': AHEAD}, [(3, [0, 0, 0.98, np.sqrt(0.5), np.sqrt(0.5), 0, 0])])],
     {'seen': 1, 'found': 1, 'other': 0, 'off': [2.0], 'far': [-2.0], 'turned': [90.0]}),
    ([({}, [])], {'seen': 0, 'found': 0, 'other': 0, 'off': [], 'far': [], 'turned': []}),
])
def test_answers_are_compared_with_what_was_shown(answers, expected):
    assert course_video.compared(answers) == {key: pytest.approx(value) for key, value in expected.items()}


def test_a_linear_video_shows_light_itself():
    camera = default_camera(WIDTH, HEIGHT)
    linear, real = (course_video.frame(0, camera, gamma)[0] for gamma in (1.0, course_video.GAMMA))
    assert np.abs(255 * (linear / 255.0) ** (1 / course_video.GAMMA) - real)[linear > 20].max() < 4.0
