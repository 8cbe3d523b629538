"""course_grader.classes.submissions: who has handed in what, and texts for folders that hold nothing."""
import argparse
import os
import subprocess

import pytest

from course_grader.classes import grade_all, graded, submissions
from course_grader.classes.submissions import Submission

NAMES = ['black_path', 'stop_at_x']


def fill(folder, files):
    """Write {path: text or None for a plain file}; a text that begins with #! makes it executable."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text or '')
        path.chmod(0o755 if text and text.startswith('#!') else 0o644)
    return str(folder)


@pytest.mark.parametrize('name, text, command', [
    ('stop_at_x.py', '', ('DIR/stop_at_x.py',)),
    ('Stop-At-X.py', '', ('DIR/Stop-At-X.py',)),
    ('src/topic_demo/scripts/stop_at_x.py', '', ('DIR/src/topic_demo/scripts/stop_at_x.py',)),
    ('stop_at_x', '#!/bin/sh\n', ('DIR/stop_at_x',)),
    ('stop_at_x.bash', '#!/bin/bash\n', ('DIR/stop_at_x.bash',)),
    ('stop_at_x.launch', '<launch/>', ('roslaunch', 'DIR/stop_at_x.launch')),
    ('stop_at_x.cmd', '# a remark\nrosrun topic_demo stop.py _x:=1\n\n', ('rosrun', 'topic_demo', 'stop.py', '_x:=1')),
    ('stop_at_x.cmd', "python3 other.py 'two words'", ('python3', 'DIR/other.py', 'two words')),
])
def test_a_program_is_found_by_its_name(tmp_path, name, text, command):
    folder = fill(tmp_path, {f'anna/{name}': text, 'anna/other.py': '', 'anna/notes.txt': '',
                             'anna/.git/stop_at_x.py': ''})
    students, found, _ = submissions.find(folder, NAMES)
    assert students == ['anna']
    assert [(one.student, one.exercise, one.trouble) for one in found] == [('anna', 'stop_at_x', None)]
    assert found[0].command == tuple(part.replace('DIR', f'{folder}/anna') for part in command)


def test_a_class(tmp_path):
    folder = fill(tmp_path, {'ben/stop_at_x.py': '', 'anna/stop_at_x.py': '', 'anna/black_path.py': '',
                             'anna/stop_at_x (1).py': '', 'carl/mine.py': '', 'exam.yaml': '', 'readme.txt': ''})
    students, found, left_out = submissions.find(folder, NAMES)
    assert [one.text() for one in left_out] == [
        'readme.txt: it lies in the folder of no student',
        'anna/stop_at_x (1).py: no exercise has this name: did you mean stop_at_x?',
        'carl/mine.py: no exercise has this name']
    assert students == ['anna', 'ben', 'carl']
    assert [one[:2] for one in found] == [('anna', 'black_path'), ('anna', 'stop_at_x'), ('ben', 'stop_at_x')]
    assert [one.packages for one in found] == [f'{folder}/anna', f'{folder}/anna', f'{folder}/ben']
    assert submissions.exercises_in(folder) == {'exam': f'{folder}/exam.yaml'}


def test_a_map_is_found_where_an_exercise_asks_for_one(tmp_path):
    folder = fill(tmp_path, {'anna/maps/stop_at_x.yaml': '', 'anna/maps/stop_at_x.pgm': '', 'anna/black_path.yaml': '',
                             'ben/stop_at_x.py': '', 'carl/mine.yaml': '', 'carl/mine.pgm': ''})
    _, found, left_out = submissions.find(folder, NAMES, of_map=lambda exercise: exercise == 'stop_at_x')
    assert [one[:3] for one in found] == [('anna', 'stop_at_x', (f'{folder}/anna/maps/stop_at_x.yaml',))]
    assert 'ben/stop_at_x.py: the exercise asks for another kind of file' in [one.text() for one in left_out]
    found = submissions.find(folder, ['stop_at_x'], only='stop_at_x', of_map=lambda exercise: True)[1]
    assert [one[:2] for one in found] == [('anna', 'stop_at_x'), ('carl', 'stop_at_x')]
    students, found, left_out = submissions.find_flat(f'{folder}/carl', 'stop_at_x', lambda exercise: True)
    assert students == ['mine'] and found[0].command == (f'{folder}/carl/mine.yaml',) and not left_out


@pytest.mark.parametrize('files, command', [
    ({'stop_at_x.py': '', 'stop_at_x.cmd': 'python3 stop_at_x.py fast'}, ('python3', 'DIR/stop_at_x.py', 'fast')),
    ({'launch/stop_at_x.launch': '', 'scripts/stop_at_x.py': ''}, ('roslaunch', 'DIR/launch/stop_at_x.launch'))])
def test_what_starts_a_program_wins_over_it(tmp_path, files, command):
    folder = fill(tmp_path, {f'anna/{name}': text for name, text in files.items()})
    assert submissions.find(folder, NAMES)[1][0].command == tuple(
        part.replace('DIR', f'{folder}/anna') for part in command)


@pytest.mark.parametrize('files, said', [
    ({'stop_at_x.py': '', 'old/stop_at_x.py': ''},
     'there are 2 programs for one exercise (old/stop_at_x.py, stop_at_x.py)'),
    ({'stop_at_x.cmd': ''}, 'stop_at_x.cmd: it contains 0 command lines; it must contain one'),
    ({'stop_at_x.cmd': 'a\nb\n'}, 'stop_at_x.cmd: it contains 2 command lines'),
    ({'stop_at_x.cmd': 'rosrun "a'}, 'stop_at_x.cmd: No closing quotation'),
    ({'stop_at_x.cmd': 'a b\0c'}, 'stop_at_x.cmd: the command contains the character NUL'),
    ({'stop_at_x.cmd': 'a ' * 60_000}, 'stop_at_x.cmd: the command has 119,999 bytes; at most 100,000'),
])
def test_what_is_wrong_with_one_spoils_no_other(tmp_path, files, said):
    folder = fill(tmp_path, {**{f'anna/{name}': text for name, text in files.items()}, 'ben/stop_at_x.py': ''})
    anna, ben = submissions.find(folder, NAMES)[1]
    assert said in anna.trouble and anna.command == ()
    assert ben.trouble is None


@pytest.mark.parametrize('name, text', [('stop_at_x', '#!/bin/sh\n'), ('stop_at_x.sh', ''),
                                        ('stop_at_x', '#!/usr/bin/env python3\n')])
def test_a_script_without_permission_is_found_by_its_kind(tmp_path, name, text):
    folder = fill(tmp_path, {f'anna/{name}': text})
    os.chmod(f'{folder}/anna/{name}', 0o644)
    assert submissions.find(folder, NAMES)[1][0].command == (f'{folder}/anna/{name}',)


@pytest.mark.parametrize('name, text, reason', [
    ('all.zip', 'PK', 'it is an archive: unpack it'),
    ('stop_at_x.tar.gz', 'x', 'it is an archive: unpack it'),
    ('stop_at_x.txt', 'import rospy', 'it is not a program: the name of a Python program ends in .py'),
    ('stop_at_x.py.txt', 'import rospy', 'it is not a program: the name of a Python program ends in .py'),
    ('stop_at_y.py', 'import rospy', 'no exercise has this name: did you mean stop_at_x?'),
    ('stop_at_x', '\x7fELF', 'it is not executable: type chmod +x'),
    ('notes.txt', 'x', 'it is not a program'),
])
def test_what_is_not_graded_is_listed_with_the_reason(tmp_path, name, text, reason):
    folder = fill(tmp_path, {f'anna/{name}': text, 'ben/stop_at_x.py': '', 'ben/notes.txt': 'a file of the program',
                             'ben/src/tools/__init__.py': ''})
    (tmp_path / 'carl').mkdir()
    students, _, left_out = submissions.find(folder, NAMES)
    assert students == ['anna', 'ben', 'carl']
    assert [one[:2] for one in left_out] == [('anna', name), ('carl', '')]
    assert left_out[0].reason.startswith(reason)
    assert left_out[1].reason == 'the folder is empty'


def test_many_files_that_are_not_graded_are_counted(tmp_path):
    folder = fill(tmp_path, {**{f'anna/{number:03}.txt': '' for number in range(100)}, 'ben/stop_at_x.py': ''})
    left_out = submissions.find(folder, NAMES)[2]
    assert len(left_out) == submissions.MAX_LEFT_OUT + 1
    assert left_out[-1].text() == 'anna: 80 more files are not graded'


@pytest.fixture(name='deep')
def deep_folder(tmp_path):
    """Fill a class with 1,500 folders in each other; pytest's own rmtree could not remove them."""
    folder = fill(tmp_path, {'anna/stop_at_x.py': '', 'ben/stop_at_x.py': ''})
    parent = os.open(f'{folder}/anna', os.O_RDONLY)
    for _ in range(1500):
        os.mkdir('d', dir_fd=parent)
        below = os.open('d', os.O_RDONLY, dir_fd=parent)
        os.close(parent)
        parent = below
    os.close(parent)
    yield folder
    subprocess.run(['rm', '-r', f'{folder}/anna'], check=True)


def test_a_thousand_folders_in_each_other_stop_nobody(deep):
    _, found, left_out = submissions.find(deep, NAMES)
    assert len(found) == 2
    assert [one.reason for one in left_out] == ['it lies in more than 50 folders']
    assert list(graded.files_of(found[0], [])) == ['stop_at_x.py']


def test_the_only_program_counts_for_a_single_exercise(tmp_path):
    folder = fill(tmp_path, {'anna/solution.py': '', 'anna/notes.txt': '', 'ben/a.py': '', 'ben/b.py': ''})
    _, found, left_out = submissions.find(folder, ['stop_at_x'], only='stop_at_x')
    assert [(one.student, one.exercise, one.program) for one in found] == [
        ('anna', 'stop_at_x', f'{folder}/anna/solution.py')]
    assert [one.name for one in left_out] == ['a.py', 'b.py']


@pytest.mark.parametrize('files, said', [
    ({}, 'It is empty.'),
    ({'stop_at_x.py': ''}, 'It contains stop_at_x.py. If it contains programs for one exercise, add --exercise NAME.'),
    ({'anna/stop.py': '', 'anna/data.txt': ''}, 'It contains anna/data.txt, anna/stop.py.'),
    ({f'anna/{letter}.py': '' for letter in 'abcdefghij'}, 'anna/h.py and 2 more.'),
])
def test_a_folder_without_submissions_is_explained(tmp_path, files, said):
    with pytest.raises(submissions.SubmissionsError) as error:
        submissions.find(fill(tmp_path, files), NAMES)
    assert 'files that have the name of an exercise (black_path, stop_at_x), such as' in str(error.value)
    assert said in str(error.value)


@pytest.mark.parametrize('parts', [2, 3])
def test_each_part_of_a_class_has_some_of_all_exercises(parts):
    found = [Submission(student, name, (), '') for student in 'abcdef' for name in ('x', 'y')]
    chosen = [grade_all._chosen(argparse.Namespace(shard=(part, parts), only=None), found)
              for part in range(1, parts + 1)]
    assert sorted(one for part in chosen for one in part) == sorted(found)
    assert all({one.exercise for one in part} == {'x', 'y'} and len(part) == 12 // parts for part in chosen)


def test_one_exercise_in_a_flat_folder(tmp_path):
    folder = fill(tmp_path, {'anna.py': '', 'ben.cmd': 'rosrun a b', 'notes.txt': '', 'dir/carl.py': ''})
    students, found, _ = submissions.find_flat(folder, 'stop_at_x')
    assert students == ['anna', 'ben']
    assert [(one.student, one.exercise, one.command) for one in found] == [
        ('anna', 'stop_at_x', (os.path.join(folder, 'anna.py'),)), ('ben', 'stop_at_x', ('rosrun', 'a', 'b'))]
    with pytest.raises(submissions.SubmissionsError, match='contains no program .* it contains carl.txt'):
        submissions.find_flat(fill(tmp_path / 'other', {'carl.txt': ''}), 'stop_at_x')
