"""usb_cam_node: its stamps, and older versions of OpenCV."""
import cv2
import pytest
import rospy

from usb_cam import node


@pytest.mark.skipif(not hasattr(cv2.utils, 'logging'), reason='OpenCV before 4.7')
def test_opencv_is_silenced_only_where_it_can_be(monkeypatch):
    before = cv2.utils.logging.getLogLevel()
    try:
        node.silence_opencv()
        assert cv2.utils.logging.getLogLevel() == cv2.utils.logging.LOG_LEVEL_SILENT
    finally:
        cv2.utils.logging.setLogLevel(before)
    monkeypatch.delattr(cv2.utils, 'logging')
    node.silence_opencv()


@pytest.mark.parametrize('wall, now, expected', [(True, 100.0, 99.5), (False, 100.0, 100.0), (False, 0.0, None)])
def test_stamp_is_the_time_of_the_image_and_in_simulated_time_that_of_the_clock(wall, now, expected, monkeypatch):
    """Half a second after the image was taken; before the simulated clock begins there is no stamp."""
    monkeypatch.setattr(node.rospy_internals, 'is_wall_time', lambda: wall)
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(now))
    stamp = node._stamp(0.5)
    assert (stamp and stamp.to_sec()) == expected
