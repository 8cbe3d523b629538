"""rospy_support.reachability: wrong addresses of a node, and topics that stay unconnected."""
import pytest
import rosgraph
import rospy

from rospy_support import reachability
from rospy_support.rospy_internals import topics

NODE = '/laptop/node'


@pytest.mark.parametrize('took, pause', [(0.0, 3.0), (0.02, 3.0), (0.2, 20.0)])
def test_looks_take_little_of_the_time(took, pause):
    assert reachability.pause_after(took, 3.0) == pytest.approx(pause)


class Topic:
    def __init__(self, connections):
        self._connections = connections

    def has_connections(self):
        return bool(self._connections)


class Manager:
    """rospy's topics of a node: {name: number of connections}."""

    def __init__(self, published, subscribed):
        self._published, self._subscribed = published, subscribed

    def get_publications(self):
        return [(name, 'a/Type') for name in self._published]

    def get_subscriptions(self):
        return [(name, 'a/Type') for name in self._subscribed]

    def get_publisher_impl(self, name):
        return Topic(self._published[name])

    def get_subscriber_impl(self, name):
        return Topic(self._subscribed[name])


@pytest.mark.parametrize('published, subscribed, state, found', [
    ({'/cmd_vel': 0}, {}, ([], [('/cmd_vel', ['/robot', NODE, '/other'])]), {('/cmd_vel', '/other, /robot')}),
    ({'/cmd_vel': 1}, {}, ([], [('/cmd_vel', ['/robot'])]), set()),
    ({'/cmd_vel': 0}, {}, ([('/cmd_vel', ['/teleop'])], []), set()),
    ({'/cmd_vel': 0}, {}, ([], [('/cmd_vel', [NODE])]), set()),
    ({}, {'/odom': 0}, ([('/odom', ['/robot'])], []), {('/odom', '/robot')}),
    ({}, {'/odom': 2}, ([('/odom', ['/robot'])], []), set()),
    ({'/rosout': 0}, {}, ([], [('/rosout', ['/rosout'])]), set()),
])
def test_topics_known_from_both_sides_without_connection(monkeypatch, published, subscribed, state, found):
    monkeypatch.setattr(topics, 'get_topic_manager', lambda: Manager(published, subscribed))
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    monkeypatch.setattr(rosgraph.Master, 'getSystemState', lambda self: (*state, []))
    assert reachability.unconnected() == found


@pytest.mark.parametrize('offered, ended', [
    ('rosrpc://localhost:1', True), ('rosrpc://10.88.0.9:1', False),  # unknown here: another machine
    (None, False), ('nonsense', False),
])
def test_a_node_of_this_machine_that_has_ended_is_told(monkeypatch, offered, ended):
    def look_up(_, name):
        if offered is None:
            raise rosgraph.MasterError('unknown')
        return offered
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    monkeypatch.setattr(rosgraph.Master, 'lookupNode', lambda self, name: 'http://localhost:1/')
    monkeypatch.setattr(rosgraph.Master, 'lookupService', look_up)
    said = reachability._silence('/turtle1/pose', '/turtlesim')
    told = '/turtlesim is registered at http://localhost:1/, but does not answer there; rosnode cleanup'
    assert (told in said) is ended
    assert ('no connection exists' in said) is not ended
