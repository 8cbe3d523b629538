"""A terminal that returns each key at once, for programs that are driven with keys."""
import os
import signal
import termios
from typing import Any


class KeyTerminal:
    """In the ``with`` block, a file descriptor's terminal returns each key at once and does not echo it.

    The terminal's settings are always restored, even while the program is suspended (Ctrl-Z). A file or pipe is not
    changed. Use it in the main thread.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self.is_terminal = os.isatty(descriptor)

    def __enter__(self) -> 'KeyTerminal':
        if self.is_terminal:
            self._found = termios.tcgetattr(self._descriptor)
            self._handlers = {signal.SIGTSTP: signal.signal(signal.SIGTSTP, self._suspend),
                              signal.SIGCONT: signal.signal(signal.SIGCONT, self._set)}
            self._set()
        return self

    def __exit__(self, *_: object) -> None:
        if self.is_terminal:
            for number, handler in self._handlers.items():
                signal.signal(number, handler)
            self._restore()

    def _set(self, *_: Any) -> None:
        mode = termios.tcgetattr(self._descriptor)
        mode[3] &= ~(termios.ICANON | termios.ECHO)
        mode[6][termios.VMIN], mode[6][termios.VTIME] = 1, 0
        termios.tcsetattr(self._descriptor, termios.TCSANOW, mode)

    def _restore(self) -> None:
        try:
            termios.tcsetattr(self._descriptor, termios.TCSANOW, self._found)
        except termios.error:
            pass  # the terminal was closed

    def _suspend(self, *_: Any) -> None:
        self._restore()
        os.kill(os.getpid(), signal.SIGSTOP)
