"""The HTTP side of a server: whose images it shows, and that connections without a whole request are closed."""
import http.client
import socket

import pytest
import tornado.web

from rosbridge_core import web
from rosbridge_core.access import Access

DEADLINE = 10.0  # [s]
PATIENCE = 0.2  # [s] of the server under test


class Hello(web.Guarded):
    def get(self):
        if not self._finished:
            self.finish('hello')

    post = get


@pytest.fixture
def serve(monkeypatch):
    """Return a function that starts a server, with the rules of ``access`` for its port, and returns the port."""
    monkeypatch.setattr(web, 'IDLE', PATIENCE)
    servers = []

    def start(access=lambda port: Access('secret'), **settings):
        sockets = web.listen(0, '127.0.0.1')
        server = web.Server(lambda: tornado.web.Application(
            [(r'/', Hello)], access=access(sockets[0].getsockname()[1]), refused=lambda reason: None, **settings),
            sockets)
        server.start()
        servers.append(server)
        return server.port
    yield start
    for server in servers:
        server.stop()


@pytest.mark.parametrize('beginning', [
    b'', b'GET / HTTP/1.1\r\nHost: localhost\r\n', b'GET / HT',
    b'POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\nab',
])
def test_half_a_request_is_closed(serve, beginning):
    with socket.create_connection(('127.0.0.1', serve()), DEADLINE) as client:
        client.sendall(beginning)
        assert client.recv(1000) in (b'', b'HTTP/1.1 400 Bad Request\r\n\r\n')


@pytest.mark.parametrize('headers, of_files, status', [
    ({'Referer': 'http://evil.example/'}, False, 403), ({'Referer': 'http://evil.example/'}, True, 403),
    ({}, False, 403), ({}, True, 200), ({'Sec-Fetch-Mode': 'navigate'}, False, 200),
    ({'Sec-Fetch-Site': 'same-origin'}, False, 200),
])
def test_images_are_for_own_pages(serve, headers, of_files, status):
    connection = http.client.HTTPConnection('127.0.0.1', serve(shown_by_files=of_files), timeout=DEADLINE)
    connection.request('GET', '/', headers={'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'no-cors',
                                            'Sec-Fetch-Dest': 'image', **headers})
    assert connection.getresponse().status == status
    connection.close()


@pytest.mark.parametrize('host, origin, status', [
    ('ann-{}.app.github.dev', 'https://ann-{}.app.github.dev', 200),  # as the browser sends them
    ('localhost:{}', 'https://ann-{}.app.github.dev', 200), ('localhost:{}', 'https://localhost:{}', 200),
    ('ann-{}.app.github.dev', None, 200),
    ('bob-{}.app.github.dev', None, 403), ('ann-1.app.github.dev', None, 403), ('ann-{}.evil.example', None, 403),
    ('localhost:{}', 'https://bob-{}.app.github.dev', 403), ('localhost:{}', 'http://ann-{}.app.github.dev', 403),
])
def test_a_codespace_forwards_its_port_by_a_name_of_its_own(serve, monkeypatch, host, origin, status):
    monkeypatch.setenv('CODESPACE_NAME', 'ann')
    monkeypatch.setenv('GITHUB_CODESPACES_PORT_FORWARDING_DOMAIN', 'app.github.dev')
    port = serve(access=lambda port: web.make_access('0.0.0.0', 'secret', '', '', False, str, port, published=True))
    connection = http.client.HTTPConnection('127.0.0.1', port, timeout=DEADLINE)
    sent = {'Host': host.format(port), **({'Origin': origin.format(port)} if origin else {})}
    connection.request('GET', '/', headers=sent)
    assert connection.getresponse().status == status
    connection.close()


def test_elsewhere_there_is_no_such_name(serve, monkeypatch):
    for name in web.CODESPACE:
        monkeypatch.delenv(name, raising=False)
    access = web.make_access('0.0.0.0', 'secret', '', '', False, str, 8000)
    assert access.origins == [] and not [name for name in access.hosts if '8000' in name]
