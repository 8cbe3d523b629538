"""SlaveGuard: only processes of the grading command its nodes; every call of others is refused, and told."""
import os
import subprocess
import sys
import threading
import xmlrpc.client

import pytest
import rosgraph.xmlrpc

from course_grader.attempt.slave_guard import SlaveGuard
from rospy_support import inbound
from rospy_support.slave_server import SlaveServer

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
def node(monkeypatch):
    monkeypatch.setattr(SlaveServer, 'allows', SlaveServer.allows)
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
    guard = SlaveGuard()
    assert '-1' in called(node, call) and node.done == []
    assert f'called {method} of a node of the grader' in guard.refused() == guard.refused()


def test_own_and_trusted_processes_call_and_everybody_asks(node):
    guard = SlaveGuard()
    own = xmlrpc.client.ServerProxy(node.uri)
    own.publisherUpdate('/master', '/clock', [])
    called(node, 'node.getPid("/x")')
    assert node.done == ['publisherUpdate', 'getPid'] and guard.refused() == ''


def test_call_of_another_user_is_refused_and_not_the_fault_of_the_program(node):
    guard = SlaveGuard(user=os.getuid() + 1)
    called(node, 'node.shutdown("/x", "bye")')
    assert node.done == [] and guard.refused() == ''
