"""ar_track_alvar.inputs: the text about a topic that brings nothing."""
import pytest

from ar_track_alvar.inputs import text_about, without

IMAGE, INFO = 'sensor_msgs/Image', 'sensor_msgs/CameraInfo'
TYPES = {'/a/image_raw': IMAGE, '/b/image_raw': IMAGE, '/a/camera_info': INFO, '/old/image': IMAGE}


@pytest.mark.parametrize('topic, publishers, parts', [
    ('/camera_image', {}, ['/camera_image: nobody publishes it', f'no topic of type {IMAGE} at all']),
    ('/camera_image', {'/b/image_raw': ['/b'], '/a/image_raw': ['/a', '/c'], '/a/camera_info': ['/a']},
     ['/camera_image: nobody',
      '/a/image_raw (by /a, /c), /b/image_raw (by /b); remap with camera_image:=/a/image_raw']),
    ('/b/image_raw', {'/b/image_raw': ['/b']}, ['/b publishes it, but nothing comes', 'does the camera run?']),
    ('/a/camera_info', {'/a/camera_info': ['/a']}, [f'/a publishes it as {INFO}, not as {IMAGE}']),
])
def test_it_says_what_there_is_and_what_to_type(topic, publishers, parts):
    text = text_about(topic, IMAGE, 'camera_image', TYPES, publishers)
    for part in parts:
        assert part in text


def test_the_tracker_s_own_pictures_are_not_proposed_to_it():
    publishers = {'/tracker/debug_image': ['/tracker'], '/a': ['/x', '/tracker'], '/b': []}
    assert without('/tracker', publishers) == {'/a': ['/x']}


def test_a_compressed_topic_is_remapped_by_the_name_of_its_picture():
    kind = 'sensor_msgs/CompressedImage'
    text = text_about('/camera_image/compressed', kind, 'camera_image', {'/a/image/compressed': kind},
                      {'/a/image/compressed': ['/a']})
    assert text.endswith('/a/image/compressed (by /a); remap with camera_image:=/a/image')
