"""The picture of a path: where turtle or robot went, and which parts counted. As PNG, and as SVG for pages.

Without motion and without counted parts there is no picture.
"""
import math
from typing import List, NamedTuple, Optional, Tuple

import cv2
import numpy as np

from course_grader.formats import templates
from course_grader.rules import fits
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from kinematic_core.worlds.turtle_world import ARENA_SIZE
from plain_support.arrays import ArrayLike, Floats, Integers

SIZE = 600  # [px] width and height
MARGIN = 48  # [px]
MIN_LENGTH = 0.01  # [m] of a path that is drawn
SIMPLIFIED = 0.6  # [px] that a simplified line may deviate
LINES = 6  # of the grid, at most, in each direction
STYLES = {  # colour (light, dark), width [px]
    'grid': ('#dddddd', '#3a3f45', 1), 'frame': ('#999999', '#777f88', 2), 'earlier': ('#c9c9c9', '#555c63', 2),
    'counted': ('#7fd08a', '#2f8f46', 13), 'path': ('#1450c8', '#7db4ff', 4), 'start': ('#222222', '#eeeeee', 4),
    'end': ('#d01414', '#ff6b6b', 4), 'text': ('#555555', '#aab2ba', 0)}
RADIUS = {'counted': 16, 'start': 9, 'end': 9}  # [px] of a single point
FILLED = 'counted', 'end'
FONT = 25  # [px]


class Line(NamedTuple):
    """A line through points (n, 2) [px], or a dot at one, in one of the STYLES."""

    style: str
    points: Integers


class Label(NamedTuple):
    """A text beside the grid; its lower left corner [px]."""

    text: str
    x: int
    y: int


class Drawing(NamedTuple):
    """Lines, the last on top, and labels."""

    lines: List[Line]
    labels: List[Label]


def drawing(exercise: Exercise, observed: Observed) -> Optional[Drawing]:
    """Return the Drawing, or None if nothing moved and nothing counted."""
    path = [(sample.x, sample.y) for sample in observed.track]
    others = [[(sample.x, sample.y) for sample in driven.track] for driven in list(observed.robots.values())[1:]]
    others = [other for other in others if other]
    counted = [part for scored in exercise.rules
               for part in scored.rule.counted_parts(observed.of_robot(scored.robot))]
    if max(map(fits.path_length, [path, *others])) < MIN_LENGTH and not counted:
        return None
    reset = observed.reset_at()
    before = [(sample.x, sample.y) for sample in observed.track if sample.t < reset]
    after = [(sample.x, sample.y) for sample in observed.track if sample.t >= reset] or path[-1:]
    low, scale = _view(exercise, np.array([*path, *(point for other in others for point in other)] or [(0.0, 0.0)]))

    def pixels(points: ArrayLike) -> Integers:
        inside = (np.asarray(points, float).reshape(-1, 2) - low) * scale + MARGIN
        return np.column_stack([inside[:, 0], SIZE - inside[:, 1]]).round().astype(np.int32)
    lines, labels = _grid(low, scale)
    if exercise.simulator == 'turtlesim':
        (left, bottom), (right, top) = pixels([(0, 0), (ARENA_SIZE, ARENA_SIZE)]).tolist()
        lines.append(Line('frame', np.array([(left, bottom), (right, bottom), (right, top), (left, top),
                                             (left, bottom)])))
    lines += [Line('counted', pixels(part)) for part in counted]
    lines += [Line(style, pixels(part)) for style, part in (
        ('earlier', before), *(('path', part) for part in [*others, after])) if len(part) > 1]
    lines += [Line(style, pixels([point])) for part in [*others, after]
              for style, point in (('start', part[0]), ('end', part[-1]))]
    simple = [line._replace(points=_simple(line.points)) for line in lines]
    return Drawing([line for line in simple if len(line.points) > 1 or line.style in RADIUS], labels)


def png(drawn: Drawing) -> bytes:
    image = np.full((SIZE, SIZE, 3), 255, np.uint8)
    for style, points in drawn.lines:
        colour = tuple(int(STYLES[style][0][start:start + 2], 16) for start in (5, 3, 1))
        if len(points) == 1:
            cv2.circle(image, tuple(points[0].tolist()), RADIUS[style], colour,
                       -1 if style in FILLED else STYLES[style][2], cv2.LINE_AA)
        else:
            cv2.polylines(image, [points], False, colour, STYLES[style][2], cv2.LINE_AA)
    for label in drawn.labels:
        cv2.putText(image, label.text, (label.x, label.y), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (85, 85, 85), 1, cv2.LINE_AA)
    counted = any(line.style == 'counted' for line in drawn.lines)
    cv2.putText(image, 'black: start   red: end' + ('   green: what counted' if counted else ''), (10, 22),
                cv2.FONT_HERSHEY_SIMPLEX, 0.5, (85, 85, 85), 1, cv2.LINE_AA)
    encoded, content = cv2.imencode('.png', image)
    assert encoded
    return content.tobytes()


def svg(drawn: Drawing) -> str:
    """Return the picture as SVG, which follows the colours of the page around it."""
    return templates.rendered('path.svg', size=SIZE, font=FONT, styles=STYLES, filled=FILLED, radius=RADIUS,
                              lines=[(line.style, line.points.tolist()) for line in drawn.lines], labels=drawn.labels)


def _view(exercise: Exercise, points: Floats) -> Tuple[Floats, float]:
    """Return (lower left corner [m], pixels per metre) of a square view of the arena, or of all points."""
    low, high = points.min(axis=0), points.max(axis=0)
    if exercise.simulator == 'turtlesim':
        low, high = np.minimum(low, 0.0), np.maximum(high, ARENA_SIZE)
    size = max(*(high - low), 1.0)
    return (low + high - size) / 2.0, (SIZE - 2 * MARGIN) / size


def _grid(low: Floats, scale: float) -> Tuple[List[Line], List[Label]]:
    """Return lines at round positions, with their labels [m]."""
    size = (SIZE - 2 * MARGIN) / scale
    step = next(step for step in (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, math.inf) if size / step < LINES)
    lines, labels = [], []
    for axis in (0, 1):
        for number in range(math.ceil(low[axis] / step), math.floor((low[axis] + size) / step) + 1):
            along = round((number * step - low[axis]) * scale + MARGIN)
            text = f'{number * step:g}'
            if axis:
                lines.append(Line('grid', np.array([(MARGIN, SIZE - along), (SIZE - MARGIN, SIZE - along)])))
                labels.append(Label(text, 6, SIZE - along + FONT // 3))
            else:
                lines.append(Line('grid', np.array([(along, MARGIN), (along, SIZE - MARGIN)])))
                labels.append(Label(text, along - FONT // 4 * len(text), SIZE - MARGIN + FONT + 4))
    return lines, labels


def _simple(points: Integers) -> Integers:
    if len(points) < 3:
        return points
    simple: Integers = np.asarray(cv2.approxPolyDP(points.reshape(-1, 1, 2), SIMPLIFIED, False), np.int32)
    return simple.reshape(-1, 2)
