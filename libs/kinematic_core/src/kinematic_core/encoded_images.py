"""Tells encoded images that were cut off from complete ones, by their first and last bytes."""

TRAILER = 1024  # [bytes] that a camera may add after the end mark
END_MARKS = {b'\xff\xd8': b'\xff\xd9', b'\x89PNG': b'IEND'}  # first bytes of JPEG and PNG: end mark


def is_truncated(start: bytes, end: bytes) -> bool:
    """Return whether a JPEG or PNG lacks its end mark; OpenCV would fill such an image up with grey.

    start: its first bytes, at least 4; end: its last TRAILER bytes. Other formats are never truncated.
    """
    return any(start.startswith(mark) and end_mark not in end for mark, end_mark in END_MARKS.items())
