"""C++ programs that were written for ROS in /opt/ros compile here: headers, boost::bind, cv_bridge."""
import os
import pathlib
import shutil
import subprocess
import textwrap

import pytest

from unit_support import REPOSITORY

pytestmark = pytest.mark.slow
SUPPORT = REPOSITORY / 'packages' / 'support' / 'rospy_support'
VARIABLE, SWITCH = 'CPLUS_INCLUDE_PATH', 'TURTLE_ROBOTONT_CPP_HEADERS'
CLEAN = {'PATH': os.defpath, 'HOME': os.environ.get('HOME', '/'), 'LANG': 'C.UTF-8'}
BUILD_TIMEOUT = 280.0  # [s]; it takes 40

POSE = """
    #include <ros/ros.h>
    #include <turtlesim/Pose.h>
    class Follower {
    public:
      Follower() { sub = node.subscribe<turtlesim::Pose>("turtle1/pose", 1, boost::bind(&Follower::pose, this, _1)); }
    private:
      void pose(const turtlesim::Pose::ConstPtr& message) { ROS_INFO("%f", message->x); }
      ros::NodeHandle node;
      ros::Subscriber sub;
    };
    int main(int argc, char** argv) { ros::init(argc, argv, "follower"); Follower follower; ros::spin(); }
"""
ACTION = """
    #include <ros/ros.h>
    #include <actionlib/server/simple_action_server.h>
    #include <actionlib_tutorials/FibonacciAction.h>
    class Server {
    public:
      Server() : server(node, "fibonacci", boost::bind(&Server::run, this, _1), false) { server.start(); }
      void run(const actionlib_tutorials::FibonacciGoalConstPtr& goal) { server.setSucceeded(); }
    private:
      ros::NodeHandle node;
      actionlib::SimpleActionServer<actionlib_tutorials::FibonacciAction> server;
    };
    int main(int argc, char** argv) { ros::init(argc, argv, "fibonacci"); Server server; ros::spin(); }
"""
CMAKE = """
    cmake_minimum_required(VERSION 3.0.2)
    project(my_course)
    find_package(catkin REQUIRED COMPONENTS actionlib roscpp)
    catkin_package()
    include_directories(${catkin_INCLUDE_DIRS})
    foreach(program follower server)
      add_executable(${program} src/${program}.cpp)
      target_link_libraries(${program} ${catkin_LIBRARIES})
    endforeach()
"""


def compiled(source, **environment):
    """Return what the compiler says about a program, without making one."""
    done = subprocess.run(['g++', '-fsyntax-only', '-Wall', '-x', 'c++', '-'], input=textwrap.dedent(source), text=True,
                          capture_output=True, check=False, env={**os.environ, **environment})
    return done.stderr if done.returncode == 0 else f'{done.stderr}code {done.returncode}'


@pytest.fixture
def workspace():
    if not os.environ.get('ROS_PACKAGE_PATH') or not shutil.which('g++'):
        pytest.skip('no workspace is sourced, or there is no g++')


@pytest.mark.usefixtures('workspace')
def test_messages_and_placeholders_are_found_without_naming_them():
    assert compiled(POSE) == ''
    assert 'turtlesim/Pose.h: No such file' in compiled('#include <turtlesim/Pose.h>', **{VARIABLE: ''})


@pytest.mark.usefixtures('workspace')
def test_programs_without_ros_have_the_names_for_themselves():
    assert compiled("""
        #include <boost/bind/bind.hpp>
        #include <functional>
        using namespace std::placeholders;
        int negative(int number) { return -number; }
        int main() { return std::bind(negative, _1)(0); }
    """) == ''


def hooked(times=1, **environment):
    """Return CPLUS_INCLUDE_PATH after the setup file of /ws was sourced ``times``."""
    hook = (SUPPORT / 'env-hooks' / '50.cpp_headers.sh.in').read_text(encoding='utf-8')
    script = hook.replace('@PROJECT_NAME@', 'rospy_support') * times
    done = subprocess.run(['sh', '-euc', f'{script}\nprintf %s "${{{VARIABLE}-unset}}"'], text=True, check=True,
                          capture_output=True, env={'CATKIN_ENV_HOOK_WORKSPACE': '/ws', **environment})
    return done.stdout


@pytest.mark.parametrize('times', [1, 2])
@pytest.mark.parametrize('environment, expected', [
    ({}, '/ws/share/rospy_support/include'),
    ({VARIABLE: ''}, '/ws/share/rospy_support/include'),  # an empty part would be the current folder
    ({VARIABLE: '/mine'}, '/ws/share/rospy_support/include:/mine'),
    ({SWITCH: '0'}, 'unset'),
    ({SWITCH: '0', VARIABLE: '/mine'}, '/mine'),
    ({SWITCH: '1'}, '/ws/share/rospy_support/include'),
])
def test_the_setup_file_adds_one_folder(times, environment, expected):
    assert hooked(times, **environment) == expected


@pytest.fixture
def package(tmp_path):
    """Return the src folder of a workspace; it has a package of two programs, which names no package of messages."""
    folder = tmp_path / 'catkin_ws' / 'src' / 'my_course'
    (folder / 'src').mkdir(parents=True)
    (folder / 'package.xml').write_text(
        '<package format="2"><name>my_course</name><version>0.0.0</version><description>mine</description>'
        '<maintainer email="me@example.org">me</maintainer><license>BSD</license>'
        '<buildtool_depend>catkin</buildtool_depend><depend>actionlib</depend><depend>roscpp</depend></package>')
    (folder / 'CMakeLists.txt').write_text(textwrap.dedent(CMAKE))
    (folder / 'src' / 'follower.cpp').write_text(textwrap.dedent(POSE))
    (folder / 'src' / 'server.cpp').write_text(textwrap.dedent(ACTION))
    return folder.parent


def build(src, environment, *command):
    done = subprocess.run(command, cwd=src.parent, env=environment, text=True, check=False, timeout=BUILD_TIMEOUT,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout
    assert {path.name for path in (src.parent).glob('devel*/**/lib/my_course/*')} == {'follower', 'server'}


@pytest.mark.nightly
def test_an_overlay_is_built(package):
    setup = pathlib.Path(os.environ.get('VIRTUAL_ENV', '/')).parent / 'env.bash'
    if not setup.is_file():
        pytest.skip('no workspace of ./run is sourced')
    build(package, CLEAN, 'bash', '-c', '. "$0"; exec catkin_make', str(setup))


@pytest.mark.nightly
@pytest.mark.skipif(not shutil.which('catkin_make'), reason='there is no catkin')
def test_a_workspace_that_our_packages_are_linked_into_is_built_at_once(package):
    """In a terminal that has not sourced anything, from nothing: the messages are made in the same run."""
    for path in ('simulation/turtlesim', 'tutorials/actionlib_tutorials', 'support/rospy_support'):
        (package / pathlib.Path(path).name).symlink_to(REPOSITORY / 'packages' / path)
    build(package, CLEAN, 'catkin_make')


@pytest.mark.skipif(not shutil.which('cmake'), reason='there is no cmake')
@pytest.mark.parametrize('installed', [False, True])
def test_cpp_programs_get_the_libraries_of_debians_cv_bridge(tmp_path, installed):
    """catkin includes the file at the end of our cv_bridgeConfig.cmake, which has set the variables of the script."""
    original = tmp_path / 'lib' / 'x86_64-linux-gnu' / 'cmake' / 'cv_bridge'
    if installed:
        original.mkdir(parents=True)
        (original / 'cv_bridgeConfig.cmake').write_text(
            'if(cv_bridge_CONFIG_INCLUDED)\n return()\nendif()\nset(cv_bridge_LIBRARIES cv_bridge)\n'
            'include(${cv_bridge_DIR}/more.cmake)')
        (original / 'more.cmake').write_text('set(cv_bridge_MORE yes)')
    extras = (REPOSITORY / 'packages/vision/cv_bridge/cmake/cv_bridge-extras.cmake').read_text(encoding='utf-8')
    script = tmp_path / 'script.cmake'
    script.write_text('set(cv_bridge_DIR /ours)\nset(cv_bridge_CONFIG_INCLUDED TRUE)\n'
                      + extras.replace('/usr/lib/', f'{tmp_path}/lib/')
                      + '\nmessage("${cv_bridge_LIBRARIES} ${cv_bridge_MORE} ${cv_bridge_DIR}")')
    done = subprocess.run(['cmake', '-P', script], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == ('cv_bridge yes /ours' if installed else '/ours')
    assert ('apt-get install libcv-bridge-dev' in done.stdout) is not installed
