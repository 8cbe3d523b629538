"""The bench of the marker detector: OpenCV's detector as a baseline, scores, the table, wrong folders."""
import json

import cv2
import numpy as np
import pytest
import rospy

import marker_bag
import no_markers
import suite_markers
from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from aruco_baseline import ArucoBaseline
from figures import OURS
from processes import BenchError
from rospy_support import images
from rostest_support import markers
from rostest_support.marker_scenes import Placed, Scene, image_of

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def no_folder_is_left(monkeypatch):
    monkeypatch.setattr(suite_markers, '_chosen', dict(suite_markers._chosen))
    monkeypatch.setattr(suite_markers, '_kept', {})


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
def test_measurements_score_and_time_each_tool(folder):
    suite_markers._chosen['folder'] = folder
    pool = {}
    for measurement in suite_markers.MEASUREMENTS.values():
        pool.update(measurement.run(None, suite_markers.QUICK))
    assert pool['ours_recall_easy'] == pool['aruco_recall_easy'] == [100] and pool['real_recall_easy'] == [0]
    assert pool['ours_position_easy'][0] < 0.2 and pool['aruco_position_easy'][0] < 1.0
    assert pool['ours_flips'] == pool['ours_false'] == pool['ours_wrong'] == [0]
    assert len(pool['ours_640x480_cpu']) == 1 and len(pool['tracking_640x480_cpu']) == suite_markers.STEPS - 1
    assert pool['tracking_found'] == [100] and pool['real_640x480_cpu'] == [7.0]
    text = suite_markers.preface({OURS: pool})
    assert [line.split('  ')[0] for line in text.splitlines()[2:6]] == [
        'here', 'here, gamma 2.2', 'ArUco', 'real tracker, stored']
    used = {figure.key for figure in suite_markers.FIGURES if 'medium' not in figure.key and 'hard' not in figure.key
            and '1280' not in figure.key and 'class_' not in figure.key and 'beside_' not in figure.key}
    assert used <= set(pool)


@pytest.mark.nightly
def test_classes_are_scored_once_and_shown():
    count = suite_markers.class_scores.PER_CLASS
    pool = suite_markers.MEASUREMENTS['classes'].run(None, count)  # one photo of each class
    assert {figure.key for figure in suite_markers.FIGURES if 'class_' in figure.key} <= set(pool)
    assert pool['class_wrong'] == pool['class_false'] == [0]
    assert suite_markers.MEASUREMENTS['classes'].run(None, count) == pool
    lines = suite_markers.preface({OURS: pool}).splitlines()
    assert lines[0].startswith('By class, development half') and lines[2].startswith('even           100.0')


def test_every_id_is_in_the_baselines_dictionary():
    camera, baseline = default_camera(), ArucoBaseline()
    for number in range(0, 256, 15):
        blank = np.full((480, 640), 220, np.uint8)
        blank[150:330, 200:380] = drawing.marker_image(number, 180)
        assert [found['id'] for found in baseline.detect(blank, camera, 0.1)] == [number]


def test_what_is_found_without_markers_is_false(tmp_path):
    """A folder with a marker, a grey image below, and a text."""
    scene = np.full((200, 200), 220, np.uint8)
    scene[50:149, 50:149] = drawing.marker_image(42, 99)
    (tmp_path / 'below').mkdir()
    cv2.imwrite(str(tmp_path / 'a.png'), scene)
    cv2.imwrite(str(tmp_path / 'below' / 'b.jpg'), np.full((100, 100), 90, np.uint8))
    (tmp_path / 'c.png').write_text('no image')
    lines = no_markers.report(str(tmp_path)).splitlines()
    assert lines[0].startswith(f'{tmp_path}/a.png: id 42 at 99, 99, 99 px wide, confidence 0.9')
    assert lines[1:] == [f'{tmp_path}: 2 images without markers; false detections: 1']
    with pytest.raises(BenchError, match='has no images of at least 16x16 pixels'):
        no_markers.report(str(tmp_path / 'none'))


def bag_of(path, images, infos):
    """Write a bag of messages, each with the time of its number [s]; return its path."""
    rosbag = pytest.importorskip('rosbag')
    with rosbag.Bag(str(path), 'w') as bag:
        for topic, messages in (('/cam/image', images), ('/cam/info', infos)):
            for number, message in enumerate(messages):
                bag.write(topic, message, rospy.Time(1 + number))
    return str(path)


def test_bag_shows_how_steadily_markers_are_found(tmp_path):
    """Marker 42 moves evenly, and is covered in the third of five images; 7 is in one image only."""
    rng, shown = np.random.default_rng(1), []
    for number in range(5):
        moving = Placed(42, 0.1, rotations.facing(0.5, 0.7, 0.3), np.array([0.01 * number, 0.0, 0.6]))
        rare = Placed(7, 0.05, rotations.facing(0.2, 0.7, 0.3), np.array([-0.2, 0.1, 0.6]))
        visible = ([moving] if number != 2 else []) + ([rare] if number == 4 else [])
        shown.append(images.to_image(image_of(rng, markers.CAMERA, visible, Scene())))
    bag = bag_of(tmp_path / 'a.bag', shown, [markers.camera_info()])
    lines = marker_bag.report(bag).splitlines()
    assert lines[0] == f'{bag}: 5 images; scatter from image to image, median / 95th'
    rows = {line.split()[0]: line.split()[1:] for line in lines[2:]}
    assert rows['42'][:4] == ['80.0', '%', 'of', '5'] and rows['7'][:2] == ['1', 'images']
    assert rows['42'][4] == '-'  # no three neighbouring images
    steady = bag_of(tmp_path / 'b.bag', [shown[0]] * 4, [markers.camera_info()])
    assert marker_bag.report(steady).splitlines()[2].split()[1:8] == '100.0 % of 4 0.00 / 0.00'.split()


def test_bag_without_one_image_topic_is_refused(tmp_path):
    bag = bag_of(tmp_path / 'a.bag', [], [markers.camera_info()])
    with pytest.raises(BenchError, match='exactly one of each is needed'):
        marker_bag.report(bag)
