"""The wire by hand, over a socket pair and a server of the test: nothing is waited for without a deadline."""
import socket
import threading

import pytest
from turtlesim.srv import Kill

import tcpros


@pytest.fixture
def pair():
    here, there = socket.socketpair()
    here.settimeout(0.2)
    with here, there:
        yield here, there


def test_frames_arrive_whole(pair):
    here, there = pair
    data = bytes(range(256)) * 1000
    sender = threading.Thread(target=there.sendall, args=(tcpros.framed(data),))
    sender.start()
    assert tcpros.receive_frame(here) == data
    sender.join()


@pytest.mark.parametrize('sent, error', [
    (b'', tcpros.NeverAnswered),
    (b'\x05\0\0\0abc', tcpros.NeverAnswered),  # the rest does not come
    (b'\xff\xff\xff\xff', tcpros.Closed),  # nobody waits for 4 GB
])
def test_what_does_not_come(pair, sent, error):
    here, there = pair
    there.sendall(sent)
    with pytest.raises(error):
        tcpros.receive_frame(here)


def test_a_closed_connection(pair):
    here, there = pair
    there.sendall(b'\x05\0')
    there.close()
    with pytest.raises(tcpros.Closed):
        tcpros.receive_frame(here)


def test_nobody_listens():
    with socket.create_server(('127.0.0.1', 0)) as server:
        place = server.getsockname()
    with pytest.raises(tcpros.Closed):
        tcpros.connect(place, 1.0)


def test_every_subscriber_is_one_of_its_own():
    first, second = (tcpros.subscription('/a', Kill) for _ in range(2))
    assert first != second


def serve(server, answers):
    connection, _ = server.accept()
    with connection:
        tcpros.receive_frame(connection)
        connection.sendall(tcpros.header(callerid='/server'))
        for answer in answers:
            tcpros.receive_frame(connection)
            connection.sendall(answer)
        connection.recv(1)


def test_caller():
    with socket.create_server(('127.0.0.1', 0)) as server:
        answers = [b'\x01' + tcpros.framed(b''), b'\0' + tcpros.framed(b'why')]
        thread = threading.Thread(target=serve, args=(server, answers))
        thread.start()
        caller = tcpros.Caller(server.getsockname(), '/kill', Kill, 0.2)
        assert caller.call(b'x') == (True, b'')
        assert caller.call(b'y') == (False, b'why')
        with pytest.raises(tcpros.NeverAnswered):
            caller.answer()
        caller.close()
        thread.join()


def test_address():
    assert tcpros.address('rosrpc://localhost:1234') == ('localhost', 1234)
