"""The images of topics, for all browsers that show them.

Threading contract: rospy's threads hand the newest image over; the loop's thread does everything else; images are
encoded in an executor, once for all browsers with the same query.
"""
import asyncio
import threading
from typing import Any, Dict, Tuple

import numpy as np
import rosgraph
import rospy
from sensor_msgs.msg import CompressedImage, Image

from browser_servers.core.query import Query, depth_picture, encoded
from rospy_support import images, rospy_internals

COMPRESSED = '/compressed'  # below the topic of the image, as image_transport has it
LARGE = 1 << 22  # [B] that rospy reads at once


class Source:
    """A topic: its newest image and its number of viewers."""

    def __init__(self, topic: str, compressed: bool, loop: asyncio.AbstractEventLoop) -> None:
        """``compressed``: the images that image_transport has compressed."""
        self.viewers, self.number, self._latched = 0, 0, False
        self._loop, self._lock = loop, threading.Lock()
        self._unread: Any = None  # the newest message that the loop has not taken yet
        self._message: Any = None  # that of ``number``
        self._encodings: Dict[Query, asyncio.Future[bytes]] = {}  # of that message
        self._arrived = asyncio.Event()
        self._subscriber = rospy.Subscriber(topic + COMPRESSED if compressed else topic,
                                            CompressedImage if compressed else Image, self._received, queue_size=1,
                                            buff_size=LARGE, tcp_nodelay=True)

    def _received(self, message: Any) -> None:
        with self._lock:
            scheduled, self._unread = self._unread is not None, message
        if not scheduled:
            self._loop.call_soon_threadsafe(self._arrive)

    def _arrive(self) -> None:
        with self._lock:
            self._message, self._unread = self._unread, None
        self.number += 1
        self._latched = rospy_internals.connection_header(self._message).get('latching') == '1'
        self._encodings = {}
        arrived, self._arrived = self._arrived, asyncio.Event()
        arrived.set()

    @property
    def before(self) -> int:
        """The number of the last image that is too old for a new viewer; 0 if it came for that one, or is latched."""
        return 0 if self.viewers == 1 or self._latched else self.number

    async def next(self, after: int, query: Query) -> Tuple[int, bytes]:
        """Return (number, data) of the newest image after number ``after``; raise ImageError."""
        while self.number <= after:
            await self._arrived.wait()
        number = self.number
        if query not in self._encodings:
            self._encodings[query] = self._loop.run_in_executor(None, _data, self._message, query)
        return number, await asyncio.shield(self._encodings[query])

    def close(self) -> None:
        self._subscriber.unregister()


def _data(message: Any, query: Query) -> bytes:
    if isinstance(message, CompressedImage):
        return bytes(message.data)
    if message.encoding == images.DEPTH:
        return encoded(depth_picture(_distances(message)), query)
    return encoded(images.bgr(message), query)


def _distances(image: Any) -> 'np.ndarray':
    rows = np.frombuffer(image.data, np.uint8)
    if not image.width or image.step < 4 * image.width or rows.size < image.step * image.height:
        raise images.ImageError(f'an image of {image.width}x{image.height} distances has {rows.size} bytes of data')
    rows = rows[:image.step * image.height].reshape(image.height, image.step)[:, :4 * image.width]
    return np.ascontiguousarray(rows).view('>f4' if image.is_bigendian else '<f4')


class Sources:
    """The topics that browsers show now."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop, self._lock = loop, asyncio.Lock()
        self._sources: Dict[Tuple[str, bool], Source] = {}

    async def open(self, query: Query) -> Source:
        """Return the Source for a query; call ``close`` once for it."""
        key = query.topic, (query.kind == 'ros_compressed'
                            and await self._loop.run_in_executor(None, _is_compressed, query.topic))
        async with self._lock:
            if key not in self._sources:
                self._sources[key] = await self._loop.run_in_executor(None, Source, *key, self._loop)
            self._sources[key].viewers += 1
            return self._sources[key]

    async def close(self, source: Source) -> None:
        async with self._lock:
            source.viewers -= 1
            if not source.viewers:
                self._sources = {key: other for key, other in self._sources.items() if other is not source}
                await self._loop.run_in_executor(None, source.close)


def _is_compressed(topic: str) -> bool:
    """Return whether a node publishes the compressed images of a topic; otherwise they are made here."""
    try:
        published = {name for name, _ in rosgraph.Master(rospy.get_name()).getPublishedTopics('')}
    except (rosgraph.MasterException, OSError):
        return True
    return topic + COMPRESSED in published or topic not in published
