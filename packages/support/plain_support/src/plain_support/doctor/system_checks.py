"""Packages, disk, Python, OpenCV, variables, the clock, devices, and the isolation of graded programs.

A command without an answer raises subprocess.TimeoutExpired: it says nothing about what it was asked for.
"""
import glob
import os
import re
import resource
import shutil
import socket
import subprocess
import sys
import time
from typing import Dict, Iterator, List, Tuple

from plain_support.doctor import devices, findings
from plain_support.doctor.addresses import MASTER_URI
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Check, Machine
from plain_support.doctor.processes import all_processes, user_name

BUILT_NEEDS, UNBUILT_NEEDS = 20.0, 1100.0  # [MB] of disk: for logs and temporary files; for all that ./run installs
OLDEST_OPENCV = (4, 6)
FUTURE = 60.0  # [s] that a file may be newer than now: folders of other machines
SAMPLE = 0.25  # [s] over which the wall clock is compared with elapsed time
ADDRESSES = 2000.0  # [MB] of address space: with 1500, OpenCV, scipy and 20 threads in one process fail
PROXIES = 'http_proxy', 'https_proxy', 'HTTP_PROXY', 'HTTPS_PROXY'
READINGS = 10  # of both clocks
JUMP = 0.2  # [s/s] by which the clock may gain: programs that set the time smoothly gain less than a tenth of it
PATIENCE = 20.0  # [s] for a command that takes well under one
CONNECT = 5.0  # [s] for a connection of this machine with itself
PATHS = 'PYTHONPATH', 'ROS_PACKAGE_PATH', 'CMAKE_PREFIX_PATH', 'LD_LIBRARY_PATH'
WRONG_ALONE = 'PYTHONHOME', 'AMENT_PREFIX_PATH'  # of another Python, of ROS 2
DISPLAY_ANSWER = 2.0  # [s] for a display on another machine
FIRST_PORT = 6000  # of X servers
DISPLAY_SOCKET = '/tmp/.X11-unix/X'
SYSTEM_PYTHONS = '/usr/bin/python3', '/bin/python3'


def packages(machine: Machine) -> Iterator[Finding]:
    """Debian packages that ./run will not be able to install."""
    if not machine.missing:
        return
    if glob.glob('/var/lib/apt/lists/*Packages*') or not shutil.which('apt-cache'):  # else ./run asks for them first
        known = offered(machine.missing)
        absent = [name for name in machine.missing if name not in known]
        if absent:
            yield findings.packages_unavailable(absent)
    if os.geteuid() != 0 and not shutil.which('sudo'):
        yield findings.packages_forbidden(machine.missing)


def disk(machine: Machine) -> Iterator[Finding]:
    """Free disk space for the workspace."""
    folder = _existing(machine.workspace)
    free, needed = shutil.disk_usage(folder).free / 1e6, BUILT_NEEDS if machine.built else UNBUILT_NEEDS
    if free < needed:
        yield findings.disk_full(folder, free, needed)


def addresses(_: Machine) -> Iterator[Finding]:
    """A limit of the address space."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < ADDRESSES * 1e6:
        yield findings.addresses_limited(limit / 1e6, ADDRESSES)


def loopback(_: Machine) -> Iterator[Finding]:
    """Connections of this machine with itself."""
    try:
        with socket.create_server(('127.0.0.1', 0)) as server:
            socket.create_connection(server.getsockname(), CONNECT).close()
    except OSError as error:
        yield findings.loopback_down(error.strerror or str(error))


def network(machine: Machine) -> Iterator[Finding]:
    """A way to the internet, while something has to be loaded from there."""
    if machine.missing and not any(map(machine.environment.get, PROXIES)) and not _has_route():
        yield findings.no_network(len(machine.missing))


def _has_route() -> bool:
    """Return whether a default route exists, for IPv4 or IPv6; True if Linux does not tell."""
    try:
        with open('/proc/net/route', encoding='ascii') as file:
            if any(line.split()[1] == '00000000' for line in file):
                return True
    except OSError:
        return True
    try:
        with open('/proc/net/ipv6_route', encoding='ascii') as file:
            return any(line.split()[:2] == ['0' * 32, '00'] and line.split()[-1] != 'lo' for line in file)
    except OSError:
        return False


def _existing(folder: str) -> str:
    """Return a folder, or its nearest parent that exists."""
    while not os.path.exists(folder):
        folder = os.path.dirname(folder)
    return folder


def folders(machine: Machine) -> Iterator[Finding]:
    """Folders that belong to root, usually because a command ran with sudo, and a workspace that cannot be made."""
    parent = _existing(machine.workspace)
    if parent != machine.workspace and not os.access(parent, os.W_OK | os.X_OK):
        yield findings.workspace_impossible(machine.workspace, parent, user_name(os.geteuid()))
    home = machine.environment.get('HOME', '')
    logs = machine.environment.get('ROS_HOME') or os.path.join(home, '.ros')
    for folder in (machine.workspace, logs, os.path.join(logs, 'log')):
        if os.path.isdir(folder) and not os.access(folder, os.W_OK):
            yield findings.folder_not_writable(folder, user_name(os.stat(folder).st_uid), user_name(os.geteuid()))


def python(machine: Machine) -> Iterator[Finding]:
    """The Python that ``python3`` means in the terminal."""
    found = shutil.which('python3', path=machine.environment.get('PATH', ''))
    expected = [machine.python] if machine.inside else [*SYSTEM_PYTHONS, machine.python]
    if found is None or any(os.path.abspath(found) == path for path in expected) or _has_ros(found, machine):
        return
    why, cure = _trap(found, machine.environment.get('VIRTUAL_ENV', ''))
    if machine.inside:
        cure += ', or open ./run shell again'
    else:
        cure += ', or work in ./run shell, which uses the right one'
    yield findings.python_shadowed(found, why, cure, fails=machine.inside)


def _has_ros(python: str, machine: Machine) -> bool:
    """Return whether a Python finds rospy."""
    try:
        done = subprocess.run([python, '-c', 'import rospy'], capture_output=True, check=False, timeout=PATIENCE,
                              env={**machine.environment, 'PYTHONDONTWRITEBYTECODE': '1'})
    except OSError:
        return False
    return done.returncode == 0


def _trap(found: str, environment: str) -> Tuple[str, str]:
    """Return which tool put a Python first in the PATH, and how to undo it."""
    if re.search(r'conda|mamba', found):
        return ' (conda)', 'type conda deactivate'
    if '/.pyenv/' in found or '/pyenv/' in found:
        return ' (pyenv)', 'type pyenv shell system'
    if environment and found.startswith(environment):
        return f' (the virtual environment {environment})', 'type deactivate'
    return '', f'take {os.path.dirname(found)} out of PATH'


def variables(machine: Machine) -> Iterator[Finding]:
    """Variables that lead to another Python, another ROS or ROS 2."""
    for name in WRONG_ALONE:
        if machine.environment.get(name):
            yield findings.foreign_variable(name, machine.environment[name], machine.inside)
    for name in PATHS:
        foreign = [part for part in machine.environment.get(name, '').split(os.pathsep) if _foreign(part, machine.ros)]
        if foreign:
            yield findings.foreign_variable(name, os.pathsep.join(foreign), machine.inside)


def _foreign(folder: str, ros: str) -> bool:
    other_ros = folder.startswith('/opt/ros/') and not (ros and f'{folder}/'.startswith(f'{ros}/'))
    versions = re.findall(r'python(\d\.\d+|2)\b', folder)
    other_python = any(version != f'{sys.version_info[0]}.{sys.version_info[1]}' for version in versions)
    return other_ros or other_python or 'conda' in folder


def opencv(machine: Machine) -> Iterator[Finding]:
    """OpenCV of the built workspace."""
    if not machine.built:
        return
    try:
        done = subprocess.run([machine.python, '-I', '-c', 'import cv2; print(cv2.__version__)'], capture_output=True,
                              text=True, check=False, timeout=PATIENCE)
    except OSError as error:
        yield findings.opencv_unusable(machine.python, f'it cannot be started ({error})')
        return
    version = tuple(int(number) for number in re.findall(r'\d+', done.stdout)[:2])
    if done.returncode:
        yield findings.opencv_unusable(machine.python, (done.stderr.strip().splitlines() or ['no answer'])[-1])
    elif version < OLDEST_OPENCV:
        yield findings.opencv_unusable(machine.python, f'its OpenCV is {done.stdout.strip()}, older than '
                                                       f'{".".join(map(str, OLDEST_OPENCV))}')


def clock(machine: Machine) -> Iterator[Finding]:
    """A clock that was set back, or runs faster or slower than elapsed time."""
    files = [os.path.join(machine.repository, 'run'), *glob.glob(os.path.join(machine.workspace, '.[bc]*'))]
    ahead: Dict[str, float] = {path: os.stat(path).st_mtime - time.time() for path in files if os.path.isfile(path)}
    late = max(ahead, key=lambda path: ahead[path], default='')
    if late and ahead[late] > FUTURE:
        yield findings.time_set_back(late, ahead[late])
    before = _gain()
    time.sleep(SAMPLE)
    gained = (_gain() - before) / SAMPLE
    if abs(gained) > JUMP:
        yield findings.clock_jumps(gained)


def _gain() -> float:
    """Return how far [s] the wall clock is ahead of the monotonic clock.

    Of several readings, the one counts in which the least time passed between the two clocks.
    """
    readings = [(time.monotonic(), time.time(), time.monotonic()) for _ in range(READINGS)]
    start, wall, end = min(readings, key=lambda reading: reading[2] - reading[0])
    return wall - (start + end) / 2.0


def isolation(_: Machine) -> Iterator[Finding]:
    """The isolation of graded programs: bubblewrap, or namespaces."""
    root = [] if os.geteuid() == 0 else ['-r']
    reason = 'neither bwrap nor unshare is installed'
    for command in (['bwrap', '--ro-bind', '/', '/', '--dev', '/dev', '--unshare-net', 'true'],
                    ['unshare', *root, '-n', 'true']):
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE)
        except OSError:
            continue
        if done.returncode == 0:
            return
        reason = done.stderr.strip().replace('\n', ' ') or reason
    yield findings.no_isolation(reason)


def offered(names: List[str]) -> List[str]:
    """Return the packages for which apt has a candidate."""
    try:
        done = subprocess.run(['apt-cache', 'policy', *names], capture_output=True, text=True, check=False,
                              env={**os.environ, 'LC_ALL': 'C'}, timeout=PATIENCE)
    except OSError:
        return []
    return re.findall(r'^(\S+):\n.*\n +Candidate: (?!\(none\))', done.stdout, re.MULTILINE)


def display(machine: Machine) -> Iterator[Finding]:
    """The X server that DISPLAY names; DISPLAY need not be set."""
    name = machine.environment.get('DISPLAY', '')
    if name and not _display_answers(name):
        yield findings.dead_display(name)


def _display_answers(display: str) -> bool:
    parts = re.fullmatch(r'(?:unix/?)?([^:]*):(\d+)(?:\.\d+)?', display)
    if parts is None:
        return False
    host, number = parts[1], int(parts[2])
    if host:
        try:
            socket.create_connection((host, FIRST_PORT + number), DISPLAY_ANSWER).close()
        except OSError:
            return False
        return True
    for address in (f'{DISPLAY_SOCKET}{number}', f'\0{DISPLAY_SOCKET}{number}'):
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(DISPLAY_ANSWER)
            if client.connect_ex(address) == 0:
                return True
    return False


def cameras(_: Machine) -> Iterator[Finding]:
    """Cameras that this user may not open, or that a program other than a ROS node has open."""
    ours = {process.pid for process in all_processes() if MASTER_URI in process.environment}
    for path, _name in devices.devices():
        reason = devices.trouble(path)
        holders = {pid for pid, _ in devices.users(path)}
        if reason and not (holders and holders <= ours and os.access(path, os.R_OK | os.W_OK)):
            yield findings.camera_unusable(reason)


CHECKS: List[Check] = [network, loopback, packages, disk, addresses, folders, python, variables, opencv, clock,
                       isolation, display, cameras]
