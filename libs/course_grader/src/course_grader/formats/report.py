"""A verdict for people and for machines: text, result.json, junit.xml and a picture of the path with what counted."""
import json
import os
import textwrap
from types import SimpleNamespace
from typing import List, Sequence, Tuple

import cv2
import numpy as np

from alvar_core.arrays import ArrayLike, Floats, Image, Integers
from course_grader.formats import junit
from course_grader.rules import rules_driving
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.scoring import Verdict
from kinematic_core.files import write_whole
from kinematic_core.worlds.turtle_world import ARENA_SIZE

PICTURE = 600  # [px] width and height
MARGIN = 40  # [px]
WIDTH = 110  # characters of a line of the text
COLOURS = {'paper': (255, 255, 255), 'frame': (180, 180, 180), 'counted': (60, 170, 60), 'path': (200, 80, 20),
           'teleport': (180, 180, 255), 'start': (0, 0, 0), 'end': (20, 20, 220), 'text': (60, 60, 60)}  # BGR


def text(exercise: Exercise, decided: Verdict) -> str:
    """Return the report to print: what was asked, what was seen, the score and its reasons."""
    lines = [f'{exercise.title}: {decided.outcome.upper()}, {decided.score:g} of 100']
    for objection in decided.objections:
        lines += textwrap.wrap(f'! {objection}', WIDTH, initial_indent='  ', subsequent_indent='    ')
    for hint in decided.hints:
        lines += textwrap.wrap(f'Hint: {hint}', WIDTH, initial_indent='  ', subsequent_indent='    ')
    for reason in decided.reasons:
        lines += textwrap.wrap(f'{reason.points:g} of {reason.of:g}  asked: {reason.asked}', WIDTH,
                               initial_indent='  ', subsequent_indent='            ')
        lines += textwrap.wrap(f'seen: {reason.seen}', WIDTH, initial_indent='            ',
                               subsequent_indent='            ')
    return '\n'.join(lines)


def write(folder: str, exercise: Exercise, observed: Observed, decided: Verdict, command: Sequence[str],
          seed: int) -> None:
    """Write result.json, junit.xml, path.png and output.txt into a folder; raise OSError when that cannot be."""
    os.makedirs(folder, exist_ok=True)
    result = {'exercise': exercise.name, 'title': exercise.title, 'command': list(command), 'seed': seed,
              'outcome': decided.outcome, 'score': decided.score, 'objections': decided.objections,
              'hints': list(decided.hints),
              'reasons': [reason._asdict() for reason in decided.reasons], 'seconds': round(observed.seconds, 3),
              'exit_code': observed.exit_code}
    write_whole(os.path.join(folder, 'result.json'), json.dumps(result, indent=2) + '\n')
    suite = junit.Suite(' '.join(command) or exercise.name, exercise.name, decided, observed.seconds)
    write_whole(os.path.join(folder, 'junit.xml'), junit.document([suite]))
    said = ''.join(f'{line.t - observed.start:8.2f}  {line.text}\n' for line in observed.lines)
    write_whole(os.path.join(folder, 'output.txt'), said)
    encoded, png = cv2.imencode('.png', picture(exercise, observed))
    assert encoded
    write_whole(os.path.join(folder, 'path.png'), png.tobytes())


def picture(exercise: Exercise, observed: Observed) -> Image:
    """Return a BGR picture (PICTURE, PICTURE, 3): the path, its parts that counted as the shape, start and end."""
    path: Floats = np.array([(sample.x, sample.y) for sample in observed.track] or [(0.0, 0.0)])
    counted = _counted(exercise, observed)
    origin, scale = _view(exercise, path)

    def pixels(points: ArrayLike) -> Integers:
        inside = (np.asarray(points, float).reshape(-1, 2) - origin) * scale + MARGIN
        return np.column_stack([inside[:, 0], PICTURE - inside[:, 1]]).round().astype(np.int32)
    image = np.full((PICTURE, PICTURE, 3), COLOURS['paper'], np.uint8)
    if exercise.simulator == 'turtlesim':
        low, high = pixels([(0, 0), (ARENA_SIZE, ARENA_SIZE)]).tolist()
        cv2.rectangle(image, low, high, COLOURS['frame'], 1)
    for trace in counted:
        cv2.polylines(image, [pixels(trace)], False, COLOURS['counted'], 7, cv2.LINE_AA)
    cv2.polylines(image, [pixels(path)], False, COLOURS['path'], 2, cv2.LINE_AA)
    for name, point in (('start', path[0]), ('end', path[-1])):
        cv2.circle(image, tuple(pixels(point)[0].tolist()), 6, COLOURS[name], -1, cv2.LINE_AA)
    caption = f'{exercise.name}   black: start   red: end' + ('   green: what counted' if counted else '')
    cv2.putText(image, caption, (10, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.45, COLOURS['text'], 1, cv2.LINE_AA)
    return image


def _counted(exercise: Exercise, observed: Observed) -> List[Floats]:
    """Return the parts of the path that counted as the shapes that were asked for."""
    return [trace for scored in exercise.rules if scored.name == 'draws'
            for trace in rules_driving.traces(observed, SimpleNamespace(**scored.parameters))]


def _view(exercise: Exercise, points: Floats) -> Tuple[Floats, float]:
    """Return (lower left corner [m], pixels a metre) of a square view that holds the arena, or all points."""
    low, high = points.min(axis=0), points.max(axis=0)
    if exercise.simulator == 'turtlesim':
        low, high = np.minimum(low, 0.0), np.maximum(high, ARENA_SIZE)
    size = max(*(high - low), 1.0)
    return (low + high - size) / 2.0, (PICTURE - 2 * MARGIN) / size
