"""A client that drives and goes away, or stalls, is stopped once."""
from browser_servers.core.deadman import Deadman


def test_silent_client_is_stopped_once():
    deadman = Deadman(0.5)
    deadman.heard(10.0)
    deadman.drove('/cmd_vel', False)
    assert deadman.expired(10.5) == []
    assert deadman.expired(10.51) == ['/cmd_vel']
    assert deadman.expired(11.0) == []


def test_messages_keep_it_going():
    deadman = Deadman(0.5)
    deadman.drove('/cmd_vel', False)
    for tick in range(100):
        deadman.heard(tick * 0.4)
        assert deadman.expired(tick * 0.4 + 0.39) == []


def test_client_that_has_stopped_itself_is_left_alone():
    deadman = Deadman(0.5)
    deadman.heard(0.0)
    deadman.drove('/cmd_vel', False)
    deadman.drove('/cmd_vel', True)
    assert deadman.expired(100.0) == [] and deadman.gone() == []


def test_client_that_goes_away_is_stopped_on_all_topics():
    deadman = Deadman(0.5)
    for topic in ('/b', '/a'):
        deadman.drove(topic, False)
    assert deadman.gone() == ['/a', '/b']


def test_without_a_timeout_nobody_is_stopped_until_the_client_asks():
    deadman = Deadman()
    deadman.heard(0.0)
    deadman.drove('/cmd_vel', False)
    assert not deadman.watching and deadman.expired(9.0) == [] and deadman.gone() == []
    deadman.timeout = 0.5
    assert deadman.watching and deadman.gone() == ['/cmd_vel']


def test_moving_topics_are_those_whose_last_velocity_was_not_zero():
    deadman = Deadman()
    deadman.drove('/a', False)
    deadman.drove('/b', False)
    deadman.drove('/a', True)
    assert deadman.moving == {'/b'}
