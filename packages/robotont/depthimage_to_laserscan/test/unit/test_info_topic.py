"""depthimage_to_laserscan.node: launch files for the original remap only the images."""
import pytest

from depthimage_to_laserscan.node import info_topic


@pytest.mark.parametrize('image, given, expected', [
    ('/camera/depth/image_rect_raw', '/camera_info', '/camera/depth/camera_info'),
    ('/camera/depth/image_rect_raw', '/mine/camera_info', '/mine/camera_info'),
    ('/image', '/camera_info', '/camera_info')])
def test_camera_info_lies_beside_the_images_unless_it_is_remapped(image, given, expected):
    assert info_topic(image, given, '/camera_info') == expected
