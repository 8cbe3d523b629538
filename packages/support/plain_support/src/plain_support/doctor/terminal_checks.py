"""The terminal, and the programs of its user."""
import glob
import os
import re
import time
from typing import Dict, Iterable, Iterator, List, Set, Tuple

from plain_support.doctor import addresses, findings, packages, processes, programs
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Check, Machine
from plain_support.doctor.processes import Process

OURS = 'turtle_robotont'
PROGRAM_START = 1 << 20  # [bytes] of a program that are read
MAX_FILES = 2000  # of one package that are examined
LOG_END = 64 << 10  # [bytes] of a log that are read
ENDING = 10.0  # [s] that a node may take to end
RESOLUTION = 1.0  # [s] of the times that are read in a log
STARTS_A_NODE = re.compile(rb'\brospy\s*\.\s*init_node\b|^\s*if __name__ ?==', re.MULTILINE)
SHUTDOWN = re.compile(r'(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d),\d+: signal_shutdown \[signal-')
NO_PROGRAMS = {'build', 'devel', 'install', 'test', 'tests', '__pycache__'}  # folders without a student's programs
EXTENSIONS = '.py.txt', '.txt', '.py~'  # of a program that was saved under a wrong name


def shell(machine: Machine) -> Iterator[Finding]:
    """Whether rosrun finds the packages here."""
    found = packages.found(machine.environment)
    script = os.path.join(machine.workspace, 'env.bash')
    if not any(package.name == OURS for package in found):
        if machine.inside:
            yield findings.shell_overridden(script)
        else:
            package = OURS if machine.ros else 'turtlesim'  # a ROS 1 in /opt/ros may have a turtlesim
            yield findings.outside_shell(package, f'{os.path.join(machine.repository, "run")} shell')
    workspace = packages.workspace_of(os.getcwd())
    sourced = packages.parts(machine.environment, packages.PREFIX_PATH)
    if workspace and workspace != machine.workspace and os.path.join(workspace, 'devel') not in sourced:
        yield findings.workspace_not_sourced(workspace)


def student_programs(machine: Machine) -> Iterator[Finding]:
    """Programs in packages of the user's own that rosrun cannot start."""
    installed = _installed(packages.parts(machine.environment, packages.PREFIX_PATH))
    for package in packages.found(machine.environment):
        if not _is_ours(package.folder, machine):
            for path in _files(package.folder):
                if (package.name, os.path.basename(path)) not in installed:
                    yield from _program(path, machine)
    for folder in packages.parts(machine.environment, packages.PACKAGE_PATH):
        for path in sorted(glob.glob(os.path.join(glob.escape(folder), '*.py'))):
            if not os.path.isfile(os.path.join(folder, 'package.xml')) and STARTS_A_NODE.search(_start(path)):
                yield findings.outside_package(path)


def _installed(prefixes: Iterable[str]) -> Set[Tuple[str, str]]:
    """Return (package, name) of the programs that catkin_install_python made; these start whatever their source."""
    return {(os.path.basename(os.path.dirname(path)), os.path.basename(path))
            for prefix in prefixes for path in glob.glob(os.path.join(glob.escape(prefix), 'lib', '*', '*'))}


def _is_ours(folder: str, machine: Machine) -> bool:
    return f'{os.path.realpath(folder)}/'.startswith(f'{os.path.realpath(machine.repository)}/')


def _files(folder: str) -> Iterator[str]:
    """Yield the files of a package that may be programs; files beside an __init__.py are modules."""
    count = 0
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if name not in NO_PROGRAMS and not name.startswith('.'))
        if '__init__.py' in names:
            continue
        for name in sorted(names):
            count += 1
            if count > MAX_FILES:
                return
            if name != 'setup.py' and not name.startswith('.'):
                yield os.path.join(parent, name)


def _program(path: str, machine: Machine) -> Iterator[Finding]:
    name, extension = os.path.basename(path), os.path.splitext(path)[1]
    if extension not in ('', '.py', '.txt', '.py~'):
        return
    content = _start(path)
    first = content.split(b'\n', 1)[0]
    if not (STARTS_A_NODE.search(content) or (first.startswith(b'#!') and b'python' in first)):
        return
    wrong = next((end for end in EXTENSIONS if name.endswith(end)), '')
    if wrong:
        yield findings.wrong_extension(path, f'{path[:-len(wrong)]}.py')
    else:
        yield from programs.faults(path, content, machine.environment)


def _start(path: str) -> bytes:
    try:
        with open(path, 'rb') as file:
            return file.read(PROGRAM_START) if os.path.isfile(path) else b''
    except OSError:
        return b''


def hanging(_: Machine) -> Iterator[Finding]:
    """Nodes of rospy that keep running after Ctrl-C or kill: according to their log, they were told to end.

    A log that two processes have open, such as two nodes with the same name, does not show which one was told. Lines
    from before the start of a process are those of an earlier node of that name.
    """
    logs: Dict[str, List[Process]] = {}
    for process in processes.all_processes():
        if process.user == os.geteuid() and addresses.MASTER_URI in process.environment:
            for path in _logs(process.pid):
                logs.setdefault(path, []).append(process)
    now = time.time()
    for path, users in logs.items():
        if len(users) == 1:
            age = processes.age(users[0].pid)
            ago = [now - moment for moment in _shutdown_times(path) if now - moment < age - RESOLUTION]
            if ago and max(ago) > ENDING:
                yield findings.does_not_end(_program_name(users[0]), max(ago), users[0].pid)


def _program_name(process: Process) -> str:
    """Return the program of a process without its interpreter and the path, and its number."""
    python = 'python' in os.path.basename(process.command[0]) and len(process.command) > 1
    script = process.command[1 if python else 0]
    return f'{process.name if script.startswith("-") else os.path.basename(script)} (process {process.pid})'


def _logs(pid: int) -> List[str]:
    """Return the logs that a process has open."""
    found = []
    for link in glob.glob(f'/proc/{pid}/fd/*'):
        try:
            path = os.readlink(link)
        except OSError:
            continue
        if path.endswith('.log'):
            found.append(path)
    return found


def _shutdown_times(path: str) -> Iterator[float]:
    """Yield the times [s] at which a node was told to end, according to the end of its log."""
    try:
        with open(path, 'rb') as file:
            file.seek(max(0, os.path.getsize(path) - LOG_END))
            text = file.read().decode(errors='replace')
    except OSError:
        return
    for match in SHUTDOWN.finditer(text):
        yield time.mktime(time.strptime(match[1], '%Y-%m-%d %H:%M:%S'))


CHECKS: List[Check] = [shell, student_programs, hanging]
