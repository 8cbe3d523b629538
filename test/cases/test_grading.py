"""The sample programs, graded: those of each exercise, and those that try to cheat."""
import sys

import pytest

from collection.kinds import REPOSITORY
from plain_support import course

EXERCISES = [(path.parent / 'samples' / name).relative_to(REPOSITORY).as_posix()
             for name, path in course.exercises(REPOSITORY / 'course').items() if course.samples(path)]
pytestmark = [pytest.mark.grading, pytest.mark.timeout(900)]

USUAL = 'some_exercises', 'red_team_namespace'
NIGHTLY = 'course_nodes', *EXERCISES, 'same_ten_times', 'hints', 'red_team_uid', 'red_team_none'


@pytest.mark.parametrize('samples', [*USUAL, *(pytest.param(name, marks=pytest.mark.nightly) for name in NIGHTLY)],
                         ids='grading/{}'.format)
def test_grading(samples, run_case, case_folder):
    run_case(sys.executable, REPOSITORY / 'test' / 'check_grading.py', samples, case_folder / 'files')
