"""What is found in images without markers: every detection is a false one.

The images of a folder and its subfolders are read; what is no image is left out. Their cameras are not known: the lens
is taken for one of about 55 degrees, and values for light.
"""
import os

import cv2

from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.prepared_image import MIN_IMAGE_SIDE
from processes import BenchError

ENDINGS = ('.bmp', '.jpeg', '.jpg', '.pgm', '.png', '.ppm', '.tif', '.tiff', '.webp')
SIZE = 0.05  # m: it changes no figure


def images_of(folder):
    """Yield (path, grey image) of the images in a folder and its subfolders."""
    for where, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            path = os.path.join(where, name)
            image = cv2.imread(path, cv2.IMREAD_GRAYSCALE) if name.lower().endswith(ENDINGS) else None
            if image is not None and min(image.shape) >= MIN_IMAGE_SIDE:
                yield path, image


def report(folder):
    """Return what is found as text; raise BenchError if the folder has no image."""
    count, lines = 0, []
    detector = Detector(SIZE, gamma=1.0)  # false markers teach no gamma
    for path, image in images_of(folder):
        count += 1
        for found in detector.detect(image, default_camera(image.shape[1], image.shape[0])):
            x, y = found.centre
            lines.append(f'{path}: id {found.id} at {x:.0f}, {y:.0f}, {found.side:.0f} px wide, '
                         f'confidence {found.confidence:.2f}')
    if not count:
        raise BenchError(f'{folder} has no images of at least {MIN_IMAGE_SIDE}x{MIN_IMAGE_SIDE} pixels: files that end '
                         f'with {", ".join(ENDINGS)} are read.')
    return '\n'.join([*lines, f'{folder}: {count} images without markers; false detections: {len(lines)}'])
