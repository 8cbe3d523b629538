"""The encodings of messages to a client: JSON, PNG, CBOR, CBOR-RAW, and fragments."""
import base64
import binascii
import json
import math
import struct
import time
from typing import Any, Callable, Dict, Iterator, Optional, Tuple, Union

import cbor2
import cv2
import numpy as np

from browser_servers.core.conversion import cbor_values, json_values, kind_of
from browser_servers.core.operations import Operation, Refused

Frame = Union[str, bytes]  # a text frame, or a binary one
LONG = 4096  # characters
MAX_OPEN = 32  # messages of which a client has sent only some fragments
MAX_PARTS = 20_000  # fragments of these messages; each takes memory beside its characters
MAX_FRAGMENTS = 1000  # of a message to a client; more would delay the other clients
PNG_HEADER = struct.Struct('>8s4x4sII')  # signature, length of the first chunk, IHDR, width, height
_dump: Callable[[Any], str] = json.JSONEncoder(separators=(',', ':'), allow_nan=False).encode
to_cbor: Callable[[Any], bytes] = cbor2.dumps


def to_json(operation: Operation) -> str:
    """Return the text of an operation; it holds no NaN."""
    return _dump(operation)


class Message:
    """A message of a topic on its way to clients: deserialised and encoded once for all, when the first can take it.

    ``data``: as ROS serialises it; ``deserialise``: returns the message; ``received``: ROS time (secs, nsecs).
    """

    def __init__(self, topic: str, data: bytes, deserialise: Callable[[bytes], Any], received: Tuple[int, int]) -> None:
        self.topic, self.data, self.received = topic, data, received
        self._deserialise = deserialise
        self._message: Any = None
        self._frames: Dict[str, Frame] = {}

    def frame(self, compression: str) -> Frame:
        """Return the publish operation of this message in one of COMPRESSIONS."""
        if compression not in self._frames:
            self._frames[compression] = self._encode(compression)
        return self._frames[compression]

    def _encode(self, compression: str) -> Frame:
        operation: Operation = {'op': 'publish', 'topic': self.topic}
        if compression == 'cbor-raw':
            secs, nsecs = self.received
            return to_cbor({**operation, 'msg': {'bytes': self.data, 'secs': secs, 'nsecs': nsecs}})
        if compression == 'png':
            return to_json({'op': 'png', 'data': to_png(str(self.frame('none')))})
        if self._message is None:
            self._message = self._deserialise(self.data)
        if compression == 'cbor':
            return to_cbor({**operation, 'msg': cbor_values(self._message)})
        return ''.join((f'{{"op":"publish","topic":{_dump(self.topic)},"msg":', *_message_parts(self._message), '}'))


def _message_parts(message: Any) -> Iterator[str]:
    """Yield a message as JSON; long arrays of bytes get by the encoder, which would search their base64 for quotes."""
    values = json_values(message)
    long = {name: values.pop(name) for name, kind in zip(message.__slots__, message._slot_types)
            if kind_of(kind).is_bytes and len(values[name]) > LONG}
    text = _dump(values)
    yield text[:-1]
    between = ',' if values else ''
    for name, value in long.items():
        yield f'{between}"{name}":"'
        yield value
        yield '"'
        between = ','
    yield '}'


def to_png(text: str) -> str:
    """Return the bytes of a text as the pixels of a PNG, in base64; line feeds fill up the image."""
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = max(1, -(-len(data) // (3 * width)))
    pixels = np.frombuffer(data.ljust(3 * width * height, b'\n'), np.uint8).reshape(height, width, 3)
    return base64.b64encode(cv2.imencode('.png', pixels[..., ::-1])[1].tobytes()).decode('ascii')


def from_png(text: str, limit: int) -> str:
    """Return the text in an image of ``to_png``, at most ``limit`` bytes; raise Refused."""
    try:
        data = base64.b64decode(text, validate=True)
        signature, chunk, width, height = PNG_HEADER.unpack(data[:PNG_HEADER.size])
    except (binascii.Error, ValueError, struct.error):
        raise Refused('png: "data" is not a PNG image in base64') from None
    if signature != b'\x89PNG\r\n\x1a\n' or chunk != b'IHDR':
        raise Refused('png: "data" is not a PNG image in base64')
    if 3 * width * height > limit:
        raise Refused(f'png: the image has {width} x {height} pixels; the message may have {limit} bytes')
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if pixels is None:
        raise Refused('png: the image is damaged')
    try:
        return bytes(pixels[..., ::-1].tobytes()).decode().rstrip('\n\0')
    except UnicodeDecodeError:
        raise Refused('png: the image does not hold a text') from None


def fragments(frame: Frame, size: Optional[int], name: str) -> Iterator[Frame]:
    """Yield the frames for a client, with at most ``size`` characters of ``data`` each; binary frames stay whole.

    A message becomes at most MAX_FRAGMENTS, with more characters each if necessary.
    """
    if size is None or isinstance(frame, bytes) or len(frame) <= size:
        yield frame
        return
    size = max(size, -(-len(frame) // MAX_FRAGMENTS))
    total = -(-len(frame) // size)
    for number in range(total):
        yield to_json({'op': 'fragment', 'id': name, 'data': frame[number * size:(number + 1) * size], 'num': number,
                       'total': total})


class Defragmenter:
    """Joins the fragments of a client, within limits of memory and time."""

    def __init__(self, limit: int, timeout: float, clock: Callable[[], float] = time.monotonic) -> None:
        """``limit`` [characters] of all incomplete messages; ``timeout`` [s] until a message must be complete."""
        self._limit, self._timeout, self._clock = limit, timeout, clock
        self._open: Dict[Any, Tuple[float, int, Dict[int, str]]] = {}  # start, total, parts
        self._size = self._parts = 0

    def add(self, fragment: Operation) -> Optional[str]:
        """Return the whole message once its last fragment is there; raise Refused."""
        name, number, total = fragment['id'], fragment['num'], fragment['total']
        self._forget_old()
        if not 0 <= number < total or total > max(1, self._limit):
            raise Refused(f'fragment: "num" is {number}; it must be from 0 to "total" - 1, and "total" is {total}')
        if name not in self._open and len(self._open) >= MAX_OPEN:
            raise Refused(f'fragment: {MAX_OPEN} messages are incomplete already')
        if name not in self._open:
            self._open[name] = self._clock(), total, {}
        _, first_total, parts = self._open[name]
        if total != first_total:
            self._forget(name)
            raise Refused(f'fragment: "total" is {total}, but was {first_total} in an earlier fragment of {name!r}')
        if number not in parts:
            parts[number] = fragment['data']
            self._size += len(fragment['data'])
            self._parts += 1
            self._refuse_if_large(name)
        if len(parts) < total:
            return None
        self._forget(name)
        return ''.join(parts[number] for number in range(total))

    def _refuse_if_large(self, name: Any) -> None:
        if self._size > self._limit or self._parts > MAX_PARTS:
            self._open.clear()
            self._size = self._parts = 0
            raise Refused(f'fragment: incomplete messages have more than {self._limit} characters or {MAX_PARTS} '
                          f'fragments with {name!r}; all are dropped')

    def _forget(self, name: Any) -> None:
        parts = self._open.pop(name)[2].values()
        self._size -= sum(map(len, parts))
        self._parts -= len(parts)

    def _forget_old(self) -> None:
        oldest = self._clock() - self._timeout
        for name in [name for name, (start, *_) in self._open.items() if start < oldest]:
            self._forget(name)
