"""The node usb_cam_node: the interface of usb_cam for a Capture.

Threading contract: the Capture's thread makes and publishes all images; services run in rospy's threads. Plain rospy
Publishers with a queue of one have a thread for each subscriber, so that an image is sent completely while the next one
is captured, and a subscriber that stops reading delays only itself. (LatestPublisher sends what does not fit into a
socket's buffer with the next message. That suits small messages, but large ones would be one image late.)
"""
import os

import cv2
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyResponse

from rospy_support import nodes, parameters, rospy_internals
from rospy_support.images import to_compressed, to_image
from rospy_support.parameters import Boolean, Integer, Number, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher, SubscriptionListener
from usb_cam.camera_info import CameraInfos
from usb_cam.core.calibration import LARGEST_SIDE
from usb_cam.core.capture import STOP_TIMEOUT, Capture
from usb_cam.core.sources import FASTEST, PIXEL_FORMATS, Settings, open_source

PNG_OPTIONS = cv2.IMWRITE_PNG_COMPRESSION, 1  # fast
MONOCHROME = ('grey', 'yuvmono10')  # pixel formats that are published as mono8
REPEAT = 30.0  # [s] between two reports of the same problem
AUTO_EXPOSURE_OFF = 1  # V4L2_EXPOSURE_MANUAL
LEVELS = 'brightness', 'contrast', 'saturation', 'sharpness', 'gain'  # in the webcam's own units
PARAMETERS = Table(
    Text('~video_device', '/dev/video0'),
    Integer('~image_width', 640, 1, LARGEST_SIDE, 'px'), Integer('~image_height', 480, 1, LARGEST_SIDE, 'px'),
    Integer('~framerate', 30, 1, int(FASTEST), 'Hz'), Text('~pixel_format', 'mjpeg', PIXEL_FORMATS),
    Text('~io_method', 'mmap', ('mmap', 'read', 'userptr')),  # only checked, as the next one: OpenCV chooses
    Text('~color_format', 'yuv422p', ('yuv420p', 'yuv422p')),
    Number('~rate', 0.0, 0.0, FASTEST, 'Hz'), Boolean('~loop', True),
    *(Integer(f'~{name}', -1, -1) for name in LEVELS),
    Boolean('~auto_white_balance', True), Integer('~white_balance', 4000, 0, 100000, 'K'),
    Boolean('~autoexposure', True), Integer('~exposure', 100, 0, 1000000),
    Boolean('~autofocus', False), Integer('~focus', -1, -1),
    Text('~image_raw/compressed/format', 'jpeg', ('jpeg', 'png')),
    Integer('~image_raw/compressed/jpeg_quality', 80, 1, 100, '%'),
    Text('~camera_frame_id', 'head_camera'), Text('~camera_name', 'head_camera'), Text('~camera_info_url', ''),
    Number('~horizontal_fov', 0.0, 0.0, 179.0, 'degrees'))


class UsbCamNode:
    """The node of usb_cam; also the Sink of its Capture."""

    def __init__(self):
        """Read the parameters and register everything; rospy must be initialised."""
        self._device, self._frame_id, self._name = PARAMETERS.read('~video_device', '~camera_frame_id', '~camera_name')
        self._settings = _settings()
        self._mono = self._settings.pixel_format in MONOCHROME
        self._format, self._quality = PARAMETERS.read('~image_raw/compressed/format',
                                                      '~image_raw/compressed/jpeg_quality')
        self._infos = CameraInfos(self._name, *PARAMETERS.read('~camera_info_url', '~horizontal_fov'))
        parameters.log_effective()
        self._throttle = WallThrottle(REPEAT)
        self._capture = None
        listener = SubscriptionListener(lambda: self._capture and self._capture.wake())
        self._image = Publisher('~image_raw', Image, listener, tcp_nodelay=True, queue_size=1)
        self._compressed = Publisher('~image_raw/compressed', CompressedImage, listener, tcp_nodelay=True,
                                           queue_size=1)
        self._info = Publisher('~camera_info', CameraInfo, listener, tcp_nodelay=True, queue_size=1)
        self._capture = Capture(lambda: open_source(self._device, self._settings, self._warn), self)
        rospy.Service('~start_capture', Empty, self._start)
        rospy.Service('~stop_capture', Empty, self._stop)

    def run(self):
        """Capture until shutdown."""
        self._capture.start()
        rospy.spin()
        self._capture.close()

    def wanted(self):
        """Return whether there is a subscriber."""
        return bool(self._image.get_num_connections() or self._compressed.get_num_connections()
                    or self._info.get_num_connections())

    def opened(self, source):
        """Log the new source, and load its calibration."""
        rospy.loginfo("Starting '%s' (%s) at %dx%d %s", self._name, self._device, *source.size,
                      f'via mmap ({self._settings.pixel_format}) at {self._settings.framerate:g} FPS' if source.live
                      else f'at {source.rate:g} Hz')
        self._throttle.forget('trouble')
        self._infos.load(source.folder)

    def picture(self, source):
        """Publish the grabbed image on all topics with subscribers."""
        stamp = _stamp(source.age())
        if stamp is None:
            self._throttle.warn('time', 'use_sim_time is true, but there is no time on /clock yet; images will be '
                                'published as soon as there is.')
            return
        bgr = source.retrieve()
        if bgr is None:
            self._throttle.warn('broken', '%s sometimes sends broken images; they are skipped.', self._device)
            return
        height, width = bgr.shape[:2]
        header = Header(stamp=stamp, frame_id=self._frame_id)
        info = self._infos.message(width, height)
        info.header = header
        encoding = 'mono8' if self._mono else 'rgb8'
        if self._image.get_num_connections():
            pixels = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY if self._mono else cv2.COLOR_BGR2RGB)
            self._image.publish(to_image(pixels, encoding, header))
        if self._compressed.get_num_connections():
            pixels = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY) if self._mono else bgr
            options = (cv2.IMWRITE_JPEG_QUALITY, self._quality) if self._format == 'jpeg' else PNG_OPTIONS
            self._compressed.publish(to_compressed(pixels, self._format, header, encoding, options))
        self._info.publish(info)

    def trouble(self, text):
        """Warn that there are no images: a new reason at once, the same one after REPEAT."""
        if self._throttle.due('trouble', text, changed=0.0):
            rospy.logerr('%s Retrying.', text)

    def ended(self):
        """Log that the last image was shown."""
        rospy.loginfo('%s: that was the last image, and ~loop is false. Call %s to play it again.', self._device,
                      rospy.resolve_name('~start_capture'))

    def _warn(self, text):
        self._throttle.warn(text, '%s', text)  # an unusable source is opened again and again

    def _start(self, _):
        self._capture.start()
        return EmptyResponse()

    def _stop(self, _):
        if not self._capture.stop():
            raise rospy.ServiceException(f'{self._device} did not answer within {STOP_TIMEOUT:g} s; it will be '
                                         f'closed when it does')
        return EmptyResponse()


def _settings():
    """Return the Settings of a source from the parameters."""
    PARAMETERS.read('~io_method', '~color_format')  # only checked
    width, height, framerate, pixel_format, rate, loop = PARAMETERS.read(
        '~image_width', '~image_height', '~framerate', '~pixel_format', '~rate', '~loop')
    return Settings(width=width, height=height, framerate=framerate, pixel_format=pixel_format, controls=_controls(),
                    rate=rate, loop=loop)


def _controls():
    """Return the webcam's controls to set, [(name, OpenCV property, value)], in usb_cam's order; -1 sets none."""
    values = [(name, PARAMETERS[f'~{name}'].read()) for name in LEVELS]
    controls = [(name, getattr(cv2, f'CAP_PROP_{name.upper()}'), value) for name, value in values if value >= 0]
    auto_white_balance, white_balance = PARAMETERS.read('~auto_white_balance', '~white_balance')
    controls.append(('auto_white_balance', cv2.CAP_PROP_AUTO_WB, int(auto_white_balance)))
    if not auto_white_balance:
        controls.append(('white_balance', cv2.CAP_PROP_WB_TEMPERATURE, white_balance))
    autoexposure, exposure = PARAMETERS.read('~autoexposure', '~exposure')
    if not autoexposure:
        controls += [('autoexposure', cv2.CAP_PROP_AUTO_EXPOSURE, AUTO_EXPOSURE_OFF),
                     ('exposure', cv2.CAP_PROP_EXPOSURE, exposure)]
    autofocus, focus = PARAMETERS.read('~autofocus', '~focus')
    controls.append(('autofocus', cv2.CAP_PROP_AUTOFOCUS, int(autofocus)))
    if not autofocus and focus >= 0:
        controls.append(('focus', cv2.CAP_PROP_FOCUS, focus))
    return controls


def _stamp(age):
    """Return the time at which an image of this age [s] was taken; None while a simulated clock has not begun."""
    now = rospy.Time.now()
    if not rospy_internals.is_wall_time():
        return now or None
    return now - rospy.Duration.from_sec(age)


def silence_opencv():
    """Keep OpenCV from logging, where it can: 4.6, which Debian 12 has, lacks ``cv2.utils.logging``."""
    logging = getattr(cv2.utils, 'logging', None)
    if logging is not None:
        logging.setLogLevel(logging.LOG_LEVEL_SILENT)


def main():
    """Run usb_cam_node."""
    os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')  # quiet: this node reports problems itself
    os.environ.setdefault('OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT', '3')  # [s] a webcam may hang; below STOP_TIMEOUT
    silence_opencv()
    nodes.init_node('usb_cam', PARAMETERS)
    UsbCamNode().run()
