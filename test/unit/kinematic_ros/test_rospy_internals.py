"""kinematic_ros.rospy_internals: whether the rospy that is installed has what that module uses."""
import rospy
import rospy.impl.tcpros_base
import rospy.rostime
from std_msgs.msg import String

from kinematic_ros import rospy_internals


def test_this_rospy_fits():
    said = '\n'.join(rospy_internals.misfits())
    assert not said, (f'rospy {rospy_internals.version()} differs from {", ".join(rospy_internals.CHECKED)}, for which '
                      f'kinematic_ros/rospy_internals.py was written; change it, or the table there:\n{said}')


def test_the_version_is_known():
    assert rospy_internals.version().startswith(rospy_internals.CHECKED)


def test_what_does_not_fit_is_named(monkeypatch):
    monkeypatch.delattr(rospy.rostime, '_set_rostime')
    monkeypatch.setattr(rospy.impl.tcpros_base.TCPROSTransport, 'close', lambda self, reason: None)
    monkeypatch.setattr(rospy.topics.Topic, '__init__', lambda self: None)
    assert rospy_internals.misfits() == [
        'rospy.rostime._set_rostime is missing',
        'rospy.impl.tcpros_base.TCPROSTransport.close takes (self, reason), not (self)',
        'rospy.topics.Topic has no attribute impl']


def test_a_missing_module_is_named(monkeypatch):
    monkeypatch.setattr(rospy_internals, 'FUNCTIONS', {'rospy.impl.no_such_module.function': ()})
    monkeypatch.setattr(rospy_internals, 'ATTRIBUTES', {'no_such_package.Class': ('socket',)})
    assert rospy_internals.misfits() == ['rospy.impl.no_such_module.function is missing',
                                         'no_such_package.Class is missing']


def test_a_publisher_without_and_after_its_topic():
    publisher = rospy.Publisher('chatter', String, queue_size=1)
    assert list(rospy_internals.connections(publisher)) == []
    rospy_internals.publish_without_threads(publisher)
    assert ['/chatter', 'std_msgs/String'] in rospy_internals.publications()
    assert '/chatter' in rospy_internals.unconnected_publications()
    publisher.unregister()
    assert list(rospy_internals.connections(publisher)) == []
    assert '/chatter' not in rospy_internals.unconnected_publications()


def test_the_caller_of_a_message():
    message = String()
    assert rospy_internals.caller(message) == ''
    message._connection_header = {'callerid': '/talker'}
    assert rospy_internals.caller(message) == '/talker'
