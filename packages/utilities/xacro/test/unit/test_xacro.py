"""xacro as rosrun and launch files start it: macros, arguments, and packages that rospack knows."""
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

from robotont_description.urdf import describe
from unit_support import REPOSITORY

SCRIPTS = REPOSITORY / 'packages' / 'utilities' / 'xacro' / 'scripts'
ROBOT = '''<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">
  <xacro:arg name="wheels" default="2"/>
  <xacro:include filename="$(find {package})/urdf/wheel.xacro"/>
  <xacro:wheel radius="${{0.1 * $(arg wheels)}}"/>
</robot>'''
WHEEL = '''<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="wheel" params="radius"><link name="wheel_${radius}"/></xacro:macro>
</robot>'''
MANIFEST = '<package><name>wheel_parts</name></package>'


@pytest.fixture
def package_path(tmp_path, monkeypatch):
    """Return a folder with the package wheel_parts, which is on the ROS_PACKAGE_PATH."""
    (tmp_path / 'wheel_parts' / 'urdf').mkdir(parents=True)
    (tmp_path / 'wheel_parts' / 'package.xml').write_text(MANIFEST)
    (tmp_path / 'wheel_parts' / 'urdf' / 'wheel.xacro').write_text(WHEEL)
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path))
    return tmp_path


def run(script, package_path, package, *arguments):
    """Return what xacro says to a file that includes one of a package."""
    (package_path / 'robot.xacro').write_text(ROBOT.format(package=package))
    return subprocess.run([sys.executable, str(SCRIPTS / script), str(package_path / 'robot.xacro'), *arguments],
                          capture_output=True, check=False, timeout=60.0)


@pytest.mark.parametrize('script', ['xacro', 'xacro.py'])
@pytest.mark.parametrize('arguments, link', [((), 'wheel_0.2'), (('--inorder', 'wheels:=3'), 'wheel_0.3')])
def test_includes_macros_and_arguments(package_path, script, arguments, link):
    done = run(script, package_path, 'wheel_parts', *arguments)
    assert (done.returncode, f'<link name="{link}'.encode() in done.stdout) == (0, True), done


def test_a_package_that_does_not_exist_is_named(package_path):
    done = run('xacro', package_path, 'wheel_part')
    assert done.returncode != 0
    assert b"there is no package 'wheel_part' on the ROS_PACKAGE_PATH" in done.stderr


def content(element):
    """Return an XML element as nested tuples, without blanks, comments and the order of its parts."""
    return element.tag, sorted(element.attrib.items()), sorted(map(content, element))


@pytest.mark.parametrize('model, prefix', [('robotont_gazebo_nuc', ''), ('robotont_gazebo_lidar', 'robot1/')])
def test_files_of_the_robotont_are_the_urdf_of_the_launch_files(model, prefix, monkeypatch):
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(REPOSITORY / 'packages' / 'robotont'))
    file = os.path.join(REPOSITORY / 'packages', 'robotont', 'robotont_gazebo', 'urdf', f'{model}.urdf.xacro')
    done = subprocess.run([sys.executable, str(SCRIPTS / 'xacro'), file, f'prefix:={prefix}'], stdout=subprocess.PIPE,
                          check=True, timeout=60.0)
    told = describe(model, prefix, REPOSITORY / 'packages' / 'robotont' / 'robotont_description' / 'urdf')
    assert content(ElementTree.fromstring(done.stdout)) == content(ElementTree.fromstring(told))
