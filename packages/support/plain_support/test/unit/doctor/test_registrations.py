"""doctor.registrations: distinguish a node from another program that answers at its address."""
import contextlib
import socket
import struct
import threading

import pytest

from plain_support.doctor import registrations

TIMEOUT = 5.0  # [s] for an answer on this machine, however loaded
NAME = '/robotont_camera/get_loggers'


@contextlib.contextmanager
def server(answer):
    """Listen, and send ``answer`` to whoever connects; yield the URI."""
    with socket.create_server(('localhost', 0)) as listener:
        def serve():
            with contextlib.suppress(OSError):
                connection, _ = listener.accept()
                with connection:
                    connection.recv(1000)
                    connection.sendall(answer)
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f'rosrpc://localhost:{listener.getsockname()[1]}'
        thread.join(TIMEOUT)


def header(*lines):
    body = b''.join(struct.pack('<I', len(line)) + line for line in lines)
    return struct.pack('<I', len(body)) + body


@pytest.mark.parametrize('answer, lives', [
    (header(b'callerid=/robotont_camera', b'md5sum=32e97e85527d4678a8f9279894bb64b0', b'type=roscpp/GetLoggers'), True),
    (header(b'error=[/other] is not a provider of [/robotont_camera/get_loggers]'), False),
    (header(b'md5sum=1', b'error=no'), False), (header(), False), (b'', False), (b'\x01', False),
    (b'HTTP/1.0 400 Bad Request\r\n\r\n', False), (b'\xff\xff\xff\x7f' + b'a' * 100, False),
    (struct.pack('<I', 8) + b'\xff\xff\xff\xff\xff\xff\xff\xff', False),
])
def test_only_the_node_itself_counts(answer, lives):
    with server(answer) as uri:
        assert registrations.offers(NAME, uri, TIMEOUT) is lives


@pytest.mark.parametrize('uri', ['rosrpc://localhost:1', 'rosrpc://', 'nonsense', 'rosrpc://localhost:99999',
                                 'rosrpc://no.such.host.invalid:5'])
def test_an_address_where_nothing_is_does_not_answer(uri):
    assert registrations.offers(NAME, uri, TIMEOUT) is False


def test_what_never_answers_is_given_up():
    with socket.create_server(('localhost', 0)) as listener:
        assert registrations.offers(NAME, f'rosrpc://localhost:{listener.getsockname()[1]}', 0.05) is False
