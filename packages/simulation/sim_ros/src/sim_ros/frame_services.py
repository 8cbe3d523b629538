"""Services that a simulator answers between two steps, like a single-threaded node.

A call is queued when it arrives. At the start of each step, the stepping thread takes all queued calls and answers them
in the order of their arrival; the answers are sent before anything that the step publishes. So consecutive calls of one
client take one step each, and calls of different clients share one.

Calls that need the master do not delay the steps: their handler is a generator that yields functions. Each function is
called in another thread, and the yield returns its result or raises its exception. The step waits for it for a short
time, which is nearly always enough, so that order and time are those of one thread; otherwise the call, and later
ones that need the master, continue in the next steps, which do not wait for it again.

Threading contract: ``put`` may be called from any thread, ``answer`` from the one that steps; handlers run there.
"""
from __future__ import annotations

import inspect
import math
import queue
import threading
import time
from typing import Any, Callable, Generator

import rospy

from rospy_support.rospy_internals import QueuedService, ServiceCall, caller

Handler = Callable[[Any], Any]  # of a request; it returns the response, or is a generator

MASTER_TIMEOUT = 0.03  # [s] of wall time that a step waits for calls of the master, which take about 3 ms


class FrameServices:
    """The services of one simulator."""

    def __init__(self, on_call: Callable[[], object] = lambda: None, by_name: bool = False) -> None:
        """``on_call()`` is called, in any thread, when there is something to answer.

        ``by_name``: answer the calls of one step in the order of callers and services. The order of arrival depends on
        chance if several nodes call.
        """
        self._on_call, self._by_name = on_call, by_name
        self._lock = threading.Lock()
        self._queued: list[tuple[ServiceCall, Handler]] = []  # (ServiceCall, its handler) since the last step
        self._unfinished: list[_Answer] = []  # _Answers that wait for the master, and those that wait for them
        self.batch = 0  # counts the steps with calls: an answer of the master in a step is valid for all its calls
        self._worker = _Worker(on_call)

    def add(self, name: str, service_class: type, handler: Handler) -> QueuedService:
        """Register a service and return it; ``handler(request)`` returns the response or is a generator that does."""
        return QueuedService(name, service_class, lambda call: self.put(call, handler))

    def put(self, call: ServiceCall, handler: Handler) -> None:
        """Queue a ServiceCall."""
        with self._lock:
            self._queued.append((call, handler))
        self._on_call()

    def answer(self, timeout: float = MASTER_TIMEOUT) -> None:
        """Answer the calls queued so far; wait for the master at most ``timeout`` [s of wall time].

        Later steps do not wait again for a call that took longer.
        """
        if not self._queued and not self._unfinished:
            return
        with self._lock:
            queued, self._queued = self._queued, []
        self.batch += 1
        if self._by_name:
            queued.sort(key=lambda each: (caller(each[0].request), each[0].service.resolved_name))
        answers = self._unfinished + [_Answer(call, handler, self._worker) for call, handler in queued]
        self._unfinished = []
        end = time.monotonic() + timeout
        for answer in answers:
            if (self._unfinished and answer.asks_master) or not answer.proceed(-math.inf if answer.late else end):
                self._unfinished.append(answer)


class _Answer:
    """The remaining work for one call."""

    def __init__(self, call: ServiceCall, handler: Handler, worker: _Worker) -> None:
        self.asks_master = inspect.isgeneratorfunction(handler)
        self._call, self._handler, self._worker = call, handler, worker
        self._steps: Generator[Callable[[], Any], Any, Any] | None = None
        self._job: _Job  # once there are steps

    @property
    def late(self) -> bool:
        """Return whether a step has already waited for it."""
        return self._steps is not None

    def proceed(self, end: float) -> bool:
        """Continue until ``end`` [s, monotonic] at the latest; return whether the call is answered."""
        try:
            self._call.answer(self._run(end) if self.asks_master else self._handler(self._call.request))
        except _Unfinished:
            return False
        except rospy.ServiceException as failure:
            self._call.fail(f'service cannot process request: {failure}')  # rospy's text
        except Exception as error:  # as in rospy, an error in a handler ends one call, not the node
            rospy.logerr('Error processing request: %s', error, exc_info=True)
            self._call.fail(f'error processing request: {error}')
        return True

    def _run(self, end: float) -> Any:
        try:
            if self._steps is None:
                self._steps = self._handler(self._call.request)
                self._job = self._worker.start(next(self._steps))
            while True:
                if not self._job.done.wait(max(0.0, end - time.monotonic())):
                    raise _Unfinished
                self._job = self._worker.start(self._job.give(self._steps))
        except StopIteration as result:
            return result.value


class _Unfinished(Exception):
    """Raised when a call still waits for the master."""


class _Job:
    """A function that is called in another thread."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self.done = threading.Event()
        self._function = function
        self._result: Any = None
        self._error: Exception | None = None

    def run(self) -> None:
        """Call it; ``done`` is set afterwards."""
        try:
            self._result = self._function()
        except Exception as error:  # give() raises it in the generator
            self._error = error
        self.done.set()

    def give(self, steps: Generator[Callable[[], Any], Any, Any]) -> Callable[[], Any]:
        """Continue a generator with the result; return its next value."""
        return steps.send(self._result) if self._error is None else steps.throw(self._error)


class _Worker:
    """The thread that waits for the master."""

    def __init__(self, on_done: Callable[[], object]) -> None:
        self._on_done = on_done
        self._jobs: queue.SimpleQueue[_Job] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None

    def start(self, function: Callable[[], Any]) -> _Job:
        """Queue a function; return its _Job."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name='frame_services', daemon=True)
            self._thread.start()
        job = _Job(function)
        self._jobs.put(job)
        return job

    def _work(self) -> None:
        while True:
            job = self._jobs.get()
            job.run()
            self._on_done()
