"""./run doctor FOLDER: what other people's packages need, and what of it is missing."""
import os
import subprocess
import sys
import textwrap

import pytest

from plain_support.doctor import cli, package_checks, system_checks
from plain_support.doctor.machine import Machine
from plain_support.doctor.package_checks import Machinery
from plain_support.doctor.package_needs import BUILD, IMPORT, INCLUDE, LISTED, RUN, read

FROM_3_14 = pytest.mark.skipif(sys.version_info < (3, 14), reason='no Python before 3.14 reads this')
XML = '<package><name>mine</name>{}</package>'


@pytest.fixture
def package(tmp_path):
    """Return a function that writes files {path: text} of a folder and reads what they need."""
    def write(files):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(textwrap.dedent(text), encoding='utf-8')
        return read(str(tmp_path))
    return write


@pytest.mark.parametrize('name, text, needs', [
    ('package.xml', XML.format('<depend>tf</depend><exec_depend version_gte="1"> joy </exec_depend>'
                               '<!-- <depend>no</depend> --><buildtool_depend>catkin</buildtool_depend>'),
     {('tf', LISTED), ('joy', LISTED)}),
    ('CMakeLists.txt', 'find_package(catkin REQUIRED COMPONENTS\n  roscpp # no\n  tf)\nfind_package(OpenCV)\n'
     'find_package(urdf REQUIRED)', {('roscpp', BUILD), ('tf', BUILD), ('catkin', BUILD), ('urdf', BUILD)}),
    ('CMakeLists.txt', 'find_package(catkin QUIET NO_POLICY_SCOPE PATHS "${path}" NO_DEFAULT_PATH)',
     {('catkin', BUILD)}),
    ('launch/a.launch', '<launch><!-- pkg="no" --><node pkg="rviz" type="rviz"/>\n'
     '<include file="$(find gazebo_ros)/launch/empty_world.launch"/></launch>', {('rviz', RUN), ('gazebo_ros', RUN)}),
    ('src/a.cpp', '#include <ros/ros.h>\n#include "turtlesim/Pose.h"\n#include <cv_bridge/cv_bridge.h>',
     {('turtlesim', INCLUDE), ('cv_bridge', INCLUDE)}),
    ('scripts/a.py', 'import rospy, os.path\nfrom tf2_geometry_msgs import PointStamped\nfrom . import other\n',
     {('rospy', IMPORT), ('os', IMPORT), ('tf2_geometry_msgs', IMPORT)}),
    ('scripts/a', '#!/usr/bin/env python\nimport rospy', {('rospy', IMPORT)}),
    ('scripts/old.py', 'import rospy\nprint "hello"\nfrom smach import State\n',
     {('rospy', IMPORT), ('smach', IMPORT)}),
    ('build/a.launch', '<node pkg="rviz"/>', set()),
    ('.git/a.launch', '<node pkg="rviz"/>', set()),
    ('README.md', 'import rospy', set()),
])
def test_what_a_file_needs(package, name, text, needs):
    assert set(package({name: text}).needs) == needs


def test_what_a_folder_has_itself_is_not_needed(package):
    needs = package({'a/package.xml': '<name>a</name>', 'a/scripts/helper.py': '', 'a/src/lib/__init__.py': '',
                     'a/scripts/run.py': 'import helper, lib\nfrom a.msg import X', 'b/package.xml': '<name>b</name>',
                     'b/b.launch': '<node pkg="a"/>'})
    assert set(needs.needs) == set() and set(needs.packages) == {'a', 'b'}


@pytest.mark.parametrize('text, line, said', [
    ('print "hello"', 1, "'print \"hello\"' is no Python 3"),
    ('try:\n    pass\nexcept OSError, error:\n    pass', 3, "'except OSError, error:' is no Python 3"),
    ('try:\n    pass\nexcept OSError, (number, why):\n    pass', 3, "'except OSError, (number, why):' is no Python 3"),
    ('def f():\n    try:\n        pass\n    except rospy.ROSException, e: pass', 4,
     "'except rospy.ROSException, e: pass' is no Python 3"),
    ('import rospy\nimport Queue', 2, 'the module Queue is queue today'),
    ('from Tkinter import *', 1, 'the module Tkinter is tkinter today'),
    ('name = raw_input()', 1, 'raw_input is input today'),
    ('a = {}\na.has_key(1)', 2, '.has_key() is in today'),
])
def test_what_is_of_python_2(package, text, line, said):
    assert list(package({'a.py': text}).old.values()) == [(line, said)]


@pytest.mark.parametrize('text', [
    'print("hello")', 'try:\n    import Queue\nexcept ImportError:\n    import queue as Queue',
    'try:\n    raw_input\nexcept NameError:\n    raw_input = input\nraw_input()',
    'from functools import reduce\nreduce(max, [1])', 'x = "\\d"',
    'from somewhere import *\ntry:\n    pass\nexcept (OSError, TheirError):\n    pass',
    pytest.param('class Mine(Exception):\n    pass\ntry:\n    pass\nexcept OSError, Mine:\n    pass', marks=FROM_3_14)])
def test_what_runs_with_both_is_not_reported(package, text):
    assert package({'a.py': text}).old == {}


THERE = Machinery({'turtlesim', 'cv_bridge'}, {'turtlesim', 'cv_bridge', 'tf'}, {'turtlesim', 'tf'},
                  {'rospy', 'turtlesim', 'cv_bridge'})


@pytest.mark.parametrize('name, kind, there', [
    ('turtlesim', RUN, True), ('turtlesim', INCLUDE, True), ('turtlesim', IMPORT, True),
    ('cv_bridge', BUILD, True), ('cv_bridge', INCLUDE, False), ('cv_bridge', IMPORT, True),
    ('rospy', IMPORT, True), ('rospy', LISTED, True), ('joy', LISTED, False), ('joy', RUN, False),
    ('python3-numpy', LISTED, True), ('libqt5', LISTED, False)])
def test_what_is_there(name, kind, there):
    assert package_checks._is_there(name, kind, THERE) is there


@pytest.mark.parametrize('name, kinds, candidates', [
    ('tf2_geometry_msgs', [IMPORT], ['python3-tf2-geometry-msgs']),
    ('urdf', [BUILD], ['liburdf-dev']),
    ('map_msgs', [INCLUDE], ['libmap-msgs-dev', 'ros-map-msgs']),
    ('image_view', [RUN], ['ros-image-view']),
    ('rviz', [RUN], ['ros-rviz', 'rviz']),
    ('yaml', [IMPORT], ['python3-yaml']),
])
def test_what_debian_may_call_it(name, kinds, candidates):
    assert package_checks._candidates(name, kinds) == candidates


def test_a_folder_is_examined(package, tmp_path, monkeypatch):
    package({'mine/package.xml': XML.format('<depend>rviz</depend><depend>eigen</depend>'),
             'mine/a.launch': '<node pkg="rviz"/>', 'mine/b.launch': '<node pkg="mine"/>',
             'mine/c.launch': '<node pkg="amcl"/><node pkg="turtlesim"/>'})
    monkeypatch.setattr(package_checks, '_machinery', lambda *_: THERE)
    monkeypatch.setattr(package_checks, 'offered', lambda names: [name for name in names if name == 'rviz'])
    found, lines = package_checks.examine(str(tmp_path), Machine({}, '', ''))
    assert [(finding.name, finding.fails) for finding in found] == [
        ('package_not_to_be_had', True), ('package_to_install', True)]
    assert lines == ['Packages here: mine.', 'Stand-ins of this repository: turtlesim.',
                     '1 of 3 launch files find all their packages, 2 with the Debian packages below.',
                     'What launch files lack, and Debian does not have: amcl (1).',
                     'All at once: sudo apt-get install --no-install-recommends rviz']


def test_a_launch_file_needs_no_headers(package, tmp_path, monkeypatch):
    package({'mine/package.xml': XML, 'mine/CMakeLists.txt': 'find_package(catkin REQUIRED COMPONENTS publisher)',
             'mine/a.launch': '<node pkg="publisher"/>'})
    there = THERE._replace(packages={'publisher'}, headers={'catkin'})
    monkeypatch.setattr(package_checks, '_machinery', lambda *_: there)
    monkeypatch.setattr(package_checks, 'offered', lambda names: [])
    found, lines = package_checks.examine(str(tmp_path), Machine({}, '', ''))
    assert len(found) == 1 and '1 of 1 launch files find all their packages.' in lines


def test_programs_with_the_same_fault_are_one_finding(package, tmp_path, monkeypatch):
    package({'mine/package.xml': XML, **{f'mine/{name}.py': '#!/nowhere/python\n' for name in 'abc'},
             'mine/d.py': '#!/usr/bin/env python3\n'})
    monkeypatch.setattr(package_checks, '_machinery', lambda *_: THERE)
    found, _ = package_checks.examine(str(tmp_path), Machine(dict(os.environ), '', ''))
    (first_line, mode) = found
    assert 'mine/a.py' in first_line.text and '(likewise b.py, c.py)' in first_line.text
    for finding in (first_line, mode):
        subprocess.run(['bash', '-c', finding.cure.replace('type ', '', 1)], check=True)
    assert package_checks.examine(str(tmp_path), Machine(dict(os.environ), '', ''))[0] == []


@pytest.mark.parametrize('arguments, code', [(['.'], 1), ([], 0)])
def test_a_command_without_an_answer_says_nothing_about_what_is_missing(package, tmp_path, monkeypatch, capsys,
                                                                        arguments, code):
    package({'mine/package.xml': XML, 'mine/a.py': '#!/usr/bin/env python3\nimport math\n'})
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(package_checks, 'PATIENCE', 1e-3)
    monkeypatch.setattr(system_checks, 'PATIENCE', 1e-3)
    monkeypatch.setattr(cli, 'CHECKS', [system_checks.isolation, system_checks.disk])
    assert cli.main([*arguments, '--workspace', str(tmp_path)]) == code
    said = capsys.readouterr().out
    assert 'gave no answer within' in said and 'missing' not in said and 'neither bwrap' not in said


def test_a_package_is_found_by_its_name(tmp_path):
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'package.xml').write_text(XML)
    machine = Machine({'ROS_PACKAGE_PATH': str(tmp_path)}, '', '')
    assert package_checks.folder_of('mine', machine) == str(tmp_path / 'mine')
    assert package_checks.folder_of(str(tmp_path), machine) == str(tmp_path)
    assert package_checks.folder_of('other', machine) is None


def test_a_name_that_is_nothing_is_refused(capsys, monkeypatch):
    monkeypatch.setitem(os.environ, 'ROS_PACKAGE_PATH', '')
    assert cli.main(['no_such_package']) == 2
    assert "'no_such_package' is neither a folder nor a package" in capsys.readouterr().err
