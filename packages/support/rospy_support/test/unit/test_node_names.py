"""Names that C++ nodes refuse are refused here, too, with one that is allowed."""
import pytest

from rospy_support import nodes
from rospy_support.parameters import ParameterError


@pytest.mark.parametrize('arguments', [
    [], ['__name:=sim_2'], ['__ns:=/a/b'], ['__ns:=a'], ['turtle1/cmd_vel:=/a/b'], ['~pose:=pose', 'a:=~b'],
    ['_pen:=a b', '_ü:=1'], ['__log:=/a b.log'], ['__ip:=1.2.3.4'], ['a b'], ['a==b'],
])
def test_names_of_ros_are_allowed(arguments):
    nodes.check_names(['node', *arguments], {})


@pytest.mark.parametrize('argument, said, better', [
    ('__name:=a b', 'a node has only letters', '__name:=a_b'), ('__name:=tü', 'a node has only', '__name:=t_'),
    ('__name:=1st', 'begins with a letter', '__name:=n1st'),
    ('__name:=a/b', 'a node has only', '__name:=a_b'), ('__name:=a-b', 'digits and _', '__name:=a_b'),
    ('__ns:=/ä', 'letters a to z, digits, _ and /', '__ns:=/_'), ('__ns:=9', 'begins with a letter', '__ns:=n9'),
    ('turtle1/cmd_vel:=/ü', 'it has only', 'turtle1/cmd_vel:=/_'),
])
def test_other_names_are_refused(argument, said, better):
    with pytest.raises(ParameterError) as error:
        nodes.check_names(['node', argument], {})
    text = str(error.value)
    assert repr(argument) in text and said in text and text.endswith(f'Type for example {better}')


def test_the_namespace_of_the_environment_counts():
    with pytest.raises(ParameterError, match='Type for example export ROS_NAMESPACE=/_$'):
        nodes.check_names([], {'ROS_NAMESPACE': '/ä'})
    nodes.check_names([], {'ROS_NAMESPACE': '/a'})
    nodes.check_names([], {'ROS_NAMESPACE': ''})


def test_a_node_does_not_start_with_such_a_name():
    with pytest.raises(ParameterError, match="'__name:=a b' is not a name that ROS allows"):
        nodes.init_node('anything', argv=['node', '__name:=a b'])
