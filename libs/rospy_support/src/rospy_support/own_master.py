"""A ROS master of one's own, on a port that nobody else uses. Does without rospy."""
import contextlib
import time
import xmlrpc.client
from typing import Callable, Iterator, List, NamedTuple, Optional

from process_support.processes import BackgroundProcess, end_with_parent
from rospy_support.ports import free_port

ANSWER_DEADLINE = 20.0  # [s] in which a master must answer
ANSWER_TIME = 1.0  # [s] after which it is asked again: what has its port need not be a master
POLL = 0.02  # [s]
TAKEN = 'already in use'  # what a master says when it finds its port taken, which leaves it alive and deaf


class MasterError(RuntimeError):
    """There is no master; the text says why."""


class OwnMaster(NamedTuple):
    """A master that answers: its URI and its process."""

    uri: str
    process: BackgroundProcess


def start_master(start: Callable[[List[str]], BackgroundProcess], port: Optional[int] = None,
                 patience: float = ANSWER_DEADLINE) -> OwnMaster:
    """Start a master by ``start(command)`` and return it when it answers; raise MasterError after ``patience`` [s].

    Without a ``port`` it gets a free one, and another one should somebody take that before it does.
    """
    deadline, said = time.monotonic() + patience, 'nothing'
    while time.monotonic() < deadline:
        try:
            number = free_port() if port is None else port
        except OSError as error:
            raise MasterError(str(error)) from None
        process, uri = start(['rosmaster', '--core', '-p', str(number)]), f'http://localhost:{number}'
        while time.monotonic() < deadline and process.runs() and TAKEN not in process.output():
            with contextlib.suppress(OSError, xmlrpc.client.Error):
                if xmlrpc.client.ServerProxy(uri, _Transport()).getPid('/own_master')[2] == process.pid:
                    return OwnMaster(uri, process)
            time.sleep(POLL)
        said = process.last_line()
        process.stop()
    raise MasterError(f'no ROS master answered within {patience:g} s; the last one said: {said}')


@contextlib.contextmanager
def own_master(log: str) -> Iterator[OwnMaster]:
    """Run a master for as long as the with statement lasts, or until this process is killed; raise MasterError.

    ``log``: the file for what it prints.
    """
    master = start_master(lambda command: BackgroundProcess(command, log, preexec_fn=end_with_parent))
    try:
        yield master
    finally:
        master.process.stop()


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = ANSWER_TIME
        return connection
