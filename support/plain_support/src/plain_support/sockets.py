"""Find the process at the other end of a TCP connection of this machine. Linux.

A process number that a peer sends is not reliable: it may belong to another namespace, or be a lie.
"""
import glob
import os
import re
import socket
from typing import Optional, Tuple

TABLES = '/proc/self/net/tcp', '/proc/self/net/tcp6'  # of this process's network
LINE = re.compile(r' *\d+: (\w+):(\w+) (\w+):(\w+) \w+ \S+ \S+ \w+ +(\d+) +\d+ +(\d+)')  # ends, user, inode


def peer_process(connection: socket.socket) -> Optional[int]:
    """Return the number of the process at the other end, the lowest of several; None if that cannot be found."""
    found = peer(connection)
    if found is None:
        return None
    link = f'socket:[{found[1]}]'
    numbers = set()
    for path in glob.iglob('/proc/[0-9]*/fd/*'):
        try:
            if os.readlink(path) == link:
                numbers.add(int(path.split('/')[2]))
        except OSError:
            continue
    return min(numbers, default=None)


def peer(connection: socket.socket) -> Optional[Tuple[int, int]]:
    """Return (user, inode) of the socket at the other end of a connection over IPv4; None if it is not here."""
    wanted = (_written(connection.getpeername()), _written(connection.getsockname()))
    for table in TABLES:
        try:
            with open(table, encoding='ascii') as file:
                lines = file.readlines()[1:]
        except OSError:
            continue
        for line in lines:
            match = LINE.match(line)
            if match and ((match[1][-8:], match[2]), (match[3][-8:], match[4])) == wanted:
                return int(match[5]), int(match[6])
    return None


def _written(address: Tuple[str, int]) -> Tuple[str, str]:
    """Return an address as Linux writes it: the bytes of a number in the machine's order; IPv6's end with them."""
    number = int.from_bytes(socket.inet_aton(address[0]), 'little')
    return f'{number:08X}', f'{address[1]:04X}'
