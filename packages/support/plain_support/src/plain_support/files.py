"""Write files completely or not at all, whatever happens to the disk or to the writing process.

A new file is written next to the final one, with an unpredictable name, and renamed when it is complete. So no program
reads half a file, and an existing file stays until the new one is complete.
"""
import contextlib
import errno
import os
import secrets
import stat
from typing import Iterator, Mapping, Union

MAX_NUMBERED = 100_000  # numbered files with one name in a folder
FULL = errno.ENOSPC, errno.EDQUOT, errno.EFBIG
STEM = 50  # characters of the file name in the temporary one: Linux allows 255 bytes, up to 4 per character

Content = Union[bytes, str]


def write_whole(path: str, content: Content) -> None:
    """Write a file, replacing an existing one; raise OSError, which names ``path``.

    ``content``: bytes, or text to encode as UTF-8. Devices and pipes (/dev/stdout) are written to directly; of a
    symbolic link, the target is replaced.
    """
    if is_special(path):
        with _naming(path), open(path, 'wb') as file:
            file.write(_bytes(content))
    else:
        write_together({path: content})


def write_together(contents: Mapping[str, Content]) -> None:
    """Write files {path: content} that belong together: if one cannot be written, none is replaced. Raise OSError."""
    with contextlib.ExitStack() as stack:
        new = {path: stack.enter_context(_new_file(path, content)) for path, content in contents.items()}
        for folder in filter(os.path.isdir, contents):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(folder))
        for path, written in new.items():
            with contextlib.suppress(OSError):
                os.chmod(written, stat.S_IMODE(os.stat(path).st_mode))  # the same mode as the previous file
            with _naming(path):
                os.replace(written, os.path.realpath(path))


def create_whole(path: str, content: Content) -> None:
    """Write a file that does not exist yet; raise FileExistsError, or another OSError, which names ``path``.

    Existing files are kept, and so are dangling symbolic links.
    """
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), path)
    with _new_file(path, content) as new, _naming(path):
        name_new(new, path)


def create_numbered(folder: str, stem: str, extension: str, content: Content) -> str:
    """Write a file with the next free number, such as a_0001.png; return its path. Raise OSError."""
    for number in range(1, MAX_NUMBERED + 1):
        path = os.path.join(folder, f'{stem}_{number:04d}{extension}')
        with contextlib.suppress(FileExistsError):
            create_whole(path, content)
            return path
    raise OSError(errno.EEXIST, f'there are {MAX_NUMBERED} files {stem}_NUMBER{extension} already', folder)


def name_new(old: str, new: str) -> None:
    """Rename a file; raise FileExistsError if the new name exists."""
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


def is_special(path: str) -> bool:
    """Return whether ``path`` exists and is neither a file nor a folder, but a device or pipe."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def unwritten(error: OSError, instead: str) -> str:
    """Return what could not be written, why, and what to do; ``instead``: such as 'choose another folder with -f'."""
    path = os.path.abspath(error.filename) if error.filename else 'a file'
    folder = os.path.dirname(path)
    cure = ''
    if error.errno in FULL:
        cure = f'make room on the disk (df -h {folder} says how much is left), or '
    elif error.errno == errno.ENOENT and folder and not os.path.isdir(folder):
        cure = f'type mkdir -p {folder}, or '
    cure += instead
    return f'{path} cannot be written: {error.strerror or error}. {cure[:1].upper()}{cure[1:]}'


@contextlib.contextmanager
def _new_file(path: str, content: Content) -> Iterator[str]:
    """Write a file next to ``path``, yield its name, and remove it unless it was renamed; raise OSError."""
    folder, name = os.path.split(os.path.realpath(path))
    new = os.path.join(folder, f'.{name[:STEM]}.{secrets.token_hex(8)}.part')
    try:
        with _naming(path), open(new, 'xb') as file:
            file.write(_bytes(content))
        yield new
    finally:
        with contextlib.suppress(OSError):
            os.unlink(new)


@contextlib.contextmanager
def _naming(path: str) -> Iterator[None]:
    """Make an OSError name ``path``."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, error.strerror, os.fspath(path)) from None


def _bytes(content: Content) -> bytes:
    return content.encode('utf-8', 'replace') if isinstance(content, str) else content
