"""course_grader.attempt.static_analysis: the programs that a command starts, and programs that use the wall clock."""
import os
import shutil
import sys

import pytest

from course_grader.attempt import static_analysis

pytestmark = pytest.mark.slow


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return a function that writes a node of the package `homework` of a student's, with a launch file for it."""
    folder = tmp_path / 'homework'
    for name in ('scripts', 'launch'):
        (folder / name).mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>homework</name></package>')
    (folder / 'launch' / 'all.launch').write_text(
        '<launch><group ns="a"><node name="node" pkg="homework" type="node.py"/></group></launch>')
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path))

    def write(text):
        path = folder / 'scripts' / 'node.py'
        path.write_text('#!/usr/bin/env python3\n' + text)
        path.chmod(0o755)
        return path
    return write


@pytest.mark.parametrize('text, wall', [
    ('import time\ntime.sleep(1)\n', True), ('from time import sleep\nsleep(1)\n', True),
    ('start = time.time()\n', True),
    ('rospy.sleep(1)\nrospy.Time.now()\n', False), ('# time.sleep(1)\n', False), ('now = datetime.now()\n', True),
    ('now = datetime.datetime.now()\n', True), ('pose = rospy.wait_for_message("pose", Pose)\n', True),
    ('rospy.wait_for_service("reset")\n', False), ('import time as t\nt.sleep(1)\n', True),
    ('from time import *\nsleep(1)\n', True), ('import rospy as r\nr.wait_for_message("a", A)\n', True),
    ('import subprocess as sp\nsp.call(["rostopic"])\n', True), ('import os\nos.system("rosservice call")\n', True),
    ('import asyncio\nasyncio.run(main())\n', True), ('there.wait(0.1)\n', True), ('there.wait()\n', False),
    ('answers.get(timeout=1)\n', True), ('", ".join(names)\n', False), ('import time\nprint(time.ctime())\n', False),
    ('print("time.sleep(1)")\n', False), ('import moves\n', True), ('from homework.moves import go\n', True),
    ('import steps\n', False), ('this is no Python\n', False),
])
def test_programs_on_wall_time_are_recognised(package, tmp_path, text, wall):
    path = package(text)
    (path.parent / 'moves.py').write_text('import time\ntime.sleep(1)\n')
    (path.parent / 'steps.py').write_text('import steps\nrospy.sleep(1)\n')
    (path.parents[1] / 'src' / 'homework').mkdir(parents=True)
    (path.parents[1] / 'src' / 'homework' / 'moves.py').write_text('import time\ntime.sleep(1)\n')
    launch_file = str(tmp_path / 'homework' / 'launch' / 'all.launch')
    for command in ([sys.executable, str(path)], [str(path)], ['rosrun', 'homework', 'node.py', '_rate:=2'],
                    ['roslaunch', 'homework', 'all.launch'], ['roslaunch', '--screen', launch_file, 'a:=1']):
        assert bool(static_analysis.wall_clock_call(command)) is wall, command


@pytest.mark.parametrize('command', [
    ['rosrun'], ['rosrun', 'homework'], ['rosrun', 'nowhere', 'node.py'], ['roslaunch'], ['nowhere.py'],
    ['roslaunch', 'nowhere', 'all.launch'], ['roslaunch', 'homework', 'no.launch'], ['roslaunch', sys.executable],
    ['sh', '-c', 'time.sleep'],
])
def test_what_cannot_be_read_is_left_to_whoever_starts_it(package, command):
    package('time.sleep(1)\n')
    assert not static_analysis.wall_clock_call(command)


@pytest.mark.parametrize('text, wall', [
    ('rosservice call /clear\n', 'rosservice'), ('rosrun a b & sleep 1\n', 'sleep'), ('rosrun homework node.py\n', ''),
    ('# sleep\necho "it\'s"\n', ''), ("echo it's; rostopic pub\n", 'rostopic'),
])
def test_shell_scripts_are_read(package, tmp_path, text, wall):
    package('rospy.sleep(1)\n')
    script = tmp_path / 'script'
    script.write_text('#!/bin/bash\n' + text)
    for command in ([str(script)], ['bash', str(script)], ['bash', '-c', text]):
        assert static_analysis.wall_clock_call(command) == wall


CHAIN = 2000  # more than Python's recursion limit


def _chain_of_modules(folder):
    for number in range(CHAIN):
        (folder / f'm{number}.py').write_text(f'import m{number + 1}\n')
    return ['python3', str(folder / 'm0.py')]


def _chain_of_scripts(folder):
    for number in range(CHAIN):
        (folder / f's{number}').write_text(f'bash {folder}/s{number + 1}\n')
    return ['bash', str(folder / 's0')]


def _chain_of_launch_files(folder):
    for number in range(CHAIN):
        (folder / f'l{number}').write_text(f'<launch><include file="{folder}/l{number + 1}"/></launch>')
    return ['roslaunch', str(folder / 'l0')]


def _file(name, text):
    def written(folder):
        (folder / name).write_bytes(text.replace('{}', str(folder)).encode())
        return {'py': ['python3'], 'launch': ['roslaunch']}.get(name.partition('.')[2], ['bash']) + [f'{folder}/{name}']
    return written


def _pipe(folder):
    os.mkfifo(folder / 'pipe.py')
    return ['python3', str(folder / 'pipe.py')]


def _endless(folder):
    (folder / 'endless.py').symlink_to('/dev/zero')
    return ['python3', str(folder / 'endless.py')]


def _long(folder):
    with open(folder / 'long.py', 'wb') as file:
        file.truncate(10 ** 12)
    return ['python3', str(folder / 'long.py')]


@pytest.mark.parametrize('write', [
    _chain_of_modules, _chain_of_scripts, _chain_of_launch_files, _pipe, _endless, _long,
    _file('itself', 'bash {}/itself\n'), _file('zero', 'bash a\0b {}/a\0b.py\n'), _file('deep.py', 't' + '.a' * CHAIN),
    _file('zero.py', 'python_script = "a\\0b"\n'), _file('number.py', 'python_script = 0\n'),
    _file('name.py', f'import {"a" * 300}, {"a." * 5000}a\n'),
    _file('unknown.launch', '<?xml version="1.0" encoding="none"?><launch/>'),
    _file('empty.launch', ''), _file('lines', ''.join(f'rosrun nowhere {n}\n' for n in range(50_000))),
    _file('nodes.launch', '<launch>' + '<node pkg="no" type="no" name="no"/>' * 20_000 + '</launch>'),
], ids=lambda write: write.__name__)
def test_no_file_of_a_student_ends_the_grader(package, tmp_path, write):
    package('')
    command = write(tmp_path)
    assert static_analysis.wall_clock_call(command) == static_analysis.compiled(command) == ''
    assert static_analysis.simulators(command) == []
    assert len(static_analysis.source(command)) <= 2 ** 20


def test_catkins_relays_lead_to_the_program(package, tmp_path):
    relay = tmp_path / 'relay.py'
    relay.write_text(f"python_script = {str(package('time.sleep(1)'))!r}\nexec(compile(open(python_script).read()))\n")
    assert static_analysis.wall_clock_call([str(relay)]) == 'time.sleep'
    assert static_analysis.wall_clock_call(['rostopic', 'pub', '-r', '10']) == 'rostopic'


def test_the_packages_own_nodes_follow_the_simulation():
    assert static_analysis.wall_clock_call(['rosrun', 'turtle_robotont', 'ar_control_node.py']) == ''


@pytest.mark.parametrize('text', [
    '<node pkg="turtlesim" type="turtlesim_node" name="sim"/>', '<group><include file="$(dirname)/sim.xml"/></group>',
    '<include file="$(find homework)/launch/sim.xml"/><include file="$(find nothing)/a"/>',
])
def test_a_simulator_in_a_launch_file_is_found(package, tmp_path, text):
    package('')
    folder = tmp_path / 'homework' / 'launch'
    (folder / 'sim.xml').write_text('<launch><node pkg="turtlesim" type="turtlesim_node" name="a"/></launch>')
    (folder / 'mine.launch').write_text(f'<launch><include file="$(dirname)/mine.launch"/>{text}</launch>')
    assert static_analysis.simulators(['roslaunch', 'homework', 'mine.launch']) == ['turtlesim/turtlesim_node']
    assert static_analysis.simulators(['roslaunch', 'homework', 'all.launch']) == []


def test_rosrun_is_replaced_by_what_it_would_execute(package, tmp_path):
    path = package('')
    line = ['rosrun', 'homework', 'node.py', '_rate:=2']
    assert static_analysis.resolved(line) == [str(path), '_rate:=2']
    for other in (['rosrun', '--debug', 'homework', 'node.py'], ['rosrun', 'homework', 'scripts/node.py'],
                  ['rosrun', 'homework', 'none.py'], ['rosrun', 'nowhere', 'node.py'], ['rosrun', 'homework'],
                  ['roslaunch', 'homework', 'all.launch'], [str(path)]):
        assert static_analysis.resolved(other) == other


@pytest.mark.parametrize('change', [
    lambda path: path.chmod(0o644),
    lambda path: path.write_text('#!/usr/bin/env python3\r\n'),
    lambda path: path.write_text('print(1)\n'),
    lambda path: (shutil.copytree(path.parent, path.parents[1] / 'old')),
])
def test_what_rosrun_would_refuse_or_ask_is_left_to_it(package, change):
    change(package(''))
    line = ['rosrun', 'homework', 'node.py']
    assert static_analysis.resolved(line) == line


def test_compiled_programs_are_recognised(package, tmp_path):
    path = package('')
    assert not static_analysis.compiled([str(path)]) and not static_analysis.compiled([sys.executable, str(path)])
    assert not static_analysis.compiled(['rosrun', 'homework', 'node.py'])
    path.write_bytes(b'\x7fELF\x02')
    for command in ([str(path)], ['rosrun', 'homework', 'node.py'], ['roslaunch', 'homework', 'all.launch']):
        assert static_analysis.compiled(command) == 'node.py'
