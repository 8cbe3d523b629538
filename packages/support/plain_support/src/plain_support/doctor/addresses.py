"""The address that this machine's nodes announce to a ROS master, and why it may be wrong."""
import os
import socket
from typing import Mapping, NamedTuple, Optional
from urllib.parse import urlsplit

from plain_support.doctor import findings
from plain_support.doctor.findings import Finding

HOSTNAME, IP, MASTER_URI = 'ROS_HOSTNAME', 'ROS_IP', 'ROS_MASTER_URI'
DEFAULT_MASTER = 'http://localhost:11311'
LOOPBACK = '127.'


class MasterAddress(NamedTuple):
    """The address of a master."""

    uri: str
    host: str
    port: int


def master_address(environment: Mapping[str, str] = os.environ) -> Optional[MasterAddress]:
    """Return the address of the master; None if ROS_MASTER_URI is not a valid URI."""
    uri = environment.get(MASTER_URI) or DEFAULT_MASTER
    try:
        parts = urlsplit(uri)
        port = parts.port
    except ValueError:
        return None
    if parts.scheme != 'http' or not parts.hostname or not port:
        return None
    return MasterAddress(uri, parts.hostname, port)


def announced(environment: Mapping[str, str] = os.environ) -> str:
    """Return the address or name that other nodes use to reach the nodes of this machine."""
    return environment.get(HOSTNAME) or environment.get(IP) or socket.gethostname()


def source(environment: Mapping[str, str] = os.environ) -> str:
    """Return where the announced address comes from."""
    return next((name for name in (HOSTNAME, IP) if environment.get(name)), "this machine's host name")


def is_here(host: str) -> bool:
    """Return whether a host is this machine: only its own addresses can be bound."""
    try:
        address = socket.gethostbyname(host or ' ')
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind((address, 0))
    except (OSError, UnicodeError):
        return False
    return True


def remedy(master: str, environment: Mapping[str, str] = os.environ) -> str:
    """Return the line to type: it announces the address of this machine that the master's host can reach."""
    unset = f'unset {HOSTNAME}; ' if HOSTNAME in environment else ''
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect((master, 9))  # sends nothing, but chooses the route
            address = probe.getsockname()[0]
    except OSError:
        address = 'ADDRESS (hostname -I shows those of this machine)'
    return f'type {unset}export ROS_IP={address}, and start it again'


def wrong_address(environment: Mapping[str, str] = os.environ) -> Optional[Finding]:
    """Return the finding that nodes on other machines cannot reach those of this one; None if they can."""
    master = master_address(environment)
    host, name = master.host if master else 'localhost', announced(environment)
    origin, cure = source(environment), remedy(host, environment)
    try:
        address = socket.gethostbyname(name)
    except (OSError, UnicodeError):
        return findings.name_without_address(origin, name, cure)
    if not is_here(address):
        return findings.address_not_here(origin, name, cure)
    if address.startswith(LOOPBACK) and not is_here(host):
        return findings.address_only_here(origin, name, host, cure)
    return None
