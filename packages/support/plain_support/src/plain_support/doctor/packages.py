"""The ROS packages that a terminal finds, read from ROS_PACKAGE_PATH as rospack does. Without ROS."""
import os
import re
from typing import Iterator, List, Mapping, NamedTuple, Optional, Set

PACKAGE_PATH, PREFIX_PATH = 'ROS_PACKAGE_PATH', 'CMAKE_PREFIX_PATH'
OF_THE_SYSTEM = '/usr/', '/opt/ros/'
DEEPEST = 6  # levels below a folder of ROS_PACKAGE_PATH
IGNORED = 'CATKIN_IGNORE', 'rospack_nosubdirs'  # files that exclude the folders below theirs


class Package(NamedTuple):
    """A package and its folder."""

    name: str
    folder: str


def parts(environment: Mapping[str, str], variable: str) -> List[str]:
    """Return the folders of a variable that are not the system's."""
    return [folder for folder in environment.get(variable, '').split(os.pathsep)
            if folder and not f'{folder}/'.startswith(OF_THE_SYSTEM)]


def found(environment: Mapping[str, str]) -> List[Package]:
    """Return the packages that rosrun finds, except those of the system."""
    seen: Set[str] = set()
    return [package for folder in parts(environment, PACKAGE_PATH) for package in _below(folder, DEEPEST, seen)]


def _below(folder: str, depth: int, seen: Set[str]) -> Iterator[Package]:
    real = os.path.realpath(folder)
    if real in seen:
        return
    seen.add(real)
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return
    if 'package.xml' in names:
        yield Package(_name(folder), folder)
    elif depth and not any(name in names for name in IGNORED):
        for name in names:
            path = os.path.join(folder, name)
            if not name.startswith('.') and os.path.isdir(path):
                yield from _below(path, depth - 1, seen)


def _name(folder: str) -> str:
    try:
        with open(os.path.join(folder, 'package.xml'), encoding='utf-8', errors='replace') as file:
            match = re.search(r'<name>\s*([\w-]+)\s*</name>', file.read())
    except OSError:
        match = None
    return match[1] if match else os.path.basename(folder)


def workspace_of(folder: str) -> Optional[str]:
    """Return the built catkin workspace that contains a folder, or None."""
    while folder != os.path.dirname(folder):
        if os.path.isfile(os.path.join(folder, 'devel', 'setup.bash')) and os.path.isdir(os.path.join(folder, 'src')):
            return folder
        folder = os.path.dirname(folder)
    return None
