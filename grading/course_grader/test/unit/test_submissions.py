"""course_grader.classes.submissions: who has handed in what, and texts for folders that hold nothing."""
import os

import pytest

from course_grader.classes import submissions

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
    assert [(one.student, one.exercise, one.trouble) for one in found] == [('anna', 'stop_at_x', '')]
    assert found[0].command == tuple(part.replace('DIR', f'{folder}/anna') for part in command)


def test_a_class(tmp_path):
    folder = fill(tmp_path, {'ben/stop_at_x.py': '', 'anna/stop_at_x.py': '', 'anna/black_path.py': '',
                             'anna/stop_at_x (1).py': '', 'carl/mine.py': '', 'exam.yaml': '', 'readme.txt': ''})
    students, found, left_out = submissions.find(folder, NAMES)
    assert left_out == ['anna/stop_at_x (1).py', 'carl/mine.py']
    assert students == ['anna', 'ben', 'carl']
    assert [one[:2] for one in found] == [('anna', 'black_path'), ('anna', 'stop_at_x'), ('ben', 'stop_at_x')]
    assert [one.packages for one in found] == [f'{folder}/anna', f'{folder}/anna', f'{folder}/ben']
    assert submissions.exercises_in(folder) == {'exam': f'{folder}/exam.yaml'}


def test_the_command_line_wins_over_what_it_starts(tmp_path):
    folder = fill(tmp_path, {'anna/stop_at_x.py': '', 'anna/stop_at_x.cmd': 'python3 stop_at_x.py fast'})
    assert submissions.find(folder, NAMES)[1][0].command == ('python3', f'{folder}/anna/stop_at_x.py', 'fast')


def test_a_launch_file_wins_over_a_program_of_its_name(tmp_path):
    folder = fill(tmp_path, {'anna/launch/stop_at_x.launch': '', 'anna/scripts/stop_at_x.py': ''})
    assert submissions.find(folder, NAMES)[1][0].command == ('roslaunch', f'{folder}/anna/launch/stop_at_x.launch')


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
    assert ben.trouble == ''


@pytest.mark.parametrize('files, said', [
    ({}, 'It is empty.'),
    ({'stop_at_x.py': ''}, 'It contains stop_at_x.py. If it contains programs for one exercise, add --exercise NAME.'),
    ({'anna/stop.py': '', 'anna/data.txt': ''}, 'It contains anna/stop.py.'),
    ({f'anna/{letter}.py': '' for letter in 'abcdefghij'}, 'anna/h.py and 2 more.'),
])
def test_a_folder_without_submissions_is_explained(tmp_path, files, said):
    with pytest.raises(submissions.SubmissionsError) as error:
        submissions.find(fill(tmp_path, files), NAMES)
    assert 'files that have the name of an exercise (black_path, stop_at_x), such as' in str(error.value)
    assert said in str(error.value)


def test_one_exercise_in_a_flat_folder(tmp_path):
    folder = fill(tmp_path, {'anna.py': '', 'ben.cmd': 'rosrun a b', 'notes.txt': '', 'dir/carl.py': ''})
    students, found, _ = submissions.find_flat(folder, 'stop_at_x')
    assert students == ['anna', 'ben']
    assert [(one.student, one.exercise, one.command) for one in found] == [
        ('anna', 'stop_at_x', (os.path.join(folder, 'anna.py'),)), ('ben', 'stop_at_x', ('rosrun', 'a', 'b'))]
    with pytest.raises(submissions.SubmissionsError, match='contains no program .* it contains carl.txt'):
        submissions.find_flat(fill(tmp_path / 'other', {'carl.txt': ''}), 'stop_at_x')
