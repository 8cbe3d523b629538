"""The picture of ~debug_image: what was found, drawn over it."""
import cv2
import numpy as np

from alvar_core import drawing

SURE, AMBIGUOUS, LEFT_OUT = (60, 220, 60), (0, 200, 255), (150, 150, 150)  # BGR
AXES = ((0, 0, 255), (0, 255, 0), (255, 0, 0))  # x, y, z
SHIFT = 4  # fractional bits of OpenCV's drawing coordinates


def draw(picture, camera, detections, published, size_of):
    """Draw Detections on a BGR picture, in place: outline, first corner, id, axes half a side long.

    published: those of them that are published, the others are grey; size_of(id): width of the square, m.
    """
    for detection in detections:
        shown = any(detection is other for other in published)
        colour = LEFT_OUT if not shown else AMBIGUOUS if detection.ambiguous else SURE
        cv2.polylines(picture, [_fixed(detection.corners)], True, colour, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(picture, _fixed(detection.corners[0]).tolist(), 4 << SHIFT, colour, -1, cv2.LINE_AA, SHIFT)
        if shown:
            _axes(picture, camera, detection, size_of(detection.id) / 2.0)
        _label(picture, detection, colour)
    return picture


def _axes(picture, camera, detection, length):
    ends = drawing.project(camera, detection.rotation, detection.position, np.vstack([np.zeros(3), np.eye(3) * length]))
    origin, *tips = _fixed(ends).tolist()
    for tip, colour in zip(tips, AXES):
        cv2.line(picture, origin, tip, colour, 2, cv2.LINE_AA, SHIFT)


def _label(picture, detection, colour):
    """The id below the marker, black behind it so that it can be read on anything."""
    x, y = detection.corners[:, 0].min(), detection.corners[:, 1].max()
    at = int(np.clip(x, 0, picture.shape[1] - 30)), int(np.clip(y + 18, 14, picture.shape[0] - 4))
    text = f'{detection.id}{"?" if detection.ambiguous else ""}'
    for shade, width in (((0, 0, 0), 4), (colour, 1)):
        cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.6, shade, width, cv2.LINE_AA)


def _fixed(points):
    """Points as OpenCV's fixed point numbers, kept within what they can hold."""
    return np.clip(np.nan_to_num(points) * (1 << SHIFT), -1e6, 1e6).round().astype(np.int32)
