"""plain_support.encoded_images: the end mark decides, wherever in the trailer it is."""
import pytest

from plain_support.encoded_images import TRAILER, is_truncated

JPEG, PNG = b'\xff\xd8\xff\xe0', b'\x89PNG\r\n\x1a\n'


@pytest.mark.parametrize('data, truncated', [
    (JPEG + b'pixels\xff\xd9', False),
    (JPEG + b'pixels\xff\xd9' + b'added by a camera', False),
    (JPEG + b'pixels', True),
    (JPEG, True),
    (JPEG + b'pixels\xff\xd9' + TRAILER * b' ', True),
    (PNG + b'pixels\0\0\0\0IEND\xaeB`\x82', False),
    (PNG + b'pixels', True),
    (b'BM, which has no end mark', False),
    (b'', False),
])
def test_end_mark_decides(data, truncated):
    assert is_truncated(data) is truncated
