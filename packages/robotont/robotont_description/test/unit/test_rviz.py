"""robotont_rviz: the command line of rviz, and its error if rviz cannot be started."""
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest
import yaml

from robotont_description import rviz
from unit_support.packages import PACKAGES

FOLDER = PACKAGES['robotont_description'].folder
DISPLAY = {'DISPLAY': ':0'}


@pytest.mark.parametrize('prefix, frame', [('', 'odom'), ('robot1/', 'robot1/odom')])
def test_command_line(prefix, frame):
    words = rviz.command(prefix, str(FOLDER), ['__name:=rviz'], lambda name: f'/usr/bin/{name}', DISPLAY)
    assert words[0] == '/usr/bin/rviz' and os.path.isfile(words[words.index('-d') + 1])
    assert words[words.index('-f') + 1] == frame and words[-1] == '__name:=rviz'


@pytest.mark.parametrize('found, environment, said', [
    (None, DISPLAY, 'type: ./run build --rviz'), (None, {}, 'type: ./run build --rviz'),
    ('/usr/bin/rviz', {}, 'DISPLAY is not set'), ('/usr/bin/rviz', {'DISPLAY': ''}, 'DISPLAY is not set')])
def test_what_is_missing_is_said(found, environment, said):
    with pytest.raises(rviz.CannotStart, match=said):
        rviz.command('', str(FOLDER), (), lambda name: found, environment)


def test_script_becomes_rviz(tmp_path):
    program = tmp_path / 'rviz'
    program.write_text('#!/bin/sh\necho "$@"\n')
    program.chmod(0o755)
    environment = {**os.environ, **DISPLAY, 'PATH': f'{tmp_path}:{os.environ["PATH"]}'}
    result = subprocess.run([sys.executable, FOLDER / 'scripts' / 'robotont_rviz', '--prefix=a/', '__name:=rviz'],
                            env=environment, capture_output=True, text=True, check=False)
    assert result.stdout.endswith('-f a/odom __name:=rviz\n'), result.stderr


def test_configuration_shows_what_the_robot_publishes():
    config = yaml.safe_load((FOLDER / 'config' / 'robotont_description.rviz').read_text(encoding='utf-8'))
    displays = {display['Class']: display for display in config['Visualization Manager']['Displays']}
    for kind, key, value in (('rviz/RobotModel', 'Robot Description', 'robot_description'),
                             ('rviz/LaserScan', 'Topic', 'scan'),
                             ('rviz/Image', 'Image Topic', 'camera/color/image_raw'),
                             ('rviz/Marker', 'Marker Topic', 'visualization_marker'), ('rviz/TF', 'Enabled', True)):
        assert displays[kind]['Enabled'] and displays[kind][key] == value


def test_rviz_does_not_follow_the_simulated_clock():
    """It is never idle: in lockstep, every step would wait for it."""
    launch = ElementTree.parse(FOLDER.parent / 'robotont_gazebo' / 'launch' / 'gazebo.launch')
    node, = (node for node in launch.iter('node') if node.get('type') == 'robotont_rviz')
    assert [remap.get('from') for remap in node.findall('remap')] == ['/use_sim_time']
