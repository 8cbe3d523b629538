"""course_page.marker_photo: photos that a page sends, one at a time, and processes that fail."""
import json
import sys
import threading

import cv2
import numpy as np
import pytest

from alvar_core import drawing
from course_page import marker_photo

pytestmark = pytest.mark.slow

DEADLINE = 30.0  # [s]
WAITS = (sys.executable, '-c', 'import sys, time; sys.stdin.buffer.read(); time.sleep(100)')


@pytest.fixture
def send(serve):
    """Return a function that sends a photo to a server with these arguments of Photos."""
    def make(*arguments):
        return serve('/marker_photo', [('/marker_photo', marker_photo.MarkerPhoto)],
                     photos=marker_photo.Photos(*arguments)).send
    return make


def test_a_photo_is_explained(send):
    image = np.full((480, 640), 200, np.uint8)
    image[150:240, 200:290] = np.where(drawing.marker_image(7, 90) > 0, 230, 20)
    code, text = send()(cv2.imencode('.png', image)[1].tobytes())
    assert code == 200 and json.loads(text)['lines'][0].startswith('1: found as marker 7 ')


def test_what_is_no_photo_and_other_sites_are_refused(send):
    post = send()
    assert post(b'<svg/>') == (422, 'The file is neither a JPEG nor a PNG\n')
    assert post(b'', Origin='http://elsewhere.example')[0] == 403


@pytest.mark.parametrize('command, timeout, error', [
    ((sys.executable, '-c', 'import os; os.abort()'), DEADLINE, 'The search of this photo failed'),
    ((sys.executable, '-c', 'print(1 / 0)'), DEADLINE, 'The search of this photo failed'),
    (WAITS, 0.5, 'more than 0.5 s: send a smaller photo'),
])
def test_a_process_that_fails_or_hangs_ends_nothing_else(send, command, timeout, error):
    post = send(command, timeout)
    for _ in range(2):
        code, text = post(b'photo')
        assert code == 422 and error in text


def test_only_some_photos_may_wait(send):
    post = send(WAITS, 1.0)
    codes = []
    senders = [threading.Thread(target=lambda: codes.append(post(b'photo')[0]))
               for _ in range(marker_photo.MAX_PHOTOS + 2)]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join(DEADLINE)
    assert sorted(codes) == [422] * marker_photo.MAX_PHOTOS + [503] * 2
