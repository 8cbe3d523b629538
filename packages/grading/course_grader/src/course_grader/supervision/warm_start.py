"""Starts processes with slow imports at the cost of a fork: a server imports once, and forks on request.

Unlike multiprocessing's forkserver, it needs no socket in the temporary folder, whose path may be too long for one, and
does not start Python again: the server is a fork of this process. If a program without isolation ends or stops the
server, another one replaces it.

Threads: create a WarmStart while the process has one thread; ``start`` may then be called in any.
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

MAX_SERVERS = 3  # that are tried to start one process
IMPORT_TIMEOUT = 60.0  # [s] of wall time on a loaded machine; a server that does not answer was stopped


class WarmStart:
    """Calls ``run(module, argument)`` in processes that have imported ``module``; its result is sent back."""

    def __init__(self, module: str, run: Callable[[ModuleType, Any], object]) -> None:
        """Start the server; it imports while the caller continues.

        If the module has a function ``prepare(argument)``, the server calls it before it forks, for more imports.
        """
        self._module, self._run, self._lock = module, run, threading.Lock()
        self._start_server(multiprocessing.get_context('fork').Process)

    def _start_server(self, kind: Callable[..., BaseProcess]) -> None:
        self._requests, theirs = multiprocessing.Pipe()
        self._server = kind(target=_serve, args=(self._module, self._run, theirs, self._requests, os.getpid()))
        self._server.start()
        self._identity = psutil.Process(self._server.pid)
        theirs.close()

    def start(self, argument: object) -> Tuple[psutil.Process, Connection]:
        """Fork a process; return it and the pipe that receives its result, or is closed without one.

        Raise OSError if no server answers.
        """
        receiver, sender = multiprocessing.Pipe(duplex=False)
        with sender, self._lock:
            for _ in range(MAX_SERVERS):
                with contextlib.suppress(EOFError, OSError, psutil.Error):
                    return self._fork(argument, sender), receiver
                self._end_server()
                # not by fork, because this process may have several threads now
                self._start_server(multiprocessing.get_context('spawn').Process)
        receiver.close()
        raise ChildProcessError('the process that starts gradings was ended or stopped again and again')

    def _fork(self, argument: object, sender: Connection) -> psutil.Process:
        self._requests.send(argument)
        reduction.send_handle(self._requests, sender.fileno(), self._identity.pid)
        if not self._requests.poll(IMPORT_TIMEOUT):
            raise TimeoutError
        started = psutil.Process(self._requests.recv())
        self._requests.send(None)  # from now on its id may be reused
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
    os.setsid()  # Ctrl-C is for the caller, which then ends this process
    processes.end_with_parent(signal.SIGKILL, parent)
    for number in processes.END_SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    del sys.argv[1:]  # otherwise rospy would apply remappings of a graded command
    # A package of a catkin workspace, once imported, puts its source folder first, where its messages are not.
    first = os.environ.get('PYTHONPATH', '').split(os.pathsep)
    sys.path[:] = [*first, *(path for path in sys.path if path not in first)]
    imported = importlib.import_module(module)
    prepare, known = getattr(imported, 'prepare', lambda argument: None), 0
    with contextlib.suppress(EOFError):
        while True:
            argument = requests.recv()
            prepare(argument)
            if len(sys.modules) > known:
                gc.freeze()  # imported modules are never garbage
                known = len(sys.modules)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)  # the next child keeps its id until the caller knows it
            sender = Connection(reduction.recv_handle(requests), readable=False)
            server = os.getpid()
            child = os.fork()
            if not child:
                processes.end_with_parent(signal.SIGKILL, server)
                _work(imported, run, argument, requests, sender)
            sender.close()
            requests.send(child)
            requests.recv()
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # ended children are reaped by the kernel
            with contextlib.suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG)[0]:
                    pass
    os._exit(0)


def _work(module: ModuleType, run: Callable[[ModuleType, Any], object], argument: object, requests: Connection,
          sender: Connection) -> None:
    """Run the requested process; never return."""
    try:
        requests.close()
        os.setsid()
        sender.send(run(module, argument))
        os._exit(0)  # without the threads and exit hooks of the module
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(1)
