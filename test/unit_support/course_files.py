"""The exercises of the course and their sample programs, for the tests."""
from typing import NamedTuple

import yaml

from plain_support import course
from unit_support import REPOSITORY

COURSE = REPOSITORY / 'course'
EXERCISES = course.exercises(COURSE)  # {name: file}
MISTAKES = REPOSITORY / 'test' / 'data' / 'mistakes.yaml'


class Mistake(NamedTuple):
    """A wrong program, and the pattern of the hint that names its mistake."""

    exercise: str
    program: str
    hint: str


def mistakes():
    """Return the Mistakes of MISTAKES."""
    return [Mistake(entry.get('exercise') or entry['of'].partition('/')[0], _program(entry), entry['hint'])
            for entry in yaml.safe_load(MISTAKES.read_text(encoding='utf-8'))]


def _program(entry):
    """Return the text of a program that is written out, or that changes a sample."""
    if 'program' in entry:
        return entry['program']
    text = sample(entry['of']).read_text(encoding='utf-8')
    for old, new in entry['change'].items():
        assert str(old) in text and str(old) != str(new), f'{MISTAKES}: {entry["of"]} has no {old!r}'
        text = text.replace(str(old), str(new))
    return text


def sample(name):
    """Return the path of a sample such as ``stop_at_x/right_if_else.py``, or of a printed program."""
    exercise, _, file = name.partition('/')
    folder = EXERCISES[exercise].parent
    return next(path for path in (folder / 'samples' / exercise / file, folder / file) if path.exists())


def programs(kind, pattern='*'):
    """Return the samples of all exercises that are ``right`` or ``wrong``; the printed answers are right ones."""
    return sorted(path for exercise in EXERCISES.values() for path in course.answers(exercise)
                  if path.name.startswith('wrong_') is (kind == 'wrong') and path.match(pattern))
