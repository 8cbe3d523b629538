"""``~camera_info`` and ``~set_camera_info``: manage the calibration in use, as camera_info_manager does.

Threading contract: one thread calls ``load`` and ``message``; the service runs in rospy's threads. A lock orders them.
"""
import math
import os
import threading

import rospkg
import rospy
from sensor_msgs.msg import CameraInfo, RegionOfInterest
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse

from plain_support import unwritten
from rospy_support.throttle import WallThrottle
from usb_cam.core import calibration
from usb_cam.core.calibration import Calibration, CalibrationError

IN_FOLDER = 'camera.yaml'  # calibration of the images in the same folder


class CameraInfos:
    """Provides the calibration at ``url``, or a substitute while there is none.

    ``name`` is the name of the camera. Without a calibration, ``horizontal_fov`` [degrees] gives an approximate one; if
    it is 0, K is all zeros.
    """

    def __init__(self, name, url, horizontal_fov):
        self._name, self._url, self._fov = name, url, horizontal_fov
        self._lock = threading.Lock()
        self._path, self._calibration, self._message = None, None, None
        self._once = WallThrottle(math.inf)  # for warnings: a source may be opened often
        self._given = False  # ~set_camera_info has set the calibration, which stays for all sources
        rospy.Service('~set_camera_info', SetCameraInfo, self._set)

    def load(self, folder):
        """Read the calibration for a source with files in ``folder`` (None: a webcam)."""
        with self._lock:
            if self._given:
                return
            self._message = self._calibration = None
            try:
                self._path = self._locate(folder)
                self._calibration = known = calibration.read(self._path)
                rospy.loginfo('camera calibration: %s', self._path)
                if known.camera_name != self._name and self._path != _beside(folder):
                    self._say(rospy.logwarn,
                              f'[{self._name}] does not match name {known.camera_name} in file {self._path}')
            except FileNotFoundError:
                self._say(rospy.logwarn, f'Camera calibration file {self._path} not found. {self._instead()}')
            except CalibrationError as error:
                self._say(rospy.logerr, f'Camera calibration refused: {error}. {self._instead()}')

    def message(self, width, height):
        """Return the CameraInfo of images with this size [px]; the same object, unless it has changed."""
        with self._lock:
            if self._message is None or (self._message.width, self._message.height) != (width, height):
                self._message = to_message(self._fitting(width, height), width, height)
            return self._message

    def _locate(self, folder):
        if not self._url and folder and os.path.exists(_beside(folder)):
            return _beside(folder)
        return self._default_path()

    def _default_path(self):
        return calibration.locate(self._url, self._name, rospkg.get_ros_home(), _package_path)

    def _fitting(self, width, height):
        """Return the Calibration to use for images with this size, or None."""
        if self._calibration is not None and self._calibration.size != (width, height):
            self._say(rospy.logerr, f'The calibration {self._path} is for images of {self._calibration.image_width}x'
                                    f'{self._calibration.image_height} (image_width, image_height); these are '
                                    f'{width}x{height}. {self._instead()}')
        elif self._calibration is not None:
            return self._calibration
        if not self._fov:
            return None
        guess = calibration.approximate(width, height, self._fov)
        self._say(rospy.logwarn, f'~camera_info is approximate: fx = fy = {guess.camera_matrix[0]:.1f} px from '
                                 f'horizontal_fov = {self._fov:g} degrees, no distortion.')
        return guess

    def _say(self, log, text):
        if self._once.due(text):
            log('%s', text)

    def _instead(self):
        if self._fov:
            return f'Using an approximate one, from horizontal_fov = {self._fov:g} degrees.'
        return ('Continuing without calibration: K in ~camera_info is all zeros. Calibrate the camera (package '
                'camera_calibration), or set _horizontal_fov to its angle of view in degrees.')

    def _set(self, request):
        with self._lock:
            try:
                self._calibration = from_message(request.camera_info, self._name)
            except CalibrationError as error:
                return SetCameraInfoResponse(False, f'set_camera_info refused: {error}')
            self._given, self._message = True, None
            try:
                self._path = self._path or self._default_path()
                calibration.write(self._path, self._calibration)
            except (OSError, CalibrationError) as error:
                why = unwritten(error, 'choose _camera_info_url:=file://PATH') if isinstance(error, OSError) else error
                return SetCameraInfoResponse(False, 'The calibration is used until this node ends, but is not kept: '
                                                    f'{why}')
        rospy.loginfo('writing calibration data to %s', self._path)
        return SetCameraInfoResponse(True, f'written to {self._path}')


def to_message(known, width, height):
    """Return the CameraInfo of a Calibration; for None, one with zeros and the size [px]."""
    if known is None:
        return CameraInfo(width=width, height=height)
    return CameraInfo(
        width=width, height=height, distortion_model=known.distortion_model, D=known.distortion_coefficients,
        K=known.camera_matrix, R=known.rectification_matrix, P=known.projection_matrix, binning_x=known.binning_x,
        binning_y=known.binning_y, roi=RegionOfInterest(**dict(known.roi)))


def from_message(info, name):
    """Return the Calibration of the camera ``name`` from a CameraInfo; raise CalibrationError."""
    roi = tuple((key, getattr(info.roi, key)) for key in calibration.ROI)
    return Calibration(info.width, info.height, name, tuple(info.K), info.distortion_model, tuple(info.D),
                       tuple(info.R), tuple(info.P), info.binning_x, info.binning_y, roi)


def _beside(folder):
    return os.path.join(folder, IN_FOLDER) if folder else None


def _package_path(package):
    try:
        return rospkg.RosPack().get_path(package)
    except rospkg.ResourceNotFound:
        raise LookupError(package) from None
