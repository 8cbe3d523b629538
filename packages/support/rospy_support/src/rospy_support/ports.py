"""A free port for a private ROS master."""
import random
import socket

PORTS = range(20000, 32000)  # below the ports that Linux assigns to clients


def free_port() -> int:
    """Return a free port of this machine; raise OSError if none is free."""
    for _ in range(200):
        port = random.SystemRandom().choice(PORTS)
        with socket.socket() as probe:
            try:
                probe.bind(('localhost', port))
                return port
            except OSError:
                continue
    raise OSError(f'there is no free port from {PORTS.start} to {PORTS.stop - 1} for a ROS master')
