"""Keeps pictures coming from a source, whatever happens to it. Without ROS.

Threading contract: ``start``, ``stop``, ``wake`` and ``close`` may be called from any thread. One thread of its own
opens, reads and closes sources and calls everything of the sink but ``wanted``, which must not wait.
"""
import threading

from usb_cam.pace import Pace
from usb_cam.sources import EndOfSource, SourceError

RETRY = 1.0  # [s] between two attempts to open what cannot be read
PATIENCE = 5.0  # [s] that stopping may take: a webcam that hangs is waited for inside OpenCV


class Capture:
    """A thread between ``open_source()``, which returns a source (sources.py) or raises SourceError, and a sink.

    The sink's methods: ``wanted()``: whether anybody looks; ``opened(source)``; ``picture(source)``: one was grabbed,
    called only while wanted; ``trouble(text)``: there are no pictures, another attempt follows; ``ended()``: the last
    picture was shown, start() begins again. A webcam is kept going while nobody looks, so that its pictures are fresh;
    files stand still then, so that nobody misses their beginning.
    """

    def __init__(self, open_source, sink, retry=RETRY):
        self._open, self._sink, self._retry = open_source, sink, retry
        self._change = threading.Condition()
        self._running, self._closed, self._idle = False, False, True
        self._thread = threading.Thread(target=self._run, name='capture', daemon=True)
        self._thread.start()

    def start(self):
        """Capture from now on."""
        with self._change:
            self._running = True
            self._change.notify_all()

    def stop(self):
        """Let go of the source; when this returns True there are no more pictures, False: it takes longer.

        It also returns True when somebody else's start() has overruled it.
        """
        with self._change:
            self._running = False
            self._change.notify_all()
            return self._change.wait_for(lambda: self._idle or self._running, PATIENCE)

    def wake(self):
        """Look again whether pictures are wanted."""
        with self._change:
            self._change.notify_all()

    def close(self):
        """End the thread."""
        with self._change:
            self._closed = True
        self.stop()
        self._thread.join(PATIENCE)

    def _run(self):
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

    def _attempt(self):
        source = None
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

    def _play(self, source):
        pace = None if source.live else Pace(source.rate)
        while self._running:
            if pace is not None:
                if not self._sink.wanted():
                    with self._change:
                        self._change.wait_for(lambda: not self._running or self._sink.wanted())
                    pace.restart()
                elif pace.left() > 0.0:
                    self._wait(pace.left())
                    continue
                else:
                    pace.next()
                    self._show(source)
            else:
                self._show(source)

    def _show(self, source):
        source.grab()
        if self._running and self._sink.wanted():
            self._sink.picture(source)

    def _wait(self, duration):
        with self._change:
            self._change.wait_for(lambda: not self._running, duration)
