"""cv_bridge: arrays and messages into each other. Expectations follow cv_bridge 1.16 with OpenCV 4.6."""
import subprocess
import sys

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from cv_bridge import CvBridge, CvBridgeError, getCvType

BRIDGE = CvBridge()
BLUE, GREEN, RED = 10, 20, 200


def message(encoding, *pixel, dtype=np.uint8, width=2, height=2):
    """Return an Image of equal pixels."""
    row = np.array([pixel] * width, dtype).tobytes()
    return Image(height=height, width=width, encoding=encoding, step=len(row), data=row * height)


def pixel(array):
    """Return the value of the only colour of an array."""
    assert (array == array[0, 0]).all()
    return array[0, 0].tolist()


@pytest.mark.parametrize('encoding, values, desired, expected', [
    ('bgr8', (BLUE, GREEN, RED), 'passthrough', [BLUE, GREEN, RED]),
    ('bgr8', (BLUE, GREEN, RED), 'bgr8', [BLUE, GREEN, RED]),
    ('bgr8', (BLUE, GREEN, RED), 'rgb8', [RED, GREEN, BLUE]),
    ('rgb8', (RED, GREEN, BLUE), 'bgr8', [BLUE, GREEN, RED]),
    ('rgb8', (RED, GREEN, BLUE), 'bgra8', [BLUE, GREEN, RED, 255]),
    ('rgba8', (RED, GREEN, BLUE, 7), 'bgra8', [BLUE, GREEN, RED, 7]),
    # 0.299 R + 0.587 G + 0.114 B = 59.8 + 11.74 + 1.14 = 72.68
    ('rgb8', (RED, GREEN, BLUE), 'mono8', 73),
    ('mono8', (9,), 'bgr8', [9, 9, 9]),
    ('mono8', (9,), 'mono16', 9 * 257),
    ('bgr8', (BLUE, GREEN, RED), 'bgr16', [BLUE * 257, GREEN * 257, RED * 257]),
    ('bgr8', (BLUE, GREEN, RED), '8UC3', [BLUE, GREEN, RED]),
    ('8UC1', (9,), '32FC1', 9.0),
    ('8UC1', (9,), '16UC1', 9 * 257),
    ('yuv422', (128, 50), 'mono8', 50),  # U or V, Y
    ('yuv422_yuy2', (50, 128), 'mono8', 50),
])
def test_image_to_array(encoding, values, desired, expected):
    assert pixel(BRIDGE.imgmsg_to_cv2(message(encoding, *values), desired)) == expected


@pytest.mark.parametrize('encoding, values, dtype, desired, expected', [
    ('mono16', (1000,), np.uint16, 'passthrough', 1000),
    ('mono16', (1000,), np.uint16, 'mono8', 4),  # 1000 / 257 = 3.89
    ('16UC1', (1000,), np.uint16, 'passthrough', 1000),
    ('32FC1', (1.5,), np.float32, 'passthrough', 1.5),
    ('32FC1', (300.0,), np.float32, '8UC1', 255),
    ('64FC2', (1.5, -2.0), np.float64, 'passthrough', [1.5, -2.0]),
    ('8SC1', (-3,), np.int8, '32SC1', -3),
])
def test_image_of_other_numbers_to_array(encoding, values, dtype, desired, expected):
    assert pixel(BRIDGE.imgmsg_to_cv2(message(encoding, *values, dtype=dtype), desired)) == expected


@pytest.mark.parametrize('pattern, first', [('rggb', 'R'), ('bggr', 'B')])
def test_bayer_pattern(pattern, first):
    raw = np.zeros((8, 8), np.uint8)
    raw[::2, ::2] = 200  # the colour that the pattern begins with
    image = Image(height=8, width=8, encoding=f'bayer_{pattern}8', step=8, data=raw.tobytes())
    blue, green, red = BRIDGE.imgmsg_to_cv2(image, 'bgr8')[4, 4].tolist()
    assert (blue, green, red) == ((0, 0, 200) if first == 'R' else (200, 0, 0))


@pytest.mark.parametrize('encoding, desired, said', [
    ('8UC3', 'bgr8', 'not known to be colours'), ('8UC1', 'mono8', 'not known to be colours'),
    ('bgr8', '8UC1', 'channels'), ('bgr8', 'bayer_rggb8', 'cannot become'),
    ('bgr8', 'nonsense', "'nonsense' is unknown"),
    ('nonsense', 'passthrough', "'nonsense' is unknown"), ('bgr8', '8UC7', "'8UC7' is unknown"),
])
def test_what_makes_no_sense_is_refused(encoding, desired, said):
    with pytest.raises(CvBridgeError, match=said):
        BRIDGE.imgmsg_to_cv2(message(encoding, *([1] * (1 if encoding == '8UC1' else 3))), desired)


def test_rows_may_be_padded_and_big_endian():
    rows = np.array([[1, 2, 999], [3, 4, 999]], '>u2')
    image = Image(height=2, width=2, encoding='mono16', step=6, is_bigendian=1, data=rows.tobytes())
    array = BRIDGE.imgmsg_to_cv2(image)
    assert array.tolist() == [[1, 2], [3, 4]] and array.dtype == np.dtype(np.uint16)


@pytest.mark.parametrize('change, said', [({'step': 5}, 'a row of 2 pixels in bgr8 has 6'),
                                          ({'data': b'12345678901'}, 'has 11 bytes of data; 12 are needed')])
def test_impossible_messages_are_refused(change, said):
    image = message('bgr8', 1, 2, 3)
    for field, value in change.items():
        setattr(image, field, value)
    with pytest.raises(CvBridgeError, match=said):
        BRIDGE.imgmsg_to_cv2(image)


@pytest.mark.parametrize('desired', ['passthrough', 'bgr8', 'rgb8'])
def test_array_of_a_message_can_be_drawn_on(desired):
    array = BRIDGE.imgmsg_to_cv2(message('bgr8', 1, 2, 3), desired)
    cv2.circle(array, (0, 0), 1, (255, 255, 255), -1)
    assert array[0, 0].tolist() == [255, 255, 255]


@pytest.mark.parametrize('array, encoding, expected', [
    (np.zeros((2, 3), np.uint8), 'passthrough', ('8UC1', 3)), (np.zeros((2, 3, 3), np.uint8), 'bgr8', ('bgr8', 9)),
    (np.zeros((2, 3, 3), np.uint8), '8UC3', ('8UC3', 9)), (np.zeros((2, 3), np.uint16), 'mono16', ('mono16', 6)),
    (np.zeros((2, 3, 1), np.float32), '32FC1', ('32FC1', 12)),
    (np.zeros((2, 3, 2), np.int16), 'passthrough', ('16SC2', 12)),
])
def test_array_to_image(array, encoding, expected):
    image = BRIDGE.cv2_to_imgmsg(array, encoding, Header(frame_id='eye'))
    assert (image.encoding, image.step) == expected and image.header.frame_id == 'eye'
    assert (image.height, image.width, image.is_bigendian) == (2, 3, 0) and len(image.data) == 2 * image.step


def test_views_and_foreign_byte_orders_become_right_messages():
    array = np.arange(24, dtype='>u2').reshape(4, 6)[::2, ::3]
    assert BRIDGE.imgmsg_to_cv2(BRIDGE.cv2_to_imgmsg(array, 'mono16')).tolist() == array.tolist()


@pytest.mark.parametrize('array, encoding, said', [
    (np.zeros((2, 3), np.uint8), 'bgr8', 'is of type 8UC1, but bgr8 needs 8UC3'), ([[1]], 'passthrough', 'not list'),
    (np.zeros(3, np.uint8), 'passthrough', 'not an image'),
    (np.zeros((2, 3), np.int64), 'passthrough', 'no images of int64'),
    (np.zeros((2, 3, 5), np.uint8), 'passthrough', '1 to 4 channels'),
])
def test_arrays_that_are_no_images_are_refused(array, encoding, said):
    with pytest.raises(CvBridgeError, match=said):
        BRIDGE.cv2_to_imgmsg(array, encoding)


@pytest.mark.parametrize('array, desired, expected', [
    (np.full((8, 8, 3), (BLUE, GREEN, RED), np.uint8), 'passthrough', [BLUE, GREEN, RED]),
    (np.full((8, 8, 3), (BLUE, GREEN, RED), np.uint8), 'rgb8', [RED, GREEN, BLUE]),
    (np.full((8, 8), 50, np.uint8), 'bgr8', [50, 50, 50]), (np.full((8, 8), 257, np.uint16), 'mono8', 1)])
def test_compressed_and_back(array, desired, expected):
    compressed = BRIDGE.cv2_to_compressed_imgmsg(array, 'png')
    assert compressed.format == 'png' and pixel(BRIDGE.compressed_imgmsg_to_cv2(compressed, desired)) == expected


@pytest.mark.parametrize('data', [b'', b'no image',
                                  cv2.imencode('.jpg', np.zeros((50, 50), np.uint8))[1].tobytes()[:-30]])
def test_compressed_images_that_cannot_be_decoded_are_refused(data):
    with pytest.raises(CvBridgeError, match='cannot be decoded'):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage(format='jpeg', data=data))


def test_an_unknown_format_is_refused():
    with pytest.raises(CvBridgeError, match="as 'nonsense'"):
        BRIDGE.cv2_to_compressed_imgmsg(np.zeros((2, 2), np.uint8), 'nonsense')


def test_names_of_types():
    assert getCvType('bgr8') == BRIDGE.encoding_to_cvtype2('8UC3') == cv2.CV_8UC3
    assert BRIDGE.encoding_to_dtype_with_channels('mono16') == ('uint16', 1)
    assert BRIDGE.cvtype2_to_dtype_with_channels(cv2.CV_32FC2) == ('float32', 2)
    assert BRIDGE.dtype_with_channels_to_cvtype2(np.dtype('uint8'), 3) == '8UC3'
    with pytest.raises(CvBridgeError):
        BRIDGE.cvtype2_to_dtype_with_channels(-1)


def test_a_program_finds_it_beside_our_opencv():
    program = 'import cv_bridge, cv2; print(cv_bridge.__file__); cv_bridge.CvBridge()'
    result = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert not result.stdout.startswith('/usr/')
