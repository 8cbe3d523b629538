"""Which vehicles of a client need a zero velocity; test_session.py holds when they are stopped."""
import pytest

from browser_servers.core.deadman import Deadman


def test_messages_keep_it_going():
    deadman = Deadman(0.5)
    deadman.drove('/cmd_vel', False)
    for tick in range(100):
        deadman.heard(tick * 0.4)
        assert deadman.expired(tick * 0.4 + 0.39) == []


@pytest.mark.parametrize('drives, moving', [
    ([('/b', False), ('/a', False)], ['/a', '/b']), ([('/a', False), ('/b', False), ('/a', True)], ['/b']),
    ([('/a', False), ('/a', True)], [])])
def test_a_client_that_goes_is_stopped_once_where_its_last_velocity_was_not_zero(drives, moving):
    deadman = Deadman(0.5)
    for topic, zero in drives:
        deadman.drove(topic, zero)
    assert deadman.moving == set(moving)
    assert deadman.gone() == moving and deadman.gone() == []
