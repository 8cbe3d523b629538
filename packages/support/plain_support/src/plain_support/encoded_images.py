"""Detect truncated encoded images, by their first and last bytes."""

TRAILER = 1024  # [bytes] that a camera may add after the end mark
END_MARKS = {b'\xff\xd8': b'\xff\xd9', b'\x89PNG': b'IEND'}  # first bytes of JPEG and PNG: end mark


def is_truncated(data: bytes) -> bool:
    """Return whether a JPEG or PNG has no end mark; OpenCV would fill the rest of such an image with grey.

    Other formats are never truncated.
    """
    end = bytes(data[-TRAILER:])
    return any(data[:len(mark)] == mark and end_mark not in end for mark, end_mark in END_MARKS.items())
