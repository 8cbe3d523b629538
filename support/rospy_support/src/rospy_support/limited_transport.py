"""XML-RPC with a time limit.

The fault: xmlrpc.client has none, so a node waits for a master that hangs, for example one that is stopped, for ever.
"""
import http.client
import xmlrpc.client
from typing import Any


class LimitedTransport(xmlrpc.client.Transport):
    """HTTP in which connecting and each answer take at most ``limit`` [s]; one thread at a time uses it."""

    def __init__(self, limit: float) -> None:
        super().__init__()
        self.limit = limit

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return the connection that stays open, or a new one."""
        connection = super().make_connection(host)
        connection.timeout = self.limit
        return connection
