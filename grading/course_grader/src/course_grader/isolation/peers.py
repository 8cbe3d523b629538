"""Which process holds the other end of a connection on this machine, as the kernel says: a name in a message is free.

``/proc/net/tcp`` has a line for each socket of this network, with its user and inode, and ``/proc/PID/fd`` a link to
the inode of each socket that a process holds. Without ROS.
"""
import contextlib
import ipaddress
import os
import socket
import sys
from typing import Iterable, NamedTuple, Optional, Tuple

TABLES = '/proc/net/tcp', '/proc/net/tcp6'  # IPv4 through an IPv6 socket is in the second one
LOCAL, REMOTE, STATE, USER, INODE = 1, 2, 3, 7, 9  # columns of a line
LISTENS = '0A'


class Peer(NamedTuple):
    """The socket at the other end: its inode, 0 if no process holds it any more, and the user who has opened it."""

    inode: int
    user: int


def of(connection: socket.socket) -> Optional[Peer]:
    """Return the Peer of a TCP connection, or None: it has gone, or is on another machine."""
    with contextlib.suppress(OSError, ValueError):
        here, there = _known(connection.getsockname()), _known(connection.getpeername())
        for table in TABLES * 2:  # the kernel may skip a line while connections come and go
            with contextlib.suppress(FileNotFoundError), open(table, encoding='ascii') as file:
                for line in file:
                    columns = line.split()
                    if (columns[LOCAL].endswith(f':{there[1]:04X}') and columns[STATE] != LISTENS
                            and _parsed(columns[LOCAL]) == there and _parsed(columns[REMOTE]) == here):
                        return Peer(int(columns[INODE]), int(columns[USER]))
    return None


def holds(pids: Iterable[int], inode: int) -> bool:
    """Return whether one of some processes holds a socket."""
    wanted = f'socket:[{inode}]'
    for pid in pids:
        folder = f'/proc/{pid}/fd'
        with contextlib.suppress(OSError):
            for name in os.listdir(folder):
                with contextlib.suppress(OSError):  # closed meanwhile
                    if os.readlink(f'{folder}/{name}') == wanted:
                        return True
    return False


def _known(address: Tuple[object, ...]) -> Tuple[str, int]:
    """Return (host, port) of a socket's address, an IPv4 address always as such."""
    return _plain(ipaddress.ip_address(str(address[0]).partition('%')[0])), int(str(address[1]))


def _parsed(text: str) -> Tuple[str, int]:
    """Return the same of an address of the table, whose 32 bit words are in the order of this machine."""
    host, _, port = text.partition(':')
    words = [int(host[start:start + 8], 16).to_bytes(4, sys.byteorder) for start in range(0, len(host), 8)]
    return _plain(ipaddress.ip_address(b''.join(words))), int(port, 16)


def _plain(address: 'ipaddress.IPv4Address | ipaddress.IPv6Address') -> str:
    return str(getattr(address, 'ipv4_mapped', None) or address)
