"""A WebSocket as a client sees it, byte by byte: messages, broken frames, limits, pings, and its end."""
import asyncio
import contextlib
import struct
import time
import zlib

import pytest
import tornado.httpserver
import tornado.web

from browser_servers.core.access import OFF, Access
from browser_servers.core.connection import CHUNK, PROTOCOL, TOO_BIG, WebSocket
from browser_servers.core.web import listen

TEXT, BINARY, CLOSE, PING, PONG = 0x81, 0x82, 0x88, 0x89, 0x8a  # first bytes of final frames
LARGEST = 1000  # [B] of a message
DEADLINE = 10.0  # [s]
NORMAL = struct.pack('!H', 1000)
HANDSHAKE = ('GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n'
             'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
             'Sec-WebSocket-Extensions: permessage-deflate\r\n\r\n')
ACCEPT = 's3pPLMBiTxaQ9kYGzzhZRbK+xOo='  # RFC 6455, 1.3


def frame(first, payload=b'', length=None):
    """Return a client's frame; its mask is zero, which changes no byte. ``length``: its claimed length."""
    length = len(payload) if length is None else length
    size = bytes((128 | length,)) if length < 126 else b'\xfe' + struct.pack('!H', length) if length < 65536 else \
        b'\xff' + struct.pack('!Q', length)
    return bytes((first,)) + size + bytes(4) + payload


def deflated(payload):
    compressor = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    return (compressor.compress(payload) + compressor.flush(zlib.Z_SYNC_FLUSH))[:-4]


class Echo(WebSocket):
    """Answers each message with the same; 'wait' with a pause before the next one is read."""

    def initialize(self, log):
        self.log = log

    def opened(self, connection, stream):
        self.connection = connection
        self.log.append(('opened', self.request.path))

    def received(self, message):
        self.log.append(message)
        if message == 'close':
            self.connection.close(4000, 'it was asked for')
        elif message == 'wait':
            return asyncio.sleep(0.1)
        else:
            self.connection.send(message)
        return None

    def drain(self):
        if self.log[-1] != 'drained':
            self.log.append('drained')

    async def ended(self):
        self.log.append('ended')


class Client:
    """A connection whose frames are read one by one."""

    def __init__(self, reader, writer):
        self._reader, self._writer = reader, writer

    def send(self, *frames):
        self._writer.write(b''.join(frames))

    async def next(self):
        """Return (first byte, payload) of the server's next frame; None at the end of the connection."""
        try:
            first, length = await self._reader.readexactly(2)
            if length >= 126:
                length = int.from_bytes(await self._reader.readexactly(2 if length == 126 else 8), 'big')
            return first, await self._reader.readexactly(length)
        except (asyncio.IncompleteReadError, ConnectionError):
            return None

    async def end(self):
        """Return (code, reason) of the close frame, after all other frames."""
        while True:
            found = await self.next()
            if found is None or found[0] == CLOSE:
                return found and (int.from_bytes(found[1][:2], 'big'), found[1][2:].decode())


def served(work, **settings):
    """Run ``work(connect, log)``; ``connect(handshake)`` returns a Client, ``log`` notes the actions of the server."""
    async def run():
        log = []
        settings.setdefault('use_compression', False)
        application = tornado.web.Application(
            [('.*', Echo, {'log': log})], access=Access(OFF), refused=log.append, websocket_max_message_size=LARGEST,
            log_function=lambda handler: None,
            **{'ping_interval': 0, 'ping_timeout': 0, **settings})
        server = tornado.httpserver.HTTPServer(application)
        listening = listen(0, '127.0.0.1')[0]
        server.add_sockets([listening])
        opened = []

        async def connect(handshake=HANDSHAKE):
            reader, writer = await asyncio.open_connection(*listening.getsockname())
            opened.append(writer)
            writer.write(handshake.encode())
            head = (await reader.readuntil(b'\r\n\r\n')).decode()
            assert head.startswith('HTTP/1.1 101 ') and ACCEPT in head, head
            return Client(reader, writer)
        try:
            return await asyncio.wait_for(work(connect, log), DEADLINE)
        finally:
            for writer in opened:
                writer.close()
            server.stop()
            listening.close()
    return asyncio.run(run())


async def until(condition):
    while not condition():
        await asyncio.sleep(0.01)


@pytest.mark.parametrize('step', [1, 3, 1000])
def test_messages_come_in_any_pieces(step):
    data = frame(TEXT, b'a') + frame(0x01, b'T\xc3') + frame(PING, b'?') + frame(0x00, b'\xb5') + \
        frame(0x80, b'nu') + frame(BINARY, b'\xff' * 300) + frame(CLOSE, NORMAL)

    async def work(connect, log):
        client = await connect()
        for begin in range(0, len(data), step):
            client.send(data[begin:begin + step])
            await asyncio.sleep(0)
        frames = [await client.next() for _ in range(5)]
        assert frames == [(TEXT, b'a'), (PONG, b'?'), (TEXT, 'T\u00f5nu'.encode()), (BINARY, b'\xff' * 300),
                       (CLOSE, NORMAL)]
        assert await client.next() is None
        await until(lambda: log[-1] == 'ended')
    served(work)


@pytest.mark.parametrize('data, code', [
    (frame(0x91), PROTOCOL), (frame(0xc1), PROTOCOL), (frame(0x80), PROTOCOL), (frame(0x01) + frame(TEXT), PROTOCOL),
    (frame(0x83), PROTOCOL), (frame(PING, b'x' * 126), PROTOCOL), (frame(0x09), PROTOCOL),
    (frame(TEXT, b'\xff'), PROTOCOL), (frame(CLOSE, b'\0\0'), PROTOCOL), (frame(CLOSE, b'\x03\xee'), PROTOCOL),
    (frame(CLOSE, NORMAL + b'\xff'), PROTOCOL),
    (frame(TEXT, b'x' * (LARGEST + 1)), TOO_BIG), (frame(TEXT, length=2 ** 63 - 1), TOO_BIG),
    (frame(0x01, b'x' * 600) + frame(0x80, b'x' * 600), TOO_BIG),
])
def test_client_that_breaks_the_rules_learns_why(data, code, caplog):
    async def work(connect, log):
        client = await connect()
        client.send(frame(TEXT, b'before'), data, frame(TEXT, b'after'))
        assert await client.next() == (TEXT, b'before')
        found, reason = await client.end()
        assert found == code
        assert '~max_message_size' in reason if code == TOO_BIG else 'RFC 6455' in reason
        client.send(frame(TEXT, b'dropped') * 100)
        await until(lambda: 'ended' in log)
        assert [one for one in log if isinstance(one, str)] == ['before', 'drained', 'ended']
    served(work)
    errors = [record.exc_info[1] for record in caplog.records if record.exc_info]
    assert all(isinstance(error, asyncio.CancelledError) for error in errors), errors  # of those that ``served`` ends


def test_compressed_messages():
    text = b'turtle' * 100

    async def work(connect, log):
        client = await connect()
        client.send(frame(0xc1, deflated(text)), frame(TEXT, b'plain'))
        first, payload = await client.next()
        assert first == 0xc1 and len(payload) < 100
        assert zlib.decompressobj(-15).decompress(payload + b'\0\0\xff\xff') == text
        await client.next()
        assert log[1:3] == [text.decode(), 'plain']
        client.send(frame(0xc1, deflated(bytes(100 * LARGEST))))
        assert (await client.end())[0] == TOO_BIG
        other = await connect()
        other.send(frame(0xc1, b'\xff' * 20))
        assert (await other.end())[0] == PROTOCOL
        await until(lambda: log.count('ended') == 2)
    served(work, use_compression=True)


@pytest.mark.parametrize('payload', [b'', b'\x03'])
def test_close_frame_without_a_code_is_answered_with_one(payload):
    async def work(connect, log):
        client = await connect()
        client.send(frame(CLOSE, payload))
        assert await client.next() == (CLOSE, b'')
        assert await client.next() is None
        await until(lambda: log[-1] == 'ended')
    served(work)


def test_server_closes_with_a_code_and_a_reason():
    async def work(connect, log):
        client = await connect()
        client.send(frame(TEXT, b'close'), frame(TEXT, b'too late'))
        assert await client.end() == (4000, 'it was asked for')
        assert await client.next() is None  # although the client never answers
        assert 'too late' not in log
    served(work)


def test_a_client_that_sends_without_end_leaves_others_their_turn():
    async def work(connect, log):
        flood, other = await connect(), await connect()
        data = frame(BINARY, bytes(LARGEST)) * (4 * CHUNK // LARGEST)

        async def send():
            while True:
                flood.send(data)
                await flood._writer.drain()

        async def read():
            while await flood.next():
                pass
        tasks = [asyncio.ensure_future(send()), asyncio.ensure_future(read())]
        for _ in range(10):
            other.send(frame(TEXT, b'now'))
            assert await other.next() == (TEXT, b'now')
        for task in tasks:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task
    served(work)


def test_the_next_message_waits_for_the_one_before():
    async def work(connect, log):
        client = await connect()
        client.send(frame(TEXT, b'wait'), frame(TEXT, b'next'))
        await until(lambda: 'drained' in log)
        assert log[-2:] == ['wait', 'drained']
        assert await client.next() == (TEXT, b'next')
    served(work)


def test_client_that_does_not_answer_pings_is_disconnected():
    async def work(connect, log):
        answers, silent = await connect(), await connect()
        for _ in range(10):
            assert await answers.next() == (PING, b'')
            answers.send(frame(PONG))
        assert [await silent.next() for _ in range(3)][0] == (PING, b'')
        while await silent.next() is not None:
            pass
        await until(lambda: log.count('ended') == 1)
    served(work, ping_interval=0.05, ping_timeout=0.3)


def test_stalled_server_does_not_take_its_clients_for_silent_ones():
    async def work(connect, log):
        client = await connect()
        for _ in range(3):
            assert await client.next() == (PING, b'')
            client.send(frame(PONG))
            await asyncio.sleep(0.02)  # the server reads that
            time.sleep(0.5)  # as if the machine was suspended, or busy with others
        assert await client.next() == (PING, b'')
    served(work, ping_interval=0.05, ping_timeout=0.3)


@pytest.mark.parametrize('old, new, status', [
    ('Version: 13', 'Version: 5', '426'), ('Sec-WebSocket-Key', 'X-Key', '400'), ('Connection: Upgrade', 'X: y', '400'),
    ('Upgrade: websocket', 'Upgrade: h2', '400'), ('Host: localhost', 'Host: evil.example', '403'),
    ('Host: localhost', 'Host: localhost\r\nOrigin: http://evil.example', '403')])
def test_what_is_no_handshake_is_refused(old, new, status):
    async def work(connect, log):
        with pytest.raises(AssertionError, match=f'HTTP/1.1 {status} '):
            await connect(HANDSHAKE.replace(old, new))
        assert ('opened', '/') not in log
    served(work)
