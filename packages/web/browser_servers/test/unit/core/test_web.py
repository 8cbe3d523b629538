"""The HTTP side of a server: whose images it shows, which files, and that half a request is closed."""
import http.client
import socket

import pytest
import tornado.web

from browser_servers.core import web
from browser_servers.core.access import Access

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

    def start(access=lambda port: Access('secret'), rules=((r'/', Hello),), **settings):
        sockets = web.listen(0, '127.0.0.1')
        server = web.Server(lambda: tornado.web.Application(
            rules, access=access(sockets[0].getsockname()[1]), refused=lambda reason: None, **settings),
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
    answer, _ = get(serve(shown_by_files=of_files), '/', {
        'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'no-cors', 'Sec-Fetch-Dest': 'image', **headers})
    assert answer.status == status


@pytest.mark.parametrize('path, status', [
    ('/', 200), ('/app/main.js', 200), ('/app/../index.html', 200), ('/none', 404), ('/app/', 404),
    *((f'/{up}/secret', None) for up in (
        '..', '%2e%2e', '.%2e', '..%2f', '%252e%252e', '..%c0%af', '..%5c', '..\\', '....//', 'app/../..', '/..')),
    ('/../web_of_others/secret', None), ('/%00', None), ('/index.html%00.js', None), ('/%ff', None),
    (f'/{"a" * 9000}', None), ('//secret', None),
])
def test_files_are_those_of_the_folder(serve, tmp_path, path, status):
    """``status`` None: any refusal."""
    for name in ('secret', 'web_of_others/secret', 'web/index.html', 'web/app/main.js'):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    answer, text = get(serve(rules=web.folder_rules(str(tmp_path / 'web'), '')), path)
    assert 'secret' not in text
    assert answer.status == status or (status is None and 400 <= answer.status < 500)


def test_no_other_site_shows_a_page_in_a_frame_and_no_type_is_guessed(serve):
    answer, _ = get(serve(), '/')
    assert answer.headers['X-Frame-Options'] == 'SAMEORIGIN' and answer.headers['X-Content-Type-Options'] == 'nosniff'


def get(port, path, headers=None):
    """Return the answer and its text."""
    connection = http.client.HTTPConnection('127.0.0.1', port, timeout=DEADLINE)
    connection.request('GET', path, headers=headers or {})
    answer = connection.getresponse()
    text = answer.read().decode('utf-8', 'replace')
    connection.close()
    return answer, text


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
    headers = {'Host': host.format(port), **({'Origin': origin.format(port)} if origin else {})}
    assert get(port, '/', headers)[0].status == status


def test_elsewhere_there_is_no_such_name(serve, monkeypatch):
    for name in web.CODESPACE:
        monkeypatch.delenv(name, raising=False)
    access = web.make_access('0.0.0.0', 'secret', '', '', False, str, 8000)
    assert access.origins == [] and not [name for name in access.hosts if '8000' in name]
