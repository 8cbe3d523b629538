"""rospy_support.ports: a port for a master."""
import socket

import pytest

from rospy_support import ports


def test_a_taken_port_is_not_given(monkeypatch):
    with socket.socket() as taken:
        taken.bind(('localhost', 0))
        monkeypatch.setattr(ports, 'PORTS', range(taken.getsockname()[1], taken.getsockname()[1] + 1))
        with pytest.raises(OSError, match='there is no free port from'):
            ports.free_port()


def test_a_port_can_be_used():
    with socket.socket() as server:
        server.bind(('localhost', ports.free_port()))
