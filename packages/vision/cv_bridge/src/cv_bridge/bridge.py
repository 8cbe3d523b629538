"""CvBridge, with the methods of cv_bridge 1.16."""
import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from cv_bridge.encodings import CHANNELS, DEPTHS, CvBridgeError, Pixels, converted, depth_of, getCvType, pixels
from plain_support import is_truncated

PASSTHROUGH = 'passthrough'  # the encoding of the image itself
DECODED = {1: 'mono', 3: 'bgr', 4: 'bgra'}  # number of channels of an image that OpenCV has decoded: their order


class CvBridge:
    """Converts between messages of sensor_msgs and arrays (height, width) or (height, width, channels).

    Arrays from messages are writable, and have the byte order of this machine.
    """

    def imgmsg_to_cv2(self, img_msg, desired_encoding=PASSTHROUGH):
        """Return the array of an Image in the desired encoding; raise CvBridgeError."""
        kind = pixels(img_msg.encoding)
        array = _array(img_msg, kind)
        if desired_encoding in (PASSTHROUGH, ''):
            return array
        return converted(array, img_msg.encoding, desired_encoding)

    def compressed_imgmsg_to_cv2(self, cmprs_img_msg, desired_encoding=PASSTHROUGH):
        """Return the array of a CompressedImage in the desired encoding; raise CvBridgeError."""
        data = np.frombuffer(cmprs_img_msg.data, np.uint8)
        cut = is_truncated(cmprs_img_msg.data)
        array = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size and not cut else None
        if array is None:
            raise CvBridgeError(f'a compressed image ({cmprs_img_msg.format!r}, {data.size} bytes) cannot be decoded: '
                                + ('it is cut off' if cut else 'OpenCV does not know its format'))
        if desired_encoding in (PASSTHROUGH, ''):
            return array
        colours = DECODED[1 if array.ndim == 2 else array.shape[2]]
        return converted(array, f'{colours}{8 * array.itemsize}', desired_encoding)

    def cv2_to_imgmsg(self, cvim, encoding=PASSTHROUGH, header=None):
        """Return the Image of an array with values in ``encoding``; raise CvBridgeError."""
        kind = _kind_of(cvim)
        if encoding == PASSTHROUGH:
            encoding = kind.name
        elif pixels(encoding).name != kind.name:
            raise CvBridgeError(f'an array of {cvim.dtype} {cvim.shape} is of type {kind.name}, but {encoding} needs '
                                f'{pixels(encoding).name}')
        native = np.ascontiguousarray(cvim, cvim.dtype.newbyteorder('<'))
        message = Image(height=cvim.shape[0], width=cvim.shape[1], encoding=encoding, is_bigendian=0,
                        step=cvim.shape[1] * kind.channels * cvim.itemsize, data=native.tobytes())
        if header is not None:
            message.header = header
        return message

    def cv2_to_compressed_imgmsg(self, cvim, dst_format='jpg'):
        """Return the CompressedImage of an array, in a format of cv2.imencode; raise CvBridgeError."""
        _kind_of(cvim)
        try:
            done, data = cv2.imencode(f'.{dst_format}', cvim)
        except cv2.error as error:
            raise CvBridgeError(f'OpenCV cannot encode an array of {cvim.dtype} {cvim.shape} as {dst_format!r}: '
                                f'{error.err}') from None
        if not done:
            raise CvBridgeError(f'OpenCV cannot encode an array of {cvim.dtype} {cvim.shape} as {dst_format!r}')
        return CompressedImage(format=dst_format, data=data.tobytes())

    def encoding_to_cvtype2(self, encoding):
        """Return OpenCV's number of the encoding's type, such as cv2.CV_8UC3."""
        return getCvType(encoding)

    def encoding_to_dtype_with_channels(self, encoding):
        """Return the encoding's numpy type by name and its number of channels, such as ('uint8', 3)."""
        kind = pixels(encoding)
        return np.dtype(DEPTHS[kind.depth]).name, kind.channels

    def cvtype2_to_dtype_with_channels(self, cvtype):
        """Return the same for OpenCV's number of a type."""
        for depth, known in DEPTHS.items():
            for channels in CHANNELS:
                if getattr(cv2, f'CV_{Pixels(depth, channels).name}') == cvtype:
                    return np.dtype(known).name, channels
        raise CvBridgeError(f'{cvtype!r} is not a type of OpenCV')

    def dtype_with_channels_to_cvtype2(self, dtype, n_channels):
        """Return OpenCV's name of a numpy type with channels, such as 8UC3."""
        return Pixels(depth_of(dtype), n_channels).name


def _array(message, kind):
    """Return a new array of an Image's pixels."""
    dtype = np.dtype(DEPTHS[kind.depth])
    row = message.width * kind.channels * dtype.itemsize
    step = message.step or row
    if step < row or step % dtype.itemsize:
        raise CvBridgeError(f'step is {step} bytes; a row of {message.width} pixels in {message.encoding} has {row}')
    needed = step * (message.height - 1) + row if message.height else 0
    if len(message.data) < needed:
        raise CvBridgeError(f'an image of {message.width}x{message.height} pixels in {message.encoding} has '
                            f'{len(message.data)} bytes of data; {needed} are needed')
    shape = (message.height, message.width, kind.channels)[:2 if kind.channels == 1 else 3]
    strides = (step, kind.channels * dtype.itemsize, dtype.itemsize)[:len(shape)]
    order = dtype.newbyteorder('>' if message.is_bigendian else '<')
    return np.ndarray(shape, order, message.data, strides=strides).astype(dtype)


def _kind_of(array):
    if not isinstance(array, np.ndarray):
        raise CvBridgeError(f'an image must be a numpy array, not {type(array).__name__}')
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] not in CHANNELS):
        raise CvBridgeError(f'an array of shape {array.shape} is not an image; its shape must be (height, width) or '
                            '(height, width, channels) with 1 to 4 channels')
    return Pixels(depth_of(array.dtype), 1 if array.ndim == 2 else array.shape[2])
