"""Find out whether a registered node is still running, over TCP and without ROS.

An open port is not enough, because another node may have it now. But every node offers the service ~get_loggers, and
in its handshake a node says whether it offers a service of this name.
"""
import socket
import struct
from typing import Dict, Optional
from urllib.parse import urlsplit

SIGN = 'get_loggers'  # the service of every node, below its name
MAX_HEADER = 1 << 16  # [bytes]
CALLER = '/ros_doctor'


def offers(name: str, uri: str, timeout: float) -> bool:
    """Return whether the service ``name`` is offered at ``uri`` (rosrpc://HOST:PORT), within ``timeout`` [s]."""
    try:
        address = urlsplit(uri)
        with socket.create_connection((address.hostname or '', address.port or 0), timeout) as connection:
            connection.settimeout(timeout)
            connection.sendall(_header({'probe': '1', 'md5sum': '*', 'callerid': CALLER, 'service': name}))
            fields = _read_header(connection)
    except (OSError, ValueError):
        return False
    return fields is not None and 'error' not in fields and 'md5sum' in fields


def _header(fields: Dict[str, str]) -> bytes:
    lines = [f'{key}={value}'.encode() for key, value in fields.items()]
    body = b''.join(struct.pack('<I', len(line)) + line for line in lines)
    return struct.pack('<I', len(body)) + body


def _read_header(connection: socket.socket) -> Optional[Dict[str, str]]:
    size, = struct.unpack('<I', _receive(connection, 4))
    if size > MAX_HEADER:
        return None
    body, fields = _receive(connection, size), {}
    while len(body) >= 4:
        length, = struct.unpack_from('<I', body)
        key, _, value = body[4:4 + length].decode(errors='replace').partition('=')
        fields[key], body = value, body[4 + length:]
    return fields


def _receive(connection: socket.socket, size: int) -> bytes:
    data = b''
    while len(data) < size:
        part = connection.recv(size - len(data))
        if not part:
            raise ConnectionError('closed before it had answered')
        data += part
    return data
