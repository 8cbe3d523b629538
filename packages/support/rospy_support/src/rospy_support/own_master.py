"""Start a private ROS master on a free port. Does not use rospy."""
import contextlib
import time
import xmlrpc.client
from typing import Any, Callable, Iterator, List, NamedTuple, Optional

from plain_support.processes import BackgroundProcess, end_with_parent
from rospy_support.limited_transport import LimitedTransport
from rospy_support.ports import free_port

ANSWER_DEADLINE = 20.0  # [s] for a master to answer at all
ANSWER_TIME = 1.0  # [s] for the answer to one call: another program may use the port
POLL = 0.02  # [s]
PORT_IN_USE = 'already in use'  # printed by a master whose port is taken; it keeps running, but never answers


class MasterError(RuntimeError):
    """The master could not be started; the text says why."""


class OwnMaster(NamedTuple):
    """A running master: its URI and its process."""

    uri: str
    process: BackgroundProcess


def start_master(start: Callable[[List[str]], BackgroundProcess], port: Optional[int] = None,
                 patience: float = ANSWER_DEADLINE) -> OwnMaster:
    """Start a master by ``start(command)`` and return it when it answers; raise MasterError after ``patience`` [s].

    Without ``port``, use a free port; if another program is faster, try the next one.
    """
    deadline, said = time.monotonic() + patience, 'nothing'
    while time.monotonic() < deadline:
        try:
            number = free_port() if port is None else port
        except OSError as error:
            raise MasterError(str(error)) from None
        process, uri = start(['rosmaster', '--core', '-p', str(number)]), f'http://localhost:{number}'
        while time.monotonic() < deadline and process.runs() and PORT_IN_USE not in process.output():
            with contextlib.suppress(OSError, xmlrpc.client.Error):
                answer: Any = xmlrpc.client.ServerProxy(uri, LimitedTransport(ANSWER_TIME)).getPid('/own_master')
                if answer[2] == process.pid:
                    return OwnMaster(uri, process)
            time.sleep(POLL)
        said = process.last_line()
        process.stop()
    raise MasterError(f'no ROS master answered within {patience:g} s; the last one said: {said}')


@contextlib.contextmanager
def own_master(log: str) -> Iterator[OwnMaster]:
    """Run a master during the with statement; it also ends if this process is killed. Raise MasterError.

    ``log`` is the file for its output.
    """
    master = start_master(lambda command: BackgroundProcess(command, log, preexec_fn=end_with_parent))
    try:
        yield master
    finally:
        master.process.stop()
