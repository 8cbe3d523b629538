"""What somebody's packages need of this machine: there, a stand-in, a Debian package to install, or not to be had."""
import collections
import glob
import json
import os
import re
import shlex
import subprocess
from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Set, Tuple

from plain_support.doctor import findings, package_needs, packages, programs
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Machine
from plain_support.doctor.package_needs import BUILD, IMPORT, INCLUDE, LISTED, RUN, Needs
from plain_support.doctor.system_checks import PATIENCE, offered

MAX_NAMES = 8  # of files or packages that one line shows
TOOLS = {  # ROS package: the Debian package with its programs, which no rule tells
    'dynamic_reconfigure': 'libdynamic-reconfigure-config-init-mutex-dev', 'image_transport': 'image-transport-tools',
    'joint_state_publisher': 'joint-state-publisher', 'joint_state_publisher_gui': 'joint-state-publisher-gui',
    'nodelet': 'libnodeletlib-tools', 'pcl_ros': 'pcl-ros-tools', 'rviz': 'rviz', 'tf': 'tf-tools',
    'topic_tools': 'topic-tools'}
MODULES = {'Image': 'python3-pil', 'PIL': 'python3-pil', 'cv': 'python3-opencv', 'serial': 'python3-serial',
           'skimage': 'python3-skimage', 'sklearn': 'python3-sklearn', 'usb': 'python3-usb', 'yaml': 'python3-yaml',
           'PyKDL': 'python3-pykdl', 'Xlib': 'python3-xlib', 'wx': 'python3-wxgtk4.0', 'gi': 'python3-gi'}
GAZEBO = 'the stand-in gazebo_ros reads the plugins of robots on wheels; Gazebo itself needs another system'
MAPPING = 'gmapping makes maps here'
FOLLOWING = 'move_base has TrajectoryPlannerROS and DWAPlannerROS here'
INSTEAD = {'gazebo_plugins': GAZEBO, 'gazebo_ros_control': GAZEBO, 'cartographer_ros': MAPPING,
           'hector_mapping': MAPPING, 'slam_toolbox': MAPPING, 'teb_local_planner': FOLLOWING}
PYTHON_ONLY = {'cv_bridge'}  # stand-ins without C++
FIND = ('import importlib.util, json, sys\ndef found(name):\n try: return bool(importlib.util.find_spec(name))\n'
        ' except (ImportError, ValueError): return False\nprint(json.dumps([n for n in sys.argv[1:] if found(n)]))')


class Machinery(NamedTuple):
    """What is there: names of stand-ins, of ROS packages, of those with C++ headers, and of Python modules."""

    stand_ins: Set[str]
    packages: Set[str]
    headers: Set[str]
    modules: Set[str]


def folder_of(name: str, machine: Machine) -> Optional[str]:
    """Return the folder that the argument of ./run doctor means, a folder or a package's name, or None."""
    if os.path.isdir(name):
        return os.path.abspath(name)
    known = {package.name: package.folder for package in packages.found(machine.environment)}
    return known.get(name)


def examine(folder: str, machine: Machine) -> Tuple[List[Finding], List[str]]:
    """Return the findings about the packages in a folder, and lines that say what is there.

    Raise subprocess.TimeoutExpired if a command that was asked gives no answer.
    """
    needs = package_needs.read(folder)
    there = _machinery(needs, machine)
    missing: Dict[str, List[str]] = {}  # name: kinds
    for name, kind in needs.needs:
        if not _is_there(name, kind, there):
            missing.setdefault(name, []).append(kind)
    debian = _debian(missing)
    for name in [name for name in missing if missing[name] == [LISTED] and not debian[name] and name not in INSTEAD]:
        del missing[name]  # rosdep's name of a library, such as eigen
    found: List[Finding] = []
    for name in sorted(missing):
        kinds = missing[name]
        file = os.path.relpath(needs.needs[name, kinds[0]], folder)
        fails = kinds != [LISTED]  # neither rosrun nor roslaunch reads package.xml
        if debian[name]:
            found.append(findings.package_to_install(name, file, debian[name], fails))
        else:
            found.append(findings.package_not_to_be_had(name, file, INSTEAD.get(name, ''), IMPORT in kinds, fails))
    found += _programs(needs, machine)
    return sorted(found, key=lambda finding: not finding.fails), _summary(needs, there, missing, debian)


def _summary(needs: Needs, there: Machinery, missing: Dict[str, List[str]],
             debian: Dict[str, List[str]]) -> List[str]:
    names = {name for name, _ in needs.needs}
    lines = [f'Packages here: {_some(needs.packages) or "none, there is no package.xml"}.']
    if names & there.stand_ins - set(missing):
        lines.append(f'Stand-ins of this repository: {_some(names & there.stand_ins - set(missing))}.')
    if needs.launch_files:
        lacked = {name for name, kinds in missing.items() if RUN in kinds}  # others may lack only its headers
        lines += _launch_lines(needs, lacked, {name for name in lacked if debian[name]})
    to_install = sorted({package for packages_ in debian.values() for package in packages_})
    if to_install:
        lines.append(f'All at once: sudo apt-get install --no-install-recommends {" ".join(to_install)}')
    return lines


def _launch_lines(needs: Needs, missing: Set[str], in_debian: Set[str]) -> List[str]:
    """Return how many launch files find all their packages, and what the others lack; ``in_debian``: Debian has it."""
    lacks = [used & missing for used in needs.launch_files.values()]
    complete, later = lacks.count(set()), sum(lack <= in_debian for lack in lacks)
    more = f', {later} with the Debian packages below' if later > complete else ''
    lines = [f'{complete} of {len(lacks)} launch files find all their packages{more}.']
    lacked = collections.Counter(name for lack in lacks for name in lack - in_debian)
    if lacked:
        names = [f'{name} ({count})' for name, count in sorted(lacked.items(), key=lambda each: (-each[1], each[0]))]
        lines.append(f'What launch files lack, and Debian does not have: {", ".join(names[:MAX_NAMES])}'
                     + (f' and {len(names) - MAX_NAMES} more.' if len(names) > MAX_NAMES else '.'))
    return lines


def _some(names: Iterable[str]) -> str:
    shown = sorted(names)
    return ', '.join(shown[:MAX_NAMES]) + (f' and {len(shown) - MAX_NAMES} more' if len(shown) > MAX_NAMES else '')


def _programs(needs: Needs, machine: Machine) -> Iterator[Finding]:
    for path, (line, what) in sorted(needs.old.items()):
        yield findings.python2_program(path, line, what)
    alike: Dict[str, List[Tuple[str, Finding]]] = {}
    for path in needs.programs:
        with open(path, 'rb') as file:
            content = file.read()
        if content.startswith(b'#!'):
            for finding in programs.faults(path, content, machine.environment):
                alike.setdefault(finding.text.replace(path, ''), []).append((path, finding))
    for (_, first), *others in alike.values():
        paths = [path for path, _ in others]
        if paths:  # all cures of programs are commands that end with the file
            first = first._replace(text=f'{first.text} (likewise {_some(map(os.path.basename, paths))})',
                                   cure=' '.join([first.cure, *map(shlex.quote, paths)]))
        yield first


def _machinery(needs: Needs, machine: Machine) -> Machinery:
    roots = [root for root in (machine.ros, '/usr') if root]
    ours = os.path.join(glob.escape(machine.repository), 'packages', '**', 'package.xml')
    stand_ins = {os.path.basename(os.path.dirname(path)) for path in glob.glob(ours, recursive=True)}
    known = {package.name for package in packages.found(machine.environment)}
    installed = {os.path.basename(os.path.dirname(path)) for root in roots
                 for path in glob.glob(os.path.join(root, 'share', '*', 'package.xml'))}
    configured = {os.path.basename(path)[:-len('Config.cmake')] for root in roots
                  for places in ('share/*/cmake', 'lib/*/cmake/*', 'lib/cmake/*')
                  for path in glob.glob(os.path.join(root, places, '*Config.cmake'))}
    modules = _modules({name for name, kind in needs.needs if kind == IMPORT}, machine)
    return Machinery(stand_ins, stand_ins | known | installed,
                     (stand_ins - PYTHON_ONLY) | known | configured | {'catkin'}, stand_ins | modules)


def _modules(names: Set[str], machine: Machine) -> Set[str]:
    """Return which modules the Python of the workspace, or of the system, finds."""
    script = os.path.join(machine.workspace, 'env.bash')
    command = ['/usr/bin/python3']
    if machine.built and os.path.isfile(script):
        command = ['bash', '-c', '. "$0" >/dev/null 2>&1; exec python3 "$@"', script]
    try:
        done = subprocess.run([*command, '-c', FIND, *sorted(names)], capture_output=True, text=True, check=True,
                              timeout=PATIENCE, env=dict(machine.environment))
        return set(json.loads(done.stdout))
    except (OSError, ValueError, subprocess.CalledProcessError):
        return set()


def _is_there(name: str, kind: str, there: Machinery) -> bool:
    if kind == BUILD:
        return name in there.headers | there.stand_ins
    if kind == INCLUDE:
        return name in there.headers
    if kind == IMPORT:
        return name in there.modules
    if kind == RUN:
        return name in there.packages
    return name in there.packages | there.headers | there.modules or '-' in name or not re.fullmatch(r'[a-z]\w*', name)


def _debian(missing: Dict[str, List[str]]) -> Dict[str, List[str]]:
    """Return {name: Debian packages that bring it}, of those that apt offers."""
    wanted = {name: _candidates(name, kinds) for name, kinds in missing.items()}
    known = set(offered(sorted({package for names in wanted.values() for package in names})))
    return {name: [package for package in names if package in known] for name, names in wanted.items()}


def _candidates(name: str, kinds: Iterable[str]) -> List[str]:
    """Return the names that Debian gives to the parts of a ROS package or Python module."""
    part = name.lower().replace('_', '-')
    found: List[str] = []
    if set(kinds) & {RUN, LISTED}:
        found += [f'ros-{part}', TOOLS.get(name, '')]
    if set(kinds) & {BUILD, INCLUDE} or (name.endswith('_msgs') and kinds != [IMPORT]):
        found += [f'lib{part}-dev'] + [f'ros-{part}'] * name.endswith('_msgs')
    if set(kinds) & {IMPORT, LISTED}:
        found += [MODULES.get(name, f'python3-{part}')]
    return [package for package in dict.fromkeys(found) if package]
