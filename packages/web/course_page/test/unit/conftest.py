"""A server of requests that pages send, and what it answers."""
import json
import time
import urllib.error
import urllib.request

import pytest
import tornado.web

from browser_servers.core import web

DEADLINE = 30.0  # [s]


class Site:
    """A server of ``rules`` in a thread of its own; requests go to ``path`` unless they name another below it."""

    def __init__(self, path, rules, **settings):
        self.path = path
        self._server = web.Server(lambda: tornado.web.Application(
            rules, access=web.make_access('127.0.0.1', '', '', '', False, str, 0), refused=lambda text: None,
            log_function=lambda handler: None, **settings), web.listen(0, '127.0.0.1'))
        self._server.start()
        self.stop = self._server.stop

    def send(self, data=None, path='', **headers):
        """Return (code, text) of a request with these bytes; without, of GET."""
        request = urllib.request.Request(f'http://localhost:{self._server.port}{self.path}{path}', data, headers)
        try:
            with urllib.request.urlopen(request, timeout=DEADLINE) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as error:
            return error.code, error.read().decode()

    def post(self, body, **headers):
        """Return (code, text) of a request with this value as JSON."""
        return self.send(json.dumps(body).encode(), **headers)

    def get(self, path=''):
        """Return the JSON that is there."""
        return json.loads(self.send(path=path)[1])

    def until(self, condition):
        """Return the JSON at ``path`` once it fulfils the condition."""
        deadline = time.monotonic() + DEADLINE
        while True:
            state = self.get()
            if condition(state):
                return state
            assert time.monotonic() < deadline, state
            time.sleep(0.01)


@pytest.fixture
def serve():
    """Return a function that makes a Site, which is stopped at the end."""
    sites = []

    def make(*arguments, **settings):
        sites.append(Site(*arguments, **settings))
        return sites[-1]
    yield make
    for site in sites:
        site.stop()
