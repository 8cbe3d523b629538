"""The HTTP side of a server for browsers: access control, files, and a loop in a thread of its own.

Every request for a WebSocket, a page or a stream passes ``Guarded.prepare``, so the rules of access.py hold for all.
"""
import asyncio
import contextlib
import hmac
import os
import secrets
import socket
import sys
import threading
import time
from typing import Any, Callable, List, Optional, Tuple, Union

import tornado.httpserver
import tornado.httputil
import tornado.netutil
import tornado.web

from browser_servers.core.access import ANY, OFF, Access, is_loopback, page_origin

COOKIE = 'turtle_robotont_token'
IDLE = 10.0  # [s] until a connection is closed that sends no request, or only a part of one
LARGEST_REQUEST = 1 << 20  # [B]
CODESPACE = 'CODESPACE_NAME', 'GITHUB_CODESPACES_PORT_FORWARDING_DOMAIN'  # of the environment in a codespace
BACKLOG = 512  # connections that wait to be accepted


class Guarded(tornado.web.RequestHandler):
    """Refuses clients that may not connect, with 403 and the reason; the token is in the address or in a cookie.

    ``prepare`` then ends the request, and tornado calls no other method.

    The application's settings have ``access``, an Access, and ``refused``, which is called with the reason; with
    ``shown_by_files`` a page that is opened as a file may show images.
    """

    def prepare(self) -> None:
        token = self.get_query_argument('token', None)
        known = token if token is not None else self.get_cookie(COOKIE)
        access: Access = self.settings['access']
        peer = self.request.remote_ip or ''
        headers = self.request.headers
        origin = page_origin(headers.get('Origin') or headers.get('Sec-WebSocket-Origin'), headers.get('Referer'),
                             headers.get('Sec-Fetch-Site'), headers.get('Sec-Fetch-Mode'),
                             self.settings.get('shown_by_files', False))
        reason = access.refusal(peer, headers.get('Host'), origin, known)
        if reason is not None:
            self.settings['refused'](f'A connection from {peer} is refused: {reason}.')
            self.refuse(403, reason)
        elif token is not None and access.token != OFF and hmac.compare_digest(token.encode(), access.token.encode()):
            self.set_cookie(COOKIE, token, httponly=True, samesite='Strict')

    def refuse(self, code: int, reason: str) -> None:
        self.clear()
        self.set_status(code)
        self.set_header('Content-Type', 'text/plain; charset=utf-8')
        self.finish(f'{reason}\n')

    def answer_json(self, text: Union[str, bytes]) -> None:
        """End the request with JSON, which browsers do not keep."""
        self.set_header('Content-Type', 'application/json')
        self.set_header('Cache-Control', 'no-store')
        self.finish(text)

    def set_default_headers(self) -> None:
        """Forbid other sites to show this one in a frame, and browsers to guess content types."""
        self.set_header('X-Content-Type-Options', 'nosniff')
        self.set_header('X-Frame-Options', 'SAMEORIGIN')


class Files(Guarded, tornado.web.StaticFileHandler):
    """Serves the files of a folder; '/' is index.html. It serves nothing outside the folder and lists no folder."""

    def set_extra_headers(self, path: str) -> None:
        """Make browsers ask each time whether a file has changed."""
        self.set_header('Cache-Control', 'no-cache')


class Missing(Guarded):
    """Answers with 404 and a text that says which addresses exist."""

    def initialize(self, text: str) -> None:
        self._text = text

    def get(self, *_: Any) -> None:
        self.refuse(404, self._text)


def make_access(address: str, token: str, origins: str, hosts: str, null_origin: bool, warn: Callable[[str], None],
                port: int, published: bool = False) -> Access:
    """Return the rules for a server that listens at an address; lists are separated by commas.

    A server that other machines can reach gets a token if none is given; ``warn`` says so, unless only the host of a
    container can reach it, at a ``published`` port.
    """
    name, forwarded = socket.gethostname(), _forwarded_name(port)
    names = [name, f'{name}.local', socket.getfqdn(), *forwarded, *_parts(hosts)]
    sites = [*(f'https://{host}' for host in forwarded), *_parts(origins)]
    if is_loopback(address):
        token = token or secrets.token_urlsafe(16)
    elif token == OFF:
        warn(f'Anybody in the network can read and move everything: address:={address} with token:=off.')
    else:
        token = token or secrets.token_urlsafe(16)
        if not published:
            warn(f'Other machines can connect, with the token: ws://{name}:{port}/?token={token} and '
                 f'http://{name}:{port}/?token={token}')
    if ANY in _parts(origins):
        warn('Any page that a browser on this machine shows can read and move everything: origins:=any.')
    return Access(token, sites, names, null_origin)


def _forwarded_name(port: int) -> List[str]:
    """Return the name by which a codespace of GitHub forwards a port to the browser of its owner; elsewhere []."""
    name, domain = (os.environ.get(key) for key in CODESPACE)
    return [f'{name}-{port}.{domain}'] if name and domain else []


def _parts(text: str) -> List[str]:
    return [part.strip() for part in text.split(',') if part.strip()]


def listen(port: int, address: str) -> List[socket.socket]:
    """Return listening sockets; port 0: a free one. Raise OSError."""
    return tornado.netutil.bind_sockets(port, address, backlog=BACKLOG)


def listen_when_free(port: int, address: str, delay: float, warn: Callable[[str], None],
                     is_shutdown: Callable[[], bool]) -> List[socket.socket]:
    """Return listening sockets; where the port is taken, try again each ``delay`` [s] until the node shuts down."""
    while True:
        try:
            return listen(port, address)
        except OSError as error:
            warn(f'Cannot listen at {address}, port {port} ({error.strerror or error}). Is another server running? '
                 f'Trying again in {delay:g} s; for another port, type _port:={port + 1}')
            time.sleep(delay)
            if is_shutdown():
                sys.exit(0)


class Server:
    """A tornado application in a thread of its own."""

    def __init__(self, make: Callable[[], tornado.web.Application], sockets: List[socket.socket],
                 tls: Optional[Tuple[str, str]] = None) -> None:
        """``make`` is called in the thread; ``tls``: files of certificate and key."""
        self._make, self._sockets, self._tls = make, sockets, tls
        self.loop = asyncio.new_event_loop()
        self._ended = threading.Event()
        self.port: int = sockets[0].getsockname()[1]

    def start(self) -> None:
        """Serve until ``stop``."""
        threading.Thread(target=self._run, name='http', daemon=True).start()

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        options = None if self._tls is None else {'certfile': self._tls[0], 'keyfile': self._tls[1]}
        server = tornado.httpserver.HTTPServer(
            self._make(), ssl_options=options, idle_connection_timeout=IDLE, body_timeout=IDLE,
            max_body_size=LARGEST_REQUEST, max_header_size=65536, no_keep_alive=False)
        server.add_sockets(self._sockets)
        self.loop.run_forever()
        server.stop()
        self._ended.set()

    def stop(self, timeout: float = 2.0) -> None:
        with contextlib.suppress(RuntimeError):
            self.loop.call_soon_threadsafe(self.loop.stop)
        self._ended.wait(timeout)


def folder_rules(folder: str, text: str) -> List[Any]:
    """Return the rules of an application for the files of a folder; without one, ``text`` is the answer."""
    if folder:
        return [(r'/(.*)', Files, {'path': os.path.realpath(folder), 'default_filename': 'index.html'})]
    return [(r'.*', Missing, {'text': text})]
