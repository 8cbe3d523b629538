"""The rendered marker sequence: ground truth and detector, covered markers, calibration, cache."""
import errno
import json
import os

import cv2
import numpy as np
import pytest
import yaml

from alvar_core import marker_sequence
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

POSITION_TOLERANCE = 0.01  # of the distance
CORNER_TOLERANCE = 0.5  # [px]


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp('sequence')
    marker_sequence.render_to(str(path))
    return path


@pytest.fixture(scope='module')
def truth(folder):
    return json.loads((folder / 'frames.json').read_text())


def picture(folder, frame):
    return cv2.imread(str(folder / frame['file']))


@pytest.mark.parametrize('number', [0, 19, 71, *nightly(15, 27, 36, 50)])  # part of a marker looked like one in 15, 19
def test_detector_finds_the_truth(folder, truth, number):
    frame = truth['frames'][number]
    camera = truth['cameras']['webcam']
    found = {one.id: one for one in Detector(marker_sequence.MARKER_SIZE).detect(
        cv2.cvtColor(picture(folder, frame), cv2.COLOR_BGR2GRAY), Camera(camera['K'], camera['D']))}
    listed = {marker['id']: marker for marker in frame['markers']}
    assert {marker for marker in listed if not listed[marker]['ignore']} <= set(found) <= set(listed)
    for marker in set(found) & set(listed):
        distance = np.linalg.norm(found[marker].position - listed[marker]['position'])
        assert distance <= POSITION_TOLERANCE * listed[marker]['distance_m']
        assert np.abs(found[marker].corners - listed[marker]['corners']).max() <= CORNER_TOLERANCE


def test_all_five_are_there_and_one_is_covered_for_a_second(truth):
    ids = [{marker['id'] for marker in frame['markers']} for frame in truth['frames']]
    assert ids[0] == set(marker_sequence.MARKERS) and ids.count(set(marker_sequence.MARKERS)) > 50
    hidden = [number for number, seen in enumerate(ids) if seen == set(marker_sequence.MARKERS) - {3}]
    assert len(hidden) == len(ids) - ids.count(ids[0]) and 8 <= len(hidden) <= 15
    assert hidden == list(range(hidden[0], hidden[-1] + 1))


def test_motion_goes_on_from_the_last_frame_to_the_first(truth):
    def places(number):
        return {marker['id']: np.array(marker['position']) for marker in truth['frames'][number]['markers']}
    steps = [max(np.linalg.norm(places(number)[marker] - places(number - 1)[marker]) for marker in (1, 2, 4, 5))
             for number in range(len(truth['frames']))]
    assert steps[0] <= max(steps[1:]) < 0.05


def test_covered_marker_is_hidden_by_one_colour(folder, truth):
    whole, hidden = truth['frames'][0], truth['frames'][36]
    corners = np.array(next(marker for marker in whole['markers'] if marker['id'] == 3)['corners'])
    (left, top), (right, bottom) = corners.min(0).astype(int), corners.max(0).astype(int)
    assert picture(folder, whole)[top:bottom, left:right].std(axis=(0, 1)).min() > 40.0
    assert picture(folder, hidden)[top:bottom, left:right].std(axis=(0, 1)).max() < 5.0


def test_same_sequence_each_time(folder):
    renderer = marker_sequence.SequenceRenderer()
    again = cv2.imencode('.jpg', renderer.image(5), [cv2.IMWRITE_JPEG_QUALITY, 92])[1].tobytes()
    assert again == (folder / 'frame_005.jpg').read_bytes()


def test_version_is_raised_with_any_change(folder, truth):
    """The cache keeps images of the same version: record these numbers anew only together with VERSION."""
    corners = {marker_id: np.mean([marker['corners'] for frame in truth['frames'] for marker in frame['markers']
                                   if marker['id'] == marker_id], axis=(0, 1)) for marker_id in marker_sequence.MARKERS}
    overview = cv2.resize(picture(folder, truth['frames'][36]), (4, 3), interpolation=cv2.INTER_AREA).mean(2)
    assert marker_sequence.VERSION == 2
    assert np.array(list(corners.values())) == pytest.approx(np.array(
        [(148.33, 150.59), (300.15, 245.71), (481.32, 144.37), (319.77, 356.35), (516.72, 255.36)]), abs=0.02)  # [px]
    assert overview == pytest.approx(np.array([(187.0, 200.7, 181.0, 174.7), (181.0, 178.7, 154.7, 165.7),
                                               (136.7, 145.7, 145.0, 151.0)]), abs=1.0)  # [grey levels]


def test_calibration_is_that_of_the_truth(folder, truth):
    calibration = yaml.safe_load((folder / 'camera.yaml').read_text())
    camera = truth['cameras']['webcam']
    assert calibration['camera_matrix']['data'] == camera['K']
    assert calibration['distortion_coefficients'] == {'rows': 1, 'cols': 5, 'data': camera['D']}
    assert (calibration['image_width'], calibration['image_height']) == (640, 480)
    assert calibration['projection_matrix']['data'][:3] == camera['K'][:3]


def test_cache_is_filled_once_and_whole(tmp_path, monkeypatch):
    calls = []

    def render_to(folder):
        calls.append(folder)
        assert not os.path.exists(os.path.join(tmp_path, 'turtle_robotont', 'marker_sequence'))
    monkeypatch.setattr(marker_sequence, 'render_to', render_to)
    first = marker_sequence.cached(str(tmp_path))
    assert marker_sequence.cached(str(tmp_path)) == first and len(calls) == 1
    assert os.listdir(tmp_path / 'turtle_robotont') == [os.path.basename(first)]


def test_rendering_that_fails_leaves_nothing(tmp_path, monkeypatch, capsys):
    def render_to(folder):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), f'{folder}/frame_000.jpg')
    monkeypatch.setattr(marker_sequence, 'render_to', render_to)
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    with pytest.raises(SystemExit, match=r'frame_000\.jpg cannot be written: No space left on device. Make room on'):
        marker_sequence.main([])
    assert os.listdir(tmp_path / 'turtle_robotont') == [] and capsys.readouterr().out == ''


@pytest.mark.parametrize('name, content', [
    ('camera.yaml', 'camera_matrix: my own'), ('frames.json', '{"cameras": {}, "frames": []}'), ('frame_007.jpg', 'x')])
def test_files_of_the_user_are_not_replaced(tmp_path, monkeypatch, name, content):
    monkeypatch.setattr(marker_sequence, 'FRAMES', 1)
    (tmp_path / name).write_text(content)
    with pytest.raises(SystemExit, match=f'has files that would be replaced, such as {name}. Choose another folder'):
        marker_sequence.main(['--output', str(tmp_path)])
    assert os.listdir(tmp_path) == [name] and (tmp_path / name).read_text() == content


def test_its_own_files_are_replaced_beside_others(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(marker_sequence, 'FRAMES', 1)
    (tmp_path / 'notes.txt').write_text('mine')
    for _ in range(2):
        marker_sequence.main(['--output', str(tmp_path)])
        assert capsys.readouterr().out == str(tmp_path)
    assert sorted(os.listdir(tmp_path)) == ['camera.yaml', 'frame_000.jpg', 'frames.json', 'notes.txt']


def test_command_prints_the_folder_as_a_launch_file_takes_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(marker_sequence, 'render_to', lambda folder: None)
    marker_sequence.main(['--output', str(tmp_path / 'new')])
    assert capsys.readouterr().out == str(tmp_path / 'new')
