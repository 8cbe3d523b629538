"""rospy_support.message_size: what genpy takes for a message although bytes are missing or left over is told apart."""
import io

import pytest
from geometry_msgs.msg import PoseWithCovariance
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Empty, Float64MultiArray, Header, String
from std_srvs.srv import EmptyRequest, SetBoolRequest
from turtlesim.srv import SpawnRequest
from visualization_msgs.msg import MarkerArray

from rospy_support.message_size import wrong_size

MESSAGES = [  # fields of every kind: of fixed size, texts, times, arrays of both, arrays of fixed length, nested
    EmptyRequest(), SetBoolRequest(True), SpawnRequest(1.0, 2.0, 3.0, 'bob'), String('x' * 300), Empty(), Header(),
    PoseWithCovariance(), CameraInfo(D=[1.0] * 5, distortion_model='plumb_bob'), Image(data=b'123'),
    Float64MultiArray(data=[1.0, 2.0]), MarkerArray()]


def serialised(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


@pytest.mark.parametrize('message', MESSAGES, ids=lambda message: message._type)
def test_right_and_wrong_sizes(message):
    data = serialised(message)
    assert wrong_size(type(message), data) == ''
    assert f'{len(data) + 1} bytes, too many' in wrong_size(type(message), data + b'\0')
    if data:
        assert f'{len(data) - 1} bytes, too few' in wrong_size(type(message), data[:-1])


def test_the_text_says_what_is_expected():
    assert wrong_size(SpawnRequest, b'...') == (
        '3 bytes, too few: float32 x, float32 y, float32 theta, string name take 16 or more')
    assert wrong_size(SpawnRequest, b'.' * 12 + b'\0' * 6) == (
        '18 bytes, too many: float32 x, float32 y, float32 theta, string name take 16')
    assert wrong_size(EmptyRequest, b'...') == '3 bytes, too many: it has no fields'


@pytest.mark.parametrize('message_class, data', [
    (String, b'\xff\xff\xff\xffabc'), (MarkerArray, b'\xff\xff\xff\xff' + b'\0' * 8),
    (Float64MultiArray, b'\xff\xff\xff\xff' * 3),
])
def test_a_length_that_cannot_be_makes_no_work(message_class, data):
    assert 'too few' in wrong_size(message_class, data)


@given(st.binary(max_size=64), st.sampled_from(MESSAGES))
def test_any_bytes_get_an_answer(data, message):
    said = wrong_size(type(message), data)
    if not said:
        assert type(message)().deserialize(data) is not None
