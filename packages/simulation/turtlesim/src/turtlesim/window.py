"""The simulator's window: a separate process, so that drawing never delays the simulator's steps.

The simulator uses a Window. The process is ``python3 -m turtlesim.window TITLE``: it shows the images (binary PPM, one
after another) from its standard input, until that ends or the user closes the window.

Threading contract: Window may be used from any thread; only ``close`` waits. One thread writes images, another one
waits for the window's process to end.
"""
from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from typing import IO, Any, Callable

from kinematic_core.worlds.turtle_world import BACKGROUND, CANVAS_SIZE
from plain_support.doctor import findings

TITLE = 'TurtleSim'
SHORTEST_PERIOD = 1.0 / 30.0  # [s] between two images shown; others are skipped
REDRAW_DELAY = 5  # [ms] of Tk after an image has arrived, so that only the newest of several is drawn
END_TIMEOUT = 1.0  # [s] for the window's process to end by itself
READ_SIZE = 1 << 20  # [bytes]

_HEADER = re.compile(rb'P6\s+(\d{1,5})\s+(\d{1,5})\s+255\s')
_MAX_HEADER = 32  # [bytes]


class Window:
    """A window of CANVAS_SIZE x CANVAS_SIZE px that shows the newest image."""

    def __init__(self, title: str = TITLE, report: Callable[[str], object] | None = None) -> None:
        """Open the window; this returns at once.

        If it cannot be opened or fails later, ``report(text)`` is called once, from another thread, with the problem
        and what to do; without ``report`` the text goes to the standard error stream.
        """
        self._report = report or (lambda text: print(text, file=sys.stderr, flush=True))
        self._change = threading.Condition()
        self._newest: Any = None
        self._last: Any = None
        self._closing = self._closed_by_user = False
        self._process: Any = _start(title)  # with pipes
        self._writer = threading.Thread(target=self._write, name='window pictures', daemon=True)
        self._watcher = threading.Thread(target=self._watch, name='window end', daemon=True)
        self._writer.start()
        self._watcher.start()

    @property
    def open(self) -> bool:
        """Return whether the window can show images: it is open, or about to open."""
        return self._process.returncode is None and not self._closing

    @property
    def closed(self) -> bool:
        """Return whether the user has closed the window; False if it could not be opened or has failed."""
        return self._closed_by_user

    def show(self, picture: Any) -> None:
        """Show an image: RGB, 8 bit, row by row from the top, as bytes or as an array of uint8.

        Do not change it afterwards. The same object is not sent again. Raise ValueError for another size.
        """
        size = picture.nbytes if hasattr(picture, 'nbytes') else len(picture)
        if size != 3 * CANVAS_SIZE * CANVAS_SIZE:
            raise ValueError(f'an image of {size} bytes; it must be {CANVAS_SIZE} x {CANVAS_SIZE} px of 3 bytes each')
        with self._change:
            if picture is not self._last:
                self._newest = self._last = picture
                self._change.notify()

    def close(self) -> None:
        """Close the window, and wait for its process to end, at most one or two seconds."""
        with self._change:
            self._closing = True
            self._change.notify()
        for end in (None, signal.SIGTERM, signal.SIGKILL):
            if end is not None:
                self._process.send_signal(end)
            self._watcher.join(END_TIMEOUT)
            if not self._watcher.is_alive():
                break
        self._writer.join(END_TIMEOUT)

    def _write(self) -> None:
        """Send the newest image, then wait until the next one may follow."""
        try:
            with self._process.stdin as pipe:
                while True:
                    with self._change:
                        self._change.wait_for(lambda: self._newest is not None or self._closing)
                        if self._closing:
                            return
                        picture, self._newest = self._newest, None
                    _send(pipe, picture)
                    time.sleep(SHORTEST_PERIOD)
        except OSError:
            pass  # the process has ended; _watch says why

    def _watch(self) -> None:
        error = self._process.stderr.read().decode(errors='replace').strip()
        code = self._process.wait()
        self._process.stderr.close()
        with self._change:
            closing, self._closing = self._closing, True
            self._closed_by_user = not closing and code == 0
            self._change.notify()
        if not closing and code != 0:
            self._report(f'{error or f"The window ended with code {code}."}\nThe simulator continues without a window.')


def _start(title: str) -> subprocess.Popen[bytes]:
    """Start the window's process in a new session, so that Ctrl-C in a terminal only reaches the simulator.

    It is not a plain_support.BackgroundProcess, whose output goes to a file, because threads use its pipes.
    """
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path))
    return subprocess.Popen([sys.executable, '-m', 'turtlesim.window', title], bufsize=0, env=environment,
                            stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def _send(pipe: IO[bytes], picture: Any) -> None:
    data = memoryview(b'P6 %d %d 255\n' % (CANVAS_SIZE, CANVAS_SIZE) + bytes(picture))
    while data:
        data = data[pipe.write(data):]


class ImageReader:
    """Finds the newest complete picture in a stream of binary PPM files of 8 bit that follow one another."""

    def __init__(self) -> None:
        self._rest = bytearray()

    def feed(self, data: bytes) -> bytes | None:
        """Return the last image that ``data`` completes, as the bytes of a PPM file, or None.

        Raise ValueError if the data are not such a stream.
        """
        self._rest += data
        newest: bytes | None = None
        while True:
            header = _HEADER.match(self._rest)
            if not header:
                if len(self._rest) >= _MAX_HEADER:
                    raise ValueError(f'{bytes(self._rest[:_MAX_HEADER])!r} is not a PPM image (P6 WIDTH HEIGHT 255)')
                return newest
            size = header.end() + 3 * int(header[1]) * int(header[2])
            if len(self._rest) < size:
                return newest
            newest = bytes(self._rest[:size])
            del header, self._rest[:size]


class _Viewer:
    """The window itself; everything happens in Tk's main loop."""

    def __init__(self, tkinter: Any, title: str, descriptor: int) -> None:
        self._images = ImageReader()
        self._newest: bytes | None = None
        self._descriptor = descriptor
        self._root = tkinter.Tk(className=title)
        self._root.title(title)
        self._root.resizable(False, False)
        self._image = tkinter.PhotoImage(width=CANVAS_SIZE, height=CANVAS_SIZE)
        tkinter.Label(self._root, image=self._image, background='#' + bytes(BACKGROUND).hex(),
                      borderwidth=0, highlightthickness=0, padx=0, pady=0).pack()
        os.set_blocking(descriptor, False)
        self._root.createfilehandler(descriptor, tkinter.READABLE, self._read)

    def run(self) -> None:
        """Show images until there are no more or the user closes the window."""
        self._root.mainloop()

    def _read(self, *_: object) -> None:
        try:
            data = os.read(self._descriptor, READ_SIZE)
        except BlockingIOError:
            return
        if not data:
            self._root.destroy()
            return
        picture = self._images.feed(data)
        if picture:
            if self._newest is None:
                self._root.after(REDRAW_DELAY, self._draw)
            self._newest = picture

    def _draw(self) -> None:
        self._image.configure(data=self._newest, format='PPM')
        self._newest = None


def main() -> None:
    """Run the window's process; exit with 0 if the window was closed, else with a text that says why."""
    try:
        import tkinter
    except ImportError as error:
        sys.exit(f'No window: Python\'s tkinter is missing ({error}). Install it: sudo apt install python3-tk')
    try:
        viewer = _Viewer(tkinter, sys.argv[1] if len(sys.argv) > 1 else TITLE, sys.stdin.fileno())
    except tkinter.TclError as error:
        sys.exit(str(findings.dead_display(os.environ.get('DISPLAY', ''), str(error))))
    try:
        viewer.run()
    except ValueError as error:
        sys.exit(f'The window ended: its standard input failed: {error}')


if __name__ == '__main__':
    main()
