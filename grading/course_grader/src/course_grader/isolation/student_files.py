"""Read the files of a submission safely: they may be pipes, links to endless devices, or terabytes."""
import os

from course_grader.isolation.limits import MEGABYTE

MAX_SIZE = MEGABYTE  # [bytes] of a source that is read; those of the course have less than 20,000


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


def check_packages(folder: str) -> None:
    """Raise UnreadableFile if ROS could not read a package.xml below a folder."""
    for parent, _, names in os.walk(folder):
        if 'package.xml' in names:
            path = os.path.join(parent, 'package.xml')
            try:
                whole(path)
            except UnreadableFile as error:
                raise UnreadableFile(f'{path}: {error}') from None
