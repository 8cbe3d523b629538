"""Say why markers are not found in a photo from anywhere: python3 -m alvar_core.detection.explained_photo < PHOTO.

It writes JSON to its output: ``lines``, and ``picture``, a JPEG in base64 with the candidates; or ``error``. Decoders
of images have faults, so this is a process of its own, which may neither take much memory nor run for long.
"""
from __future__ import annotations

import base64
import json
import os
import resource
import sys

MAX_PIXELS = 4_000_000
MEMORY, PROCESSOR = 3 << 30, 30  # [bytes] of addresses, most of them never used; [s]
SIGNATURES = b'\xff\xd8\xff', b'\x89PNG\r\n\x1a\n'
QUALITY = 85  # of the JPEG


class PhotoError(ValueError):
    """A photo that cannot be searched; the text is for the user."""


def answer(photo: bytes) -> dict[str, object]:
    """Return ``lines`` and ``picture`` of a JPEG or PNG; raise PhotoError."""
    import cv2
    import numpy as np

    from alvar_core.camera import default_camera
    from alvar_core.detection.detector import Detector
    from alvar_core.detection.explanation import explain
    from alvar_core.detection.prepared_image import ImageError
    if not photo.startswith(SIGNATURES):
        raise PhotoError('The file is neither a JPEG nor a PNG')
    try:
        image = cv2.imdecode(np.frombuffer(photo, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:  # more than MAX_PIXELS
        image = None
    if image is None:
        raise PhotoError(f'The file is damaged, or has more than {MAX_PIXELS // 1_000_000} million pixels')
    height, width = image.shape[:2]
    try:
        # The lens of a photo is not known; its size in metres is of no account
        explained = explain(Detector(1.0), cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), default_camera(width, height))
    except ImageError as error:
        raise PhotoError(f'The photo cannot be searched: {error}') from None
    _, encoded = cv2.imencode('.jpg', explained.outlined(image), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return {'lines': explained.lines, 'picture': base64.b64encode(encoded.tobytes()).decode()}


def main() -> None:
    """Answer for the photo in the standard input."""
    os.environ['OPENCV_IO_MAX_IMAGE_PIXELS'] = str(MAX_PIXELS)  # OpenCV reads these when it is loaded
    os.environ['OPENBLAS_NUM_THREADS'] = '1'
    for what, most in (resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, PROCESSOR), (resource.RLIMIT_CORE, 0):
        resource.setrlimit(what, (most, most))
    try:
        found = answer(sys.stdin.buffer.read())
    except PhotoError as error:
        found = {'error': str(error)}
    json.dump(found, sys.stdout)


if __name__ == '__main__':
    main()
