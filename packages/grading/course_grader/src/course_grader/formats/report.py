"""A verdict for people and programs: text, result.json, junit.xml, and a picture of the path and what counted."""
import json
import os
import textwrap
from typing import Dict, Sequence, Union

from course_grader.formats import harmless, junit, path_picture
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.scoring import Verdict
from plain_support import write_together

WIDTH = 110  # characters of a line of the text


def text(exercise: Exercise, decided: Verdict) -> str:
    """Return the report to print: what was asked, what was seen, the score and its reasons."""
    lines = [f'{exercise.title}: {decided.outcome.upper()}, {decided.score:g} of 100']
    for objection in decided.objections:
        lines += textwrap.wrap(f'! {objection}', WIDTH, initial_indent='  ', subsequent_indent='    ')
    for advice in decided.advice():
        lines += textwrap.wrap(advice, WIDTH, initial_indent='  ', subsequent_indent='    ')
    shown = decided.public().reasons
    for reason in shown:
        lines += textwrap.wrap(f'{reason.points:g} of {reason.of:g}  asked: {reason.asked}', WIDTH,
                               initial_indent='  ', subsequent_indent='            ')
        lines += textwrap.wrap(f'seen: {reason.seen}', WIDTH, initial_indent='            ',
                               subsequent_indent='            ')
    hidden = sum(reason.of for reason in decided.reasons if reason not in shown)
    if hidden:
        lines.append(f'  {hidden:g} points are for checks that are not shown yet')
    return '\n'.join(lines)


def write(folder: str, exercise: Exercise, observed: Observed, decided: Verdict, command: Sequence[str],
          seed: int, isolation: str = '', notes: Sequence[str] = ()) -> None:
    """Write result.json, junit.xml, output.txt and, if there is a path, path.png and path.svg, all or none.

    ``notes``: remarks that change no score. Raise OSError.
    """
    os.makedirs(folder, exist_ok=True)
    result = {'exercise': exercise.name, 'title': exercise.title, 'asks': exercise.asks,
              'command': list(command), 'seed': seed, 'outcome': decided.outcome, 'score': decided.score,
              'objections': decided.objections, 'hints': list(decided.hints), 'certain': decided.certain,
              'notes': list(notes),
              'reasons': [reason._asdict() for reason in decided.reasons], 'seconds': round(observed.seconds, 3),
              'exit_code': observed.exit_code, 'isolation': isolation}
    suite = junit.Suite(' '.join(command) or exercise.name, exercise.name, decided.public(), observed.seconds,
                        isolation)
    output = ''.join(f'{line.t - observed.start:8.2f}  {harmless.plain(line.text)}\n' for line in observed.lines)
    files: Dict[str, Union[str, bytes]] = {
        'result.json': json.dumps(result, indent=2) + '\n', 'junit.xml': junit.document([suite]), 'output.txt': output}
    drawn = path_picture.drawing(exercise, observed)
    if drawn:
        files.update({'path.png': path_picture.png(drawn), 'path.svg': path_picture.svg(drawn)})
    write_together({os.path.join(folder, name): content for name, content in files.items()})
