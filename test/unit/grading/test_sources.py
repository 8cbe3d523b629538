"""turtle_robotont.grading.sources: which programs look at the wall clock."""
import sys

import pytest

from turtle_robotont.grading import sources


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
    ('import time\ntime.sleep(1)\n', True), ('from time import sleep\n', True), ('start = time.time()\n', True),
    ('rospy.sleep(1)\nrospy.Time.now()\n', False), ('# time.sleep(1)\n', False), ('now = datetime.now()\n', True),
    ('now = datetime.datetime.now()\n', True), ('pose = rospy.wait_for_message("pose", Pose)\n', True),
    ('rospy.wait_for_service("reset")\n', False), ('import math, time as t\n', True), ('import time\n', False),
])
def test_programs_on_wall_time_are_recognised(package, tmp_path, text, wall):
    path = package(text)
    launch_file = str(tmp_path / 'homework' / 'launch' / 'all.launch')
    for command in ([sys.executable, str(path)], [str(path)], ['rosrun', 'homework', 'node.py', '_rate:=2'],
                    ['roslaunch', 'homework', 'all.launch'], ['roslaunch', '--screen', launch_file, 'a:=1']):
        assert sources.looks_at_the_wall_clock(command) is wall, command


@pytest.mark.parametrize('command', [
    ['rosrun'], ['rosrun', 'homework'], ['rosrun', 'nowhere', 'node.py'], ['roslaunch'], ['nowhere.py'],
    ['roslaunch', 'nowhere', 'all.launch'], ['roslaunch', 'homework', 'no.launch'], ['roslaunch', sys.executable],
    ['sh', '-c', 'time.sleep'],
])
def test_what_cannot_be_read_is_left_to_whoever_starts_it(package, command):
    package('time.sleep(1)\n')
    assert sources.looks_at_the_wall_clock(command) is False
