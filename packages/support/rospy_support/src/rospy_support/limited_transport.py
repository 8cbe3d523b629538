"""XML-RPC with a timeout.

The fault: xmlrpc.client has none, so a node waits forever for a master that hangs or is suspended.
"""
import http.client
import xmlrpc.client
from typing import Any


class LimitedTransport(xmlrpc.client.Transport):
    """HTTP with a timeout of ``limit`` [s] for connecting and for each answer; one thread at a time uses it."""

    def __init__(self, limit: float) -> None:
        super().__init__()
        self.limit = limit

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return the open connection, or a new one."""
        connection = super().make_connection(host)
        connection.timeout = self.limit
        return connection
