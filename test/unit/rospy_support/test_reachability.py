"""rospy_support.reachability: what is wrong with a node's address, and which topics stay unconnected."""
import socket

import pytest
import rosgraph
import rospy

from rospy_support import reachability, rospy_internals

NODE = '/laptop/node'
NO_ADDRESS = '10.88.0.9'  # none of a machine that runs tests


@pytest.mark.parametrize('environment, master, said', [
    ({'ROS_HOSTNAME': 'localhost'}, 'localhost', ''),
    ({'ROS_IP': '127.0.0.1'}, '127.0.0.1', ''),
    ({'ROS_HOSTNAME': 'localhost'}, NO_ADDRESS,
     f'The master is on another machine ({NO_ADDRESS}), but ROS_HOSTNAME is localhost, which other machines cannot'),
    ({'ROS_IP': '127.0.0.1'}, NO_ADDRESS, f'The master is on another machine ({NO_ADDRESS}), but ROS_IP is 127.0.0.1'),
    ({'ROS_IP': NO_ADDRESS}, 'localhost', f'ROS_IP is {NO_ADDRESS}, but this machine has the addresses '),
    ({'ROS_HOSTNAME': 'no-such-name'}, 'localhost', "ROS_HOSTNAME is 'no-such-name', a name that has no address"),
    ({'ROS_HOSTNAME': 'x' * 70}, 'localhost', f"ROS_HOSTNAME is {'x' * 70!r}, a name that has no address"),
])
def test_wrong_addresses_are_named(monkeypatch, environment, master, said):
    lookup = socket.gethostbyname
    monkeypatch.setattr(socket, 'gethostbyname', lambda name: lookup(name if name != 'no-such-name' else 'x' * 70))
    for name in ('ROS_HOSTNAME', 'ROS_IP'):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv('ROS_MASTER_URI', f'http://{master}:11311')
    text = reachability.wrong_address()
    assert text.startswith(said) and bool(text) == bool(said)
    if said:
        assert 'export ROS_IP=' in text and ('unset ROS_HOSTNAME' in text) == ('ROS_HOSTNAME' in environment)


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
