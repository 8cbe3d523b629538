"""Frames of a WebSocket: those of a client in any pieces, those of a server by their bytes, and broken ones."""
import os
import zlib

import pytest

from rosbridge_core.frames import BINARY, CLOSE, PING, TEXT, Broken, Reader, accept_key, frame, unmasked

MASK = b'\x11\x22\x33\x44'


def masked(first, payload, mask=MASK):
    """Return a client's frame with a first byte."""
    length = len(payload)
    size = bytes((128 | length,)) if length < 126 else b'\xfe' + length.to_bytes(2, 'big') if length < 65536 else \
        b'\xff' + length.to_bytes(8, 'big')
    return bytes((first,)) + size + mask + unmasked(mask, payload)


def read(data, step=None, largest=1 << 20, deflate=False):
    """Return the messages in the bytes, given to a Reader in pieces of ``step`` bytes."""
    reader, step = Reader(largest, deflate), step or len(data)
    return [one for begin in range(0, len(data), step) for one in reader.feed(data[begin:begin + step])]


def test_handshake_of_the_standard():
    assert accept_key('dGhlIHNhbXBsZSBub25jZQ==') == 's3pPLMBiTxaQ9kYGzzhZRbK+xOo='  # RFC 6455, 1.3


def test_masked_frame_of_the_standard():
    assert read(b'\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58') == [(TEXT, 'Hello')]  # RFC 6455, 5.7


@pytest.mark.parametrize('length, head', [
    (0, b'\x82\0'), (125, b'\x82\x7d'), (126, b'\x82\x7e\0\x7e'), (65535, b'\x82\x7e\xff\xff'),
    (65536, b'\x82\x7f\0\0\0\0\0\1\0\0'),
])
def test_server_says_the_length(length, head):
    assert frame(BINARY, b'x' * length) == head + b'x' * length
    assert read(masked(0x82, b'x' * length)) == [(BINARY, b'x' * length)]


@pytest.mark.parametrize('step', [1, 2, 3, 7, 1000])
def test_messages_come_in_any_pieces(step):
    data = masked(0x81, b'a') + masked(0x01, b'T\xc3') + masked(0x89, b'?') + masked(0x00, b'\xb5') + \
        masked(0x80, b'nu') + masked(0x82, b'\xff' * 300) + masked(0x88, b'\x03\xe8')
    assert read(data, step) == [(TEXT, 'a'), (PING, b'?'), (TEXT, 'T\u00f5nu'), (BINARY, b'\xff' * 300),
                                (CLOSE, b'\x03\xe8')]


@pytest.mark.parametrize('data, code, said', [
    (b'\x81\x01a', 1002, 'masked'), (masked(0x91, b''), 1002, 'reserved'), (masked(0xc1, b''), 1002, 'reserved'),
    (masked(0x80, b''), 1002, 'opcode 0'), (masked(0x01, b'') + masked(0x81, b''), 1002, 'opcode 1'),
    (masked(0x83, b''), 1002, 'opcode 3'), (masked(0x89, b'x' * 126), 1002, 'control'),
    (masked(0x09, b''), 1002, 'control'), (masked(0x81, b'\xff'), 1007, 'UTF-8'),
    (masked(0x81, b'x' * 1001), 1009, '1000 bytes'), (b'\x81\xff' + b'\x7f' * 8, 1009, '1000 bytes'),
    (masked(0x01, b'x' * 600) + masked(0x80, b'x' * 600), 1009, '1000 bytes'),
    (masked(0x88, b'\x03'), 1002, "close frame begins with '03'"),
    (masked(0x88, b'\x03\xee'), 1002, 'close frame'), (masked(0x88, b'\0\0'), 1002, 'close frame'),
])
def test_broken_frame_is_named(data, code, said):
    with pytest.raises(Broken, match=said) as caught:
        read(data, largest=1000)
    assert caught.value.code == code


def test_messages_before_a_broken_frame_are_delivered():
    reader, came = Reader(1000), []
    with pytest.raises(Broken):
        for one in reader.feed(masked(0x81, b'stop') + b'\xff\0'):
            came.append(one)
    assert came == [(TEXT, 'stop')]


def test_compressed_messages():
    text = b'turtle' * 1000
    sent = frame(TEXT, text, True)
    assert sent[0] == 0xc1 and len(sent) < 200
    body = sent[2:] if sent[1] < 126 else sent[4:]
    assert zlib.decompressobj(-15).decompress(body + b'\0\0\xff\xff') == text
    assert read(masked(0xc1, body), deflate=True) == [(TEXT, text.decode())]
    assert read(masked(0x81, b'plain'), deflate=True) == [(TEXT, 'plain')]
    with pytest.raises(Broken, match='100 bytes'):
        read(masked(0xc1, body), largest=100, deflate=True)
    with pytest.raises(Broken, match='damaged'):
        read(masked(0xc1, b'\xff' * 20), deflate=True)


def test_garbage_is_refused_or_waits_for_more():
    for _ in range(300):
        try:
            read(os.urandom(50), largest=1000)
        except Broken as broken:
            assert broken.code in (1002, 1007, 1009)
