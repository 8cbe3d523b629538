"""rospy_support.reachability: what is wrong with a node's address, and which topics stay unconnected."""
import pytest
import rosgraph
import rospy

from rospy_support import reachability, rospy_internals

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
    monkeypatch.setattr(rospy_internals, 'get_topic_manager', lambda: Manager(published, subscribed))
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    monkeypatch.setattr(rosgraph.Master, 'getSystemState', lambda self: (*state, []))
    assert reachability.unconnected() == found
