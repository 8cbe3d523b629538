"""Convert sensor_msgs images from and to numpy arrays, without cv_bridge, which brings its own OpenCV.

Arrays are (height, width) or (height, width, channels), uint8 or uint16 in this machine's byte order.
"""
import sys
from typing import Dict, NamedTuple, Optional, Sequence, Type

import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage, Image, PointCloud2, PointField
from std_msgs.msg import Header

from plain_support import is_truncated
from plain_support.arrays import Array


class ImageError(ValueError):
    """An image cannot be read; the text says why."""


class Encoding(NamedTuple):
    """Pixel format of an Image: type, number of channels, OpenCV's conversions to grey and BGR (None: not needed)."""

    type: Type[np.generic]
    channels: int
    grey: Optional[int]
    bgr: Optional[int]


_PLAIN = {
    'mono8': Encoding(np.uint8, 1, None, cv2.COLOR_GRAY2BGR),
    'mono16': Encoding(np.uint16, 1, None, cv2.COLOR_GRAY2BGR),
    '8UC1': Encoding(np.uint8, 1, None, cv2.COLOR_GRAY2BGR),
    '16UC1': Encoding(np.uint16, 1, None, cv2.COLOR_GRAY2BGR),
    '8UC3': Encoding(np.uint8, 3, cv2.COLOR_BGR2GRAY, None),
    '8UC4': Encoding(np.uint8, 4, cv2.COLOR_BGRA2GRAY, cv2.COLOR_BGRA2BGR),
    'yuv422': Encoding(np.uint8, 2, cv2.COLOR_YUV2GRAY_UYVY, cv2.COLOR_YUV2BGR_UYVY),
    'yuv422_yuy2': Encoding(np.uint8, 2, cv2.COLOR_YUV2GRAY_YUY2, cv2.COLOR_YUV2BGR_YUY2),
}
_COLOUR = {f'{order}{bits}': Encoding(kind, len(order), getattr(cv2, f'COLOR_{order.upper()}2GRAY'),
                                      getattr(cv2, f'COLOR_{order.upper()}2BGR', None))
           for bits, kind in ((8, np.uint8), (16, np.uint16)) for order in ('rgb', 'bgr', 'rgba', 'bgra')}
# OpenCV names a Bayer pattern after the second row's second and third pixel, ROS after the first row's first two
_BAYER = {f'bayer_{pattern}{bits}': Encoding(kind, 1, getattr(cv2, f'COLOR_BAYER_{opencv}2GRAY'),
                                             getattr(cv2, f'COLOR_BAYER_{opencv}2BGR'))
          for bits, kind in ((8, np.uint8), (16, np.uint16))
          for pattern, opencv in (('rggb', 'BG'), ('bggr', 'RG'), ('gbrg', 'GR'), ('grbg', 'GB'))}
DEPTH = '32FC1'  # [m], float32; read by depths(), not by pixels()
_DEPTHS = {DEPTH: Encoding(np.float32, 1, None, None), '16UC1': _PLAIN['16UC1']}
ENCODINGS = {**_PLAIN, **_COLOUR, **_BAYER}
_KINDS = {(np.dtype(np.uint8), 1): 'mono8', (np.dtype(np.uint16), 1): 'mono16', (np.dtype(np.uint8), 3): 'bgr8',
          (np.dtype(np.uint8), 4): 'bgra8'}
_FIELDS = [PointField(name, 4 * index, PointField.FLOAT32, 1) for index, name in enumerate(('x', 'y', 'z', 'rgb'))]
_AS_STORED = cv2.IMREAD_IGNORE_ORIENTATION  # a camera matrix describes the image before Exif rotates it


def pixels(image: Image) -> Array:
    """Return the encoded pixels of an Image, without a copy if possible; raise ImageError for unusable data."""
    return _array(image, ENCODINGS)


def depths(image: Image) -> Array:
    """Return the depths (height, width) float32 [m] of a depth Image; NaN or inf where nothing was measured.

    In millimetres (16UC1), 0 means the same (REP 118). Raise ImageError for other encodings and unusable data.
    """
    array = _array(image, _DEPTHS)
    if array.dtype == np.float32:
        return array
    return np.where(array == 0, np.float32(np.nan), array * np.float32(0.001))


def _array(image: Image, encodings: Dict[str, Encoding]) -> Array:
    encoding = encodings.get(image.encoding)
    if encoding is None:
        raise ImageError(f'encoding {image.encoding!r} is unknown; the known ones are: {", ".join(sorted(encodings))}')
    size = f'{image.width}x{image.height}'
    if not image.width or not image.height:
        raise ImageError(f'an image of {size} pixels has no pixels')
    if image.encoding.startswith('yuv') and image.width % 2:
        raise ImageError(f'an image of {size} pixels in {image.encoding} needs an even width')
    item = np.dtype(encoding.type).itemsize
    row = image.width * encoding.channels * item
    if image.step < row or image.step % item:
        raise ImageError(f'step is {image.step} bytes; a row of {image.width} pixels in {image.encoding} has {row}')
    needed = image.step * (image.height - 1) + row
    if len(image.data) < needed:
        raise ImageError(f'an image of {size} pixels in {image.encoding} has {len(image.data)} bytes of data, '
                         f'{image.step * image.height} are needed; is it cut off?')
    kind = np.dtype(encoding.type).newbyteorder('>' if image.is_bigendian else '<')
    shape = (image.height, image.width, encoding.channels)[:2 if encoding.channels == 1 else 3]
    strides = (image.step, encoding.channels * item, item)[:len(shape)]
    array = np.ndarray(shape, kind, image.data, strides=strides)
    return array.astype(encoding.type, copy=False)


def grey(image: Image) -> Array:
    """Return the grey image, (height, width) uint8, of an Image or a CompressedImage."""
    if isinstance(image, CompressedImage):
        return _decoded(image, cv2.IMREAD_GRAYSCALE)
    return _eight_bits(_converted(pixels(image), ENCODINGS[image.encoding].grey))


def bgr(image: Image) -> Array:
    """Return the colour image, (height, width, 3) uint8 in OpenCV's order, of an Image or a CompressedImage."""
    if isinstance(image, CompressedImage):
        return _decoded(image, cv2.IMREAD_COLOR)
    return _eight_bits(_converted(pixels(image), ENCODINGS[image.encoding].bgr))


def to_image(array: Array, encoding: Optional[str] = None, header: Optional[Header] = None) -> Image:
    """Return the Image of an array; without ``encoding``: mono8, mono16, bgr8 or bgra8. Raise ImageError."""
    array = np.asarray(array)
    channels = array.shape[2] if array.ndim == 3 else 1
    encoding = encoding or _KINDS.get((array.dtype, channels))
    known = _DEPTHS[DEPTH] if encoding == DEPTH else ENCODINGS.get(encoding or '')
    if known is None or array.ndim not in (2, 3) or (array.dtype, channels) != (np.dtype(known.type), known.channels):
        raise ImageError(f'an array of {array.dtype} {array.shape} is not an image in {encoding}')
    image = Image(height=array.shape[0], width=array.shape[1], encoding=encoding,
                  is_bigendian=int(sys.byteorder == 'big'), step=array.shape[1] * channels * array.itemsize,
                  data=array.tobytes())
    if header is not None:
        image.header = header
    return image


def to_compressed(array: Array, kind: str = 'jpeg', header: Optional[Header] = None, encoding: Optional[str] = None,
                  options: Sequence[int] = ()) -> CompressedImage:
    """Return the CompressedImage, 'jpeg' or 'png', of a grey, BGR or BGRA array, described as by image_transport.

    ``encoding`` is that of the raw Image, by default the array's; ``options`` are those of cv2.imencode.
    """
    array = np.ascontiguousarray(array)
    name = _KINDS[array.dtype, 1 if array.ndim == 2 else array.shape[2]]
    data = cv2.imencode(f'.{kind}', array, list(options))[1].tobytes()
    stored = '' if array.ndim == 2 else name
    image = CompressedImage(format=f'{encoding or name}; {kind} compressed {stored}', data=data)
    if header is not None:
        image.header = header
    return image


def to_cloud(points: Array, colour: Array, encoding: str, header: Header) -> PointCloud2:
    """Return an organised PointCloud2 of points (height, width, 3) float32 [m] and colours in bgr8 or rgb8."""
    height, width = points.shape[:2]
    packed = cv2.cvtColor(points, cv2.COLOR_BGR2BGRA)  # the fastest way to add a fourth channel
    four = cv2.cvtColor(colour, cv2.COLOR_BGR2BGRA if encoding == 'bgr8' else cv2.COLOR_RGB2BGRA)
    packed.view(np.uint32)[..., 3] = four.view(np.uint32)[..., 0] & 0xFFFFFF
    return PointCloud2(header=header, height=height, width=width, fields=_FIELDS, point_step=16, row_step=16 * width,
                       is_dense=False, data=packed.tobytes())


def _converted(array: Array, code: Optional[int]) -> Array:
    return array if code is None else cv2.cvtColor(np.ascontiguousarray(array), code)


def _eight_bits(array: Array) -> Array:
    return array if array.dtype == np.uint8 else (array >> 8).astype(np.uint8)


def _decoded(image: CompressedImage, flags: int) -> Array:
    data = np.frombuffer(image.data, np.uint8)
    cut = is_truncated(image.data)
    array = cv2.imdecode(data, flags | _AS_STORED) if data.size and not cut else None
    if array is None:
        why = 'it is cut off' if cut else 'OpenCV does not know its format'
        raise ImageError(f'a compressed image ({image.format!r}, {data.size} bytes) cannot be decoded: {why}')
    return array
