"""course_grader.isolation.view: the files that a program sees, and those that are its own."""
import os

import pytest

from course_grader.isolation import view


def write(path, text='', mode=0o644):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(mode)
    return str(path)


def test_no_token_reaches_a_program():
    base = {'PATH': '/usr/bin', 'LC_ALL': 'C', 'GITHUB_TOKEN': 'secret', 'COMMIT_URL': 'x', 'PYTHONPATH': '/a',
            'LD_PRELOAD': 'lib.so', 'HOME': '/root', 'PYTHONSTARTUP': '/x'}
    got = view.environment(base, '/box', '/tmp')
    assert 'secret' not in got.values()
    assert {'GITHUB_TOKEN', 'COMMIT_URL', 'LD_PRELOAD', 'PYTHONSTARTUP'}.isdisjoint(got)
    assert (got['HOME'], got['PATH'], got['LC_ALL']) == ('/box/home', '/usr/bin', 'C')
    assert got['PYTHONPATH'] == f'{view.FIRST_ON_PATH}:/a'


def test_own_files_are_the_package_or_the_folder_or_the_file(tmp_path):
    program = write(tmp_path / 'anna' / 'a.py')
    assert view.own_files(['/usr/bin/env', program, 'x:=1'], None) == [str(tmp_path / 'anna')]
    assert view.own_files([program], str(tmp_path)) == [str(tmp_path)]
    assert view.own_files([program], None, [str(tmp_path / 'anna' / 'home')]) == [program]
    assert view.own_files(['rosrun', 'a', 'b'], None) == []


def test_a_link_to_a_file_of_somebody_else_is_found(tmp_path):
    solution, own = write(tmp_path / 'ben' / 'a.py'), tmp_path / 'anna'
    real = write(own / 'src' / 'b.py')
    os.symlink(solution, own / 'a.py')
    os.symlink(real, own / 'b.py')
    assert view.escaping([str(own / 'b.py'), real], [str(own)]) is None
    assert view.escaping(['python3', str(own / 'a.py')], [str(own)]) == str(own / 'a.py')
    assert view.escaping([str(own / 'a.py')], [str(own / 'a.py')]) == str(own / 'a.py')
    assert view.escaping([real], [real]) is None


def test_of_a_workspace_a_program_sees_definitions_alone(tmp_path):
    python, source = tmp_path / 'devel', tmp_path / 'src'
    for name in ('turtlesim/msg/_Pose.py', 'turtlesim/node.py', 'turtle_robotont/__init__.py', 'course_grader/cli.py'):
        write(python / name)
    for name in ('turtlesim/package.xml', 'turtlesim/msg/Pose.msg', 'turtlesim/scripts/node', 'exercises/a.yaml'):
        write(source / name)
    shown = [place for _, place in view.shown({'PYTHONPATH': str(python), 'ROS_PACKAGE_PATH': str(source)}, [])]
    assert [os.path.relpath(place, tmp_path) for place in shown if place.startswith(str(tmp_path))] == [
        'devel/turtlesim/msg', 'src/turtlesim/msg', 'src/turtlesim/package.xml']


def test_a_program_sees_the_repair_of_rospy(tmp_path):
    write(tmp_path / 'python_path' / 'sitecustomize.py')
    path = f'{tmp_path}/devel:{tmp_path}/python_path'
    assert f'{tmp_path}/python_path' in [place for _, place in view.shown({'PYTHONPATH': path}, [])]


@pytest.mark.parametrize('copied', [
    lambda own, folder: view.readable([(own, own)], folder, []),
    lambda own, folder: view.staged(['python3'], {}, [(own, own)], folder)])
def test_files_are_copied_for_each_run(tmp_path, copied):
    """A link in the folder of the program, such as ~/.ros/log/latest, ended the second one."""
    own, folder = tmp_path / 'anna', str(tmp_path / 'files')
    write(own / 'notes.txt', mode=0o600)
    os.symlink(own / 'log', own / 'latest')
    copied(str(own), folder)
    write(own / 'more.txt')
    copied(str(own), folder)
    assert sorted(os.listdir(f'{folder}{own}')) == ['latest', 'more.txt', 'notes.txt']


@pytest.mark.parametrize('mode, staged', [(0o644, False), (0o600, True)])
def test_another_user_gets_copies_of_what_only_the_teacher_can_read(tmp_path, monkeypatch, mode, staged):
    program = write(tmp_path / 'anna' / 'a.py', 'x', mode)
    os.mkfifo(tmp_path / 'anna' / 'pipe')  # cannot be copied
    monkeypatch.setattr(view, 'reachable', lambda path, deep=True: not os.stat(program).st_mode & 0o004 == 0)
    own = str(tmp_path / 'anna')
    command, surroundings = view.staged(['python3', program], {'ROS_PACKAGE_PATH': f'{own}:/usr/share'}, [(own, own)],
                                        str(tmp_path / 'files'))
    place = str(tmp_path / 'files') + own if staged else own
    assert command == ['python3', f'{place}/a.py']
    assert surroundings['ROS_PACKAGE_PATH'] == f'{place}:/usr/share'
    assert os.stat(f'{place}/a.py').st_mode & 0o444 == (0o444 if staged or mode == 0o644 else 0)


def test_another_user_gets_a_folder_for_temporary_files_that_it_can_reach(tmp_path, monkeypatch):
    tmp_path.chmod(0o700)
    for folder, expected in ((tmp_path, '/tmp'), (tmp_path / 'inside', '/tmp'), ('/var/tmp', '/var/tmp')):
        monkeypatch.setattr(view.tempfile, 'tempdir', str(folder))
        assert view.temporary() == expected


def test_parents_are_the_highest_first_without_those_of_the_system():
    assert view.parents(['/a/b/c', '/a/b/c/d', '/usr/share/x', '/tmp/y/z']) == ['/a', '/a/b', '/tmp/y']
