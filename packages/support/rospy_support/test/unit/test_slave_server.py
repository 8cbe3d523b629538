"""rospy_support.slave_server: XML-RPC as every client speaks it, on connections that a SocketWatch reads."""
import http.client
import socket
import threading
import xmlrpc.client

import pytest

from rospy_support import slave_server
from rospy_support.inbound import SocketWatch
from rospy_support.slave_server import BODY_LIMIT, SlaveServer
from rostest_support.waiting import until

DEADLINE = 10.0  # [s] for what takes milliseconds


@pytest.fixture
def server():
    reports = []
    made = SlaveServer(SocketWatch(lambda *said: reports.append(said)), ('127.0.0.1', 0), 0)
    made.reports = reports
    made.register_function(lambda *values: [1, 'said', list(values)], 'echo')
    made.register_function(lambda: 1 / 0, 'fail')
    thread = threading.Thread(target=made.serve_forever)
    thread.start()
    yield made
    made.server_close()
    thread.join(DEADLINE)
    assert not thread.is_alive()


def connect(server, data=b''):
    connection = socket.create_connection(server.server_address, DEADLINE)
    connection.sendall(data)
    return connection


def test_calls_on_one_connection(server):
    proxy = xmlrpc.client.ServerProxy('http://{}:{}/'.format(*server.server_address))
    for number in range(3):
        assert proxy.echo('/caller', number) == [1, 'said', ['/caller', number]]
    with pytest.raises(xmlrpc.client.Fault, match='ZeroDivisionError'):
        proxy.fail()
    assert proxy.echo() == [1, 'said', []]


def test_connections_are_kept_and_closed_as_http_asks(server):
    body = xmlrpc.client.dumps((), 'echo')
    connection = http.client.HTTPConnection(*server.server_address, timeout=DEADLINE)
    connection.request('POST', '/RPC2', body)
    assert connection.getresponse().read()
    kept = connection.sock
    connection.request('POST', '/RPC2', body, {'Connection': 'close'})
    assert connection.sock is kept
    answer = connection.getresponse()
    assert answer.status == 200 and xmlrpc.client.loads(answer.read()) == (([1, 'said', []],), None)
    old = connect(server, b'POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n%s' % (len(body), body.encode()))
    with old, old.makefile('rb') as file:
        assert b'200 OK' in file.read()  # it ends: the server has closed it


def test_a_body_that_comes_in_pieces_and_one_of_the_greatest_length(server):
    body = xmlrpc.client.dumps(('x' * (BODY_LIMIT - 1000),), 'echo').encode()
    with connect(server, b'POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n' % len(body)) as connection:
        for start in range(0, len(body), 100_000):
            connection.sendall(body[start:start + 100_000])
        with connection.makefile('rb') as file:
            assert b'200 OK' in file.readline()


@pytest.mark.parametrize('size', [BODY_LIMIT + 1, 50_000_000, 10 ** 30])
def test_a_body_that_is_too_long_is_refused_before_it_comes(server, size):
    with connect(server, b'POST / HTTP/1.1\r\nContent-Length: %d\r\n\r\n' % size) as connection:
        assert connection.recv(1000).startswith(b'HTTP/1.1 413 ')
        assert connection.recv(1000) == b''
    (kind, said), = server.reports
    assert kind == 'refused' and str(size) in said


def test_a_call_that_takes_long_keeps_nobody_out(server):
    done, waited = threading.Event(), []
    server.register_function(lambda: waited.append(done.wait(DEADLINE)) or True, 'wait')
    body = xmlrpc.client.dumps((), 'wait').encode()
    with connect(server, b'POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n%s' % (len(body), body)) as waiting:
        assert xmlrpc.client.ServerProxy('http://{}:{}/'.format(*server.server_address)).echo()[0] == 1
        assert not waited
        done.set()
        assert b'200 OK' in waiting.recv(100)


def test_idle_and_slow_connections_cost_no_thread_and_are_closed(server, monkeypatch):
    monkeypatch.setattr(slave_server, 'DEADLINE', 1.5)
    threads = threading.active_count()
    connections = [connect(server, data) for data in 50 * [b'', b'POST / HTTP/1.1\r\n']]
    assert xmlrpc.client.ServerProxy('http://{}:{}/'.format(*server.server_address)).echo()[0] == 1
    until(lambda: threading.active_count() <= threads)
    for connection in connections:
        with connection:
            assert connection.recv(1) == b''


def test_a_client_that_goes_without_its_answer_harms_nobody(server):
    body = xmlrpc.client.dumps(('x' * 1_000_000,), 'echo').encode()
    for _ in range(3):
        connect(server, b'POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n%s' % (len(body), body)).close()
    assert xmlrpc.client.ServerProxy('http://{}:{}/'.format(*server.server_address)).echo()[0] == 1
