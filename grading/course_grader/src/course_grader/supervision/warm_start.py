"""Starts processes that need a slow import, at the cost of a fork: a server imports once, and forks on request.

As multiprocessing's forkserver, without its socket in the temporary folder, whose name may be too long for one, and
without starting Python anew: the server is a fork of this process. Should a program end or stop the server, which it
can where nothing isolates it, another one takes its place.

Threading contract: a WarmStart is made while the process has one thread; ``start`` may then come from any.
"""
import contextlib
import gc
import importlib
import multiprocessing
import os
import signal
import sys
import threading
import traceback
from multiprocessing import reduction
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any, Callable, Tuple

import psutil

from plain_support import processes

SERVERS = 3  # that one process is tried with
LONGEST_IMPORT = 60.0  # [s] of wall time, on a loaded machine, until a server answers; one that does not was stopped


class WarmStart:
    """Calls ``run(module, argument)`` in processes that have imported ``module``; what it returns is sent back."""

    def __init__(self, module: str, run: Callable[[ModuleType, Any], object]) -> None:
        """Start the server; it imports while the caller goes on."""
        self._module, self._run, self._lock = module, run, threading.Lock()
        self._start_server(multiprocessing.get_context('fork').Process)

    def _start_server(self, kind: Callable[..., BaseProcess]) -> None:
        self._requests, theirs = multiprocessing.Pipe()
        self._server = kind(target=_serve, args=(self._module, self._run, theirs, self._requests, os.getpid()))
        self._server.start()
        self._identity = psutil.Process(self._server.pid)
        theirs.close()

    def start(self, argument: object) -> Tuple[psutil.Process, Connection]:
        """Fork a process; return it and the end of a pipe that receives its result, or is closed without one.

        Raise OSError where no server answers.
        """
        receiver, sender = multiprocessing.Pipe(duplex=False)
        with sender, self._lock:
            for _ in range(SERVERS):
                with contextlib.suppress(EOFError, OSError, psutil.Error):
                    return self._fork(argument, sender), receiver
                self._end_server()
                # anew, because by now this process may have several threads
                self._start_server(multiprocessing.get_context('spawn').Process)
        receiver.close()
        raise ChildProcessError('the process that starts gradings was ended or stopped again and again')

    def _fork(self, argument: object, sender: Connection) -> psutil.Process:
        self._requests.send(argument)
        reduction.send_handle(self._requests, sender.fileno(), self._identity.pid)
        if not self._requests.poll(LONGEST_IMPORT):
            raise TimeoutError
        started = psutil.Process(self._requests.recv())
        self._requests.send(None)  # from now on its number may become another process's
        return started

    def _end_server(self) -> None:
        processes.end(lambda: {self._identity}, processes.KILL)
        self._requests.close()
        self._server.join()

    def close(self) -> None:
        """End the server; the processes that it has forked end with it."""
        with self._lock:
            self._end_server()


def _serve(module: str, run: Callable[[ModuleType, Any], object], requests: Connection, other_end: Connection,
           parent: int) -> None:
    """Import, then fork a process for each request, until the other end is closed."""
    other_end.close()
    os.setsid()  # Ctrl-C is for the caller, who then ends this
    processes.end_with_parent(signal.SIGKILL, parent)
    for number in processes.END_SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    del sys.argv[1:]  # they are not the module's: rospy would take names of a graded command for its own
    imported = importlib.import_module(module)
    gc.freeze()  # what is imported is garbage in no process
    with contextlib.suppress(EOFError):
        while True:
            argument = requests.recv()
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)  # the next one keeps its number until it is known
            sender = Connection(reduction.recv_handle(requests), readable=False)
            server = os.getpid()
            child = os.fork()
            if not child:
                processes.end_with_parent(signal.SIGKILL, server)
                _work(imported, run, argument, requests, sender)
            sender.close()
            requests.send(child)
            requests.recv()
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # whoever ends is gone
            with contextlib.suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG)[0]:
                    pass
    os._exit(0)


def _work(module: ModuleType, run: Callable[[ModuleType, Any], object], argument: object, requests: Connection,
          sender: Connection) -> None:
    """Be the process that was asked for; never return."""
    try:
        requests.close()
        os.setsid()
        sender.send(run(module, argument))
        os._exit(0)  # threads and hooks of the module have nothing left to do
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(1)
