"""The Python interface of cv_bridge: convert ROS images to arrays of OpenCV and back."""
from cv_bridge.bridge import CvBridge, CvBridgeError
from cv_bridge.encodings import getCvType

__all__ = ['CvBridge', 'CvBridgeError', 'getCvType']
