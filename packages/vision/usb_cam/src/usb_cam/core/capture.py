"""Read images from a source, and open it again if it fails. Without ROS.

Threading contract: ``start``, ``stop``, ``wake`` and ``close`` may be called from any thread. A thread of the Capture
opens, reads and closes sources and calls the sink; ``wanted``, which must not block, is called by other threads too.
"""
import threading
import time
from typing import Callable, Optional, Protocol

from usb_cam.core.sources import EndOfSource, Source, SourceError

RETRY = 1.0  # [s] between two attempts to open a source
STOP_TIMEOUT = 5.0  # [s] for stopping, because OpenCV waits for a webcam that hangs


class Sink(Protocol):
    """Receives the images of a Capture."""

    def wanted(self) -> bool:
        """Return whether there is a subscriber."""

    def opened(self, source: Source) -> None:
        """Handle a new source, which has been opened."""

    def picture(self, source: Source) -> None:
        """Retrieve the image that the source has grabbed; called only while wanted."""

    def trouble(self, text: str) -> None:
        """Handle the lack of images, for the reason ``text``; another attempt follows."""

    def ended(self) -> None:
        """Handle the end of the source after its last image; Capture.start plays it again."""


class FrameSchedule:
    """A fixed time grid for the images of a file, so that delays do not add up.

    Deadlines at ``rate`` [Hz], the first one at once; ``clock`` returns seconds and never goes back.
    """

    def __init__(self, rate: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._period, self._clock = 1.0 / rate, clock
        self.restart()

    def restart(self) -> None:
        """Start a new grid now, after a break."""
        self._start, self._slot = self._clock(), 0

    def time_left(self) -> float:
        """Return the time [s] until the next image is due; 0 or less: it is due."""
        return self._start + self._slot * self._period - self._clock()

    def advance(self) -> None:
        """Advance to the next deadline; skip missed ones, so that no burst of images follows."""
        missed = max(0, int(-self.time_left() / self._period))
        self._slot += 1 + missed


class Capture:
    """A thread between ``open_source()``, which returns a Source or raises SourceError, and a sink.

    A webcam is read even without a subscriber, so that its images are fresh; files pause, so that no subscriber misses
    their start.
    """

    def __init__(self, open_source: Callable[[], Source], sink: Sink, retry: float = RETRY) -> None:
        self._open, self._sink, self._retry = open_source, sink, retry
        self._change = threading.Condition()
        self._running, self._closed, self._idle = False, False, True
        self._thread = threading.Thread(target=self._run, name='capture', daemon=True)
        self._thread.start()

    def start(self) -> None:
        """Start capturing."""
        with self._change:
            self._running = True
            self._change.notify_all()

    def stop(self) -> bool:
        """Close the source; return whether it is closed within STOP_TIMEOUT; after that, no image comes.

        Also return True if another thread has called start() in the meantime.
        """
        with self._change:
            self._running = False
            self._change.notify_all()
            return self._change.wait_for(lambda: self._idle or self._running, STOP_TIMEOUT)

    def wake(self) -> None:
        """Check again whether images are wanted."""
        with self._change:
            self._change.notify_all()

    def close(self) -> None:
        """End the thread."""
        with self._change:
            self._closed = True
        self.stop()
        self._thread.join(STOP_TIMEOUT)

    def _run(self) -> None:
        while True:
            with self._change:
                self._idle = not self._running
                self._change.notify_all()
                self._change.wait_for(lambda: self._running or self._closed)
                if self._closed:
                    self._idle = True
                    return
                self._idle = False
            self._attempt()

    def _attempt(self) -> None:
        source: Optional[Source] = None
        try:
            source = self._open()
            self._sink.opened(source)
            self._play(source)
        except EndOfSource:
            with self._change:
                self._running = False
            self._sink.ended()
        except SourceError as error:
            self._sink.trouble(str(error))
            self._wait(self._retry)
        finally:
            if source is not None:
                source.close()

    def _play(self, source: Source) -> None:
        schedule = None if source.live else FrameSchedule(source.rate)
        while self._running:
            if schedule is not None:
                if not self._sink.wanted():
                    with self._change:
                        self._change.wait_for(lambda: not self._running or self._sink.wanted())
                    schedule.restart()
                elif schedule.time_left() > 0.0:
                    self._wait(schedule.time_left())
                    continue
                else:
                    schedule.advance()
                    self._show(source)
            else:
                self._show(source)

    def _show(self, source: Source) -> None:
        source.grab()
        if self._running and self._sink.wanted():
            self._sink.picture(source)

    def _wait(self, duration: float) -> None:
        with self._change:
            self._change.wait_for(lambda: not self._running, duration)
