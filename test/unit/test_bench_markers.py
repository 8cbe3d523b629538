"""./run bench markers: scores and times of each tool, the table by class."""
import json

import cv2
import numpy as np
import pytest

import suite_markers
from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from aruco_baseline import ArucoBaseline
from figures import OURS
from rostest_support.marker_scenes import Placed, Scene, image_of


@pytest.fixture(autouse=True)
def chosen(monkeypatch):
    monkeypatch.setattr(suite_markers, '_chosen', {'folder': suite_markers.FOLDER})
    monkeypatch.setattr(suite_markers, '_kept', {})
    return suite_markers._chosen


@pytest.fixture
def folder(tmp_path):
    """A folder with one easy frame: marker 42, 0.1 m wide, 0.6 m away."""
    camera = default_camera()
    placed = Placed(42, 0.1, rotations.facing(0.5, 0.7, 0.3), np.array([0.05, 0.0, 0.6]))
    picture = image_of(np.random.default_rng(1), camera, [placed], Scene())
    cv2.imwrite(str(tmp_path / 'a.png'), picture)
    marker = {'id': 42, 'position': placed.position.tolist(),
              'orientation': rotations.quaternion_from_matrix(placed.rotation).tolist(),
              'corners': placed.corners.tolist(), 'distance_m': float(np.linalg.norm(placed.position)), 'ignore': False}
    frame = {'name': 'a', 'file': 'a.png', 'camera': 'c', 'marker_size_m': 0.1, 'difficulty': 'easy',
             'markers': [marker]}
    camera = {'K': camera.matrix.ravel().tolist(), 'D': [], 'width': 640, 'height': 480}
    (tmp_path / 'frames.json').write_text(json.dumps({'set': 'one', 'cameras': {'c': camera}, 'frames': [frame]}))
    (tmp_path / 'real_alvar.json').write_text(json.dumps({'frames': {'a': {'detections': [], 'detect_ms': 7.0}}}))
    return tmp_path


@pytest.mark.nightly
def test_measurements_score_and_time_each_tool(folder, chosen):
    chosen['folder'], pool = folder, {}
    for name in ('single', 'gamma', 'tracking', 'many', 'aruco', 'stored'):
        pool.update(suite_markers.MEASUREMENTS[name].run(None, suite_markers.QUICK))
    assert pool['ours_recall_easy'] == pool['aruco_recall_easy'] == [100] and pool['real_recall_easy'] == [0]
    assert pool['ours_position_easy'][0] < 0.2 and pool['aruco_position_easy'][0] < 1.0
    assert pool['ours_flips'] == pool['ours_false'] == pool['ours_wrong'] == [0]
    assert pool['tracking_found'] == [100] and pool['real_640x480_cpu'] == [7.0]
    assert [line.split('  ')[0] for line in suite_markers.preface({OURS: pool}).splitlines()[2:6]] == [
        'here', 'here, gamma 2.2', 'ArUco', 'real tracker, stored']


@pytest.mark.nightly
def test_classes_are_scored_once_and_shown():
    count = suite_markers.class_scores.PER_CLASS
    pool = suite_markers.MEASUREMENTS['classes'].run(None, count)  # one photo of each class
    assert {figure.key for figure in suite_markers.FIGURES if 'class_' in figure.key} <= set(pool)
    assert pool['class_wrong'] == pool['class_false'] == [0]
    assert suite_markers.MEASUREMENTS['classes'].run(None, count) == pool
    lines = suite_markers.preface({OURS: pool}).splitlines()
    assert lines[0].startswith('By class') and lines[2].startswith('even           100.0')


def test_every_id_is_in_the_baselines_dictionary():
    camera, baseline = default_camera(), ArucoBaseline()
    for number in range(0, 256, 15):
        blank = np.full((480, 640), 220, np.uint8)
        blank[150:330, 200:380] = drawing.marker_image(number, 180)
        assert [found['id'] for found in baseline.detect(blank, camera, 0.1)] == [number]
