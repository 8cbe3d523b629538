"""rospy_support.own_master: real masters, and failed starts."""
import os
import socket
import xmlrpc.client

import pytest

from plain_support.processes import BackgroundProcess
from rospy_support import own_master, ports

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def at_home(monkeypatch, tmp_path):
    """Masters of this machine, with their logs in the test's folder."""
    monkeypatch.setenv('ROS_HOSTNAME', 'localhost')
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))


def starter(tmp_path, program=None):
    return lambda command: BackgroundProcess(program or command, str(tmp_path / 'master.log'))


def test_a_master_lasts_as_long_as_the_with_statement(tmp_path):
    with own_master.own_master(str(tmp_path / 'master.log')) as master:
        assert xmlrpc.client.ServerProxy(master.uri).getPid('/test')[2] == master.process.pid
    assert not master.process.runs()
    with pytest.raises(OSError):
        xmlrpc.client.ServerProxy(master.uri).getPid('/test')


def test_a_port_that_is_taken_meanwhile_is_left_for_another(tmp_path, monkeypatch):
    free = ports.free_port()
    with socket.socket() as taken:
        taken.bind(('localhost', 0))
        taken.listen()
        given = iter([taken.getsockname()[1], free])
        monkeypatch.setattr(own_master, 'free_port', lambda: next(given))
        master = own_master.start_master(starter(tmp_path))
    with master.process:
        assert master.uri == f'http://localhost:{free}'


def test_a_master_starts_again_on_its_port(tmp_path):
    first = own_master.start_master(starter(tmp_path))
    first.process.stop()
    again = own_master.start_master(starter(tmp_path), int(first.uri.rsplit(':', 1)[1]))
    again.process.stop()
    assert again.uri == first.uri


def test_no_master_is_explained(tmp_path):
    program = ['sh', '-c', 'echo no module named rosmaster; exec sleep 60']
    with pytest.raises(own_master.MasterError, match='no ROS master answered within 2 s; .*no module'):
        own_master.start_master(starter(tmp_path, program), patience=2.0)


def test_no_free_port_is_explained(tmp_path, monkeypatch):
    with socket.socket() as taken:
        taken.bind(('localhost', 0))
        monkeypatch.setattr(ports, 'PORTS', range(taken.getsockname()[1], taken.getsockname()[1] + 1))
        with pytest.raises(own_master.MasterError, match='there is no free port'):
            own_master.start_master(starter(tmp_path))
    assert not os.path.exists(tmp_path / 'master.log')
