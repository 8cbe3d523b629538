"""The packages of sourced workspaces: which commands belong to them, what is found of them, and what is not theirs."""
import os

import pytest

from course_grader import usage
from course_grader.isolation import sourced
from unit_support import REPOSITORY


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Return a sourced workspace: a package of the student's own, one made by catkin_make, and links of ./run link."""
    for name in ('topic_demo', 'shapes_msgs'):
        (tmp_path / 'src' / name).mkdir(parents=True)
        (tmp_path / 'src' / name / 'package.xml').write_text(f'<package><name>{name}</name></package>')
    (tmp_path / 'src' / 'topic_demo' / 'publisher.py').write_text('')
    (tmp_path / 'src' / 'turtlesim').symlink_to(REPOSITORY / 'packages' / 'simulation' / 'turtlesim')
    for name in ('shapes_msgs', 'turtlesim'):
        (tmp_path / 'devel' / sourced.MODULES / name).mkdir(parents=True)
    (tmp_path / 'devel' / '.catkin').write_text('')
    monkeypatch.setenv(sourced.PACKAGE_PATH, f'{tmp_path}/src:/usr/share:{tmp_path}/none')
    monkeypatch.setenv(sourced.PREFIX_PATH, f'{tmp_path}/devel:/usr')
    return tmp_path


def test_the_students_packages_are_found_with_what_was_made_of_them(workspace):
    found = usage.sourced_packages(os.environ)
    mine = dict(found.packages)
    assert mine['topic_demo'] == f'{workspace}/src/topic_demo' and 'shapes_msgs' in mine
    assert not {'turtlesim', 'turtle_robotont', 'rospy'} & set(mine)
    assert found.prefixes[0] == f'{workspace}/devel' and '/usr' not in found.prefixes
    here = [path for path in found.built() if path.startswith(str(workspace))]
    assert here == [f'{workspace}/devel/.catkin', f'{workspace}/devel/{sourced.MODULES}/shapes_msgs']


@pytest.mark.parametrize('command, concern', [
    (['rosrun', 'topic_demo', 'publisher.py'], True), (['roslaunch', '--screen', 'topic_demo', 'a.launch'], True),
    (['rosrun', 'turtlesim', 'draw_square'], False), (['rosrun'], False), (['python3', '{0}/elsewhere.py'], False),
    (['python3', '{0}/src/topic_demo/publisher.py'], True), (['rostopic', 'topic_demo'], False),
])
def test_only_a_command_of_theirs_sees_them(workspace, command, concern):
    (workspace / 'elsewhere.py').write_text('')
    assert usage.sourced_packages(os.environ).concern([part.format(workspace) for part in command]) is concern


def test_they_come_first_in_the_environment():
    made = sourced.Sourced((('a', '/w/src/a'),), ('/w/devel',)).environment({'PYTHONPATH': '/p', 'HOME': '/h'})
    assert made == {'HOME': '/h', 'ROS_PACKAGE_PATH': '/w/src/a', 'CMAKE_PREFIX_PATH': '/w/devel',
                    'PYTHONPATH': f'/w/devel/{sourced.MODULES}:/p', 'LD_LIBRARY_PATH': '/w/devel/lib'}
    assert sourced.Sourced().environment({'PYTHONPATH': '/p', 'LD_LIBRARY_PATH': ''})['PYTHONPATH'] == '/p'


@pytest.mark.parametrize('command, said', [
    (['rosrun', 'topic_dem', 'publisher.py'], 'there is no package topic_dem in the workspaces of this terminal. '
     'Did you mean topic_demo? Type this'),
    (['roslaunch', 'zzzz', 'a.launch'], '\n  source ~/ros_ws/devel/setup.bash\n  ./run grade x -- roslaunch zzzz'),
])
def test_a_package_that_is_not_sourced_is_wrong_usage(workspace, command, said):
    with pytest.raises(usage.UsageError) as error:
        usage.check_package(['x'], command)
    assert said in str(error.value)


@pytest.mark.parametrize('command', [['rosrun', 'topic_demo', 'no.py'], ['rosrun', 'turtlesim', 'mimic'],
                                     ['true', 'zz'], ['rosrun', 'rostopic', 'rostopic'], ['rosrun']])
def test_what_rosrun_finds_is_left_to_it(workspace, command):
    usage.check_package(['x'], command)
