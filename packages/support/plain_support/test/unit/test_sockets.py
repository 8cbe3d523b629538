"""plain_support.sockets: who is at the other end, whatever it says."""
import os
import socket
import subprocess
import sys

import pytest

from plain_support import sockets

CLIENT = '''
import socket, sys
with socket.socket(getattr(socket, sys.argv[2])) as client:
    client.connect((sys.argv[3], int(sys.argv[1])))
    client.sendall(b'.')
    sys.stdin.read()
'''


@pytest.mark.parametrize('family, address', [('AF_INET', '127.0.0.1'), ('AF_INET6', '::ffff:127.0.0.1')])
def test_the_process_of_a_peer(family, address):
    with socket.create_server(('127.0.0.1', 0)) as server:
        port = server.getsockname()[1]
        with subprocess.Popen([sys.executable, '-c', CLIENT, str(port), family, address],
                              stdin=subprocess.PIPE) as client:
            connection, _ = server.accept()
            with connection:
                assert connection.recv(1) == b'.'
                assert sockets.peer_process(connection) == client.pid
                peer = sockets.peer(connection)
                assert peer.user == os.geteuid()
                assert sockets.holds([client.pid], peer.inode) and not sockets.holds([os.getpid()], peer.inode)
                client.stdin.close()
                client.wait()
                assert sockets.peer_process(connection) is None
                peer = sockets.peer(connection)
                assert peer is None or not peer.inode  # nobody holds it
