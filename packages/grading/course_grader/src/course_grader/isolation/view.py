"""The files that a program sees: the system, ROS, the interfaces of the workspace, and its own files.

Of a catkin workspace it sees messages, services, actions and their definitions, but no nodes and no modules except
LIBRARIES. Paths are the same inside and outside.
"""
import contextlib
import os
import shutil
import stat
import sys
import tempfile
from typing import Container, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple

SYSTEM = ('/usr', '/bin', '/sbin', '/lib', '/lib32', '/lib64', '/libx32', '/opt/ros')
SETTINGS = ('alternatives', 'default/locale', 'fonts', 'group', 'host.conf', 'hosts', 'ld.so.cache', 'ld.so.conf',
            'ld.so.conf.d', 'locale.alias', 'localtime', 'magic', 'mime.types', 'nsswitch.conf', 'passwd', 'protocols',
            'python3', 'ros', 'services', 'timezone')  # below /etc
SHARED = '/tmp', '/var/tmp'
DEFINITIONS = 'msg', 'srv', 'action'  # folders of a package that students may read and import
LIBRARIES = {'cv_bridge': ('cv_bridge', 'plain_support')}  # packages that students import: what these need
FIRST_ON_PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'student_path')  # of PYTHONPATH
VARIABLES = ('CMAKE_PREFIX_PATH', 'LANG', 'LANGUAGE', 'LD_LIBRARY_PATH', 'PATH', 'PYTHONNOUSERSITE', 'PYTHONPATH',
        'ROS_DISTRO', 'ROS_ETC_DIR', 'ROS_HOSTNAME', 'ROS_MASTER_URI', 'ROS_PACKAGE_PATH', 'ROS_PYTHON_VERSION',
        'ROS_ROOT', 'ROS_VERSION', 'TERM', 'TZ', 'VIRTUAL_ENV')  # passed on
SET_VARIABLES = {'PYTHONUNBUFFERED': '1', 'PYTHONDONTWRITEBYTECODE': '1', 'USER': 'student', 'LOGNAME': 'student',
                 'OPENBLAS_NUM_THREADS': '1'}  # numpy would take memory for each core


def environment(base: Mapping[str, str], folder: str, temporary: str) -> Dict[str, str]:
    """Return the environment of a program: only the variables that are listed here.

    ``base``: the grader's; ``folder``: where the program may write, ``temporary`` for its temporary files.
    """
    kept = {name: value for name, value in base.items() if name in VARIABLES or name.startswith('LC_')}
    path = os.pathsep.join(filter(None, (FIRST_ON_PATH, base.get('PYTHONPATH'))))
    home = os.path.join(folder, 'home')
    return {**kept, **SET_VARIABLES, 'PYTHONPATH': path, 'HOME': home, 'PWD': os.path.join(folder, 'work'),
            'TMPDIR': temporary, 'ROS_HOME': os.path.join(home, '.ros'),
            'ROS_LOG_DIR': os.path.join(home, '.ros', 'log')}


def folders(surroundings: Mapping[str, str]) -> List[str]:
    """Return the folders of an environment() that must exist."""
    return [surroundings[name] for name in ('HOME', 'PWD', 'TMPDIR', 'ROS_HOME', 'ROS_LOG_DIR')]


def own_files(command: Sequence[str], package: Optional[str], avoided: Iterable[str] = ()) -> List[str]:
    """Return the folders and files that belong to a program: its package, else the folder of its file.

    ``avoided``: folders that are never shown completely, such as the home folder; of these, only the file itself
    belongs to the program.
    """
    if package:
        return [os.path.abspath(package)]
    found: List[str] = []
    for part in command:
        path = os.path.abspath(part)
        if os.path.isfile(path) and os.sep in part and not below(path, [*SYSTEM, sys.prefix]):
            folder = os.path.dirname(path)
            shown = path if any(below(place, [folder]) for place in avoided) else folder
            if shown not in found:
                found.append(shown)
    return found


def never_shown(*places: str) -> List[str]:
    """Return ``places`` and the other folders that own_files must not show completely."""
    return [os.path.realpath(place) for place in ('/', os.path.expanduser('~'), tempfile.gettempdir(), *places)]


def below(path: str, places: Iterable[str]) -> bool:
    """Return whether a path is one of some places or lies below one."""
    return any(path == place or path.startswith(place.rstrip(os.sep) + os.sep) for place in places)


def parents(places: Iterable[str]) -> List[str]:
    """Return the folders above some places, except system folders and those below a place, highest first."""
    found = set()
    for place in places:
        parent = os.path.dirname(place)
        while parent != os.path.dirname(parent):
            found.add(parent)
            parent = os.path.dirname(parent)
    return sorted(folder for folder in found if folder != '/tmp' and not below(folder, [*SYSTEM, *places]))


def escaping(command: Sequence[str], own: Sequence[str]) -> Optional[str]:
    """Return the file of a command that links to a file outside of the program, or None."""
    real = [os.path.join(os.path.realpath(os.path.dirname(place)), os.path.basename(place)) if os.path.isfile(place)
            else os.path.realpath(place) for place in own]
    return next((part for part in command if below(os.path.abspath(part), own) and os.path.exists(part)
                 and not below(os.path.realpath(part), real)), None)


def shown(surroundings: Mapping[str, str], own: Sequence[str]) -> List[Tuple[str, str]]:
    """Return [(path, its path inside)] of what a program sees besides the system, parents first."""
    places = [FIRST_ON_PATH, *own]
    if not below(sys.prefix, SYSTEM):
        places += [sys.prefix, sys.base_prefix]
    for entry in surroundings.get('PYTHONPATH', '').split(os.pathsep):
        places += _modules(entry)
    for entry in surroundings.get('ROS_PACKAGE_PATH', '').split(os.pathsep):
        places += _definitions(entry)
    seen = [place for place in dict.fromkeys(map(os.path.abspath, filter(None, places)))
            if os.path.exists(place) and not below(place, SYSTEM)]
    return [(os.path.realpath(place), place) for place in sorted(seen)]


def reachable(path: str, deep: bool = True) -> bool:
    """Return whether every user of this machine may read a file or folder; ``deep``: and everything in it."""
    parents = [path]
    while parents[-1] != os.path.dirname(parents[-1]):
        parents.append(os.path.dirname(parents[-1]))
    if not all(_allows(parent, stat.S_IXOTH) for parent in parents[1:]):
        return False
    return _allows(path, stat.S_IROTH) and all(
        _allows(os.path.join(parent, name), stat.S_IROTH)
        for parent, folders, names in os.walk(path if deep else '') for name in (*folders, *names))


def unreadable(path: str, avoided: Container[str] = ()) -> str:
    """Return the first file or folder in a place that not every user may read, without a look at what is above it.

    ``avoided``: folders that are left out.
    """
    if not _allows(path, stat.S_IROTH) or os.path.isdir(path) and not _allows(path, stat.S_IXOTH):
        return path
    for parent, folders, names in os.walk(path):
        folders[:] = [name for name in folders if name != '__pycache__' and os.path.join(parent, name) not in avoided]
        for name, right in (*((one, stat.S_IROTH | stat.S_IXOTH) for one in folders),
                            *((one, stat.S_IROTH) for one in names)):
            inner = os.path.join(parent, name)
            with contextlib.suppress(OSError):  # it has just been removed
                if os.lstat(inner).st_mode & right != right:
                    return inner
    return ''


def readable(places: Iterable[Tuple[str, str]], folder: str, avoided: Sequence[str]) -> List[Tuple[str, str]]:
    """Return the places of shown() with copies in a folder of what other users cannot read.

    Python's own prefix is never copied; folders that are ``avoided`` are empty there. Raise OSError.
    """
    found = []
    for source, place in places:
        if place not in (sys.prefix, sys.base_prefix) and unreadable(source, avoided):
            _copy(source, folder + place, avoided)
            for hidden in avoided:
                if below(hidden, [place]):
                    os.makedirs(folder + hidden, exist_ok=True)
            source = folder + place
        found.append((source, place))
    _open(folder)
    return found


def temporary() -> Optional[str]:
    """Return a folder for temporary files that every user can access, or None; TMPDIR may be private."""
    return next((place for place in (tempfile.gettempdir(), *SHARED) if reachable(place, deep=False)), None)


def _allows(path: str, right: int) -> bool:
    try:
        return bool(os.lstat(path).st_mode & right)
    except OSError:
        return False


def staged(command: Sequence[str], surroundings: Mapping[str, str], places: Iterable[Tuple[str, str]], folder: str
           ) -> Tuple[List[str], Dict[str, str]]:
    """Copy files that another user cannot read into a folder; return command and environment that use the copies.

    ``places`` are those of ``shown``. Python's own prefix is not copied: the system's Python takes its place.
    """
    python = [sys.prefix, sys.base_prefix]
    moved = []
    for source, place in places:
        if reachable(source, place not in python):
            continue
        moved.append(place)
        if place not in python:
            _copy(source, folder + place)
    _open(folder)

    def there(text: str) -> str:
        if below(text, [place for place in python if place in moved]):
            return os.path.realpath(text)
        return folder + text if os.path.exists(folder + text) and text.startswith(os.sep) else text
    return list(map(there, command)), {name: os.pathsep.join(map(there, value.split(os.pathsep)))
                                       for name, value in surroundings.items()}


def _copy(source: str, target: str, avoided: Container[str] = ()) -> None:
    def ignored(folder: str, names: List[str]) -> List[str]:
        return [*_no_files(folder, names), *(name for name in names if os.path.join(folder, name) in avoided)]
    os.makedirs(os.path.dirname(target), exist_ok=True)
    if os.path.isdir(source):
        shutil.rmtree(target, ignore_errors=True)  # of an earlier run; links in it could not be written again
        shutil.copytree(source, target, symlinks=True, ignore=ignored)
    else:
        shutil.copyfile(source, target)
        shutil.copymode(source, target)


def _open(folder: str) -> None:
    """Let every user read a folder and what is in it."""
    for parent, _, names in os.walk(folder):
        for path in (parent, *(os.path.join(parent, name) for name in names)):
            if not os.path.islink(path):
                mode = os.stat(path).st_mode
                os.chmod(path, mode | 0o444 | (0o111 if mode & 0o111 else 0))


def _no_files(folder: str, names: List[str]) -> List[str]:
    """Return the pipes, sockets and devices among the names in a folder, which cannot be copied."""
    copied = stat.S_IFREG, stat.S_IFDIR, stat.S_IFLNK
    return [name for name in names if stat.S_IFMT(os.lstat(os.path.join(folder, name)).st_mode) not in copied]


def _modules(folder: str) -> Iterator[str]:
    """Yield the Python packages of a workspace that are generated from definitions, and its sitecustomize."""
    if os.path.isfile(os.path.join(folder, 'sitecustomize.py')) and not below(folder, SYSTEM):
        yield folder  # the repair of rospy
    for package in _entries(folder):
        for name in DEFINITIONS:
            yield os.path.join(folder, package, name)
        if package in LIBRARIES:
            for needed in LIBRARIES[package]:
                yield os.path.join(folder, needed)


def _definitions(folder: str) -> Iterator[str]:
    """Yield the message definitions of the packages in a folder of a workspace, and the LIBRARIES' modules."""
    needed = {name for names in LIBRARIES.values() for name in names}
    for package in _entries(folder):
        place = os.path.join(folder, package)
        kinds = [os.path.join(place, name) for name in DEFINITIONS if os.path.isdir(os.path.join(place, name))]
        if kinds:
            yield from (os.path.join(place, 'package.xml'), *kinds)
        if package in needed:
            yield os.path.join(place, 'src')


def _entries(folder: str) -> List[str]:
    """Return the names in a folder, none for a system folder."""
    return sorted(os.listdir(folder)) if folder and not below(folder, SYSTEM) and os.path.isdir(folder) else []
