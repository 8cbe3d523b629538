"""Every suite of ./run bench can be loaded and describes itself, without anything being measured."""
import importlib
from pathlib import Path

import pytest

import suite_grading
from course_grader.classes import submissions

REPOSITORY = Path(__file__).resolve().parents[2]
SUITES = sorted(path.stem for path in (REPOSITORY / 'bench').glob('suite_*.py'))


@pytest.mark.parametrize('name', SUITES)
def test_suite_describes_its_measurements_and_figures(name):
    suite = importlib.import_module(name)
    assert suite.MEASUREMENTS and suite.FIGURES and suite.__doc__


@pytest.mark.parametrize('exercise', suite_grading.EXERCISES)
def test_programs_that_grading_is_measured_with_are_handed_in_as_a_class_reads_them(exercise, tmp_path):
    for program in (suite_grading.right_program(exercise), suite_grading.wrong_program(exercise)):
        suite_grading.hand_in(program, tmp_path / program.stem)
    _, found, _ = submissions.find(str(tmp_path), suite_grading.EXERCISES)
    assert [one.exercise for one in found] == [exercise, exercise]
