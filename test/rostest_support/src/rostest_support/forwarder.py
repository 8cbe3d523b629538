"""Connections that are forwarded to another address."""
import contextlib
import socket
import threading

from rostest_support.waiting import until


class Forwarder:
    """Forwards connections to the address ``there``, (host, port), as a container engine or a proxy does.

    While ``stalled`` is set, nothing passes: a network that stands still. Its threads use the network of the thread
    that makes it.
    """

    def __init__(self, there, port=0):
        """``port`` of this machine, to connect to; 0: a free one."""
        self.stalled, self._there = threading.Event(), there
        self._server = socket.create_server(('127.0.0.1', port))
        self.port = self._server.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):  # it is closed
            while True:
                client = self._server.accept()[0]
                server = socket.create_connection(self._there)
                threading.Thread(target=self._serve, args=(client, server), daemon=True).start()

    def _serve(self, client, server):
        threading.Thread(target=self._copy, args=(client, server), daemon=True).start()
        self._copy(server, client)

    def _copy(self, source, destination):
        with source, destination, contextlib.suppress(OSError):
            while True:
                data = source.recv(65536)
                until(lambda: not self.stalled.is_set(), 'the network', 60.0)
                if not data:
                    return
                destination.sendall(data)

    def close(self):
        """Accept no more."""
        self.stalled.clear()
        self._server.close()
