"""Why markers are not found in a photo: its words and picture, and files that are no photo or meant to do harm."""
import base64
import json
import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest

from alvar_core import drawing
from alvar_core.detection.explained_photo import MAX_PIXELS, PhotoError, answer

pytestmark = pytest.mark.slow


def photo(ending='.png', width=640):
    """Return a file with marker 42, 90 px wide."""
    image = np.full((480, width, 3), 200, np.uint8)
    image[150:240, 200:290] = np.where(drawing.marker_image(42, 90) > 0, 230, 20)[:, :, None]
    return cv2.imencode(ending, cv2.GaussianBlur(image, (0, 0), 0.7))[1].tobytes()


def chunk(kind, data):
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))


def claimed(width, height):
    """Return a small PNG that unpacks to an image of this size."""
    rows = zlib.compressobj(9)
    data = b''.join(rows.compress(bytes(width // 8 + 1)) for _ in range(height)) + rows.flush()
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 1, 0, 0, 0, 0))
            + chunk(b'IDAT', data) + chunk(b'IEND', b''))


def run(data):
    """Return the answer of the process."""
    return json.loads(subprocess.run([sys.executable, '-m', 'alvar_core.detection.explained_photo'], input=data,
                                     stdout=subprocess.PIPE, check=True, timeout=60).stdout)


@pytest.mark.parametrize('ending', ['.png', '.jpg'])
def test_a_photo_is_explained_in_words_and_drawn(ending):
    found = answer(photo(ending))
    assert found['lines'][0].startswith('1: found as marker 42 (90 px wide')
    drawn = cv2.imdecode(np.frombuffer(base64.b64decode(found['picture']), np.uint8), cv2.IMREAD_COLOR)
    assert drawn.shape == (480, 640, 3)
    blue, green, red = drawn[150:240, 197:203].reshape(-1, 3).mean(0)  # its outline is green
    assert green > red + 40 and green > blue + 40


@pytest.mark.parametrize('data, said', [
    (b'', 'neither a JPEG nor a PNG'), (b'GIF89a' + bytes(100), 'neither a JPEG nor a PNG'),
    (b'P6 64 64 255\n' + bytes(64 * 64 * 3), 'neither a JPEG nor a PNG'), (photo('.bmp'), 'neither a JPEG nor a PNG'),
    (b'\xff\xd8\xff' + bytes(range(256)), 'damaged'), (photo()[:40], 'damaged'),
    (cv2.imencode('.png', np.zeros((4, 4, 3), np.uint8))[1].tobytes(), 'cannot be searched'),
])
def test_what_is_no_photo_is_refused_with_a_reason(data, said):
    with pytest.raises(PhotoError, match=said):
        answer(data)


def test_the_process_answers_and_unpacks_no_more_than_it_may():
    assert run(photo('.jpg'))['lines'][0].startswith('1: found as marker 42')
    side = 30_000
    bomb = claimed(side, side)
    assert len(bomb) < 1_000_000 and side ** 2 > MAX_PIXELS
    assert run(bomb) == {'error': 'The file is damaged, or has more than 4 million pixels'}
