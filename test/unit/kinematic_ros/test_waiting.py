"""kinematic_ros.waiting: what is said about a topic that brings nothing."""
import pytest

from kinematic_ros.waiting import text_about

KIND = 'std_msgs/Empty'


@pytest.mark.parametrize('types, publishers, text', [
    ({}, {}, 'Nothing comes on /a: nobody publishes it.'),
    ({'/a': KIND}, {'/a': ['/n']}, 'Nothing comes on /a, though /n publishes it.'),
    ({'/a': '*'}, {'/a': ['/n', '/m']}, 'Nothing comes on /a, though /n, /m publishes it.'),
    ({'/a': 'std_msgs/String'}, {'/a': ['/n']},
     'Nothing comes on /a: /n publishes it as std_msgs/String, not as std_msgs/Empty.'),
    ({'/b': KIND, '/c': KIND, '/d': 'std_msgs/String'}, {'/b': ['/n'], '/c': ['/m'], '/d': ['/n']},
     'Nothing comes on /a: nobody publishes it. There is /b (by /n), /c (by /m) of the type std_msgs/Empty; '
     'remap with name:=/b .'),
])
def test_text_names_the_topic_its_publishers_and_what_there_is_instead(types, publishers, text):
    assert text_about('/a', KIND, 'name', types, publishers) == text
