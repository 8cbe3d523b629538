"""Images of topics over HTTP: a stream, and a single image.

Threading contract: everything runs in the loop's thread, except encoding.
"""
import asyncio
import contextlib
import re
from typing import Any, AsyncIterator, Optional, Tuple

import tornado.iostream

from browser_servers.core.query import InvalidQuery, Query, content_type, read
from browser_servers.core.web import Guarded
from browser_servers.sources import Source
from rospy_support.images import ImageError

BOUNDARY = 'boundarydonotcross'  # between two images, as the original has it
FIRST_IMAGE = 10.0  # [s] that a snapshot waits
LINGER = 5.0  # [s] that a topic stays subscribed for the next image of one who asks for one after the other
SLOW = 10.0  # [s] in which a browser must have taken an image


class Page(Guarded):
    """What all pages share; ``settings``: sources, default_kind, streams (a list of one count), max_streams."""

    def prepare(self) -> None:
        """Let pages that may connect also read the images, and not only show them."""
        super().prepare()
        origin = self.request.headers.get('Origin')
        if origin and not self._finished:
            self.set_header('Access-Control-Allow-Origin', origin)
            self.set_header('Vary', 'Origin')

    def query(self) -> Optional[Query]:
        """Return the Query of the address, or None once the refusal is sent."""
        try:
            return read(lambda name: self.get_query_argument(name, None), self.settings['default_kind'])
        except InvalidQuery as error:
            self.refuse(400, str(error))
            return None

    @contextlib.asynccontextmanager
    async def source(self, query: Query, linger: float = 0.0) -> AsyncIterator[Source]:
        """Yield the Source of a query, and close it afterwards, or ``linger`` [s] later."""
        sources = self.settings['sources']
        source = await sources.open(query)
        try:
            yield source
        finally:
            if linger:
                asyncio.get_event_loop().call_later(linger, lambda: asyncio.ensure_future(sources.close(source)))
            else:
                await sources.close(source)


class Snapshot(Page):
    """The next image, and its number; with ``after``, the newest one after the image with this number."""

    async def get(self) -> None:
        query = self.query()
        if query is None:
            return
        after = self.get_query_argument('after', None)
        async with self.source(query, 0.0 if after is None else LINGER) as source:
            before = source.before if after is None else _number(after, source.number)
            try:
                number, data = await asyncio.wait_for(source.next(before, query), FIRST_IMAGE)
            except asyncio.TimeoutError:
                self.refuse(504, f'no image has come on {query.topic} within {FIRST_IMAGE:g} s. http://'
                                 f'{self.request.host}/ lists the topics of images')
                return
            except ImageError as error:
                self.refuse(415, f'the image of {query.topic} cannot be shown: {error}')
                return
        self.set_header('Content-Type', content_type(data))
        self.set_header('Cache-Control', 'no-store')
        self.set_header('Image-Number', str(number))
        self.finish(data)


def _number(text: str, newest: int) -> int:
    """Return the number of an image; 0 if it is none of this source, which counts from 1."""
    number = int(text) if re.fullmatch('[0-9]{1,15}', text) else 0
    return number if number <= newest else 0


class Stream(Page):
    """Images one after the other; a browser that is slower than the topic gets the newest each time."""

    def initialize(self) -> None:
        self._gone = asyncio.get_event_loop().create_future()

    async def get(self) -> None:
        query = self.query()
        if query is None:
            return
        streams = self.settings['streams']
        if streams[0] >= self.settings['max_streams']:
            self.refuse(503, f'{streams[0]} streams are shown already; ~max_streams allows more')
            return
        streams[0] += 1
        try:
            await self._send(query)
        except (tornado.iostream.StreamClosedError, asyncio.TimeoutError):
            connection: Any = self.request.connection  # tornado's type has no stream
            connection.stream.close()
        finally:
            streams[0] -= 1

    async def _send(self, query: Query) -> None:
        self.set_header('Content-Type', f'multipart/x-mixed-replace;boundary={BOUNDARY}')
        self.set_header('Cache-Control', 'no-store')
        self.write(f'--{BOUNDARY}\r\n')
        await self.flush()
        async with self.source(query) as source:
            number = 0
            while True:
                number, data = await self._next(source, number, query)
                if data is not None:
                    self.write(f'Content-Type: {content_type(data)}\r\nContent-Length: {len(data)}\r\n\r\n')
                    self.write(data)
                    self.write(f'\r\n--{BOUNDARY}\r\n')
                    await asyncio.wait_for(self.flush(), SLOW)

    async def _next(self, source: Source, number: int, query: Query) -> Tuple[int, Optional[bytes]]:
        """Return (number, data), data None for an image that cannot be shown; raise StreamClosedError."""
        task = asyncio.ensure_future(source.next(number, query))
        await asyncio.wait({task, self._gone}, return_when=asyncio.FIRST_COMPLETED)
        if self._gone.done():
            task.cancel()
            raise tornado.iostream.StreamClosedError()
        try:
            return await task
        except ImageError as error:
            self.settings['warn'](f'The image of {query.topic} cannot be shown: {error}')
            return source.number, None

    def on_connection_close(self) -> None:
        """End the stream; called by tornado."""
        if not self._gone.done():
            self._gone.set_result(None)
        super().on_connection_close()

