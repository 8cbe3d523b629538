"""Values that differ from student to student: drawn by the name, filled into all texts, and mistakes named."""
import json

import pytest
import yaml

from course_grader import cli
from course_grader.classes import grade_all
from course_grader.formats import systems
from course_grader.rules import exercise

TEXT = """
title: Stop at x = $goal
asks: Write a node that stops the turtle at x = $goal, at $speed.
time: 45 s
vary: {goal: 8 to 10 m, speed: 0.40 to 0.80 m/s}
checks:
  - {check: commands, points: 20, linear: at most $speed}
  - {check: stops, points: 80, x: $goal}
symptoms:
  - {lost: stops, hint: publish zero at x = $goal}
"""


def of(student, text=TEXT):
    return exercise.parse(yaml.safe_load(text), 'stop', student)


def test_a_student_has_the_same_values_everywhere_and_others_have_others():
    anna = of('Anna Berg')
    goal = anna.rules[1].rule.x
    assert 8.0 <= goal <= 10.0 and goal == round(goal, 1) and anna.varies
    assert f'{goal:g} m' in anna.title and f'x = {goal:g} m, at ' in anna.asks
    assert anna.symptoms[0]['hint'] == f'publish zero at x = {goal:g} m'
    assert 0.4 <= anna.rules[0].rule.linear[1] <= 0.8
    assert of(' anna  BERG') == anna
    assert len({of(f'student {number}').rules[1].rule.x for number in range(100)}) > 10


@pytest.mark.parametrize('old, new, said', [
    ('goal: 8 to 10 m', 'goal: 8 m', 'vary: goal: "8 m" must be a span with a unit, such as "8 to 10 m"'),
    ('goal: 8 to 10 m', 'goal: 8 to 10 parsec', 'must be a span with a unit'),
    ('goal: 8 to 10 m', 'goal: 10 to 8 m', 'starts above its end'),
    ('{goal: 8 to 10 m, speed: 0.40 to 0.80 m/s}', '5', 'vary is 5; it must be a mapping'),
    ('x: $goal', 'x: $gaol', '$gaol stands in the exercise, but not in vary'),
    ('vary: {', 'vary: {more: 1 to 2 m, ', 'vary has more, but $more stands nowhere')])
def test_mistakes_are_named(old, new, said):
    with pytest.raises(exercise.ExerciseError) as error:
        of('anna', TEXT.replace(old, new))
    assert said in str(error.value).replace("'", '"')


def test_the_sheet_tells_a_student_the_task(tmp_path, capsys):
    (tmp_path / 'stop.yaml').write_text(TEXT)
    assert cli.main(['--sheet', 'Anna Berg', str(tmp_path / 'stop.yaml')]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith('Anna Berg\n') and ' '.join(of('Anna Berg').asks.split()) in ' '.join(printed.split())
    assert cli.main(['--sheet', 'Anna Berg', str(tmp_path / 'none.yaml')]) == 2


def test_a_single_grading_asks_for_the_name(tmp_path, capsys):
    (tmp_path / 'stop.yaml').write_text(TEXT)
    (tmp_path / 'a.py').write_text('')
    assert cli.main([str(tmp_path / 'stop.yaml'), '--', str(tmp_path / 'a.py')]) == 2
    assert 'differ from student to student: add --student NAME' in capsys.readouterr().err


@pytest.mark.parametrize('form, name, environment', [
    ('classroom50', 'anna-b', {'OWNER': 'anna-b', 'USERNAME': 'runner'}), ('classroom50', '', {}),
    ('vpl', 'Anna Berg', {'MOODLE_USER_NAME': 'Anna Berg', 'MOODLE_USER_ID': '7', 'MOODLE_GROUP_NAME': ''}),
    ('vpl', 'Group 3', {'MOODLE_USER_NAME': 'Anna Berg', 'MOODLE_GROUP_NAME': 'Group 3'}), ('vpl', '', {}),
    ('gradescope', 'Anna Berg', [{'name': 'Anna Berg', 'email': 'a@b.c', 'id': 1}]),
    ('gradescope', 'Anna Berg and Ben Li', [{'name': 'Ben Li'}, {'name': 'Anna Berg'}]),
    ('gradescope', '', []), ('gradescope', '', 5), ('gradescope', '', [{'id': 5}]), ('gradescope', '', None),
    ('text', '', {'OWNER': 'a', 'USERNAME': 'b', 'MOODLE_USER_NAME': 'c'})])
def test_a_system_tells_the_name_of_the_student(tmp_path, form, name, environment):
    if form == 'gradescope' and environment is not None:
        (tmp_path / 'submission_metadata.json').write_text(json.dumps({'users': environment}))
    runner = systems.Runner(environment if isinstance(environment, dict) else {}, autograder=str(tmp_path))
    assert systems.student(form, runner) == name


@pytest.mark.parametrize('variables, goal', [({'MOODLE_USER_NAME': 'Anna Berg'}, 'Anna Berg'), ({}, None)])
def test_the_name_in_the_system_draws_the_values(tmp_path, monkeypatch, capsys, variables, goal):
    (tmp_path / 'stop.yaml').write_text(TEXT)
    for name, value in {'VPL_GRADEMIN': '0', 'VPL_GRADEMAX': '10', **variables}.items():
        monkeypatch.setenv(name, value)
    graded = []
    monkeypatch.setattr(cli.Supervisor, 'grade', lambda self, job, *_: graded.append(job.exercise) or interrupted())
    code = cli.main([str(tmp_path / 'stop.yaml'), '--output', str(tmp_path / 'out'), '--', str(tmp_path / 'a.py')])
    assert graded == ([of(goal)] if goal else [])
    assert ('add --student NAME' in capsys.readouterr().err) == (goal is None) and code != 0


def interrupted():
    raise KeyboardInterrupt


def test_a_class_of_everybody_called_me_is_refused(tmp_path, capsys):
    (tmp_path / 'me').mkdir()
    (tmp_path / 'stop.yaml').write_text(TEXT)
    (tmp_path / 'me' / 'stop.py').write_text('')
    assert cli.main(['--all', str(tmp_path), '--output', str(tmp_path / 'out')]) == 2
    assert 'differ from student to student, and the folder me has no name of one' in capsys.readouterr().err


def test_in_a_class_each_submission_has_its_own(tmp_path, monkeypatch):
    (tmp_path / 'stop.yaml').write_text(TEXT)
    for student in ('Anna Berg', 'Ben Li'):
        (tmp_path / student).mkdir()
        (tmp_path / student / 'stop.py').write_text('')
    works = []
    monkeypatch.setattr(grade_all, '_grade', lambda options, left: (works.extend(left), ([], False))[1])
    cli.main(['--all', str(tmp_path), '--output', str(tmp_path / 'out')])
    assert [work.exercise for work in works] == [of('Anna Berg'), of('Ben Li')]
    assert [work.repeat[3:5] for work in works] == [('--student', 'Anna Berg'), ('--student', 'Ben Li')]
