"""rospy_support.topic_diagnosis: the text about a topic that brings nothing."""
import pytest

from rospy_support.topic_diagnosis import text_about

IMAGE, INFO = 'sensor_msgs/Image', 'sensor_msgs/CameraInfo'
TYPES = {'/a/image_raw': IMAGE, '/b/image_raw': IMAGE, '/a/camera_info': INFO, '/own/image': IMAGE, '/any': '*'}


@pytest.mark.parametrize('topic, publishers, text', [
    ('/camera_image', {}, f'/camera_image: no node publishes it. There is no other topic of type {IMAGE}.'),
    ('/camera_image', {'/b/image_raw': ['/b'], '/a/image_raw': ['/a', '/c'], '/a/camera_info': ['/a'],
                       '/own/image': []},
     f'/camera_image: no node publishes it. Topics of type {IMAGE}: /a/image_raw (by /a, /c), /b/image_raw (by /b); '
     'remap with camera_image:=/a/image_raw'),
    ('/b/image_raw', {'/b/image_raw': ['/b']},
     '/b/image_raw: /b publishes it, but no message arrives: does that node get its own input? '
     f'There is no other topic of type {IMAGE}.'),
    ('/any', {'/any': ['/r']},
     '/any: /r publishes it, but no message arrives: does that node get its own input? '
     f'There is no other topic of type {IMAGE}.'),
    ('/a/camera_info', {'/a/camera_info': ['/a', '/c']},
     f'/a/camera_info: /a, /c publishes it as {INFO}, not as {IMAGE}. There is no other topic of type {IMAGE}.'),
])
def test_it_says_who_publishes_and_what_there_is_instead(topic, publishers, text):
    assert text_about(topic, IMAGE, 'camera_image', TYPES, publishers) == text


def test_a_compressed_topic_is_remapped_by_the_name_of_its_picture():
    kind = 'sensor_msgs/CompressedImage'
    text = text_about('/camera_image/compressed', kind, 'camera_image', {'/a/image/compressed': kind},
                      {'/a/image/compressed': ['/a']})
    assert text.endswith('/a/image/compressed (by /a); remap with camera_image:=/a/image')
