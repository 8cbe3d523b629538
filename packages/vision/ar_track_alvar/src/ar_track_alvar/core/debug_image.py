"""The image of ~debug_image: the camera's image with the detections drawn over it."""
from typing import Callable, Sequence, Tuple, Union

import cv2
import numpy as np

from alvar_core import drawing
from alvar_core.camera import Camera
from alvar_core.detection.detection import Detection

SURE, AMBIGUOUS, LEFT_OUT = (60, 220, 60), (0, 200, 255), (150, 150, 150)  # BGR
AXES = ((0, 0, 255), (0, 255, 0), (255, 0, 0))  # x, y, z
SHIFT = 4  # fractional bits of OpenCV's drawing coordinates
LABEL_SIZE, LABEL_WIDTH = 0.75, 2  # of the id in an image 640 px wide; the pen [px]
OUTLINE = [(x, y) for x in (-2, 0, 2) for y in (-2, 0, 2) if x or y]  # [px]

Colour = Tuple[int, int, int]  # BGR


def draw(image: np.ndarray, camera: Camera, detections: Sequence[Detection], published: Sequence[Detection],
         size_of: Callable[[Union[int, str]], float]) -> np.ndarray:
    """Draw Detections on an image (height, width, 3) uint8 BGR, in place: outline, first corner, id, axes.

    The axes are half a side long. Detections that are not in ``published`` are drawn grey; ``size_of(id)`` returns the
    width [m] of a marker.
    """
    for detection in detections:
        shown = detection in published
        colour = AMBIGUOUS if detection.ambiguous else SURE
        if not shown:
            colour = LEFT_OUT
        cv2.polylines(image, [_fixed(detection.corners)], True, colour, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(image, _fixed(detection.corners[0]).tolist(), 4 << SHIFT, colour, -1, cv2.LINE_AA, SHIFT)
        if shown:
            _axes(image, camera, detection, size_of(detection.id) / 2.0)
        _label(image, detection, colour)
    return image


def _axes(image: np.ndarray, camera: Camera, detection: Detection, length: float) -> None:
    ends = drawing.project(camera, detection.rotation, detection.position, np.vstack([np.zeros(3), np.eye(3) * length]))
    origin, *tips = _fixed(ends).tolist()
    for tip, colour in zip(tips, AXES):
        cv2.line(image, origin, tip, colour, 2, cv2.LINE_AA, SHIFT)


def _label(image: np.ndarray, detection: Detection, colour: Colour) -> None:
    """Write the id below the marker, light with a dark outline, so that it is readable on any background."""
    text, size = f'{detection.id}{"?" if detection.ambiguous else ""}', max(LABEL_SIZE * image.shape[1] / 640.0, 0.5)
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, LABEL_WIDTH)
    x, y = detection.corners[:, 0].mean() - width / 2.0, detection.corners[:, 1].max() + height + 6
    at = np.clip((x, y), (2, height + 2), (max(2, image.shape[1] - width - 2), image.shape[0] - 4)).astype(int)
    light = tuple((part + 255) // 2 for part in colour)
    for shift in (*OUTLINE, (0, 0)):  # a thicker pen would also widen the letters
        cv2.putText(image, text, (at + shift).tolist(), cv2.FONT_HERSHEY_SIMPLEX, size,
                    (0, 0, 0) if any(shift) else light, LABEL_WIDTH, cv2.LINE_AA)


def _fixed(points: np.ndarray) -> np.ndarray:
    """Return points (..., 2) [px] as int32 with SHIFT fractional bits, clipped to the range of OpenCV."""
    fixed: np.ndarray = np.clip(np.nan_to_num(points) * (1 << SHIFT), -1e6, 1e6).round().astype(np.int32)
    return fixed
