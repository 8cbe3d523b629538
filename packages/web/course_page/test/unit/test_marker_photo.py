"""course_page.marker_photo: photos that a page sends, one at a time, and processes that fail."""
import json
import sys
import threading
import urllib.error
import urllib.request

import cv2
import numpy as np
import pytest
import tornado.web

from alvar_core import drawing
from browser_servers.core import web
from course_page import marker_photo

pytestmark = pytest.mark.slow

DEADLINE = 30.0  # [s]
WAITS = (sys.executable, '-c', 'import sys, time; sys.stdin.buffer.read(); time.sleep(100)')


@pytest.fixture
def served():
    """Yield a function that serves photos with these arguments of Photos."""
    servers = []

    def serve(*arguments):
        made = web.Server(lambda: tornado.web.Application(
            [('/marker_photo', marker_photo.MarkerPhoto)], refused=lambda text: None,
            access=web.make_access('127.0.0.1', '', '', '', False, str, 0),
            photos=marker_photo.Photos(*arguments), log_function=lambda handler: None), web.listen(0, '127.0.0.1'))
        made.start()
        servers.append(made)
        return made
    yield serve
    for server in servers:
        server.stop()


def send(server, data, **headers):
    """Return (code, text) of a request with a photo."""
    request = urllib.request.Request(f'http://localhost:{server.port}/marker_photo', data, headers)
    try:
        with urllib.request.urlopen(request, timeout=DEADLINE) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_a_photo_is_explained(served):
    image = np.full((480, 640), 200, np.uint8)
    image[150:240, 200:290] = np.where(drawing.marker_image(7, 90) > 0, 230, 20)
    code, text = send(served(), cv2.imencode('.png', image)[1].tobytes())
    assert code == 200 and json.loads(text)['lines'][0].startswith('1: found as marker 7 ')


def test_what_is_no_photo_and_other_sites_are_refused(served):
    server = served()
    assert send(server, b'<svg/>') == (422, 'The file is neither a JPEG nor a PNG\n')
    assert send(server, b'', Origin='http://elsewhere.example')[0] == 403


@pytest.mark.parametrize('command, timeout, said', [
    ((sys.executable, '-c', 'import os; os.abort()'), DEADLINE, 'The search of this photo failed'),
    ((sys.executable, '-c', 'print(1 / 0)'), DEADLINE, 'The search of this photo failed'),
    (WAITS, 0.5, 'more than 0.5 s: send a smaller photo'),
])
def test_a_process_that_fails_or_hangs_ends_nothing_else(served, command, timeout, said):
    server = served(command, timeout)
    for _ in range(2):
        code, text = send(server, b'photo')
        assert code == 422 and said in text


def test_only_some_photos_may_wait(served):
    server = served(WAITS, 1.0)
    codes = []
    senders = [threading.Thread(target=lambda: codes.append(send(server, b'photo')[0]))
               for _ in range(marker_photo.MOST + 2)]
    for each in senders:
        each.start()
    for each in senders:
        each.join(DEADLINE)
    assert sorted(codes) == [422] * marker_photo.MOST + [503] * 2
