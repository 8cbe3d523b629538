"""Find markers in an image, or in a folder of images: ./run markers PATH [--json OUT].

Every frame is searched on its own; only the response of each camera is learnt. PATH/frames.json names the frames with
file, camera and marker_size_m, and the cameras with K and D. Without this file, all PNGs and JPEGs count, as taken by
a webcam, and positions are in widths of a marker. OUT gets
{"tool", "frames": {name: {"detections": [{"id", "position", "orientation", ...}], "detect_ms"}}}.

--explain prints for each candidate of each frame why it is a marker or not, and draws that into FOLDER/NAME.png.
"""
from __future__ import annotations

import argparse
import functools
import json
import os
import statistics
import sys
import time
from typing import Any, Callable, Sequence

import cv2

from alvar_core.arrays import Image
from alvar_core.camera import Camera, default_camera
from alvar_core.detection import explanation
from alvar_core.detection.detection import Detection
from alvar_core.detection.detector import Detector, checked_candidates
from alvar_core.detection.light import checked_gamma
from alvar_core.detection.thresholds import MAX_CANDIDATES
from plain_support import unwritten, write_whole

DESCRIPTION = 'frames.json'
IMAGES = '.png', '.jpg', '.jpeg'
Look = Callable[[Detector, Image, Camera, str], None]


class ResultError(Exception):
    """A result cannot be written; the text says what to do."""


def detection_record(detection: Detection) -> dict[str, Any]:
    """Return a Detection as the scorer's dictionary, in m and as a quaternion x y z w."""
    return {'id': detection.id, 'position': [round(float(v), 6) for v in detection.position],
            'orientation': [round(float(v), 7) for v in detection.quaternion],
            'corners': [[round(float(v), 3) for v in corner] for corner in detection.corners],
            'confidence': round(detection.confidence, 4), 'ambiguous': detection.ambiguous,
            'doubtful': detection.doubtful, 'bend': round(detection.bend, 3),
            'ambiguity': round(detection.ambiguity, 4), 'reprojection_error_px': round(detection.error, 4)}


def _milliseconds(detector: Detector, image: Image, camera: Camera, repeats: int) -> tuple[list[Detection], float]:
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        found = detector.detect(image, camera)
        times.append((time.perf_counter() - start) * 1e3)
    return found, sorted(times)[len(times) // 2]


def explain(detector: Detector, image: Image, camera: Camera, name: str, pictures: str | None = None,
            point: tuple[float, float] | None = None) -> None:
    """Print where the search for each candidate of a frame ended; draw it into a folder ``pictures``.

    Of a ``point`` (x, y) [px], say what is there.
    """
    explained = explanation.explain(detector, image, camera)
    print(f'{name}:', *explained.lines, *([explained.at(point)] if point else []), sep='\n  ')
    if pictures is not None:
        try:
            os.makedirs(pictures, exist_ok=True)
        except OSError as error:
            raise ResultError(unwritten(error, 'choose another place')) from None
        path = os.path.join(pictures, f'{os.path.basename(name)}.png')
        _write(path, cv2.imencode('.png', explained.draw(image))[1].tobytes())
        print(f'  drawn in {path}')


def _write(path: str, content: bytes | str) -> None:
    """Write a result; raise ResultError if that fails."""
    try:
        write_whole(path, content)
    except OSError as error:
        raise ResultError(unwritten(error, 'choose another place')) from None


def _described(path: str) -> dict[str, Any]:
    """Return the content of a folder's frames.json; without one, the same for an image or for those in a folder."""
    description = os.path.join(path, DESCRIPTION)
    if os.path.exists(description):
        with open(description) as described:
            truth = json.load(described)
        if not isinstance(truth, dict):
            raise ValueError(f'it holds a {type(truth).__name__}; it must be a mapping with cameras and frames')
        return truth
    files = sorted(os.listdir(path)) if os.path.isdir(path) else [os.path.abspath(path)]
    files = [file for file in files if file.lower().endswith(IMAGES)]
    if not files:
        raise FileNotFoundError(0, f'is neither a PNG or JPEG, nor a folder with one, or with a {DESCRIPTION}', path)
    cameras, frames = {}, []
    for file in files:
        height, width = _read(os.path.join(path, file)).shape
        size = f'{width} x {height}'
        cameras[size] = {'K': default_camera(width, height).matrix, 'D': []}
        frames.append({'name': os.path.basename(file), 'file': file, 'camera': size})
    return {'cameras': cameras, 'frames': frames}


def _read(path: str) -> Image:
    """Return the grey image in a file; raise ValueError unless it is one."""
    image = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise ValueError(f'{path} cannot be read as an image')
    return image


def run(folder: str, repeats: int = 1, look: Look | None = None, **options: Any) -> dict[str, Any]:
    """Return the results of an image or of all frames in a folder; raise OSError or ValueError that says what is wrong.

    ``look(detector, image, camera, name)`` is called for each frame; ``options`` are those of a Detector.
    """
    truth = _described(folder)
    layout = truth.get('marker', {})
    detectors = {name: Detector(1.0, layout.get('data_cells', 5), layout.get('margin_cells', 2), **options)
                 for name in truth['cameras']}
    cameras = {name: Camera(c['K'], c['D']) for name, c in truth['cameras'].items()}
    frames = {}
    for frame in truth['frames']:
        path = os.path.join(folder, frame['file'])
        image = _read(path)
        detector = detectors[frame['camera']]
        detector.size = float(frame.get('marker_size_m') or 1.0)
        found, ms = _milliseconds(detector, image, cameras[frame['camera']], repeats)
        frames[frame['name']] = {'detections': [detection_record(d) for d in found], 'detect_ms': round(ms, 3)}
        if detector.left_out:
            print(f'{path}: {detector.left_out} candidates are left out; set a larger --max-candidates',
                  file=sys.stderr)
        if look is not None:
            look(detector, image, cameras[frame['camera']], frame['name'])
    return {'tool': f'alvar_core, single frames, {cv2.getNumThreads()} thread', 'set': truth.get('set'),
            'frames': frames}


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options; exit with 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run markers', description=__doc__.split('\n')[0])
    parser.add_argument('path', help='a PNG or JPEG, or a folder of them; a frames.json in it may name them, their '
                        'camera (K, D) and marker_size_m, as in test/data/alvar')
    parser.add_argument('--json', metavar='OUT', help='write the results here')
    parser.add_argument('--repeat', type=int, default=1, help='runs per frame; the median time counts')
    parser.add_argument('--gamma', type=_checked(float, checked_gamma),
                        help="exponent of the cameras' response: 1 if their values are proportional to light, usually "
                        '2.2; without it, it is learnt from the markers')
    parser.add_argument('--max-candidates', type=_checked(int, checked_candidates), default=MAX_CANDIDATES, metavar='N',
                        help='search at most N candidates of a frame (%(default)s)')
    parser.add_argument('--threads', type=int, default=1, help="OpenCV's threads")
    parser.add_argument('--explain', nargs='?', const='', metavar='FOLDER',
                        help='print why each candidate is a marker or not, and draw it into pictures in FOLDER')
    parser.add_argument('--at', type=_point, metavar='X,Y', help='with --explain: say what is at this pixel')
    options = parser.parse_args(arguments)
    if options.at and options.explain is None:
        parser.error('--at needs --explain')
    for option, written in (('--explain', options.explain), ('--json', options.json)):
        if written and os.path.realpath(written) in map(os.path.realpath, (
                options.path, os.path.join(options.path, DESCRIPTION))):
            parser.error(f'{option} {written} is what is read, which would be replaced; choose another place')
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return the exit status."""
    options = _parse(arguments)
    look: Look | None = None
    if options.explain is not None:
        look = functools.partial(explain, pictures=options.explain or None, point=options.at)
    cv2.setNumThreads(options.threads)
    description = os.path.join(options.path, DESCRIPTION)
    if not os.path.exists(description):
        description = options.path
    try:
        results = run(options.path, max(1, options.repeat), look, gamma=options.gamma,
                      max_candidates=options.max_candidates)
        if options.json:
            _write(options.json, json.dumps(results, indent=1))
    except ResultError as error:
        return _fail(error)
    except KeyError as error:
        return _fail(f'{description}: {error} is missing')
    except OSError as error:
        return _fail(f'{error.filename}: {error.strerror}')
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        return _fail(f'{description}: {error}')
    frames = results['frames'].values()
    found, median = sum(len(frame['detections']) for frame in frames), statistics.median(
        [frame['detect_ms'] for frame in frames] or [0.0])
    written = f': {options.json}' if options.json else ''
    print(f'{found} markers in {len(frames)} frames, {median:.1f} ms per frame (median){written}')
    return 0


def _checked(kind: Callable[[str], Any], check: Callable[[Any], Any]) -> Callable[[str], Any]:
    """Return a function of a text for argparse that returns check(kind(text))."""
    def convert(text: str) -> Any:
        try:
            return check(kind(text))
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return convert


def _point(text: str) -> tuple[float, float]:
    """Return (x, y) of 'X,Y'."""
    try:
        x, y = map(float, text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r}: two numbers are needed, such as 320,240') from None
    return x, y


def _fail(text: object) -> int:
    print(f'./run markers: {text}', file=sys.stderr)
    return 1


if __name__ == '__main__':
    sys.exit(main())
