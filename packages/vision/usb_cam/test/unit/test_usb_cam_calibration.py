"""usb_cam.core.calibration: good and bad files, where they lie, writing, and the approximation."""
import math

import pytest

from usb_cam.core.calibration import CalibrationError, approximate, locate, parse, read, write

# What camera_calibration writes, with numbers of its own for each entry.
GOOD = '''image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [ 601.5,   0. , 320.25,
            0. , 602.5, 240.75,
            0. ,   0. ,   1.  ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.4, 0.2, 1e-05, -0.002, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [590.5, 0, 319.5, 0, 0, 591.5, 239.5, 0, 0, 0, 1, 0]
'''


def test_a_good_file_is_read_number_by_number():
    known = parse(GOOD)
    assert known.size == (640, 480) and known.camera_name == 'head_camera'
    assert known.camera_matrix == (601.5, 0.0, 320.25, 0.0, 602.5, 240.75, 0.0, 0.0, 1.0)
    assert known.distortion_model == 'plumb_bob'
    assert known.distortion_coefficients == (-0.4, 0.2, 0.00001, -0.002, 0.0)  # 1e-05 is a text to PyYAML
    assert known.rectification_matrix == (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    assert known.projection_matrix == (590.5, 0.0, 319.5, 0.0, 0.0, 591.5, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0)


@pytest.mark.parametrize('old, new, field, value', [
    ('distortion_model: plumb_bob\n', '', 'distortion_model', 'plumb_bob'),
    ('camera_name: head_camera\n', '', 'camera_name', 'unknown'),
    ('camera_name: head_camera', 'camera_name: head_camera\nbinning_x: 2', 'binning_x', 2),
    ('camera_name: head_camera', 'camera_name: x\nroi: {x_offset: 4, width: 8, do_rectify: true}', 'roi',
     (('x_offset', 4), ('y_offset', 0), ('height', 0), ('width', 8), ('do_rectify', True))),
    ('plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.4, 0.2, 1e-05, -0.002, 0]',
     'equidistant\ndistortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [1, 2, 3, 4]',
     'distortion_coefficients', (1.0, 2.0, 3.0, 4.0)),
])
def test_what_may_be_missing_or_otherwise(old, new, field, value):
    assert old in GOOD
    assert getattr(parse(GOOD.replace(old, new)), field) == value


@pytest.mark.parametrize('old, new, said', [
    (GOOD, '', 'not a calibration: it must have the keys image_width'),
    (GOOD, '- 1\n- 2', 'not a calibration'),
    (GOOD, 'a: [1', 'not YAML'),
    ('image_width: 640\n', '', 'image_width is missing; a calibration has image_width, image_height, camera_name'),
    ('image_height: 480\n', '', 'image_height is missing'),
    ('camera_matrix:', 'camera_matrx:', 'camera_matrix is missing'),
    ('distortion_coefficients:', 'other:', 'distortion_coefficients is missing'),
    ('rectification_matrix:', 'other:', 'rectification_matrix is missing'),
    ('projection_matrix:', 'other:', 'projection_matrix is missing'),
    ('image_width: 640', 'image_width: 0', 'image_width is 0; it must be a whole number from 1 to'),
    ('image_width: 640', 'image_width: 640.5', 'image_width is 640.5'),
    ('image_width: 640', 'image_width: yes', 'image_width is True'),
    ('image_height: 480', 'image_height: -480', 'image_height is -480'),
    ('image_height: 480', 'image_height: 10000000', 'image_height is 10000000'),
    ('[ 601.5', '[ .nan', 'camera_matrix is [nan'),
    ('[ 601.5', '[ nan', 'camera_matrix is [nan'),
    ('591.5', '.inf', 'projection_matrix is [590.5, 0.0, 319.5, 0.0, 0.0, inf'),
    ('-0.4', '-.inf', 'distortion_coefficients is [-inf'),
    ('[ 601.5', '[ 0', 'camera_matrix has fx = 0 and fy = 602.5; both must be above 0'),
    ('602.5', '-602.5', 'fy = -602.5'),
    ('[ 601.5', '[ six', "camera_matrix is ['six', 0.0"),
    ('[ 601.5', '[ true', 'camera_matrix is [True, 0.0'),
    ('[ 601.5,', '[', 'camera_matrix has 8 numbers in data, but rows and cols are (3, 3)'),
    ('rows: 3\n  cols: 4', 'rows: 4\n  cols: 3', 'projection_matrix has rows and cols (4, 3); it must be (3, 4)'),
    ('cols: 5', 'cols: 4', 'distortion_coefficients has 5 numbers in data, but rows and cols are (1, 4)'),
    ('cols: 5\n  data: [-0.4,', 'cols: 3\n  data: [0] #', 'distortion_coefficients has 1 numbers in data'),
    ('cols: 5\n  data: [-0.4, 0.2,', 'cols: 3\n  data: [', 'has 3 numbers; plumb_bob needs 4 or 5'),
    ('data: [1, 0, 0, 0, 1, 0, 0, 0, 1]', 'data: 7', 'rectification_matrix is {'),
    ('plumb_bob', 'plum_bob', "distortion_model is 'plum_bob'; it must be one of plumb_bob, rational_polynomial"),
    ('plumb_bob', 'rational_polynomial', 'has 5 numbers; rational_polynomial needs 8 or 12 or 14'),
    ('camera_name: head_camera', 'roi: 7', 'roi is 7'),
    ('camera_name: head_camera', 'roi: {width: -7}', 'roi: width is -7'),
    ('camera_name: head_camera', 'binning_x: two', "binning_x is 'two'"),
])
def test_bad_files_are_refused_with_the_key(old, new, said, tmp_path):
    assert old in GOOD
    path = tmp_path / 'bad.yaml'
    path.write_text(GOOD.replace(old, new, 1), encoding='utf-8')
    with pytest.raises(CalibrationError) as error:
        read(str(path))
    assert str(error.value).startswith(f'{path}: ') and said in str(error.value)


def test_what_is_no_text_file(tmp_path):
    (tmp_path / 'a.yaml').write_bytes(b'\xff\xfe\0image')
    with pytest.raises(CalibrationError, match='a.yaml: not UTF-8 text'):
        read(str(tmp_path / 'a.yaml'))
    with pytest.raises(CalibrationError, match='Is a directory'):
        read(str(tmp_path))
    with pytest.raises(FileNotFoundError):
        read(str(tmp_path / 'none.yaml'))


def test_what_is_written_is_read_again_and_nothing_else_is_left(tmp_path):
    known = parse(GOOD.replace('camera_name: head_camera', 'camera_name: a\nbinning_y: 3\nroi: {height: 7}'))
    path = tmp_path / 'new' / 'folder' / 'a.yaml'
    write(str(path), known)
    assert read(str(path)) == known
    assert [entry.name for entry in path.parent.iterdir()] == ['a.yaml']
    text = path.read_text(encoding='utf-8')  # roscpp's parser wants rows, cols and data in a sequence
    assert 'camera_matrix:\n  rows: 3\n  cols: 3\n  data: [601.5, 0.0, 320.25,' in text


@pytest.mark.parametrize('fov, f', [
    (90.0, 320.0), (60.0, 320.0 * math.sqrt(3.0)), (2.0 * math.degrees(math.atan(0.5)), 640.0)])
def test_approximation_has_half_the_width_under_half_the_angle(fov, f):
    # tan(fov / 2) = (640 / 2) / f; the middle of 640x480 pixels from 0 to 639 and 479 is (319.5, 239.5)
    known = approximate(640, 480, fov)
    assert known.camera_matrix == pytest.approx((f, 0.0, 319.5, 0.0, f, 239.5, 0.0, 0.0, 1.0))
    assert known.projection_matrix == pytest.approx((f, 0.0, 319.5, 0.0, 0.0, f, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0))
    assert set(known.distortion_coefficients) == {0.0}


def packages(name):
    return {'robot': '/opt/robot'}[name]


@pytest.mark.parametrize('url, path', [
    ('', '/home/.ros/camera_info/cam.yaml'),
    ('file:///a/b.yaml', '/a/b.yaml'),
    ('FILE:///a/${NAME}_${NAME}.yaml', '/a/cam_cam.yaml'),
    ('file://${ROS_HOME}/c.yaml', '/home/.ros/c.yaml'),
    ('package://robot/calib/${NAME}.yaml', '/opt/robot/calib/cam.yaml'),
])
def test_urls(url, path):
    assert locate(url, 'cam', '/home/.ros', packages) == path


@pytest.mark.parametrize('url, said', [
    ('/a/b.yaml', 'it must be file:///FOLDER/FILE.yaml or package://'),
    ('file://a/b.yaml', 'it must be'), ('file:///', 'it must be'), ('http://a/b', 'it must be'),
    ('package://robot', 'it must be'), ('package:///b.yaml', 'it must be'), ('file:///${HOME}/a.yaml', 'it must be'),
    ('package://robbot/a.yaml', "there is no package 'robbot'"),
])
def test_urls_that_lead_nowhere(url, said):
    with pytest.raises(CalibrationError, match=said) as error:
        locate(url, 'cam', '/home/.ros', packages)
    assert repr(url) in str(error.value)
