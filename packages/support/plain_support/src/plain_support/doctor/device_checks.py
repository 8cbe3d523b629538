"""The display and the cameras."""
import os
import re
import socket
from typing import Iterator, List

from plain_support.doctor import addresses, devices, findings, processes
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Check, Machine

ANSWER_TIME = 2.0  # [s] for a display on another machine
FIRST_PORT = 6000  # of X servers
SOCKET = '/tmp/.X11-unix/X'


def display(machine: Machine) -> Iterator[Finding]:
    """The X server that DISPLAY names; DISPLAY need not be set."""
    name = machine.environment.get('DISPLAY', '')
    if name and not _answers(name):
        yield findings.dead_display(name)


def _answers(display: str) -> bool:
    parts = re.fullmatch(r'(?:unix/?)?([^:]*):(\d+)(?:\.\d+)?', display)
    if parts is None:
        return False
    host, number = parts[1], int(parts[2])
    try:
        if host:
            socket.create_connection((host, FIRST_PORT + number), ANSWER_TIME).close()
            return True
    except OSError:
        return False
    for address in (f'{SOCKET}{number}', f'\0{SOCKET}{number}'):
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(ANSWER_TIME)
            if client.connect_ex(address) == 0:
                return True
    return False


def cameras(_: Machine) -> Iterator[Finding]:
    """Cameras that this user may not open, or that a program other than a ROS node has open."""
    ours = {process.pid for process in processes.all_processes() if addresses.MASTER_URI in process.environment}
    for path, _name in devices.devices():
        said = devices.trouble(path)
        holders = {pid for pid, _ in devices.users(path)}
        if said and not (holders and holders <= ours and os.access(path, os.R_OK | os.W_OK)):
            yield findings.camera_unusable(said)


CHECKS: List[Check] = [display, cameras]
