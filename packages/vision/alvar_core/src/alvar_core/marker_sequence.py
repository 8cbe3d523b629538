"""The short image sequence of the AR part: five markers move in a room, one is covered for a while. Without ROS.

The camera is a webcam with some distortion; the markers have the ids 1 to 5 and the size that the course prints.
``render_to`` writes the images, camera.yaml in the format of ROS's camera_calibration, and frames.json with the ground
truth: for each frame the markers with id, corners [px], position [m] and orientation (x y z w) in the camera's optical
frame. ``ignore`` is set for a marker that is partly covered; one that is covered is not listed. The motion repeats
after the last frame.

A launch file calls ``main`` before the camera's node starts. It renders into a given folder, or once into a cache in
ROS_HOME (~/.ros), as other files of ROS, with one folder per version of the sequence.
"""
import argparse
import json
import math
import os
import re
import shutil
import sys
import tempfile
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from alvar_core import drawing, rotations
from alvar_core.camera import Camera, default_camera
from plain_support import unwritten, write_whole

SET = 'marker_sequence'  # what frames.json says that it describes
START = f'{{"set": "{SET}"'.encode()
VERSION = 2  # of images and ground truth, and the name of the cached copy: increase it with every change
FRAMES = 72
RATE = 10.0  # [Hz] of the images
MARKER_SIZE = 0.068  # [m] of the black square
WIDTH, HEIGHT = 640, 480  # [px]
MARKERS = (1, 2, 3, 4, 5)
COVERED = 3  # the marker that is covered
COVER_FRAMES = (26, 46)  # the first frame with the cover, and the first one after it
CARD, COVER = 11.0 / 9.0, 2.2  # sides of a marker's white card and of the cover, in marker sides
FINE = 2  # pixels of the drawn canvas per pixel of the camera, in each direction
MARGIN = 48  # [px] of the camera that the canvas extends on each side, which the distorted camera sees
CELL = 12  # [px] of a marker's texture
NOISE = 1.5  # grey levels, standard deviation of a pixel
ROOM = {'left': -1.6, 'right': 1.5, 'ceiling': -1.1, 'floor': 0.95, 'wall': 3.2}  # [m] in the optical frame


class MarkerPose(NamedTuple):
    """The pose of a marker in the optical frame: rotation (3, 3) and position (3,) [m]."""

    rotation: np.ndarray
    position: np.ndarray


def marker_poses(frame: int) -> Dict[int, MarkerPose]:
    """Return {id: MarkerPose} of all markers in a frame, 0 to FRAMES - 1."""
    phase = 2.0 * math.pi * frame / FRAMES
    sin, cos = math.sin(phase), math.cos(phase)
    return {  # rocks; comes near; rolls, and is covered; passes by; turns aside
        1: MarkerPose(rotations.facing(0.6 + 0.2 * sin, phase, 0.2 * cos),
                      np.array([-0.25 + 0.05 * cos, -0.13 + 0.05 * sin, 0.75])),
        2: MarkerPose(rotations.facing(0.35, 0.5, 0.1 * sin), np.array([-0.03, 0.01, 0.9 + 0.4 * cos])),
        3: MarkerPose(rotations.facing(0.45, 2.0, phase), np.array([0.22, -0.13, 0.7])),
        4: MarkerPose(rotations.facing(0.5, 1.2, -0.3 * sin), np.array([0.27 * sin, 0.17, 0.75])),
        5: MarkerPose(rotations.facing(0.75 * math.sin(2.0 * phase), math.pi / 2.0, 0.1),
                      np.array([0.25, 0.02, 0.65])),
    }


def cover_centre(frame: int) -> Optional[float]:
    """Return the x of the cover's middle, in marker sides to the right of the covered marker; None without cover."""
    start, end = COVER_FRAMES
    if not start <= frame < end:
        return None
    across = 6.0 * (frame + 0.5 - start) / (end - start) - 3.0
    return across ** 3 / 9.0  # slow while it covers the marker


def visible(frame: int, marker_id: int) -> str:
    """Return how much of a marker is visible in a frame: 'seen', 'part' or 'covered'."""
    centre = cover_centre(frame) if marker_id == COVERED else None
    if centre is None or abs(centre) > (COVER + CARD) / 2.0 + CARD:
        return 'seen'
    return 'covered' if abs(centre) < COVER / 2.0 - math.sqrt(0.5) else 'part'


def ground_truth(camera: Camera, frame: int) -> List[Dict[str, Any]]:
    """Return the entries of frames.json for the markers that a camera sees in a frame."""
    entries = []
    for marker_id, (rotation, position) in marker_poses(frame).items():
        if visible(frame, marker_id) != 'covered':
            corners = drawing.project(camera, rotation, position, drawing.object_corners(MARKER_SIZE))
            entries.append({'id': marker_id, 'size_m': MARKER_SIZE, 'corners': corners.round(3).tolist(),
                            'position': position.round(6).tolist(),
                            'orientation': [round(float(v), 7) for v in rotations.quaternion_from_matrix(rotation)],
                            'distance_m': round(float(np.linalg.norm(position)), 4),
                            'ignore': visible(frame, marker_id) == 'part'})
    return entries


class SequenceRenderer:
    """Renders the images of the sequence; has the camera, its view of the empty room, and the maps to its pixels."""

    def __init__(self) -> None:
        self.camera = default_camera(WIDTH, HEIGHT, distorted=True)
        self._to_canvas = np.array([[FINE, 0, FINE * (MARGIN + 0.5) - 0.5], [0, FINE, FINE * (MARGIN + 0.5) - 0.5],
                                    [0, 0, 1]]) @ self.camera.matrix
        fine = np.stack(np.meshgrid(np.arange(WIDTH * FINE), np.arange(HEIGHT * FINE)), -1)
        at = ((self.camera.to_ideal((fine + 0.5) / FINE - 0.5) + MARGIN + 0.5) * FINE - 0.5).astype(np.float32)
        self._maps = cv2.convertMaps(at[..., 0], at[..., 1], cv2.CV_16SC2)
        self._room = self._draw_room()
        self._textures = {marker_id: _texture(marker_id) for marker_id in MARKERS}
        self._noise = np.random.default_rng(7).normal(0.0, NOISE, (HEIGHT + 64, WIDTH + 64, 1)).astype(np.float32)

    def image(self, frame: int) -> np.ndarray:
        """Return the image of a frame, (HEIGHT, WIDTH, 3) uint8 BGR."""
        canvas = self._room.copy()
        for marker_id, pose in sorted(marker_poses(frame).items(), key=lambda item: -item[1].position[2]):
            self._paste(canvas, self._textures[marker_id], pose, MARKER_SIZE * CARD)
        centre = cover_centre(frame)
        if centre is not None:
            covered = marker_poses(frame)[COVERED]
            cover = MarkerPose(rotations.facing(0.0, 0.0, 0.0), covered.position + [centre * MARKER_SIZE, 0.0, -0.02])
            self._paste(canvas, _paper(), cover, MARKER_SIZE * COVER)
        fine = cv2.remap(canvas, self._maps[0], self._maps[1], cv2.INTER_LINEAR)
        image = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)
        top, left = frame * 29 % 64, frame * 47 % 64
        return cv2.convertScaleAbs(image + self._noise[top:top + HEIGHT, left:left + WIDTH])

    def ground_truth(self, frame: int) -> List[Dict[str, Any]]:
        """Return the entries of frames.json for the markers of a frame."""
        return ground_truth(self.camera, frame)

    def _paste(self, canvas: np.ndarray, texture: np.ndarray, pose: MarkerPose, side: float) -> None:
        """Draw a square texture (N, N, 3) with a side [m] at a pose on the canvas."""
        half, count = side / 2.0, len(texture)
        plane = np.column_stack([pose.rotation[:, 0], pose.rotation[:, 1], pose.position])
        scale = np.array([[side / count, 0, side / count / 2 - half], [0, -side / count, half - side / count / 2],
                          [0, 0, 1]])
        _warp(canvas, texture, self._to_canvas @ plane @ scale)

    def _draw_room(self) -> np.ndarray:
        """Return the canvas without markers: back wall, side walls, ceiling and floor, each a plain texture."""
        canvas = np.zeros(((HEIGHT + 2 * MARGIN) * FINE, (WIDTH + 2 * MARGIN) * FINE, 3), np.uint8)
        rng, r = np.random.default_rng(3), ROOM
        x, y, z = np.eye(3)
        far, height, depth = r['right'] - r['left'], r['floor'] - r['ceiling'], r['wall'] - 0.3
        near = z * 0.3
        for texture, origin, across, down in (
                (_wall(rng, far, height), x * r['left'] + y * r['ceiling'] + z * r['wall'], x, y),
                (_plain(rng, (150, 165, 172), depth, height), x * r['left'] + y * r['ceiling'] + near, z, y),
                (_plain(rng, (165, 178, 184), depth, height), x * r['right'] + y * r['ceiling'] + near, z, y),
                (_plain(rng, (208, 212, 214), far, depth), x * r['left'] + y * r['ceiling'] + near, x, z),
                (_planks(rng, far, depth), x * r['left'] + y * r['floor'] + near, x, z)):
            pixel = np.diag([1.0 / PER_METRE, 1.0 / PER_METRE, 1.0])
            _warp(canvas, texture, self._to_canvas @ np.column_stack([across, down, origin]) @ pixel)
        return canvas


PER_METRE = 100  # [px] of the room's textures


def _plain(rng: np.random.Generator, colour: Tuple[int, int, int], width: float, height: float) -> np.ndarray:
    """Return a texture, ``width`` x ``height`` [m], in one colour with gradual changes of brightness."""
    coarse = rng.normal(0.0, 7.0, (4, 5)).astype(np.float32)
    size = round(width * PER_METRE), round(height * PER_METRE)
    light = cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)[..., None]
    texture: np.ndarray = np.clip(np.array(colour, np.float32) + light, 0, 255).astype(np.uint8)
    return texture


def _wall(rng: np.random.Generator, width: float, height: float) -> np.ndarray:
    """Return the back wall: a window, a picture, a shelf, a skirting board."""
    wall = _plain(rng, (186, 200, 204), width, height)

    def rectangle(left: float, top: float, right: float, bottom: float, colour: Tuple[int, int, int],
                  thickness: int = -1) -> None:
        a, b = (round(left * PER_METRE), round(top * PER_METRE)), (round(right * PER_METRE), round(bottom * PER_METRE))
        cv2.rectangle(wall, a, b, colour, thickness)
    rectangle(0.3, 0.3, 1.3, 1.2, (235, 225, 205))
    rectangle(0.3, 0.3, 1.3, 1.2, (110, 130, 140), 6)
    rectangle(0.79, 0.3, 0.81, 1.2, (110, 130, 140))
    rectangle(1.9, 0.4, 2.6, 0.9, (120, 90, 70))
    cv2.circle(wall, (225, 65), 16, (70, 150, 200), -1)
    rectangle(1.6, 1.5, 2.9, 1.55, (70, 100, 130))
    for number, colour in enumerate([(60, 60, 150), (120, 90, 50), (80, 130, 70), (50, 110, 160), (130, 70, 110)]):
        rectangle(1.8 + 0.12 * number, 1.22 + 0.03 * (number % 3), 1.9 + 0.12 * number, 1.5, colour)
    rectangle(0.0, height - 0.1, width, height, (120, 135, 145))
    return wall


def _planks(rng: np.random.Generator, width: float, depth: float) -> np.ndarray:
    """Return the floor: planks that run towards the wall."""
    floor = _plain(rng, (86, 122, 158), width, depth)
    for left in range(0, floor.shape[1], 18):
        plank = floor[:, left:left + 18]
        plank[:] = cv2.add(plank, float(rng.uniform(-14.0, 14.0)))  # type: ignore[call-overload]  # stubs lack scalars
        floor[:, left] = floor[:, left] // 2
    return floor


def _texture(marker_id: int) -> np.ndarray:
    """Return a card with a marker and a white margin of one cell."""
    black = cv2.resize(drawing.marker_image(marker_id, 9), None, fx=CELL, fy=CELL, interpolation=cv2.INTER_NEAREST)
    card = np.pad(black, CELL, constant_values=255)
    return cv2.cvtColor(cv2.convertScaleAbs(card, alpha=0.78, beta=26), cv2.COLOR_GRAY2BGR)


def _paper() -> np.ndarray:
    """Return a sheet of coloured paper."""
    return np.full((64, 64, 3), (96, 148, 96), np.uint8)


def _warp(canvas: np.ndarray, texture: np.ndarray, homography: np.ndarray) -> None:
    """Draw a texture on the canvas; homography (3, 3): from the texture's pixels to the canvas's."""
    height, width = texture.shape[:2]
    edge = np.array([[-0.5, -0.5], [width - 0.5, -0.5], [width - 0.5, height - 0.5], [-0.5, height - 0.5]], np.float32)
    corners = cv2.perspectiveTransform(edge[None], homography)[0]
    low = np.clip(np.floor(corners.min(0)).astype(int), 0, canvas.shape[1::-1])
    high = np.clip(np.ceil(corners.max(0)).astype(int) + 1, 0, canvas.shape[1::-1])
    part = canvas[low[1]:high[1], low[0]:high[0]]
    moved = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1]]) @ homography
    drawn = cv2.warpPerspective(texture, moved, tuple(int(v) for v in high - low), flags=cv2.INTER_LINEAR,
                                borderMode=cv2.BORDER_REPLICATE)
    mask = np.zeros(part.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, ((corners - low) * 16).round().astype(np.int32), 255, shift=4, lineType=cv2.LINE_AA)
    share = mask[..., None] * np.float32(1.0 / 255.0)
    part[:] = (drawn * share + part * (1.0 - share) + 0.5).astype(np.uint8)


def others_of(folder: str) -> List[str]:
    """Return the files that render_to would replace and that are not from an earlier call; raise OSError."""
    there = [name for name in sorted(os.listdir(folder))
             if re.fullmatch(r'frame_\d{3}\.jpg|frames\.json|camera\.yaml', name)]
    if 'frames.json' in there:
        with open(os.path.join(folder, 'frames.json'), 'rb') as file:
            if file.read(len(START)) == START:
                return []
    return there


def render_to(folder: str) -> None:
    """Write the sequence into a folder, which must exist; raise OSError."""
    renderer, frames = SequenceRenderer(), []
    for frame in range(FRAMES):
        name = f'frame_{frame:03d}'
        _, jpeg = cv2.imencode('.jpg', renderer.image(frame), [cv2.IMWRITE_JPEG_QUALITY, 92])
        write_whole(os.path.join(folder, f'{name}.jpg'), jpeg.tobytes())
        frames.append({'name': name, 'file': f'{name}.jpg', 'camera': 'webcam', 'marker_size_m': MARKER_SIZE,
                       'kind': 'markers', 'difficulty': 'easy', 'markers': renderer.ground_truth(frame)})
    camera = renderer.camera
    matrix, distortion = camera.matrix.ravel().tolist(), camera.distortion[:5].tolist()
    write_whole(os.path.join(folder, 'frames.json'), json.dumps({
        'set': SET, 'rate': RATE, 'marker': {'data_cells': 5, 'margin_cells': 2},
        'cameras': {'webcam': {'width': WIDTH, 'height': HEIGHT, 'K': matrix, 'D': distortion,
                               'distortion_model': 'plumb_bob'}}, 'frames': frames}))
    write_whole(os.path.join(folder, 'camera.yaml'), calibration_yaml(matrix, distortion))


def calibration_yaml(matrix: Sequence[float], distortion: Sequence[float]) -> str:
    """Return the text of a calibration file; matrix: 9 numbers row by row [px], distortion: 5 numbers, plumb_bob."""
    projection = [*matrix[0:3], 0.0, *matrix[3:6], 0.0, *matrix[6:9], 0.0]
    rows = [('camera_matrix', 3, 3, matrix), ('distortion_coefficients', 1, 5, distortion),
            ('rectification_matrix', 3, 3, np.eye(3).ravel().tolist()), ('projection_matrix', 3, 4, projection)]
    text = f'image_width: {WIDTH}\nimage_height: {HEIGHT}\ncamera_name: head_camera\ndistortion_model: plumb_bob\n'
    return text + ''.join(f'{name}:\n  rows: {height}\n  cols: {width}\n  data: {data}\n'
                          for name, height, width, data in rows)


def cached(ros_home: str) -> str:
    """Return the folder with the sequence below ``ros_home``; render the sequence first if needed. Raises OSError."""
    parent = os.path.join(ros_home, 'turtle_robotont')
    folder = os.path.join(parent, f'marker_sequence_{VERSION}')
    if os.path.exists(folder):
        return folder
    os.makedirs(parent, exist_ok=True)
    new = tempfile.mkdtemp(prefix='marker_sequence_', dir=parent)
    try:
        render_to(new)
        os.chmod(new, 0o755)
        os.rename(new, folder)  # appears complete or not at all
    except OSError:
        if not os.path.exists(folder):  # if it does, another launch file was faster
            raise
    finally:
        shutil.rmtree(new, ignore_errors=True)
    return folder


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Render the images; print the folder, without a newline for launch files, or exit with 1 and the reason."""
    parser = argparse.ArgumentParser(prog='marker_sequence.py', description=__doc__.split('\n')[0])
    parser.add_argument('--output', metavar='DIR', help='folder for the images (default: rendered once, in ROS_HOME)')
    options = parser.parse_args(arguments)
    try:
        if options.output:
            folder = os.path.abspath(options.output)
            os.makedirs(folder, exist_ok=True)
            others = others_of(folder)
            if others:
                sys.exit(f'marker_sequence.py: {folder} has files that would be replaced, such as {others[-1]}. Choose '
                         'another folder with --output')
            render_to(folder)
        else:
            folder = cached(os.environ.get('ROS_HOME') or os.path.expanduser('~/.ros'))
    except OSError as error:
        sys.exit(f'marker_sequence.py: {unwritten(error, "choose another folder with --output")}')
    print(folder, end='', flush=True)
