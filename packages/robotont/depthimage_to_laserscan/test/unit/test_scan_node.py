"""depthimage_to_laserscan.node: its parameters, and where it looks for camera_info."""
import pytest
import rospy

from depthimage_to_laserscan.node import ScanNode, info_topic
from rospy_support.parameters import Parameter, ParameterError


@pytest.mark.parametrize('image, given, expected', [
    ('/camera/depth/image_rect_raw', '/camera_info', '/camera/depth/camera_info'),
    ('/camera/depth/image_rect_raw', '/mine/camera_info', '/mine/camera_info'),
    ('/image', '/camera_info', '/camera_info')])
def test_camera_info_lies_beside_the_images_unless_it_is_remapped(image, given, expected):
    """Launch files for the original remap only the images."""
    assert info_topic(image, given, '/camera_info') == expected


def test_a_range_that_ends_before_it_begins_is_refused(monkeypatch):
    given = {'~range_min': 5.0, '~range_max': 1.0}
    monkeypatch.setattr(Parameter, 'read', lambda self: given.get(self.name, self.default))
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name)
    with pytest.raises(ParameterError, match='range_min is 5; it must be below range_max, which is 1 m'):
        ScanNode()
