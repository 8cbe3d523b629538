"""The root package by itself, as catkin sees a clone: its error without turtlesim, its needs, its installation.

Only Debian's ROS and packages that the tests put beside it are there, nothing else of this repository.
"""
import os
import shutil
import subprocess
import time
import xmlrpc.client

import pytest

from rospy_support.own_master import own_master
from unit_support import REPOSITORY
from unit_support.cases import nightly

pytestmark = pytest.mark.slow
ENVIRONMENT = {'PATH': os.defpath, 'HOME': os.environ.get('HOME', '/'), 'LANG': 'C.UTF-8',
               'ROS_LANG_DISABLE': 'gencpp:geneus:genlisp:gennodejs'}  # the programs need only Python
BUILD_TIMEOUT = 120.0  # [s]; it takes 15
START_TIMEOUT = 60.0  # [s] until a program has registered; it takes 1
STARTERS = {'browser.py': 'course_page', 'demo.py': 'course_grader', 'grade.py': 'course_grader',
            'marker_sequence.py': 'alvar_core'}


def run(*command, folder):
    return subprocess.run(command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=BUILD_TIMEOUT, check=False)


def make_workspace(folder):
    """Return a workspace with the root package alone."""
    source = folder / 'catkin_ws' / 'src'
    source.mkdir(parents=True)
    (source / 'turtle_robotont').symlink_to(REPOSITORY)
    return source.parent


def interfaces(source, name, origin):
    """Make a package ``name`` with nothing but the messages and services of a folder."""
    package = source / name
    for kind in ('msg', 'srv'):
        if (origin / kind).is_dir():
            shutil.copytree(origin / kind, package / kind)
    files = {kind: ' '.join(sorted(path.name for path in package.glob(f'{kind}/*'))) for kind in ('msg', 'srv')}
    (package / 'package.xml').write_text(
        f'<package format="2"><name>{name}</name><version>1.0.0</version><description>-</description>'
        '<maintainer email="a@example.org">-</maintainer><license>-</license>'
        '<buildtool_depend>catkin</buildtool_depend>'
        '<depend>geometry_msgs</depend><depend>std_msgs</depend><depend>message_generation</depend></package>')
    (package / 'CMakeLists.txt').write_text(
        f'cmake_minimum_required(VERSION 3.0.2)\nproject({name})\n'
        'find_package(catkin REQUIRED COMPONENTS message_generation geometry_msgs std_msgs)\n'
        + ''.join(f'add_{kind}_files(FILES {names})\n' for kind, names in
                  (('message', files['msg']), ('service', files['srv'])) if names)
        + 'generate_messages(DEPENDENCIES geometry_msgs std_msgs)\ncatkin_package()\n')


@pytest.mark.parametrize('tool', ['catkin_make', *nightly('catkin_make_isolated')])
def test_without_turtlesim_cmake_stops_and_says_what_to_type(tmp_path, tool):
    workspace = make_workspace(tmp_path)
    result = run(tool, folder=workspace)
    assert result.returncode != 0
    output = ' '.join(result.stdout.split())
    assert f'There is no package turtlesim here; turtle_robotont brings one along. Type: {REPOSITORY}/run link ' \
           f'{workspace}' in output


@pytest.mark.nightly
def test_without_the_marker_messages_it_stops_too(tmp_path):
    workspace = make_workspace(tmp_path)
    interfaces(workspace / 'src', 'turtlesim', REPOSITORY / 'packages' / 'simulation' / 'turtlesim')
    result = run('catkin_make', folder=workspace)
    assert result.returncode != 0 and 'There is no package ar_track_alvar_msgs here' in result.stdout


@pytest.fixture(scope='module')
def installed(tmp_path_factory):
    """Return a workspace with the root package and interfaces of others, installed."""
    workspace = make_workspace(tmp_path_factory.mktemp('alone'))
    interfaces(workspace / 'src', 'turtlesim', REPOSITORY / 'packages' / 'simulation' / 'turtlesim')
    interfaces(workspace / 'src', 'ar_track_alvar_msgs', REPOSITORY / 'packages' / 'vision' / 'ar_track_alvar_msgs')
    result = run('catkin_make', 'install', folder=workspace)
    assert result.returncode == 0, result.stdout
    return workspace


@pytest.fixture(scope='module')
def master(tmp_path_factory):
    """Return the URI of a master for the programs."""
    with own_master(str(tmp_path_factory.mktemp('master') / 'master.log')) as started:
        yield started.uri


def nodes_of(master):
    """Return the names of the nodes that publish /rosout, as all nodes do."""
    _, _, (publishers, _, _) = xmlrpc.client.ServerProxy(master).getSystemState('/test')
    return {node for topic, nodes in publishers if topic == '/rosout' for node in nodes}


def start(workspace, master, script, output):
    """Start a program from the install space."""
    environment = {**ENVIRONMENT, 'ROS_HOME': str(workspace / 'ros_home'), 'ROS_HOSTNAME': 'localhost'}
    return subprocess.Popen(
        ['sh', '-c', f'. {workspace}/install/setup.sh && export ROS_MASTER_URI={master} && '
         f'exec rosrun turtle_robotont {script}'], env=environment, stdout=output, stderr=subprocess.STDOUT,
        cwd=workspace)


@pytest.mark.nightly
@pytest.mark.parametrize('script', sorted(path.name for path in (REPOSITORY / 'scripts').glob('*.py')))
def test_program_starts_from_the_install_space(installed, master, tmp_path, script):
    """A node registers at the master; a starter says which package is missing, and what to type."""
    before = nodes_of(master)
    with open(tmp_path / 'output', 'w') as output:
        process = start(installed, master, script, output)
    try:
        if script in STARTERS:
            assert process.wait(START_TIMEOUT) == 1
            assert f'{script}: the package {STARTERS[script]} is not in this workspace' in printed(tmp_path)
            assert 'run link ~/catkin_ws' in printed(tmp_path)
            return
        end = time.monotonic() + START_TIMEOUT
        while nodes_of(master) <= before:
            assert process.poll() is None and time.monotonic() < end, printed(tmp_path)
            time.sleep(0.05)
    finally:
        process.kill()
        process.wait()


def printed(folder):
    return (folder / 'output').read_text()


@pytest.mark.nightly
def test_launch_files_and_docs_are_installed(installed):
    share = installed / 'install' / 'share' / 'turtle_robotont'
    for name in ('launch', 'docs'):
        assert {path.name for path in (REPOSITORY / name).iterdir()} == {path.name for path in (share / name).iterdir()}


def test_rostests_of_the_root_are_the_lessons():
    """Those of the rooms need the whole repository."""
    assert 'set(test_folders test/course ' in (REPOSITORY / 'CMakeLists.txt').read_text()
    names = [path.name for path in REPOSITORY.glob('test/**/*.test')]
    assert len(set(names)) == len(names), 'rostest finds a file by its name alone'
