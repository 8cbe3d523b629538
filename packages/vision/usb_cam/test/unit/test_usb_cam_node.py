"""usb_cam_node with older versions of OpenCV."""
import cv2
import pytest

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
