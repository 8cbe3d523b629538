"""cv_bridge's Python interface: images of ROS to and from the arrays of OpenCV."""
from cv_bridge.bridge import CvBridge, CvBridgeError
from cv_bridge.encodings import getCvType

__all__ = ['CvBridge', 'CvBridgeError', 'getCvType']
