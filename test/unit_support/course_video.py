"""A video of a course: a hand-held camera with a rolling shutter moves along a wall of markers.

Each row of an image is exposed for EXPOSURE, later than the one above it, and shows the wall as it is seen then. Values
have a gamma, and the video is compressed. What was shown is known: ids, and poses at the time at which the middle of a
marker was exposed.
"""
import functools
import math
import os
from typing import Any, Dict, NamedTuple

import cv2
import numpy as np

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from unit_support.marker_classes import marker_cells
from unit_support.marker_score import rotation_between

WIDTH, HEIGHT, RATE = 640, 480, 30.0  # px; Hz
SIZE = 0.10  # [m] of the markers
WALL = {3: (-0.42, 0.05), 14: (-0.14, -0.09), 77: (0.14, 0.09), 201: (0.42, -0.05)}  # id: place [m], x right, y up
SPAN, FINE = (2.0, 1.4), 1500.0  # [m] of the wall; [px/m] of its picture
POSTERS = 60
BLACK, PAPER = 25.0, 205.0  # greys of the print
READOUT, EXPOSURE = 0.020, 0.008  # [s] from the first row to the last; that each is exposed
MOMENTS, KNOTS = 6, 9  # of an exposure; of the way of the camera during an image
BLUR, NOISE, GAMMA = 0.6, 2.0, 2.2  # [px] of the lens; [greys]; of a real camera (1: linear)
INSIDE = 3.0  # [px] from the rim of the image at which a corner counts as seen
CODECS = {'avc1': 'H.264', 'mp4v': 'MPEG-4 (this OpenCV encodes no H.264)'}  # the first one that OpenCV encodes


class Video(NamedTuple):
    """A video: its file, the name of its codec, and for each frame {id: pose} of what it shows.

    A pose has seven numbers: the position [m] in the camera, and the orientation x, y, z, w.
    """

    path: str
    codec: str
    shown: Any


def pose(time):
    """Return rotation and position [m] of the wall in the camera at a time [s]."""
    turn = 2 * math.pi * time
    rotation = rotations.facing(0.35 * math.sin(0.31 * turn), 0.4 * math.sin(0.17 * turn), 0.12 * math.sin(0.23 * turn))
    return rotation, np.array([0.35 * math.sin(0.29 * turn) + 0.004 * math.sin(4.1 * turn),
                               0.06 * math.sin(0.41 * turn) + 0.004 * math.sin(5.3 * turn),
                               0.95 + 0.25 * math.cos(0.21 * turn)])


@functools.lru_cache(maxsize=1)
def wall():
    """Return the picture of the wall: markers on white paper, before posters."""
    rng = np.random.default_rng(3)
    width, height = (int(span * FINE) for span in SPAN)
    rough = rng.normal(130, 8, (height // 100, width // 100)).astype(np.float32)
    picture = cv2.resize(rough, (width, height), interpolation=cv2.INTER_CUBIC)
    for _ in range(POSTERS):
        x, y, wide, high = (int(v) for v in rng.uniform(0, [width, height, 300, 200]))
        picture[y:y + high, x:x + wide] = rng.uniform(20, 220)
    for number, place in WALL.items():
        half = int(SIZE / 2 * FINE)
        x, y = (int(v) for v in _on_picture(*place))
        paper = half + half // 3
        picture[y - paper:y + paper, x - paper:x + paper] = PAPER
        cells = cv2.resize(marker_cells(number).astype(np.uint8), (2 * half, 2 * half), interpolation=cv2.INTER_NEAREST)
        picture[y - half:y + half, x - half:x + half] = np.where(cells > 0, PAPER, BLACK)
    return cv2.blur(picture, (3, 3))  # a pixel of the camera covers about this much


def _on_picture(x, y):
    return (x + SPAN[0] / 2) * FINE, (SPAN[1] / 2 - y) * FINE


def frame(number, camera, gamma=GAMMA):
    """Return the grey image (HEIGHT, WIDTH) uint8 of a frame, and {id: pose (7,)} of what it shows."""
    rng, begun = np.random.default_rng([7, number]), number / RATE
    columns, rows = np.arange(WIDTH, dtype=np.float32), np.arange(HEIGHT)
    times = np.linspace(0, READOUT + EXPOSURE, KNOTS)
    knots = np.array([_to_picture(begun + time, camera) for time in times]).reshape(KNOTS, 9)
    light = np.zeros((HEIGHT, WIDTH), np.float32)
    for moment in (np.arange(MOMENTS) + 0.5) / MOMENTS * EXPOSURE:
        ways = np.stack([np.interp(moment + READOUT * rows / HEIGHT, times, each) for each in knots.T], 1)
        ways = ways.reshape(HEIGHT, 3, 3)
        shift = (ways[:, :, 1] * rows[:, None] + ways[:, :, 2]).astype(np.float32)
        x, y, w = (ways[:, k, :1].astype(np.float32) * columns + shift[:, k, None] for k in range(3))
        light += cv2.remap(wall(), x / w, y / w, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    light = cv2.GaussianBlur(light / MOMENTS, (0, 0), BLUR)
    light += rng.normal(0, NOISE, light.shape)
    image = np.round(255 * (np.clip(light, 0, 255) / 255) ** (1 / gamma)).astype(np.uint8)
    return image, _shown(begun, camera)


def _to_picture(time, camera):
    """Return the homography (3, 3) from pixels of the camera to those of the wall's picture."""
    rotation, position = pose(time)
    to_camera = camera.matrix @ np.column_stack([rotation[:, :2], position])
    on_picture = np.array([[FINE, 0, SPAN[0] / 2 * FINE - 0.5], [0, -FINE, SPAN[1] / 2 * FINE - 0.5], [0, 0, 1]])
    way = on_picture @ np.linalg.inv(to_camera)
    return way / way[2, 2]


def _shown(begun, camera):
    shown: Dict[int, Any] = {}
    for number, place in WALL.items():
        row = HEIGHT / 2
        for _ in range(3):  # the row tells the time, and the time tells the row
            rotation, position = pose(begun + EXPOSURE / 2 + READOUT * row / HEIGHT)
            middle = rotation @ [*place, 0.0] + position
            corners = drawing.project(camera, rotation, middle, drawing.object_corners(SIZE))
            row = corners[:, 1].mean()
        if (corners > INSIDE).all() and (corners < [WIDTH - INSIDE, HEIGHT - INSIDE]).all():
            shown[number] = np.concatenate([middle, rotations.quaternion_from_matrix(rotation)])
    return shown


def make(folder, seconds, gamma=GAMMA):
    """Write a video of this length into a folder; return the Video."""
    camera = default_camera(WIDTH, HEIGHT)
    os.environ['OPENCV_FFMPEG_LOGLEVEL'] = '-8'  # else OpenCV and FFmpeg tell of each codec that they do not have
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    for codec in CODECS:
        path = os.path.join(folder, f'course_{gamma:g}_{codec}.mp4')
        writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*codec), RATE, (WIDTH, HEIGHT))
        if writer.isOpened():
            break
    shown = []
    for number in range(int(seconds * RATE)):
        image, poses = frame(number, camera, gamma)
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
        shown.append({str(key): value.tolist() for key, value in poses.items()})
    writer.release()
    return Video(path, CODECS[codec], shown)


def frames_of(path):
    """Return the BGR images of a video."""
    capture, images = cv2.VideoCapture(path), []
    while True:
        good, image = capture.read()
        if not good:
            return images
        images.append(image)


def compared(answers):
    """Return what is found in frames: ``answers`` are their {id: pose} as shown, and (id, pose) as found.

    ``seen``: markers that they show; ``found``: how many of these; ``other``: ids that are not on the wall; ``off``:
    errors of positions, ``far``: of distances, above 0 if too long [% of the distance]; ``turned``: of rotations [deg].
    """
    seen = found = other = 0
    off, far, turned = [], [], []
    for shown, markers in answers:
        seen += len(shown)
        by_id = {str(number): pose for number, pose in markers}
        other += sum(int(number) not in WALL for number in by_id)
        for number, pose in shown.items():
            if number in by_id:
                found += 1
                (position, orientation), (place, turn) = ((each[:3], each[3:]) for each in (pose, by_id[number]))
                distance = float(np.linalg.norm(position))
                off.append(100.0 * float(np.linalg.norm(np.subtract(place, position))) / distance)
                far.append(100.0 * (float(np.linalg.norm(place)) / distance - 1.0))
                turned.append(rotation_between(orientation, turn))
    return {'seen': seen, 'found': found, 'other': other, 'off': off, 'far': far, 'turned': turned}
