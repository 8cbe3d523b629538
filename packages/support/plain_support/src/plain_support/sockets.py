"""Find the process at the other end of a TCP connection of this machine, as the kernel says. Linux.

A name or number that a peer sends is not reliable: it may belong to another namespace, or be a lie. The TABLES have a
line for each socket of this process's network, with its user and inode, and ``/proc/PID/fd`` has a link to the inode of
each socket that a process holds.
"""
import contextlib
import glob
import ipaddress
import os
import socket
import sys
from typing import Iterable, Iterator, List, NamedTuple, Optional, Tuple

TABLES = '/proc/self/net/tcp', '/proc/self/net/tcp6'  # IPv4 through an IPv6 socket is in the second one
LOCAL, REMOTE, STATE, USER, INODE = 1, 2, 3, 7, 9  # columns
LISTENS = '0A'  # a state


class Peer(NamedTuple):
    """The socket at the other end: its inode, 0 if no process holds it any more, and the user who has opened it."""

    inode: int
    user: int


def rows(table: str) -> Iterator[List[str]]:
    """Yield the columns of each socket of a table, none if that does not exist."""
    with contextlib.suppress(OSError), open(table, encoding='ascii') as file:
        next(file)
        for line in file:
            yield line.split()


def peer(connection: socket.socket) -> Optional[Peer]:
    """Return the Peer of a TCP connection, or None: it has gone, or is on another machine."""
    with contextlib.suppress(OSError, ValueError):
        here, there = _known(connection.getsockname()), _known(connection.getpeername())
        for table in TABLES * 2:  # the kernel may skip a line while connections come and go
            for columns in rows(table):
                if (columns[LOCAL].endswith(f':{there[1]:04X}') and columns[STATE] != LISTENS
                        and parsed(columns[LOCAL]) == there and parsed(columns[REMOTE]) == here):
                    return Peer(int(columns[INODE]), int(columns[USER]))
    return None


def peer_process(connection: socket.socket) -> Optional[int]:
    """Return the number of the process at the other end, the lowest of several; None if that cannot be found."""
    found = peer(connection)
    pids = sorted(int(path.split('/')[2]) for path in glob.glob('/proc/[0-9]*')) if found and found.inode else []
    return next((pid for pid in pids if found and holds([pid], found.inode)), None)


def holds(pids: Iterable[int], inode: int) -> bool:
    """Return whether one of some processes holds a socket."""
    link = f'socket:[{inode}]'
    for pid in pids:
        folder = f'/proc/{pid}/fd'
        with contextlib.suppress(OSError):
            for name in os.listdir(folder):
                with contextlib.suppress(OSError):  # closed meanwhile
                    if os.readlink(f'{folder}/{name}') == link:
                        return True
    return False


def parsed(text: str) -> Tuple[str, int]:
    """Return (host, port) of an address in a table, an IPv4 address always as such."""
    host, _, port = text.partition(':')
    words = [int(host[start:start + 8], 16).to_bytes(4, sys.byteorder) for start in range(0, len(host), 8)]
    return _plain(ipaddress.ip_address(b''.join(words))), int(port, 16)


def _known(address: Tuple[object, ...]) -> Tuple[str, int]:
    """Return (host, port) of a socket's address, an IPv4 address always as such."""
    return _plain(ipaddress.ip_address(str(address[0]).partition('%')[0])), int(str(address[1]))


def _plain(address: 'ipaddress.IPv4Address | ipaddress.IPv6Address') -> str:
    return str(getattr(address, 'ipv4_mapped', None) or address)
