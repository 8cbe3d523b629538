"""sim_ros.subscriber_backlog: messages that wait in sockets."""
import socket

import pytest

from sim_ros import subscriber_backlog

TABLE = '''  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
   0: 0100007F:1F90 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 1 1 0000000000000000 100 0 0
   1: 0100007F:D431 0100007F:1F90 01 00000000:00000190 00:00000000 00000000     0        0 2 1 0000000000000000 20 4 30
   2: 0100007F:1F90 0100007F:D431 01 000000FF:00000000 00:00000000 00000000     0        0 3 1 0000000000000000 20 4 30
'''


class Connection:
    def __init__(self, endpoint_id, connected):
        self.endpoint_id, self.socket = endpoint_id, connected


class Publisher:
    def __init__(self, *connections):
        self.impl = self
        self.connections = connections


def test_rows_of_a_table():
    queues = subscriber_backlog.receive_queues(TABLE.splitlines())
    assert queues == {(8080, 0): 0, (0xD431, 8080): 0x190, (8080, 0xD431): 0}


@pytest.mark.parametrize('family, host', [(socket.AF_INET, '127.0.0.1'), (socket.AF_INET6, '::1')])
def test_unread_messages_of_a_real_connection(family, host):
    with socket.create_server((host, 0), family=family) as server, socket.create_connection(
            server.getsockname()[:2]) as reader:
        writer, _ = server.accept()
        with writer, socket.socket() as closed:
            publisher = Publisher(Connection('/slow', writer), Connection('/gone', closed), Connection('/left', None))
            assert subscriber_backlog.unread(publisher, 12) == {'/slow': 0}
            writer.sendall(b'.' * (12 * 30 + 5))
            assert subscriber_backlog.unread(publisher, 12) == {'/slow': 30}
            reader.recv(12 * 10)
            assert subscriber_backlog.unread(publisher, 12) == {'/slow': 20}


def test_nobody_subscribes():
    assert subscriber_backlog.unread(Publisher(), 12) == {}
    publisher = Publisher()
    publisher.impl = None  # unregistered
    assert subscriber_backlog.unread(publisher, 12) == {}


def test_a_lag_monitor_counts_looks_and_names_who_is_behind(monkeypatch):
    wall, unread = [100.0], {'/on_time': 10, '/slow': 11, '/slower': 25}  # a lag of 0.2 s is 10 steps of 0.02 s
    monkeypatch.setattr(subscriber_backlog.time, 'monotonic', lambda: wall[0])
    monkeypatch.setattr(subscriber_backlog, 'unread', lambda clock, size: unread)
    monitor = subscriber_backlog.LagMonitor('/clock', 12, 0.02)
    assert monitor.lag() == pytest.approx(0.5)
    assert (monitor.late, monitor.busy) == (1, '/slow, /slower')
    wall[0] += 0.09
    assert monitor.lag() == 0.0 and monitor.late == 1  # no look is due
    wall[0] += 0.02
    assert monitor.lag() == pytest.approx(0.5) and monitor.late == 2
    wall[0] += 0.11
    unread = {'/slow': 10}
    assert monitor.lag() == 0.0
    assert (monitor.late, monitor.busy) == (2, '/slow, /slower')  # the last that were behind
