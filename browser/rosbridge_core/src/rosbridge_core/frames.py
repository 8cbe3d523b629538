"""The frames of a WebSocket (RFC 6455): bytes of a client to its messages, and messages to bytes. No sockets.

With ``deflate``, messages are compressed each on its own (RFC 7692, without context takeover).
"""
import base64
import hashlib
import zlib
from typing import Iterator, Optional, Tuple, Union

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
CONTINUATION, FINAL, COMPRESSED, RESERVED, MASKED = 0, 128, 64, 48, 128
LARGEST_CONTROL = 125  # [B]
PROTOCOL, NO_TEXT, TOO_BIG = 1002, 1007, 1009  # close codes
GUID = '258EAFA5-E914-47DA-95CA-C5AB0DC85B11'
TAIL = b'\0\0\xff\xff'  # the end of every compressed message, which is not sent


class Broken(Exception):
    """A client breaks the rules; ``code`` and ``reason`` close its connection."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code, self.reason = code, reason


def accept_key(key: str) -> str:
    """Return the answer to the key of a client's handshake."""
    return base64.b64encode(hashlib.sha1((key + GUID).encode()).digest()).decode('ascii')


def frame(opcode: int, payload: bytes, deflate: bool = False) -> bytes:
    """Return the frame that a server sends."""
    first = FINAL | opcode
    if deflate and opcode in (TEXT, BINARY):
        compressor = zlib.compressobj(wbits=-zlib.MAX_WBITS)
        payload = (compressor.compress(payload) + compressor.flush(zlib.Z_SYNC_FLUSH))[:-len(TAIL)]
        first |= COMPRESSED
    length = len(payload)
    if length <= LARGEST_CONTROL:
        return bytes((first, length)) + payload
    if length < 1 << 16:
        return bytes((first, 126)) + length.to_bytes(2, 'big') + payload
    return bytes((first, 127)) + length.to_bytes(8, 'big') + payload


def unmasked(mask: bytes, data: bytes) -> bytes:
    """Return data XOR the mask of 4 bytes, again and again."""
    length = len(data)
    key = (mask * (length // 4 + 1))[:length]
    return (int.from_bytes(data, 'little') ^ int.from_bytes(key, 'little')).to_bytes(length, 'little')


def _closes(payload: bytes) -> bool:
    """Return whether the payload of a close frame is empty, or begins with a code that may be sent."""
    code = int.from_bytes(payload[:2], 'big')
    return not payload or len(payload) >= 2 and (1000 <= code <= 1014 and code not in (1004, 1005, 1006)
                                                 or 3000 <= code <= 4999)


class Reader:
    """Takes the bytes of one client."""

    def __init__(self, largest: int, deflate: bool = False) -> None:
        """``largest`` [B] of a message; ``deflate``: it may be compressed."""
        self._largest, self._deflate = largest, deflate
        self._data = bytearray()
        self._opcode: Optional[int] = None  # of a message that came only in part
        self._compressed = False
        self._parts = bytearray()

    def feed(self, data: bytes) -> Iterator[Tuple[int, Union[str, bytes]]]:
        """Yield (opcode, text or bytes) of each message that is complete; raise Broken."""
        self._data += data
        begin = 0
        try:
            while True:
                head = self._head(begin)
                if head is None:
                    return
                start, length = head
                if len(self._data) < start + length:
                    return
                first = self._data[begin]
                payload = unmasked(bytes(self._data[start - 4:start]), bytes(self._data[start:start + length]))
                begin = start + length
                message = self._take(first, payload)
                if message is not None:
                    yield message
        finally:
            del self._data[:begin]

    def _head(self, begin: int) -> Optional[Tuple[int, int]]:
        """Return where the payload of a frame starts and how long it is, None if that has not come yet."""
        data = self._data
        there = len(data) - begin
        if there < 2:
            return None
        first, second = data[begin], data[begin + 1]
        length, size = second & 127, 2
        if length >= 126:
            size = 4 if length == 126 else 10
            if there < size:
                return None
            length = int.from_bytes(data[begin + 2:begin + size], 'big')
        if not second & MASKED:
            raise Broken(PROTOCOL, 'a frame of a client must be masked')
        if first & RESERVED or first & COMPRESSED and not self._deflate:
            raise Broken(PROTOCOL, 'a reserved bit is set')
        if first & CLOSE and (length > LARGEST_CONTROL or not first & FINAL):
            raise Broken(PROTOCOL, f'a control frame must be whole, and have at most {LARGEST_CONTROL} bytes')
        if length + len(self._parts) > self._largest:
            raise Broken(TOO_BIG, f'a message may have {self._largest} bytes; ~max_message_size allows more')
        return begin + size + 4, length

    def _take(self, first: int, payload: bytes) -> Optional[Tuple[int, Union[str, bytes]]]:
        opcode = first & 15
        if opcode == CLOSE and not _closes(payload):
            raise Broken(PROTOCOL, f'a close frame begins with {payload[:2].hex()!r}; it must have a code of RFC 6455, '
                                   'as 03e8 (1000)')
        if opcode in (CLOSE, PING, PONG):
            return opcode, payload
        if opcode not in (CONTINUATION, TEXT, BINARY) or (opcode == CONTINUATION) != (self._opcode is not None):
            raise Broken(PROTOCOL, f'a frame has the opcode {opcode} at the wrong time')
        if opcode != CONTINUATION:
            self._opcode, self._compressed = opcode, bool(first & COMPRESSED)
        if self._parts or not first & FINAL:
            self._parts += payload
        if not first & FINAL:
            return None
        opcode, whole = self._opcode or TEXT, bytes(self._parts) or payload
        self._opcode, self._parts = None, bytearray()
        return opcode, self._decoded(opcode, self._inflated(whole) if self._compressed else whole)

    def _inflated(self, payload: bytes) -> bytes:
        inflate = zlib.decompressobj(-zlib.MAX_WBITS)
        try:
            data = inflate.decompress(payload + TAIL, self._largest + 1)
        except zlib.error as error:
            raise Broken(NO_TEXT, f'a compressed message is damaged: {error}') from None
        if len(data) > self._largest:
            raise Broken(TOO_BIG, f'a message may have {self._largest} bytes; ~max_message_size allows more')
        return data

    @staticmethod
    def _decoded(opcode: int, payload: bytes) -> Union[str, bytes]:
        if opcode == BINARY:
            return payload
        try:
            return payload.decode()
        except UnicodeDecodeError:
            raise Broken(NO_TEXT, 'a text message is not valid UTF-8') from None
