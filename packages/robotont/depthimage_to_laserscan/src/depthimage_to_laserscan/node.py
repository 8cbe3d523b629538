"""The node depthimage_to_laserscan: a LaserScan for each depth image.

Threading contract: rospy's threads of the two subscriptions; a camera_info is stored in one assignment, and the thread
of the images makes the scans.
"""
import rospy
from sensor_msgs.msg import CameraInfo, Image, LaserScan

from depthimage_to_laserscan.core.projection import Camera, ScanError, Settings, scan
from rospy_support import nodes, parameters
from rospy_support.images import ImageError, depths
from rospy_support.parameters import Integer, Number, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher

NAME = 'depthimage_to_laserscan'
FARTHEST = 10.0  # [m] the most that the original allows
REPEAT = 5.0  # [s] between two reports of the same trouble
PARAMETERS = Table(Integer('~scan_height', 1, 1, 500, 'px'), Number('~scan_time', 0.033, 0.0, 1.0, 's'),
                   Number('~range_min', 0.45, 0.0, FARTHEST, 'm'), Number('~range_max', FARTHEST, 0.0, FARTHEST, 'm'),
                   Text('~output_frame_id', 'camera_depth_frame'))


class ScanNode:
    """Publishes ``scan`` while it has subscribers."""

    def __init__(self) -> None:
        """Read the parameters and register everything."""
        height, self._scan_time, nearest, farthest, self._frame = PARAMETERS.read()
        if nearest >= farthest:
            name = rospy.resolve_name('~range_min')
            raise parameters.ParameterError(f'parameter {name} is {nearest:g}; it must be below range_max, which is '
                                            f'{farthest:g} m. Set both with _range_min:=0.45 _range_max:=10')
        self._settings = Settings(height, nearest, farthest)
        self._throttle = WallThrottle(REPEAT)
        self._info: CameraInfo = None
        self._scan = Publisher('scan', LaserScan, queue_size=10)
        self._info_topic = info_topic(rospy.resolve_name('image'), rospy.resolve_name('camera_info'),
                                      f'{rospy.get_namespace()}camera_info')
        rospy.Subscriber(self._info_topic, CameraInfo, self._on_info, queue_size=1)
        rospy.Subscriber('image', Image, self._on_image, queue_size=1, buff_size=2 ** 24, tcp_nodelay=True)
        parameters.log_effective()

    def _on_info(self, info: CameraInfo) -> None:
        self._info = info

    def _on_image(self, image: Image) -> None:
        if not self._scan.get_num_connections():
            return
        info = self._info
        if info is None:
            self._throttle.warn('info', 'No message on %s yet; scans begin with it.', self._info_topic)
            return
        try:
            found = scan(depths(image), _camera(info), self._settings)
        except (ImageError, ScanError) as error:
            self._throttle.warn('image', 'Ignored an image on %s: %s', rospy.resolve_name('image'), error)
            return
        message = LaserScan(angle_min=found.first, angle_max=found.last,
                            angle_increment=(found.last - found.first) / max(1, len(found.ranges) - 1),
                            scan_time=self._scan_time, range_min=self._settings.nearest,
                            range_max=self._settings.farthest, ranges=found.ranges.tolist())
        message.header.stamp, message.header.frame_id = image.header.stamp, self._frame or image.header.frame_id
        self._scan.publish(message)


def info_topic(image: str, given: str, default: str) -> str:
    """Return the topic of camera_info for that of the images: beside it, as in image_transport, unless it is remapped.

    ``given`` is camera_info as it is remapped, ``default`` as it is not.
    """
    return given if given != default else f'{image.rpartition("/")[0]}/camera_info'


def _camera(info: CameraInfo) -> Camera:
    """Return the Camera of a CameraInfo; P is that of rectified images, but some drivers fill in only K."""
    return Camera(info.P[0], info.P[2], info.P[6]) if info.P[0] else Camera(info.K[0], info.K[2], info.K[5])


def main() -> None:
    """Run depthimage_to_laserscan."""
    nodes.init_node(NAME, PARAMETERS)
    ScanNode()
    rospy.spin()
