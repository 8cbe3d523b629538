"""test/pages/check_seed.py types every command of a text, in its order; course_texts.py finds them."""

import pytest

from rostest_support import course_texts
from unit_support import REPOSITORY

SAMPLE = '''rosrun is explained here
[user at]:~/a/src$ catkin_create_pkg b rospy
c Created file b/package.xml Created file b/CMakeLists.txt
Created folder /home/somebody/a/src/b
$ rosservice type [service name]
$ rosservice call /b # terminal 2
name: "c"
'''


@pytest.fixture
def seed(monkeypatch):
    pytest.importorskip('cv2')
    monkeypatch.syspath_prepend(str(REPOSITORY / 'test' / 'pages'))
    import check_seed
    monkeypatch.setattr(course_texts, 'text', lambda number: SAMPLE)
    return check_seed.Seed(0)


def test_commands_of_a_text():
    assert course_texts.commands(SAMPLE) == [
        ('catkin_create_pkg b rospy', SAMPLE.splitlines()[2:]), ('rosservice call /b', ['name: "c"'])]
    assert [command for command, _ in course_texts.commands('    roscore\nrostopic echo /a\nrospy.spin()\n')] == [
        'roscore', 'rostopic echo /a']
    assert course_texts.folder(SAMPLE) == '~/a/src'
    assert course_texts.output(SAMPLE, 'Created') == [
        'Created file b/package.xml', 'Created file b/CMakeLists.txt', 'Created folder .../a/src/b']


def test_every_command_is_typed_in_its_order(seed):
    with pytest.raises(ValueError, match='not typed.*catkin_create_pkg.*rosservice call'):
        seed.end()
    seed.type(1, 'catkin_create_pkg')
    with pytest.raises(ValueError, match='the text goes on with rosservice call /b, not with roscore'):
        seed.leave_out('roscore', 'it runs')


def test_what_is_printed_is_what_the_text_prints(seed):
    seed.type(1, 'catkin_create_pkg', 'rosservice')
    seed.end()
    assert [action.text for _, action in seed.actions] == ['catkin_create_pkg b rospy', 'rosservice call /b']
    assert seed.printed(1) == ['name: "c"']
    with pytest.raises(ValueError, match='the text goes on with its end, not with roscore'):
        seed.type(1, 'roscore')
