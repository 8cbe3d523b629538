"""Files that are there as a whole or not at all, whatever becomes of the disk or of the process that writes them.

A new file is written beside the wanted one, with a name that nobody can foresee, and is renamed when it is complete. So
nobody reads half a file, and what was there before stays until then.
"""
import contextlib
import errno
import os
import secrets
import stat

MOST_NUMBERED = 100_000  # files of one name in a folder
STEM = 50  # characters of the file's name in that of the new one: Linux allows 255 bytes, of up to 4 a character


def write_whole(path, content):
    """Write a file, in the place of one that exists; raise OSError, which names ``path``.

    ``content``: bytes, or text that becomes UTF-8. Devices and pipes (/dev/stdout) are written to as they are, and so
    is what a symbolic link leads to.
    """
    if is_special(path) or os.path.islink(path):
        with _naming(path), open(path, 'wb') as file:
            file.write(_bytes(content))
        return
    with _new_file(path, content) as new:
        with contextlib.suppress(OSError):
            os.chmod(new, stat.S_IMODE(os.stat(path).st_mode))  # as that of the one before
        os.replace(new, path)


def create_whole(path, content):
    """Write a file that is not there yet; raise FileExistsError, or another OSError, which names ``path``.

    What exists stays, a symbolic link that leads nowhere included.
    """
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), path)
    with _new_file(path, content) as new:
        name_new(new, path)


def create_numbered(folder, stem, extension, content):
    """Write a file with the next free number, such as a_0001.png; return its path. Raise OSError."""
    for number in range(1, MOST_NUMBERED + 1):
        path = os.path.join(folder, f'{stem}_{number:04d}{extension}')
        with contextlib.suppress(FileExistsError):
            create_whole(path, content)
            return path
    raise OSError(errno.EEXIST, f'there are {MOST_NUMBERED} files {stem}_NUMBER{extension} already', folder)


def name_new(old, new):
    """Rename a file; raise FileExistsError where the new name is taken."""
    try:
        os.link(old, new)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if os.path.lexists(new):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), new) from None
        os.rename(old, new)
    else:
        os.unlink(old)


def is_special(path):
    """Return whether something is there that is neither a file nor a folder: a device, a pipe."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


@contextlib.contextmanager
def _new_file(path, content):
    """Write a file beside ``path``, hand out its name, and remove it unless it was renamed; errors name ``path``."""
    folder, name = os.path.split(os.path.abspath(path))
    new = os.path.join(folder, f'.{name[:STEM]}.{secrets.token_hex(8)}.part')
    try:
        with _naming(path):
            with open(new, 'xb') as file:
                file.write(_bytes(content))
            yield new
    finally:
        with contextlib.suppress(OSError):
            os.unlink(new)


@contextlib.contextmanager
def _naming(path):
    """Let an OSError name ``path``."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, error.strerror, os.fspath(path)) from None


def _bytes(content):
    return content.encode('utf-8', 'replace') if isinstance(content, str) else content
