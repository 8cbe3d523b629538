"""The exercises of the course and their sample programs, for the tests."""
import pathlib

from plain_support import course

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
COURSE = REPOSITORY / 'course'
EXERCISES = course.exercises(COURSE)  # {name: file}


def sample(name):
    """Return the path of a sample such as ``stop_at_x/right_if_else.py``, or of a printed program."""
    exercise, _, file = name.partition('/')
    folder = EXERCISES[exercise].parent
    return next(path for path in (folder / 'samples' / exercise / file, folder / file) if path.exists())


def programs(kind, pattern='*'):
    """Return the samples of all exercises that are ``right`` or ``wrong``; the printed answers are right ones."""
    return sorted(path for exercise in EXERCISES.values() for path in course.answers(exercise)
                  if path.name.startswith('wrong_') is (kind == 'wrong') and path.match(pattern))


def exercise_of(program):
    """Return the name of the exercise that a sample or a printed answer belongs to."""
    return program.parent.name if program.name.startswith(('right_', 'wrong_')) else program.stem
