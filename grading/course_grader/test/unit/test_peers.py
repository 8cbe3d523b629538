"""Peers: who holds the other end of a connection, as the kernel says."""
import os
import socket
import subprocess
import sys

import pytest

from course_grader.isolation import peers

CONNECTS = '''
import socket, sys
family, host, port = int(sys.argv[1]), sys.argv[2], int(sys.argv[3])
connection = socket.socket(family)
connection.connect((host, port))
sys.stdin.read()
'''


@pytest.mark.parametrize('family, host', [(socket.AF_INET, '127.0.0.1'), (socket.AF_INET6, '::ffff:127.0.0.1')])
def test_other_process_holds_the_connection(family, host):
    with socket.socket() as listening:
        listening.bind(('127.0.0.1', 0))
        listening.listen()
        port = listening.getsockname()[1]
        child = subprocess.Popen([sys.executable, '-c', CONNECTS, str(int(family)), host, str(port)],
                                 stdin=subprocess.PIPE)
        with child, listening.accept()[0] as connection:
            peer = peers.of(connection)
            assert peer.user == os.getuid()
            assert peers.holds([child.pid], peer.inode) and not peers.holds([os.getpid()], peer.inode)


def test_own_process_holds_the_connection_and_nobody_one_that_was_closed():
    with socket.socket() as listening:
        listening.bind(('127.0.0.1', 0))
        listening.listen()
        client = socket.create_connection(listening.getsockname())
        with listening.accept()[0] as connection:
            assert peers.holds([os.getpid()], peers.of(connection).inode)
            client.close()
            peer = peers.of(connection)
            assert peer is None or not peer.inode
