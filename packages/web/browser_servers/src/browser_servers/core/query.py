"""A browser's query: the part of an address after the question mark."""
import re
from typing import Callable, NamedTuple, Optional

import cv2
import numpy as np

KINDS = 'mjpeg', 'ros_compressed', 'png'
MISSING_KINDS = 'vp8', 'vp9', 'h264'  # of the original, for which Debian's OpenCV has no encoder that streams
LARGEST = 4096  # [px] of a side
NAME = re.compile(r'/?[A-Za-z][A-Za-z0-9_/]{0,999}')


class InvalidQuery(ValueError):
    """An address that cannot be served; the text has the fault and what is allowed."""


class Query(NamedTuple):
    """A topic, and how its images are shown; ``width`` and ``height`` [px] 0: as they are; ``quality`` [%] of JPEG."""

    topic: str
    kind: str = KINDS[0]
    quality: int = 95
    width: int = 0
    height: int = 0
    invert: bool = False


def read(get: Callable[[str], Optional[str]], default_kind: str) -> Query:
    """Return the query whose fields ``get`` returns as texts, or None; raise InvalidQuery."""
    topic = get('topic') or ''
    if not NAME.fullmatch(topic):
        raise InvalidQuery('the address needs the topic of an image, at most 1000 characters, as ?topic=/image_raw; it '
                           f'has {topic[:99]!r}')
    kind = get('type') or default_kind
    if kind in MISSING_KINDS:
        raise InvalidQuery(f'type={kind} is not supported here; use one of {", ".join(KINDS)}')
    if kind not in KINDS:
        raise InvalidQuery(f'type={kind[:40]} is unknown; it must be one of {", ".join(KINDS)}')
    quality = _number('quality', get('quality'), 95, 1, 100)
    width, height = (_number(name, get(name), 0, 0, LARGEST) for name in ('width', 'height'))
    return Query(f'/{topic.strip("/")}', kind, quality, max(0, width), max(0, height), get('invert') is not None)


def _number(name: str, text: Optional[str], default: int, low: int, high: int) -> int:
    if text is None or text == '-1':  # the original's word for the default
        return default
    if not re.fullmatch('[0-9]{1,6}', text) or not low <= int(text) <= high:
        raise InvalidQuery(f'{name}={text[:40]} must be a whole number from {low} to {high}')
    return int(text)


def encoded(bgr: 'np.ndarray', query: Query) -> bytes:
    """Return an image, (height, width, 3) uint8 in OpenCV's order, as the query wants it: PNG or JPEG."""
    if query.width or query.height:
        height, width = bgr.shape[:2]
        size = query.width or round(width * query.height / height), query.height or round(height * query.width / width)
        bgr = cv2.resize(bgr, (max(1, size[0]), max(1, size[1])), interpolation=cv2.INTER_AREA)
    if query.invert:
        bgr = cv2.rotate(bgr, cv2.ROTATE_180)
    if query.kind == 'png':
        return bytes(cv2.imencode('.png', bgr, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1])
    return bytes(cv2.imencode('.jpg', bgr, [cv2.IMWRITE_JPEG_QUALITY, query.quality])[1])


def content_type(data: bytes) -> str:
    """Return the MIME type of an encoded image."""
    return 'image/png' if data.startswith(b'\x89PNG') else 'image/jpeg'


def depth_picture(depth: 'np.ndarray') -> 'np.ndarray':
    """Return distances [m] as a picture: near is dark, far is bright, unknown is black."""
    known = np.nan_to_num(depth, nan=0.0, posinf=0.0, neginf=0.0)
    scaled = (known * (255.0 / max(float(known.max(initial=0.0)), 1e-6))).clip(0, 255).astype(np.uint8)
    return np.repeat(scaled[:, :, None], 3, axis=2)
