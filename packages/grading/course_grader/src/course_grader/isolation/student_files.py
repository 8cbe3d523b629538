"""Read the files of a submission safely: they may be pipes, links to endless devices, terabytes, or very deep."""
import os
from typing import Callable, Iterator, List, Optional, Tuple

from course_grader.isolation.limits import MEGABYTE
from plain_support import documents

MAX_SIZE = MEGABYTE  # [bytes] of a source that is read; those of the course have less than 20,000
MAX_DEPTH = 50  # folders in each other; those of a catkin workspace are 6


class UnreadableFile(ValueError):
    """A file cannot be read completely; the text says why."""


def read(path: str, limit: int = MAX_SIZE) -> bytes:
    """Return the first bytes of a file, at most ``limit``; b'' unless it is a readable file."""
    try:
        if os.path.isfile(path):
            with open(path, 'rb') as file:
                return file.read(limit)
    except (OSError, ValueError):
        pass  # the program that runs it reports what is wrong
    return b''


def whole(path: str) -> bytes:
    """Return the content of a file of at most MAX_SIZE bytes; raise UnreadableFile."""
    if not os.path.isfile(path):
        raise UnreadableFile('it is not a file')
    try:
        with open(path, 'rb') as file:
            content = file.read(MAX_SIZE + 1)
    except OSError as error:
        raise UnreadableFile(f'it cannot be read: {error.strerror}') from None
    if len(content) > MAX_SIZE:
        size = os.path.getsize(path) / MEGABYTE
        raise UnreadableFile(f'it has {size:.1f} MB; at most {MAX_SIZE / MEGABYTE:g} MB are read')
    return content


def walk(folder: str, too_deep: Callable[[str], object] = lambda path: None
         ) -> Iterator[Tuple[str, List[str], List[str]]]:
    """Walk like os.walk, sorted, to a depth of MAX_DEPTH; ``too_deep(path)`` is called for each deeper folder.

    os.walk recurses in some versions of Python, and fails in a thousand folders in each other.
    """
    pending = [(folder, 0)]
    while pending:
        parent, depth = pending.pop()
        folders: List[str] = []
        names: List[str] = []
        try:
            with os.scandir(parent) as entries:
                for entry in entries:
                    (folders if entry.is_dir() else names).append(entry.name)
        except OSError:
            continue
        folders.sort()
        yield parent, folders, sorted(names)
        below = [path for path in (os.path.join(parent, name) for name in folders) if not os.path.islink(path)]
        if depth < MAX_DEPTH:
            pending += [(path, depth + 1) for path in reversed(below)]
        else:
            for path in below:
                too_deep(path)


def unusable_packages(folder: str) -> Optional[str]:
    """Return why ROS cannot search a folder for packages, and what to do, or None.

    ROS reads each package.xml below it, and follows links.
    """
    wrong: List[str] = []

    def too_deep(path: str) -> None:
        wrong.append(f'{os.path.relpath(path, folder)[:200]} is a folder in more than {MAX_DEPTH} others: ROS does not '
                     'search it for packages')
    root = os.path.realpath(folder)
    for parent, folders, names in walk(folder, too_deep):
        for name in folders:
            path = os.path.join(parent, name)
            if os.path.islink(path) and not (os.path.realpath(path) + os.sep).startswith(root + os.sep):
                wrong.append(f'{path} is a link to a folder of somebody else: hand in the folder itself')
        if 'package.xml' in names:
            wrong += filter(None, [_fault(os.path.join(parent, 'package.xml'))])
        if wrong:
            break
    return wrong[0] if wrong else None


def _fault(path: str) -> Optional[str]:
    """Return what is wrong with a package.xml, or None."""
    try:
        documents.parse_xml(whole(path))
    except UnreadableFile as error:
        return f'{path}: {error}'
    except documents.DocumentError as error:
        return (f'{path}: {error}, so ROS does not find the package: each <tag> needs its </tag>, and & is written '
                '&amp;')
    return None
