"""turtle_teleop_key without ROS: the keys in a stream of bytes, and a real terminal (pty) that is put back."""
import os
import pty
import random
import signal
import subprocess
import sys
import termios
import threading

import pytest

from turtlesim import teleop
from turtlesim.teleop import QUIT, KeyDecoder, KeyTerminal, TeleopNode, keys_from

UP, DOWN, RIGHT, LEFT = b'\x1b[A', b'\x1b[B', b'\x1b[C', b'\x1b[D'
SECONDS = 20  # more than enough for what takes milliseconds

KEYS = [
    # bytes, keys
    (UP, ['up']),
    (DOWN, ['down']),
    (RIGHT, ['right']),
    (LEFT, ['left']),
    (b'\x1bOA\x1bOB\x1bOC\x1bOD', ['up', 'down', 'right', 'left']),  # application cursor mode, as in some terminals
    (b'\x1b[1;2A\x1b[1;5D', ['up', 'left']),  # with Shift, with Ctrl
    (b'\x1b\x1b[A', ['up']),  # with Alt in rxvt; or a lone Escape, then up
    (b'\x1b[1;1:1A\x1b[1;1:2A\x1b[1;1:3A', ['up', 'up']),  # kitty: pressed, repeated, released
    (b'q', [QUIT]),
    (b'Q', [QUIT]),
    (b'\x1bq', [QUIT]),  # a lone Escape, then q
    (b'\x03', [QUIT]),
    (b'\x04', [QUIT]),
    (UP + b'q' + UP, ['up', QUIT, 'up']),
    (UP + UP + LEFT, ['up', 'up', 'left']),
    (b'ABCDwasdhjkl [A OA\r\n\t\x00\x7f', []),  # letters that end the sequences of arrows are not arrows
    ('ä→🐢q'.encode(), [QUIT]),
    (b'\x1bOP\x1b[[A\x1b[15~\x1b[3~\x1b[H\x1b[Z', []),  # F1, F1 of the console, F5, Delete, Home, Shift-Tab
    (b'\x1b[5A\x1b[2;3A\x1b[?1A', []),  # sequences that end like an arrow, but are not key presses
    (b'\x1b[200~' + UP + b'\x1b[201~', ['up']),
    (b'\x1b', []),
    (b'\x1b[', []),
    (b'\x1b[\x1b[A', ['up']),  # a sequence broken off
    (b'\x1b[' + b'1' * 100 + b'q', [QUIT]),  # too long for a sequence: not kept forever
]


@pytest.mark.parametrize('data,keys', KEYS)
def test_keys_are_decoded_however_the_bytes_arrive(data, keys):
    for cut in range(len(data)):
        decoder = KeyDecoder()
        assert decoder.feed(data[:cut]) + decoder.feed(data[cut:]) == keys, f'cut before byte {cut}'
    decoder = KeyDecoder()
    assert [key for byte in data for key in decoder.feed(bytes([byte]))] == keys


def test_noise_breaks_nothing_and_is_not_kept():
    noise, decoder = random.Random(1), KeyDecoder()
    for _ in range(2000):
        decoder.feed(bytes(noise.choice(b'\x1b[O;:0123456789ABCD~ q\xff') for _ in range(noise.randrange(40))))
    assert len(decoder._rest) < 40
    assert decoder.feed(b'\x18' + UP) [-1] == 'up'


@pytest.fixture
def terminal():
    """Both ends of a terminal: the user's, the program's."""
    user, program = pty.openpty()
    yield user, program
    for descriptor in (user, program):
        try:
            os.close(descriptor)
        except OSError:
            pass  # closed by the test


def test_a_terminal_gives_keys_at_once_unseen_and_is_put_back(terminal):
    user, program = terminal
    before = termios.tcgetattr(program)
    with KeyTerminal(program) as keys:
        assert keys.is_terminal
        local = termios.tcgetattr(program)[3]
        assert not local & (termios.ICANON | termios.ECHO)
        assert local & termios.ISIG  # Ctrl-C and Ctrl-Z still work
        os.write(user, UP)
        assert os.read(program, 100) == UP
    assert termios.tcgetattr(program) == before


@pytest.mark.parametrize('error', [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_terminal_is_put_back_whatever_happens(terminal, error):
    _, program = terminal
    before = termios.tcgetattr(program)
    with pytest.raises(error), KeyTerminal(program):
        raise error
    assert termios.tcgetattr(program) == before


def test_a_terminal_that_was_closed_meanwhile_is_no_error(terminal):
    user, program = terminal
    with KeyTerminal(program):
        os.close(user)
        os.close(program)


def test_signal_handlers_are_put_back(terminal):
    handlers = [signal.getsignal(number) for number in (signal.SIGTSTP, signal.SIGCONT)]
    with KeyTerminal(terminal[1]):
        assert signal.getsignal(signal.SIGTSTP) not in handlers
    assert [signal.getsignal(number) for number in (signal.SIGTSTP, signal.SIGCONT)] == handlers


def test_a_suspended_program_leaves_the_terminal_as_it_was_and_takes_it_again(terminal):
    user, program = terminal
    before = termios.tcgetattr(program)
    code = (f'import sys; sys.path[:0] = {sys.path!r}; from turtlesim.teleop import KeyTerminal\n'
            'with KeyTerminal(0): print("ready", flush=True); input()')
    child = subprocess.Popen([sys.executable, '-c', code], stdin=program, stdout=subprocess.PIPE,
                             preexec_fn=os.setpgrp)  # in an orphaned group, SIGTSTP does nothing
    try:
        assert child.stdout.readline() == b'ready\n'
        assert termios.tcgetattr(program) != before
        child.send_signal(signal.SIGTSTP)
        _, status = os.waitpid(child.pid, os.WUNTRACED)
        assert os.WIFSTOPPED(status)
        assert termios.tcgetattr(program) == before
        child.send_signal(signal.SIGCONT)
        os.write(user, b'\n')
        assert child.wait(SECONDS) == 0
        assert termios.tcgetattr(program) == before
    finally:
        child.kill()
        child.wait()


def test_what_is_no_terminal_is_left_alone():
    reader, writer = os.pipe()
    with KeyTerminal(reader) as keys:
        assert not keys.is_terminal
    os.close(reader)
    os.close(writer)


class Keyboard:
    """Keys through pipes: one to write them to, one to wake the reader."""

    def __init__(self):
        self.reader, self.writer = os.pipe()
        self.wake_reader, self.wake_writer = os.pipe()

    def keys(self):
        return keys_from(self.reader, self.wake_reader)

    def type(self, data):
        os.write(self.writer, data)
        return self

    def end(self):
        os.close(self.writer)
        return self


def test_keys_come_one_by_one_until_the_end_of_the_input():
    assert list(Keyboard().type(UP + b'x' + LEFT).end().keys()) == ['up', 'left']


def test_nothing_after_quit():
    assert list(Keyboard().type(UP + b'q' + UP).keys()) == ['up']


def test_a_key_comes_before_the_next_one_is_typed():
    keyboard = Keyboard()
    keys = keyboard.keys()
    for data, key in ((UP, 'up'), (RIGHT, 'right')):
        keyboard.type(data)
        assert next(keys) == key


def test_waking_ends_the_waiting():
    keyboard, keys = Keyboard(), []
    reader = threading.Thread(target=lambda: keys.extend(keyboard.keys()), daemon=True)
    reader.start()
    os.write(keyboard.wake_writer, b'.')
    reader.join(SECONDS)
    assert not reader.is_alive() and keys == []


def test_a_terminal_that_hangs_up_ends_the_keys(terminal):
    user, program = terminal
    with KeyTerminal(program):
        keys = keys_from(program, Keyboard().wake_reader)
        os.write(user, UP)
        assert next(keys) == 'up'
        os.close(user)
        assert list(keys) == []


class LatePublisher:
    """A publisher that a subscriber, which the master knows, connects to a moment later; it calls ``on_subscribe``."""

    resolved_name = '/turtle1/cmd_vel'

    def __init__(self, _topic, _type, listener):
        self.connections, self.sent, self._listener = 0, [], listener

    def connect(self):
        self.connections = 1
        self._listener.peer_subscribe(self.resolved_name, None, None)

    def get_num_connections(self):
        return self.connections

    def wanted(self):
        return self.connections > 0

    def publish(self, twist):
        self.sent.append((self.connections, twist.linear.x))


@pytest.mark.parametrize('known, connections', [(['/turtlesim'], 1), ([], 0)])
def test_the_first_key_waits_for_a_simulator_that_the_master_knows(monkeypatch, known, connections):
    warned = []
    for name, value in {'LatestPublisher': LatePublisher, '_scale': lambda name: 2.0}.items():
        monkeypatch.setattr(teleop, name, value)
    monkeypatch.setattr(teleop.rospy, 'on_shutdown', lambda hook: None)
    monkeypatch.setattr(TeleopNode, '_listeners', lambda self: known)
    node = TeleopNode()
    monkeypatch.setattr(node._throttle, 'warn', lambda *said: warned.append(said))
    if known:
        threading.Timer(0.1, node._publisher.connect).start()
    node._press('up')
    assert node._publisher.sent == [(connections, 2.0)]
    assert bool(warned) is not bool(known)
