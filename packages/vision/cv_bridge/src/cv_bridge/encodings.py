"""The encodings of sensor_msgs/Image, and conversions between them.

``mono8``, ``bgr8``, ``bayer_rggb8`` and so on mean colours; ``8UC3``, ``32FC1`` and so on are only types of numbers.
"""
import re
from typing import NamedTuple

import cv2
import numpy as np

from rospy_support.images import ENCODINGS

DEPTHS = {'8U': np.uint8, '8S': np.int8, '16U': np.uint16, '16S': np.int16, '32S': np.int32, '32F': np.float32,
          '64F': np.float64}
CHANNELS = (1, 2, 3, 4)
NUMBERS = re.compile(rf'({"|".join(DEPTHS)})(?:C([{"".join(map(str, CHANNELS))}]))?')
COLOURS = re.compile('(mono|rgba?|bgra?)(8|16)|(bayer_.*|yuv422.*)')
BLACK_TO_WHITE = {(1, 2): 65535.0 / 255.0, (2, 1): 255.0 / 65535.0}  # bytes of a number before and after: factor


class CvBridgeError(TypeError):
    """An image cannot be converted; the text says why."""


class Pixels(NamedTuple):
    """The type of a pixel: ``depth`` (a key of DEPTHS) and the number of channels."""

    depth: str
    channels: int

    @property
    def name(self):
        """Return OpenCV's name, such as 8UC3."""
        return f'{self.depth}C{self.channels}'


def pixels(encoding):
    """Return the Pixels of an encoding; raise CvBridgeError for an unknown one."""
    numbers = NUMBERS.fullmatch(encoding)
    if numbers:
        return Pixels(numbers[1], int(numbers[2] or 1))
    known = ENCODINGS.get(encoding)
    if known is None:
        raise CvBridgeError(f'the encoding {encoding!r} is unknown; the known ones are {", ".join(sorted(ENCODINGS))}, '
                            f'and numbers without a meaning such as {Pixels("32F", 1).name}')
    return Pixels(depth_of(known.type), known.channels)


def depth_of(dtype):
    """Return the key in DEPTHS of a numpy type; raise CvBridgeError if OpenCV does not support it."""
    for depth, known in DEPTHS.items():
        if np.dtype(dtype).newbyteorder('=') == known:
            return depth
    raise CvBridgeError(f'OpenCV has no images of {np.dtype(dtype).name}; it has '
                        f'{", ".join(np.dtype(known).name for known in DEPTHS.values())}')


def getCvType(encoding):  # cv_bridge's name
    """Return OpenCV's number of an encoding's type, such as cv2.CV_8UC3."""
    return getattr(cv2, f'CV_{pixels(encoding).name}')


def converted(image, encoding, desired):
    """Return an array in the encoding ``desired``; raise CvBridgeError if such a conversion is not possible."""
    if encoding == desired:
        return image
    ours, wanted = pixels(encoding), pixels(desired)
    if COLOURS.fullmatch(encoding) and COLOURS.fullmatch(desired):
        return _as_depth(_recoloured(image, encoding, desired), wanted.depth)
    if COLOURS.fullmatch(desired):
        raise CvBridgeError(f'an image in {encoding} cannot become one in {desired}: its numbers are not known to be '
                            'colours. Ask for passthrough, and convert the array yourself')
    if ours.channels != wanted.channels:
        raise CvBridgeError(f'an image in {encoding} has {ours.channels} channels, one in {desired} {wanted.channels}')
    return _as_depth(image, wanted.depth)


def _as_depth(image, depth):
    """Return the image with another depth: scale between 8 and 16 bits, and limit values that are too large."""
    kind = np.dtype(DEPTHS[depth])
    if image.dtype == kind:
        return image
    values = image * BLACK_TO_WHITE.get((image.itemsize, kind.itemsize), 1.0)
    if kind.kind == 'f':
        return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.rint(values), limits.min, limits.max).astype(kind)


def _recoloured(image, encoding, desired):
    ours, wanted = _space(encoding), _space(desired)
    if ours == wanted and ours is not None:
        return image
    if wanted is None or (encoding.startswith('bayer') and wanted.endswith('A')):
        raise CvBridgeError(f'an image in {encoding} cannot become one in {desired}')
    image = np.ascontiguousarray(image)
    if ours is None:  # a Bayer pattern or YUV
        known = ENCODINGS[encoding]
        if wanted == 'GRAY':
            return cv2.cvtColor(image, known.grey)
        image, ours = cv2.cvtColor(image, known.bgr), 'BGR'
    return image if ours == wanted else cv2.cvtColor(image, getattr(cv2, f'COLOR_{ours}2{wanted}'))


def _space(encoding):
    """Return OpenCV's name for the colours of an encoding; None for Bayer patterns and YUV, which can only be read."""
    order = COLOURS.fullmatch(encoding)[1]
    return {'mono': 'GRAY', None: None}.get(order, order and order.upper())
