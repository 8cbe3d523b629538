"""Reading what a student has handed in, which may be anything: a pipe, a link to a device without end, terabytes."""
import os

from course_grader.isolation.limits import MEGABYTE

LONGEST = MEGABYTE  # [bytes] of a source that is looked at; those of the course have less than 20,000


class NoFile(ValueError):
    """Something is not a file that can be read whole; the text says why."""


def read(path: str, most: int = LONGEST) -> bytes:
    """Return the beginning of a file, at most ``most`` bytes; nothing of what is no file, or cannot be read."""
    try:
        if os.path.isfile(path):
            with open(path, 'rb') as file:
                return file.read(most)
    except (OSError, ValueError):
        pass  # whoever starts it will say what is wrong with it
    return b''


def whole(path: str) -> bytes:
    """Return the content of a file of at most LONGEST bytes; raise NoFile."""
    if not os.path.isfile(path):
        raise NoFile('it is no file')
    try:
        with open(path, 'rb') as file:
            content = file.read(LONGEST + 1)
    except OSError as error:
        raise NoFile(f'it cannot be read: {error.strerror}') from None
    if len(content) > LONGEST:
        raise NoFile(f'it has {os.path.getsize(path) / MEGABYTE:.1f} MB; at most {LONGEST / MEGABYTE:g} MB are read')
    return content


def check_packages(folder: str) -> None:
    """Raise NoFile when ROS could not read a package.xml below a folder."""
    for parent, _, names in os.walk(folder):
        if 'package.xml' in names:
            path = os.path.join(parent, 'package.xml')
            try:
                whole(path)
            except NoFile as error:
                raise NoFile(f'{path}: {error}') from None
