"""Sources of images: a webcam (V4L2), a video file, a folder of images or one image. Without ROS; not thread-safe."""
import os
import stat
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Tuple

import cv2
import numpy as np

from plain_support import is_truncated
from plain_support.doctor import devices

FOURCC = {'yuyv': 'YUYV', 'uyvy': 'UYVY', 'mjpeg': 'MJPG', 'yuvmono10': 'Y10 ', 'rgb24': 'RGB3', 'bgr24': 'BGR3',
          'grey': 'GREY', 'yu12': 'YU12', 'h264': 'H264'}  # usb_cam's pixel_format: V4L2's code
PIXEL_FORMATS = tuple(FOURCC)
IMAGE_SUFFIXES = ('.bmp', '.jpeg', '.jpg', '.pbm', '.pgm', '.png', '.pnm', '.ppm', '.tif', '.tiff', '.webp')
# as stored: an image that is rotated according to its EXIF data does not match its calibration
DECODE = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
OLDEST = 1.0  # [s] a V4L2 time stamp older than this belongs to another clock
BROKEN = 30  # consecutive broken images before a webcam is given up; the first ones are often broken
SLOWEST, FASTEST = 0.01, 1000.0  # [Hz] range in which the rate in a video file is trusted

Warn = Callable[[str], None]
OpenCapture = Callable[[str, int], cv2.VideoCapture]


class SourceError(Exception):
    """A source provides no images; the text names it, the reason, and what to do."""


class EndOfSource(Exception):
    """The source has no more images."""


@dataclass
class Settings:
    """The settings of a source; webcams ignore ``rate`` and ``loop``, files use only these and ``framerate``.

    width, height [px]; framerate [Hz]; pixel_format of PIXEL_FORMATS; controls [(name, OpenCV property, value)];
    rate [Hz], 0: a video's own, or framerate for images; loop: start again at the end.
    """

    width: int = 640
    height: int = 480
    framerate: float = 30.0
    pixel_format: str = 'mjpeg'
    controls: List[Tuple[str, int, float]] = field(default_factory=list)
    rate: float = 0.0
    loop: bool = True


class Source:
    """A source of images. The constructor opens it and reads a first image; ``close`` ends it.

    size    (width, height) [px] of all its images
    live    True if it sets the pace itself
    rate    [Hz] of its images, unless live
    folder  of its files, unless live
    """

    size: Tuple[int, int]
    live: bool
    rate: float
    folder: Optional[str]

    def grab(self) -> None:
        """Advance to the next image; raise EndOfSource or SourceError."""
        raise NotImplementedError

    def retrieve(self) -> Optional[np.ndarray]:
        """Return the grabbed image, (height, width, 3) uint8 BGR, or None if it is broken; at most once per grab."""
        raise NotImplementedError

    def age(self) -> float:
        """Return how long ago [s] the image was taken."""
        raise NotImplementedError

    def close(self) -> None:
        """Release the device or file."""
        raise NotImplementedError


def open_source(path: str, settings: Settings, warn: Warn, capture: OpenCapture = cv2.VideoCapture) -> Source:
    """Return the source for a path; raise SourceError.

    ``warn(text)`` is called for problems that do not prevent images; ``capture`` makes an OpenCV capture.
    """
    if not path:
        raise SourceError(f'video_device is empty; it must be a device, a file or a folder. {devices.listing()}')
    path = os.path.abspath(os.path.expanduser(path))
    if devices.is_device(path):
        return Webcam(path, settings, warn, capture)
    try:
        mode = os.stat(path).st_mode
    except OSError as error:
        raise SourceError(f'{path}: {error.strerror}. {devices.listing()}') from None
    if not stat.S_ISDIR(mode) and not stat.S_ISREG(mode):  # reading a pipe would block forever
        raise SourceError(f'{path} is neither a device nor a file nor a folder. {devices.listing()}')
    if stat.S_ISDIR(mode) or path.lower().endswith(IMAGE_SUFFIXES):
        return Images(path, settings, warn)
    return Video(path, settings, warn, capture)


class Webcam(Source):
    """A V4L2 device, read with OpenCV."""

    live, folder = True, None

    def __init__(self, path: str, settings: Settings, warn: Warn, capture: OpenCapture = cv2.VideoCapture) -> None:
        self._path = path
        if not os.access(path, os.R_OK | os.W_OK):
            raise SourceError(devices.explain(path))
        self._capture = capture(path, cv2.CAP_V4L2)
        if not self._capture.isOpened():
            self._capture.release()
            raise SourceError(devices.explain(path))
        self._set(settings, warn)
        self._broken = 0
        image = None
        try:
            while image is None:
                self.grab()
                image = self.retrieve()
        except SourceError:
            self._capture.release()
            raise
        self.size = image.shape[1], image.shape[0]
        self._compare(settings, warn)

    def grab(self) -> None:
        """Wait for the next image."""
        if not self._capture.grab():
            raise SourceError(devices.explain(self._path))
        self._grabbed = time.monotonic()

    def retrieve(self) -> Optional[np.ndarray]:
        """Return the image grabbed last, None if it is broken; raise SourceError after too many broken ones."""
        image = _retrieved(self._capture)
        if image is None:
            self._broken += 1
            if self._broken > BROKEN:
                raise SourceError(f'{self._path}: its images cannot be decoded; try another pixel_format.')
            return None
        self._broken = 0
        if len(image) == 1:  # some versions of OpenCV return bgr24 in one row
            return image.reshape(int(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT)), -1, 3)
        return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image

    def age(self) -> float:
        """Return how long ago [s] the image was taken, by the driver's time stamp if there is one."""
        age = time.monotonic() - self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        return age if 0.0 <= age <= OLDEST else time.monotonic() - self._grabbed

    def close(self) -> None:
        """Release the device."""
        self._capture.release()

    def _set(self, settings: Settings, warn: Warn) -> None:
        # the format first: sizes and rates depend on it
        fourcc = cv2.VideoWriter_fourcc  # type: ignore[attr-defined]  # the stubs lack this name, which all versions have
        self._capture.set(cv2.CAP_PROP_FOURCC, fourcc(*FOURCC[settings.pixel_format]))
        for name, value in (('WIDTH', settings.width), ('HEIGHT', settings.height)):
            self._capture.set(getattr(cv2, f'CAP_PROP_FRAME_{name}'), value)
        self._capture.set(cv2.CAP_PROP_FPS, settings.framerate)
        refused = [f'{name}={value}' for name, prop, value in settings.controls if not self._capture.set(prop, value)]
        if refused:
            warn(f'{self._path} rejects {", ".join(refused)}; v4l2-ctl --list-ctrls shows what it accepts.')

    def _compare(self, settings: Settings, warn: Warn) -> None:
        """Warn about every setting that the webcam does not use as requested."""
        size, rate = (settings.width, settings.height), self._capture.get(cv2.CAP_PROP_FPS)
        code = int(self._capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, 'little', signed=True).decode('ascii', 'replace')
        got = [('{}x{} pixels'.format(*size), '{}x{}'.format(*self.size), self.size == size),
               (f'the pixel_format {settings.pixel_format}', code.strip(), code == FOURCC[settings.pixel_format]),
               (f'{settings.framerate:g} images per second', f'{rate:g}', not 0.0 < rate <= settings.framerate - 1.0)]
        different = [f'{asked} (it delivers {given})' for asked, given, as_asked in got if not as_asked]
        if different:
            warn(f'{self._path} does not offer {", ".join(different)}.')


class _File(Source):
    live = False
    folder: str

    def age(self) -> float:
        """Return 0: an image shown now counts as taken now."""
        return 0.0


class Video(_File):
    """A video file, read with OpenCV's FFmpeg."""

    def __init__(self, path: str, settings: Settings, warn: Warn, capture: OpenCapture = cv2.VideoCapture) -> None:
        self._path, self._loop, self._warn, self._open = path, settings.loop, warn, capture
        self.folder = os.path.dirname(path)
        self._rewind()
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.rate = settings.rate or (rate if SLOWEST <= rate <= FASTEST else settings.framerate)
        self._announced = self._capture.get(cv2.CAP_PROP_FRAME_COUNT)
        height, width = self.retrieve().shape[:2]
        self.size = width, height
        self._number, self._first_is_due = 1, True  # the current image, which the first grab() has to return

    def grab(self) -> None:
        """Advance to the next image, from the last one to the first; without ``loop``, raise EndOfSource there."""
        if self._first_is_due:
            self._first_is_due = False
        elif self._capture.grab():
            self._number += 1
        else:
            if self._number < 0.9 * self._announced:  # some formats announce a few too many
                self._warn(f'{self._path} ends after {self._number} of {self._announced:.0f} images: is it complete?')
            if not self._loop:
                raise EndOfSource
            self._capture.release()
            self._rewind()
            self._number = 1

    def retrieve(self) -> np.ndarray:
        """Return the image grabbed last."""
        image = _retrieved(self._capture)
        if image is None:
            raise SourceError(f'{self._path}: an image of the video cannot be decoded.')
        return image

    def close(self) -> None:
        """Close the file."""
        self._capture.release()

    def _rewind(self) -> None:
        """Open the file and grab its first image."""
        self._capture = self._open(self._path, cv2.CAP_FFMPEG)
        if not self._capture.isOpened() or not self._capture.grab():
            self._capture.release()
            raise SourceError(f'{self._path}: {_unreadable(self._path)}')


class Images(_File):
    """The images of a folder in natural order, listed again for each round; or one image again and again.

    The first readable image determines the size. Images that are unreadable or have another size are skipped, each with
    one warning.
    """

    def __init__(self, path: str, settings: Settings, warn: Warn) -> None:
        self._path, self._loop, self._warn = path, settings.loop, warn
        self.folder = path if os.path.isdir(path) else os.path.dirname(path)
        self.rate = settings.rate or settings.framerate
        self._bad: Dict[str, Any] = {}  # path of a skipped image: its modification time, and the size asked
        self._list()
        self._find_next()
        self._first_is_due = True  # the current image, which the first grab() has to return

    def grab(self) -> None:
        """Advance to the next image, from the last one to the first; without ``loop``, raise EndOfSource there."""
        if self._first_is_due:
            self._first_is_due = False
        elif not self._find_next():
            if not self._loop:
                raise EndOfSource
            self._list()
            self._find_next()

    def retrieve(self) -> np.ndarray:
        """Return the current image."""
        return self._image

    def close(self) -> None:
        """Do nothing, because no file stays open."""

    def _list(self) -> None:
        """List the images for a new round."""
        try:
            names = os.listdir(self._path) if os.path.isdir(self._path) else ['']
        except OSError as error:
            raise SourceError(f'{self._path}: {error.strerror}.') from None
        self._remaining = [os.path.join(self._path, name).rstrip('/') for name in sorted(names, key=devices.natural)
                           if (name or self._path).lower().endswith(IMAGE_SUFFIXES)]
        if not self._remaining:
            raise SourceError(f'{self._path} contains no images; their names end in {", ".join(IMAGE_SUFFIXES)}.')
        self._round_size: Optional[Tuple[int, int]] = None
        self._listed = len(self._remaining)

    def _find_next(self) -> bool:
        """Read the next usable image; return whether there is one in this round."""
        while self._remaining:
            path = self._remaining.pop(0)
            state: Any = None
            try:
                status = os.stat(path)
                state = status.st_mtime_ns, self._round_size
                if self._bad.get(path) != state:
                    if not stat.S_ISREG(status.st_mode):
                        raise ValueError('it is not a file.')
                    self._image = self._read(path)
                    return True
            except FileNotFoundError:
                pass  # removed since the folder was listed
            except (OSError, ValueError, cv2.error) as error:
                self._warn(f'{path} is skipped: {getattr(error, "strerror", None) or error}')
                self._bad[path] = state
        if self._round_size is None:
            raise SourceError(f'{self._path}: none of the {self._listed} images can be read.')
        return False

    def _read(self, path: str) -> np.ndarray:
        with open(path, 'rb') as file:
            data = file.read()
        if not data:
            raise ValueError('the file is empty.')
        image = None if is_truncated(data) else cv2.imdecode(np.frombuffer(data, np.uint8), DECODE)
        if image is None:
            raise ValueError('the file is cut off or not an image.')
        height, width = image.shape[:2]
        if self._round_size not in (None, (width, height)):
            raise ValueError(f'it has {width}x{height} pixels, the first image {self.size[0]}x{self.size[1]}.')
        self.size = self._round_size = width, height
        return image


def _retrieved(capture: cv2.VideoCapture) -> Optional[np.ndarray]:
    """Return the image that an OpenCV capture grabbed last, or None if it cannot be decoded."""
    try:
        ok, image = capture.retrieve()
    except cv2.error:
        return None
    return image if ok and image is not None and image.size else None


def _unreadable(path: str) -> str:
    """Return why a file is not a video."""
    try:
        with open(path, 'rb') as file:
            return 'not a readable video: cut off, or of another kind.' if file.read(1) else 'the file is empty.'
    except OSError as error:
        return f'{error.strerror}.'
