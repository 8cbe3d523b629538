"""Guard: only processes of the grading command its nodes, and what other users say over ROS does not arrive."""
import http.client
import os
import subprocess
import sys
import threading
import xmlrpc.client

import pytest
import rosgraph.xmlrpc
from rospy.exceptions import TransportInitError
from rospy.impl import tcpros_base
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_service import TCPROSServiceClient
from std_srvs.srv import Trigger

from course_grader.attempt import guard
from course_grader.attempt.guard import Guard
from plain_support import sockets
from rospy_support import inbound
from rospy_support.rospy_internals.topics import HOLDER
from rospy_support.slave_server import SlaveServer

pytestmark = pytest.mark.slow

ANSWERS = '''
import socket, sys
import rosgraph.network
with socket.create_server(('127.0.0.1', 0)) as listening:
    print(listening.getsockname()[1], flush=True)
    connection, _ = listening.accept()
    rosgraph.network.read_ros_handshake_header(connection, __import__('io').BytesIO(), 4096)
    header = {'callerid': '/x', 'md5sum': '*', 'type': '*', '_holder': 'the grading'}
    connection.sendall(rosgraph.network.encode_ros_handshake_header(header))
    sys.stdin.read()
'''
MASTER = '''
import functools, subprocess, sys
from course_grader.attempt import forked
from course_grader.attempt.guard import Guard
from course_grader.isolation import levels
SETS = """
import sys, xmlrpc.client
try:
    print(xmlrpc.client.ServerProxy(sys.argv[1]).setParam("/x", "/speed", 1)[::2], flush=True)
except OSError:
    print("refused", flush=True)
"""
program, other = levels.USERS[-2:]
master, uri = forked.start_master(sys.argv[1], 20.0, Guard(program).admits)
for user in (0, program, other):
    subprocess.run(['/usr/bin/python3', '-c', SETS, uri], cwd='/', preexec_fn=functools.partial(levels.become, user))
master.process.kill()
'''
CALLS = 'import sys, xmlrpc.client as c; print(eval(sys.argv[2], {"node": c.ServerProxy(sys.argv[1]), "c": c}))'


class Node(rosgraph.xmlrpc.XmlRpcHandler):
    """A slave API that counts."""

    def __init__(self):
        self.done = []

    def _ready(self, uri):
        self.uri = uri

    def publisherUpdate(self, caller, topic, uris):
        """Count."""
        self.done.append('publisherUpdate')
        return 1, '', 0

    def shutdown(self, caller, why=''):
        """Count."""
        self.done.append('shutdown')
        return 1, '', 0

    def getPid(self, caller):
        """Count."""
        self.done.append('getPid')
        return 1, '', 7


@pytest.fixture
def guarded(monkeypatch):
    """Restore what a Guard replaces."""
    for owner, name in (SlaveServer, 'allows'), (inbound.SocketWatch, 'admits'), (TCPROSTransport, 'connect'):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    monkeypatch.setattr(tcpros_base, '_is_use_tcp_keepalive', lambda: False)  # which asks the master


@pytest.fixture
def node(guarded):
    server = SlaveServer(inbound.SocketWatch(lambda *texts: None), ('127.0.0.1', 0))
    handler = Node()
    server.register_instance(handler)
    server.register_multicall_functions()
    threading.Thread(target=server.serve_forever, daemon=True).start()
    handler.uri = f'http://127.0.0.1:{server.server_address[1]}/'
    yield handler
    server.server_close()


def called(node, text):
    """Return what a call from another process answers."""
    return subprocess.run([sys.executable, '-c', CALLS, node.uri, text], stdout=subprocess.PIPE, check=True,
                          text=True, timeout=60).stdout.strip()


@pytest.mark.parametrize('call, method', [
    ('node.publisherUpdate("/master", "/clock", [])', 'publisherUpdate'), ('node.shutdown("/x", "bye")', 'shutdown'),
    ('node.system.multicall([{"methodName": "shutdown", "params": ["/x"]}])', 'system.multicall')])
def test_call_of_another_process_changes_nothing_and_is_told(node, call, method):
    guard = Guard()
    assert '-1' in called(node, call) and node.done == []
    assert f'called {method} of a node of the grader' in guard.refused().text


def test_own_and_trusted_processes_call_and_everybody_asks(node):
    guard = Guard()
    own = xmlrpc.client.ServerProxy(node.uri)
    own.publisherUpdate('/master', '/clock', [])
    called(node, 'node.getPid("/x")')
    assert node.done == ['publisherUpdate', 'getPid'] and guard.refused() is None


def test_call_of_another_user_is_refused_and_not_the_fault_of_the_program(node):
    guard = Guard(user=os.getuid() + 1)
    called(node, 'node.shutdown("/x", "bye")')
    assert node.done == [] and guard.refused() is None


@pytest.fixture
def of_somebody_else(guarded, monkeypatch):
    """Guard as if this user were neither the program's nor the grading's."""
    monkeypatch.setattr(os, 'geteuid', lambda: os.getuid() + 1)
    return Guard(user=os.getuid() + 2)


def test_connection_of_somebody_else_is_closed(node, of_somebody_else):
    with pytest.raises((ConnectionError, http.client.HTTPException)):
        xmlrpc.client.ServerProxy(node.uri).getPid('/x')
    assert node.done == [] and of_somebody_else.refused() is None


@pytest.fixture
def service():
    """Yield the address of a service that answers every header, in a process of its own."""
    with subprocess.Popen([sys.executable, '-c', ANSWERS], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          text=True) as process:
        yield '127.0.0.1', int(process.stdout.readline())
        process.kill()


def connected(address):
    transport = TCPROSTransport(TCPROSServiceClient('/turtle_command', Trigger), '/turtle_command')
    transport.connect(*address, 'rosrpc://x')
    transport.close()
    return transport.header[HOLDER]


def test_who_answers_is_known_whatever_the_header_says(guarded, service):
    Guard(user=os.getuid())
    assert connected(service) == guard.PROGRAM


def test_own_process_is_not_the_program(guarded, service, monkeypatch):
    monkeypatch.setattr(sockets, 'holds', lambda pids, inode: True)
    Guard(user=os.getuid())
    assert connected(service) == guard.GRADING


def test_answer_of_somebody_else_is_not_taken(of_somebody_else, service):
    with pytest.raises(TransportInitError, match='somebody else'):
        connected(service)


@pytest.mark.skipif(os.geteuid() != 0, reason='needs root, as the level uid')
def test_master_serves_the_program_and_the_grading_and_no_other_user(tmp_path):
    done = subprocess.run([sys.executable, '-c', MASTER, str(tmp_path / 'master.txt')], stdout=subprocess.PIPE,
                          check=True, text=True, timeout=60)
    assert done.stdout.split('\n')[:-1] == ['[1, 0]', '[1, 0]', 'refused']
