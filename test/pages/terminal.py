"""A terminal to type into: a bash behind a pseudo-terminal, whose output a thread collects.

Threads: the reading thread appends to the output, the others only read it.
"""
import codecs
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import termios
import threading
import time

PROMPT = re.compile(r'(?:\(turtle_robotont\) [^\n]*|(?:\A|\n)page)[$#] \Z')
OWN_PROMPT = 'page$ '
ANSI = re.compile(r'\x1b\[[0-9;?]*[A-Za-z]|\x1b\][^\x07]*\x07|\x1b[=>]|\x07')
SIZE = struct.pack('HHHH', 50, 1000, 0, 0)  # rows and columns, so that nothing is wrapped
STARTED = 1.0  # [s] after its first line, a program counts as started by the reader who types the next command
SILENT = 10.0  # [s] the same for a program that prints nothing
AGAIN = 10.0  # [s] after which Ctrl-C is pressed again: roslaunch is slow, and a second one makes it faster
POLL = 0.05  # [s]


class TerminalError(RuntimeError):
    """The terminal did not reach the expected state; the text names it."""


class Terminal:
    """A bash in ``folder`` with these environment variables."""

    def __init__(self, folder, environment):
        self._master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, SIZE)
        self._process = subprocess.Popen(['bash', '--norc', '--noprofile', '-i'], cwd=folder, stdin=slave, stdout=slave,
                                         stderr=slave, start_new_session=True, preexec_fn=_use_terminal,
                                         env=dict(environment, PS1=OWN_PROMPT, TERM='dumb'))
        os.close(slave)
        self._output, self._typed_at, self._last_news = '', 0, time.monotonic()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _begin(self):
        self._typed_at = 0
        self._note_news()

    def _note_news(self):
        self._last_news = time.monotonic()

    def _read(self):
        decoder = codecs.getincrementaldecoder('utf-8')('replace')
        while True:
            try:
                text = decoder.decode(os.read(self._master, 65536))
            except OSError:  # the last program has closed its side
                return
            self._output += ANSI.sub('', text).replace('\r', '')
            self._last_news = time.monotonic()

    @property
    def transcript(self):
        """Return everything that was shown."""
        return self._output

    def printed(self):
        """Return the lines printed since the last command was typed, without that one and the prompt."""
        lines = PROMPT.sub('', self._output[self._typed_at:]).splitlines()
        return lines[1:]

    def free(self):
        """Return whether the last command has ended: the prompt is there."""
        return PROMPT.search(self._output[self._typed_at:]) is not None

    def silent_for(self):
        """Return how long [s] it printed nothing."""
        return time.monotonic() - self._last_news

    def type(self, command, timeout):
        """Type a command as soon as the last one has ended; TerminalError after timeout [s] of silence."""
        self.wait_free(timeout)
        self._typed_at = len(self._output)
        self.send(command + '\n')

    def send(self, text):
        """Send key presses."""
        os.write(self._master, text.encode())
        self._last_news = time.monotonic()

    def wait_free(self, timeout):
        """Wait until the last command has ended; TerminalError after timeout [s] of silence."""
        while not self.free():
            if self.silent_for() > timeout:
                raise TerminalError(f'the last command has not ended; it printed:\n{self.tail()}')
            time.sleep(POLL)

    def wait_started(self):
        """Wait until the last command has ended, or has printed something a second ago, or SILENT is over."""
        end, printed = time.monotonic() + SILENT, None
        while not self.free() and time.monotonic() < end:
            if printed is None and self.printed():
                printed, end = True, time.monotonic() + STARTED
            time.sleep(POLL)

    def tail(self):
        """Return the last lines printed."""
        return '\n'.join(f'  | {line}' for line in self.printed()[-20:])

    def end_program(self, timeout):
        """Press Ctrl-C until the prompt is there; return the list of programs that did not end."""
        end = time.monotonic() + timeout
        while not self.free():
            self.send('\x03')
            pressed = time.monotonic()
            while not self.free() and time.monotonic() < pressed + AGAIN:
                time.sleep(POLL)
            if time.monotonic() > end and not self.free():
                return [f'did not end by Ctrl-C:\n{self.tail()}']
        return []

    def close(self, timeout):
        """End the program and the shells; return the list of programs that did not end by Ctrl-C."""
        stubborn = self.end_program(timeout)
        os.killpg(self._process.pid, signal.SIGHUP)
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        return stubborn


def _use_terminal():
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
