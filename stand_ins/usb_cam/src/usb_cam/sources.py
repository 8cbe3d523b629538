"""Where pictures come from: a webcam (V4L2), a video file, a folder of pictures or one picture. Without ROS.

A source is open from its constructor on, which has seen a first picture: ``size`` (width, height) [px] is the size of
all its pictures, ``live`` whether it keeps its own pace, else ``rate`` [Hz] is that of its pictures and ``folder`` the
one that they lie in. ``grab`` goes on to the next picture; ``retrieve``, once a grab at most, returns it, (height,
width, 3) uint8 BGR, or None when it is broken; ``age`` [s] tells how long ago it was taken; ``close`` lets go of the
device. Not thread safe.
"""
import os
import stat
import time
from dataclasses import dataclass, field

import cv2
import numpy as np

from usb_cam import devices

FOURCC = {'yuyv': 'YUYV', 'uyvy': 'UYVY', 'mjpeg': 'MJPG', 'yuvmono10': 'Y10 ', 'rgb24': 'RGB3', 'bgr24': 'BGR3',
          'grey': 'GREY', 'yu12': 'YU12', 'h264': 'H264'}  # pixel_format as usb_cam calls it: as V4L2 does
PIXEL_FORMATS = tuple(FOURCC)
PICTURES = ('.bmp', '.jpeg', '.jpg', '.pbm', '.pgm', '.png', '.pnm', '.ppm', '.tif', '.tiff', '.webp')
# as stored: turning a picture as its EXIF data say would take it away from its calibration
DECODE = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
JPEG_BEGINS, JPEG_ENDS, TRAILER = b'\xff\xd8', b'\xff\xd9', 1024  # [bytes] that cameras may add after the end
OLDEST = 1.0  # [s] a V4L2 time stamp that says more is on another clock
BROKEN = 30  # pictures in a row that a webcam may send before it is given up; the first ones often are
SLOWEST, FASTEST = 0.01, 1000.0  # [Hz] what a video may say about its rate


class SourceError(Exception):
    """There are no pictures; the text says of what, why, and what to do."""


class EndOfSource(Exception):
    """The last picture was the last one."""


@dataclass
class Settings:
    """What is asked of a source: of a webcam all but ``rate`` and ``loop``, of files only these and ``framerate``.

    width, height [px]; framerate [Hz]; pixel_format of PIXEL_FORMATS; controls [(name, OpenCV property, value)];
    rate [Hz], 0: a video's own, framerate for pictures; loop: begin again at the end.
    """

    width: int = 640
    height: int = 480
    framerate: float = 30.0
    pixel_format: str = 'mjpeg'
    controls: list = field(default_factory=list)
    rate: float = 0.0
    loop: bool = True


def open_source(path, settings, warn, capture=cv2.VideoCapture):
    """Return the source that a path stands for; raise SourceError.

    ``warn(text)`` is told what is wrong without being the end; ``capture`` makes an OpenCV capture.
    """
    if not path:
        raise SourceError(f'video_device is empty: it must be a device, a file or a folder. {devices.listing()}')
    path = os.path.abspath(os.path.expanduser(path))
    if devices.is_device(path):
        return Webcam(path, settings, warn, capture)
    try:
        mode = os.stat(path).st_mode
    except OSError as error:
        raise SourceError(f'{path}: {error.strerror}. {devices.listing()}') from None
    if not stat.S_ISDIR(mode) and not stat.S_ISREG(mode):  # a pipe would be waited for for ever
        raise SourceError(f'{path} is neither a device nor a file nor a folder. {devices.listing()}')
    if stat.S_ISDIR(mode) or path.lower().endswith(PICTURES):
        return Pictures(path, settings, warn)
    return Video(path, settings, warn, capture)


class Webcam:
    """A V4L2 device by OpenCV."""

    live, folder, rate = True, None, None

    def __init__(self, path, settings, warn, capture=cv2.VideoCapture):
        self._path = path
        if not os.access(path, os.R_OK | os.W_OK):
            raise SourceError(devices.explain(path))
        self._capture = capture(path, cv2.CAP_V4L2)
        if not self._capture.isOpened():
            self._capture.release()
            raise SourceError(devices.explain(path))
        self._set(settings, warn)
        self._broken, picture = 0, None
        try:
            while picture is None:
                self.grab()
                picture = self.retrieve()
        except SourceError:
            self._capture.release()
            raise
        self.size = picture.shape[1], picture.shape[0]
        self._compare(settings, warn)

    def grab(self):
        """Wait for the next picture."""
        if not self._capture.grab():
            raise SourceError(devices.explain(self._path))
        self._grabbed = time.monotonic()

    def retrieve(self):
        """Return the picture grabbed last; raise SourceError when too many in a row were broken."""
        picture = _retrieved(self._capture)
        if picture is None:
            self._broken += 1
            if self._broken > BROKEN:
                raise SourceError(f'{self._path}: its pictures cannot be decoded; try another pixel_format.')
            return None
        self._broken = 0
        if len(picture) == 1:  # some OpenCVs hand out bgr24 in one row
            return picture.reshape(int(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT)), -1, 3)
        return cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture

    def age(self):
        """Return how long ago [s] the picture was taken, by the driver's time stamp where it has one."""
        age = time.monotonic() - self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        return age if 0.0 <= age <= OLDEST else time.monotonic() - self._grabbed

    def close(self):
        """Let go of the device."""
        self._capture.release()

    def _set(self, settings, warn):
        # first the format: sizes and rates depend on it
        self._capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*FOURCC[settings.pixel_format]))
        for name, value in (('WIDTH', settings.width), ('HEIGHT', settings.height)):
            self._capture.set(getattr(cv2, f'CAP_PROP_FRAME_{name}'), value)
        self._capture.set(cv2.CAP_PROP_FPS, settings.framerate)
        refused = [f'{name}={value}' for name, prop, value in settings.controls if not self._capture.set(prop, value)]
        if refused:
            warn(f'{self._path} does not take {", ".join(refused)}; v4l2-ctl --list-ctrls shows what it takes.')

    def _compare(self, settings, warn):
        """Warn of what the webcam gives instead of what it was asked for."""
        size, rate = (settings.width, settings.height), self._capture.get(cv2.CAP_PROP_FPS)
        code = int(self._capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, 'little', signed=True).decode('ascii', 'replace')
        got = [('{}x{} pixels'.format(*size), '{}x{}'.format(*self.size), self.size == size),
               (f'the pixel_format {settings.pixel_format}', code.strip(), code == FOURCC[settings.pixel_format]),
               (f'{settings.framerate:g} pictures a second', f'{rate:g}', not 0.0 < rate <= settings.framerate - 1.0)]
        different = [f'{asked} (it gives {given})' for asked, given, as_asked in got if not as_asked]
        if different:
            warn(f'{self._path} does not offer {", ".join(different)}.')


class _File:
    live = False

    def age(self):
        """Return 0: what is shown now counts as taken now."""
        return 0.0


class Video(_File):
    """A video file by OpenCV's FFmpeg."""

    def __init__(self, path, settings, warn, capture=cv2.VideoCapture):
        self._path, self._loop, self._warn, self._open = path, settings.loop, warn, capture
        self.folder = os.path.dirname(path)
        self._rewind()
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.rate = settings.rate or (rate if SLOWEST <= rate <= FASTEST else settings.framerate)
        self._announced = self._capture.get(cv2.CAP_PROP_FRAME_COUNT)
        height, width = self.retrieve().shape[:2]
        self.size = width, height
        self._number, self._held = 1, True

    def grab(self):
        """Go on to the next picture; after the last to the first again. Raises EndOfSource without ``loop``."""
        if self._held:
            self._held = False
        elif self._capture.grab():
            self._number += 1
        else:
            if self._number < 0.9 * self._announced:  # formats count a few too many
                self._warn(f'{self._path} ends after {self._number} of {self._announced:.0f} pictures: is it whole?')
            if not self._loop:
                raise EndOfSource
            self._capture.release()
            self._rewind()
            self._number = 1

    def retrieve(self):
        """Return the picture grabbed last."""
        picture = _retrieved(self._capture)
        if picture is None:
            raise SourceError(f'{self._path}: a picture of the video could not be decoded.')
        return picture

    def close(self):
        """Let go of the file."""
        self._capture.release()

    def _rewind(self):
        """Open the file and grab its first picture."""
        self._capture = self._open(self._path, cv2.CAP_FFMPEG)
        if not self._capture.isOpened() or not self._capture.grab():
            self._capture.release()
            raise SourceError(f'{self._path}: {_unreadable(self._path)}')


class Pictures(_File):
    """The pictures of a folder in their natural order, listed anew for each round; or one picture again and again.

    The first one that can be read decides on the size; others that cannot be read, or are of another size, are named
    once and left out.
    """

    def __init__(self, path, settings, warn):
        self._path, self._loop, self._warn = path, settings.loop, warn
        self.folder = path if os.path.isdir(path) else os.path.dirname(path)
        self.rate = settings.rate or settings.framerate
        self.size, self._bad = None, {}
        self._list()
        self._find_next()
        self._held = True

    def grab(self):
        """Go on to the next picture; after the last to the first again. Raises EndOfSource without ``loop``."""
        if self._held:
            self._held = False
        elif not self._find_next():
            if not self._loop:
                raise EndOfSource
            self._list()
            self._find_next()

    def retrieve(self):
        """Return the picture that ``grab`` went on to."""
        return self._picture

    def close(self):
        """Nothing is held open."""

    def _list(self):
        """Begin a round."""
        try:
            names = os.listdir(self._path) if os.path.isdir(self._path) else ['']
        except OSError as error:
            raise SourceError(f'{self._path}: {error.strerror}.') from None
        self._rest = [os.path.join(self._path, name).rstrip('/') for name in sorted(names, key=devices.natural)
                      if (name or self._path).lower().endswith(PICTURES)]
        if not self._rest:
            raise SourceError(f'{self._path} holds no pictures; they end in {", ".join(PICTURES)}.')
        self.size, self._seen = None, len(self._rest)

    def _find_next(self):
        """Read the next picture that can be used; return whether there is one in this round."""
        while self._rest:
            path = self._rest.pop(0)
            try:
                status = os.stat(path)
                state = status.st_mtime_ns, self.size
                if self._bad.get(path) != state:
                    if not stat.S_ISREG(status.st_mode):
                        raise ValueError('it is no file.')
                    self._picture = self._read(path)
                    return True
            except FileNotFoundError:
                pass  # removed since the folder was listed
            except (OSError, ValueError, cv2.error) as error:
                self._warn(f'{path} is left out: {getattr(error, "strerror", None) or error}')
                self._bad[path] = state
        if self.size is None:
            raise SourceError(f'{self._path}: none of the {self._seen} pictures can be read.')
        return False

    def _read(self, path):
        with open(path, 'rb') as file:
            data = file.read()
        if not data:
            raise ValueError('the file is empty.')
        cut_off = data.startswith(JPEG_BEGINS) and JPEG_ENDS not in data[-TRAILER:]  # older OpenCVs fill up with grey
        picture = None if cut_off else cv2.imdecode(np.frombuffer(data, np.uint8), DECODE)
        if picture is None:
            raise ValueError('the file is cut off or no picture.')
        height, width = picture.shape[:2]
        if self.size not in (None, (width, height)):
            raise ValueError(f'it has {width}x{height} pixels, those before {self.size[0]}x{self.size[1]}.')
        self.size = width, height
        return picture


def _retrieved(capture):
    """Return the picture that an OpenCV capture grabbed last, or None when it cannot be decoded."""
    try:
        ok, picture = capture.retrieve()
    except cv2.error:
        return None
    return picture if ok and picture is not None and picture.size else None


def _unreadable(path):
    """Return why a file is no video."""
    try:
        with open(path, 'rb') as file:
            return 'no video that can be read: cut off, or of another kind.' if file.read(1) else 'the file is empty.'
    except OSError as error:
        return f'{error.strerror}.'
