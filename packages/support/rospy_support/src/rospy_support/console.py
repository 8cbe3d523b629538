"""Keep a node running if its standard output, standard error or log file is closed, full or not read.

rospy's log handlers raise an exception in the code that logs when the standard output is closed or its reader has gone
(``node | head``), and print a traceback for every line if the log file cannot be written. These nodes continue without.
"""
import contextlib
import errno
import logging.handlers
import os
import sys
from typing import IO, Any, Callable, Iterator, Optional, Type

import rosgraph.roslogging
import rospkg

from rospy_support import rospy_internals

LOST = errno.EPIPE, errno.EBADF, errno.EIO  # the stream is unusable: no reader, closed, terminal gone
NOWHERE = '/'  # a folder that always exists; nothing is written into it


def guard() -> None:
    """Replace sys.stdout and sys.stderr by streams that never fail. Call it before rospy.init_node, which uses them."""
    for descriptor in (0, 1, 2):  # a closed number would go to the next file or connection, which would get all prints
        with contextlib.suppress(FileExistsError):
            _occupy(descriptor)
    sys.stdout = Console(sys.stdout)
    sys.stderr = Console(sys.stderr)


class Console:
    """Wraps a text stream (or None): writes each line at once, and drops it if it cannot be written."""

    def __init__(self, stream: Optional[IO[str]]) -> None:
        """``stream`` is None if Python found it closed."""
        self._stream = stream if stream is not None else open(os.devnull, 'w', encoding='utf-8')
        if hasattr(self._stream, 'reconfigure'):  # do not fail for characters that the locale cannot encode
            self._stream.reconfigure(line_buffering=True, errors='backslashreplace')

    def write(self, text: str) -> int:
        """Write ``text``; return its length."""
        with self._losses():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write buffered text."""
        with self._losses():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextlib.contextmanager
    def _losses(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if error.errno in LOST:
                self._let_go()
        except ValueError:  # closed by the program itself
            pass

    def _let_go(self) -> None:
        """Discard all further output, including buffered text."""
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


class LogFile(logging.handlers.RotatingFileHandler):
    """rospy's log file; if it cannot be written, the node says so once and continues without it."""

    def __init__(self, *args: Any, **kwds: Any) -> None:
        self._lost = False
        try:
            super().__init__(*args, **kwds)
        except OSError as error:
            super().__init__(os.devnull, delay=True)
            self._give_up(error)

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, unless the file was given up."""
        if not self._lost:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:
        """Give the file up if it cannot be written; report other errors as usual."""
        error = sys.exc_info()[1]
        if isinstance(error, (OSError, ValueError)):
            self._give_up(error)
        else:
            super().handleError(record)

    def _give_up(self, error: BaseException) -> None:
        if not self._lost:
            self._lost = True
            _say(os.environ.get('ROS_LOG_FILENAME', 'the log file'), error)
            with contextlib.suppress(OSError, ValueError):
                self.close()


@contextlib.contextmanager
def log_file_guarded() -> Iterator[None]:
    """In this context, rospy.init_node uses LogFile, and works without a log folder that cannot be created."""
    original = logging.handlers.RotatingFileHandler
    _use_handler(LogFile)
    try:
        with rospy_internals.logging_configured_by(_configure):
            yield
    finally:
        _use_handler(original)


def _use_handler(handler: Type[logging.Handler]) -> None:
    """Let rosgraph's configuration of logging find this class as RotatingFileHandler."""
    vars(logging.handlers)['RotatingFileHandler'] = handler


def _configure(configure: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Configure logging as rosgraph does, but without a log file if there is no folder for it."""
    folder = os.path.dirname(os.path.join(rospkg.get_log_dir(), options.get('filename') or ''))
    try:
        if not os.path.isdir(folder):
            rosgraph.roslogging.makedirs_with_parent_perms(folder)
        return configure(*arguments, **options)
    except Exception as error:  # rosgraph.roslogging.LoggingException, OSError and others
        _say(folder, error)
    _use_handler(_NoFile)
    options['filename'] = 'none'
    configure(*arguments, env={**os.environ, rospkg.environment.ROS_LOG_DIR: NOWHERE}, **options)
    return None


class _NoFile(logging.NullHandler):
    """Accepts the arguments of a file handler and writes nothing."""

    def __init__(self, *_: Any, **__: Any) -> None:
        super().__init__()


def _say(where: str, error: BaseException) -> None:
    print(f'WARNING: no log file: {where}: {getattr(error, "strerror", None) or error}. The node continues without it; '
          'set ROS_LOG_DIR to a writable folder.', file=sys.stderr)


def _occupy(descriptor: int) -> None:
    """Open /dev/null as ``descriptor`` if that is closed."""
    try:
        os.fstat(descriptor)
    except OSError:
        nowhere = os.open(os.devnull, os.O_RDWR)
        if nowhere != descriptor:
            os.dup2(nowhere, descriptor)
            os.close(nowhere)
        os.set_inheritable(descriptor, True)
