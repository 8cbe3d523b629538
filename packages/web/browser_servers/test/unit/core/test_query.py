"""Requests of a browser, and the pictures that it gets."""
import cv2
import numpy as np
import pytest

from browser_servers.core.query import InvalidQuery, Query, content_type, depth_picture, encoded, read

RED = np.full((40, 60, 3), (0, 0, 255), np.uint8)


def read_fields(**fields):
    return read(fields.get, 'mjpeg')


@pytest.mark.parametrize('fields, query', [
    ({'topic': '/camera/image_raw'}, Query('/camera/image_raw')), ({'topic': 'image'}, Query('/image')),
    ({'topic': '/a', 'type': 'png', 'quality': '-1', 'width': '320', 'invert': ''},
     Query('/a', 'png', 95, 320, 0, True)),
    ({'topic': '/a', 'type': 'ros_compressed', 'quality': '30'}, Query('/a', 'ros_compressed', 30)),
])
def test_query_is_read(fields, query):
    assert read_fields(**fields) == query


@pytest.mark.parametrize('fields, error', [
    ({}, 'needs the topic of an image'), ({'topic': '/a b'}, "it has '/a b'"), ({'topic': '../etc'}, 'needs the topic'),
    ({'topic': '/a', 'type': 'vp8'}, 'type=vp8 is not supported here; use one of mjpeg'),
    ({'topic': '/a', 'type': 'gif'}, 'must be one of mjpeg, ros_compressed, png'),
    ({'topic': '/a', 'quality': '0'}, 'quality=0 must be a whole number from 1 to 100'),
    ({'topic': '/a', 'width': '99999'}, 'width=99999 must be'),
    ({'topic': '/a', 'height': '1e3'}, 'height=1e3 must be'), ({'topic': 'x' * 1001}, 'at most 1000 characters'),
    ({'topic': '/a', 'width': '\u0661'}, 'must be a whole number'), ({'topic': '/\u00e4'}, 'needs the topic'),
])
def test_wrong_query_is_refused(fields, error):
    with pytest.raises(InvalidQuery, match=error):
        read_fields(**fields)


@pytest.mark.parametrize('query, kind, size', [
    (Query('/a'), 'image/jpeg', (40, 60)), (Query('/a', 'png'), 'image/png', (40, 60)),
    (Query('/a', width=30), 'image/jpeg', (20, 30)), (Query('/a', height=80), 'image/jpeg', (80, 120)),
    (Query('/a', width=10, height=10), 'image/jpeg', (10, 10)), (Query('/a', width=1), 'image/jpeg', (1, 1)),
])
def test_image_has_the_kind_and_size_that_were_asked_for(query, kind, size):
    data = encoded(RED, query)
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert content_type(data) == kind and picture.shape[:2] == size
    assert np.abs(picture.astype(int) - (0, 0, 255)).max() <= 3  # what JPEG may change a plain colour by


def test_inverted_image_is_upside_down():
    image = RED.copy()
    image[0, 0] = 0
    picture = cv2.imdecode(np.frombuffer(encoded(image, Query('/a', 'png', invert=True)), np.uint8), cv2.IMREAD_COLOR)
    assert picture[-1, -1].tolist() == [0, 0, 0] and picture[0, 0].tolist() == [0, 0, 255]


def test_distances_become_grey():
    picture = depth_picture(np.array([[0.0, 1.0, 2.0, np.nan, np.inf]], np.float32))
    assert picture[0, :, 0].tolist() == [0, 127, 255, 0, 0]
    assert depth_picture(np.zeros((2, 2), np.float32)).max() == 0
