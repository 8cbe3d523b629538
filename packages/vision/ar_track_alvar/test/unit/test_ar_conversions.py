"""ar_track_alvar.conversions: cameras from CameraInfo, messages from poses."""
import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Quaternion, Transform, Vector3
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from alvar_core.camera import CameraError, FisheyeCamera
from alvar_core.detection.detector import Detection
from ar_track_alvar import conversions
from ar_track_alvar.conversions import MarkerPose
from plain_support import LARGEST_MARKER_ID

K = [500.0, 0, 320.0, 0, 510.0, 240.0, 0, 0, 1]
P = [450.0, 0, 310.0, 0, 0, 460.0, 230.0, 0, 0, 0, 1, 0]
NAN = float('nan')
CLOSE = 1e-9


def info(**fields):
    made = CameraInfo(width=640, height=480, distortion_model='plumb_bob', D=[0.1, -0.2, 0.001, 0.002, 0.0], K=K, P=P)
    for name, value in fields.items():
        part, _, field = name.partition('__')
        setattr(made if not field else getattr(made, part), field or part, value)
    return made


def test_the_matrix_and_the_distortion_are_those_of_the_message():
    camera = conversions.camera_of(info(), 640, 480)
    assert camera.matrix.ravel().tolist() == K and camera.distortion[:5].tolist() == [0.1, -0.2, 0.001, 0.002, 0.0]


@pytest.mark.parametrize('model, values', [('rational_polynomial', [0.1] * 8), ('plumb_bob', [0.1] * 4),
                                           ('rational_polynomial', [0.1] * 8 + [0.0] * 4)])
def test_models_of_opencv(model, values):
    camera = conversions.camera_of(info(distortion_model=model, D=values), 640, 480)
    assert camera.distorted and type(camera).__name__ == 'Camera'


@pytest.mark.parametrize('model', ['equidistant', 'fisheye'])
def test_fisheye_models(model):
    camera = conversions.camera_of(info(distortion_model=model, D=[0.1, 0.0, 0.0, 0.0]), 640, 480)
    assert isinstance(camera, FisheyeCamera)


@pytest.mark.parametrize('model', ['', 'plumb_bob', 'whatever'])
@pytest.mark.parametrize('values', [[], [0.0] * 5])
def test_without_distortion_the_model_does_not_matter(model, values):
    assert not conversions.camera_of(info(distortion_model=model, D=values), 640, 480).distorted


def test_an_equidistant_lens_is_never_without_distortion():
    camera = conversions.camera_of(info(distortion_model='equidistant', D=[0.0] * 4), 640, 480)
    assert isinstance(camera, FisheyeCamera) and camera.distorted


def test_rectified_pictures_are_described_by_p_alone():
    camera = conversions.camera_of(info(), 640, 480, rectified=True)
    assert not camera.distorted and (camera.fx, camera.fy, camera.cx, camera.cy) == (450.0, 460.0, 310.0, 230.0)


def test_binning_two_pixels_into_one():
    """Binned pixel 0 covers the pixels 0 and 1, its centre is at 0.5: u' = (u + 0.5) / 2 - 0.5."""
    camera = conversions.camera_of(info(binning_x=2, binning_y=2), 320, 240)
    assert (camera.fx, camera.fy) == (250.0, 255.0)
    assert (camera.cx, camera.cy) == pytest.approx((320.5 / 2 - 0.5, 240.5 / 2 - 0.5), abs=CLOSE)


def test_a_region_of_interest():
    camera = conversions.camera_of(info(roi__x_offset=100, roi__y_offset=50, roi__width=200, roi__height=160), 200, 160)
    assert (camera.fx, camera.cx, camera.cy) == (500.0, 220.0, 190.0)


def test_a_region_of_interest_binned_by_different_numbers():
    """(320 - 100 + 0.5) / 2 - 0.5 = 109.75 and (240 - 50 + 0.5) / 4 - 0.5 = 47.125."""
    camera = conversions.camera_of(info(roi__x_offset=100, roi__y_offset=50, roi__width=200, roi__height=160,
                                        binning_x=2, binning_y=4), 100, 40)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((250.0, 127.5, 109.75, 47.125), abs=CLOSE)


def test_a_message_without_a_size_fits_any_picture():
    assert conversions.camera_of(info(width=0, height=0), 123, 77).fx == 500.0


@pytest.mark.parametrize('fields, size, said', [
    ({'K': [0.0] * 9}, (640, 480), r'K is \[\[0.0, .*fx and fy must be above 0.*calibrate it'),
    ({'K': [NAN] + K[1:]}, (640, 480), r'K is \[\[nan'),
    ({'K': [-500.0] + K[1:]}, (640, 480), r'K is \[\[-500.0'),
    ({'K': K[:2] + [float('inf')] + K[3:]}, (640, 480), 'all must be finite'),
    ({'D': [NAN] * 5}, (640, 480), 'D is .*nan'),
    ({'distortion_model': 'pinhole'}, (640, 480), "distortion_model is 'pinhole'; known are: plumb_bob, rational"),
    ({'distortion_model': ''}, (640, 480), "distortion_model is ''"),
    ({'D': [0.1] * 9}, (640, 480), 'up to 8'),
    ({'distortion_model': 'equidistant'}, (640, 480), '4 finite numbers'),
    ({}, (320, 240), 'the image has 320x240 pixels, camera_info is for 640x480'),
    ({}, (640, 481), '640x481'),
    ({'binning_x': 2, 'binning_y': 2}, (640, 480), 'is for 320x240 .*binning 2x2'),
    ({'roi__width': 100, 'roi__height': 90}, (640, 480), 'is for 100x90 .*roi 100x90'),
])
def test_what_no_camera_can_have_is_refused(fields, size, said):
    with pytest.raises(CameraError, match=said):
        conversions.camera_of(info(**fields), *size)


def test_a_zero_p_of_a_rectified_picture_is_refused_as_p():
    with pytest.raises(CameraError, match='^P is'):
        conversions.camera_of(info(P=[0.0] * 12), 640, 480, rectified=True)


def test_keys_differ_as_soon_as_anything_of_the_camera_does():
    keys = [conversions.camera_key(info(**fields), 640, 480, False) for fields in (
        {}, {'K': [501.0] + K[1:]}, {'D': [0.1]}, {'P': [1.0] + P[1:]}, {'distortion_model': 'x'}, {'width': 1},
        {'binning_x': 2}, {'roi__x_offset': 1}, {'roi__width': 3})]
    keys += [conversions.camera_key(info(), 320, 480, False), conversions.camera_key(info(), 640, 480, True)]
    assert len(set(keys)) == len(keys)
    assert keys[0] == conversions.camera_key(info(header=Header(seq=7)), 640, 480, False)


@pytest.mark.parametrize('confidence, ambiguous, percent', [
    (0.99, False, 99), (0.65, False, 65), (1.2, False, 100), (0.99, True, 50), (1.0, True, 50), (0.65, True, 32),
    (-0.1, False, 0)])
def test_confidence_is_above_50_only_where_the_orientation_is_sure(confidence, ambiguous, percent):
    assert conversions.confidence(SimpleNamespace(confidence=confidence, ambiguous=ambiguous)) == percent


def test_confidence_of_a_doubtful_pose_is_at_most_50():
    doubtful = SimpleNamespace(confidence=0.9, ambiguous=False, doubtful=True)
    assert conversions.confidence(doubtful) == 45


def detection(marker_id):
    return Detection(marker_id, np.zeros((4, 2)), np.eye(3), np.zeros(3), 0.9, 0.0, False, 0.1, [])


def test_ids_that_are_no_numbers_are_left_out_and_two_markers_may_have_one_id():
    found = [detection(marker_id) for marker_id in (7, 'text', 2 ** 32, 2 ** 32 - 1, 7, 0)]
    fit, others = conversions.numbered(found)
    assert [d.id for d in fit] == [0, 7, 7, 2 ** 32 - 1] and others == ['text', 2 ** 32]


QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # a quarter turn about z
MARKER = MarkerPose(7, np.eye(3), np.array([1.0, 2.0, 3.0]), 98, 0.05)
HEADER = Header(frame_id='camera')
HALF = np.sqrt(0.5)


def numbers(message):
    return [getattr(message, name) for name in message.__slots__]


def test_the_transform_of_a_marker():
    message = conversions.transform_of(MARKER, HEADER)
    assert (message.header.frame_id, message.child_frame_id) == ('camera', 'ar_marker_7')
    assert numbers(message.transform.translation) == [1.0, 2.0, 3.0]
    assert numbers(message.transform.rotation) == pytest.approx([0, 0, 0, 1])


def test_the_cube_of_a_marker():
    message = conversions.rviz_marker_of(MARKER, HEADER)
    assert (message.type, message.action, message.ns, message.id) == (Marker.CUBE, Marker.ADD, 'basic_shapes', 7)
    assert numbers(message.scale) == pytest.approx([0.05, 0.05, 0.01])
    assert message.lifetime.to_sec() == 1.0
    assert numbers(message.pose.position) == [1.0, 2.0, 3.0]


@pytest.mark.parametrize('number, colour', [(0, (0, 0, 1)), (1, (1, 0, 0)), (2, (0, 1, 0)), (3, (0, 0.5, 0.5)),
                                            (4, (0.5, 0.5, 0)), (5, (0.5, 0, 0.5)), (70000, (0.5, 0, 0.5))])
def test_the_cubes_have_the_colours_of_the_original(number, colour):
    message = conversions.rviz_marker_of(replace(MARKER, id=number), HEADER)
    assert (message.color.r, message.color.g, message.color.b, message.color.a) == (*colour, 1.0)


def test_the_pose_in_another_frame():
    """The camera is at (10, 0, 0), turned by a quarter: camera (1, 2, 3) is (-2, 1, 3) in directions of the frame."""
    header = Header(frame_id='map')
    message = conversions.alvar_marker_of(MARKER, header, QUARTER, np.array([10.0, 0.0, 0.0]))
    assert (message.id, message.confidence) == (7, 98)
    assert message.header.frame_id == message.pose.header.frame_id == 'map'
    assert numbers(message.pose.pose.position) == pytest.approx([8.0, 1.0, 3.0])
    assert numbers(message.pose.pose.orientation) == pytest.approx([0, 0, HALF, HALF])


@pytest.mark.parametrize('scale', [1.0, 3.0])
def test_a_transform_becomes_a_matrix_also_when_its_quaternion_is_not_of_length_one(scale):
    rotation, translation = conversions.matrix_of(Transform(Vector3(1, 2, 3), Quaternion(0, 0, scale, scale)))
    assert np.abs(rotation - QUARTER).max() < CLOSE and translation.tolist() == [1, 2, 3]


def test_the_largest_ids_fit_into_the_messages():
    marker = MarkerPose(LARGEST_MARKER_ID, np.eye(3), np.zeros(3), 98, 0.05)
    for message in (conversions.rviz_marker_of(marker, HEADER),
                    AlvarMarkers(HEADER, [conversions.alvar_marker_of(marker, HEADER, np.eye(3), np.zeros(3))])):
        message.serialize(io.BytesIO())
