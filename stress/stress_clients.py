"""Clients that never read, are stopped or killed, come and go, stay idle or are slow; and what an idle node uses."""

import functools
import os
import signal
import socket
import sys
import time

from turtlesim.msg import Pose

import tcpros
from figures import Figure, Target, median, median_rate
from processes import cpu_between, tree_cpu
from trial import Attack, Trial, answers, listen, losses
from under_test import SPAN, TROUBLE, rate, running

HERE = os.path.dirname(os.path.abspath(__file__))
TOPIC = '/turtle1/pose'
SMALL_BUFFER = 4096  # [bytes] of a subscriber that never reads, so that it is full soon
RATE = Target('near', 62.5)
PATHS = HERE, os.path.join(os.path.dirname(HERE), 'bench')
PROBES = 9  # of each kind
SLOW_PERIOD = 0.5  # [s] between two bytes of a slow header
PATIENT = 15.0  # [s] for a call beside 2,000 connections
STOPPED = '''
import sys, threading
sys.path[:0] = sys.argv[1].split(':')
import tcpros
from turtlesim.msg import Pose
receivers = [tcpros.Receiver(tcpros.subscribe(sys.argv[2], '/turtle1/pose', Pose)) for _ in range(int(sys.argv[3]))]
print('ready', flush=True)
threading.Event().wait()
'''


def start(subject, scale, _rng):
    """Memory, descriptors and threads of a node that nobody uses."""
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        time.sleep(scale.seconds(2.0, 0.5))
        return {'start_memory': [node.memory()], 'start_descriptors': [node.descriptors()],
                'start_threads': [node.threads()]}


def never_reading(subject, scale, _rng):
    """50, then 300 subscribers that never read: does the one that reads get every pose?"""
    found = {}
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        receiver, deaf_ones = node.receiver(), []
        for count in (50, 300):
            while len(deaf_ones) < count:
                deaf_ones.append(trial.answered(lambda: tcpros.subscribe(node.uri, TOPIC, Pose, buffer=SMALL_BUFFER)))
            begun, before = time.monotonic(), tree_cpu(node.pid)
            found[f'unread_rate_{count}'] = [rate(receiver, scale.seconds(10.0, 2.0))]
            found[f'unread_cpu_{count}'] = [100.0 * cpu_between(before, tree_cpu(node.pid)) /
                                            (time.monotonic() - begun)]
            found[f'unread_memory_{count}'] = [node.memory()]
        receiver.close()
        for one in filter(None, deaf_ones):
            one.close()
        found.update(trial.samples('unread'))
    return found


def stopped(subject, scale, _rng):
    """30 subscribers in a process that is stopped, and then killed."""
    count = scale.count(30, 30)
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        receiver = node.receiver()
        command = [sys.executable, '-c', STOPPED, os.pathsep.join(PATHS), node.uri, str(count)]
        with subject.start('stopped subscribers', command) as child:
            _await_ready(child)
            trial.inputs += count
            os.kill(child.pid, signal.SIGSTOP)
            found = {'stopped_rate': [rate(receiver, scale.seconds(10.0, 2.0))]}
            os.kill(child.pid, signal.SIGKILL)
            found['killed_rate'] = [rate(receiver, scale.seconds(5.0, 2.0))]
        receiver.close()
        found.update(trial.samples('stopped'))
    return found


def _await_ready(child, deadline=30.0):
    end = time.monotonic() + deadline
    while 'ready' not in child.tail():
        child.require_alive()
        if time.monotonic() > end:
            raise tcpros.NeverAnswered('the subscribers')
        time.sleep(0.05)


def coming_and_going(subject, scale, _rng):
    """1,000 subscribers, one after the other; half of them close in the middle of a message."""
    count = scale.count(1000, 60)
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        receiver = node.receiver()
        start = len(receiver.stamps)
        seconds = []
        place = node.tcpros_place()
        for number in range(count):
            before = time.monotonic()
            trial.answered(functools.partial(_come_and_go, place, number % 2))
            seconds.append(1e3 * (time.monotonic() - before))
        found = {'connect_time': seconds, 'connect_rate': [median_rate(receiver.stamps[start:], SPAN)]}
        receiver.close()
        found.update(trial.samples('connects'))
    return found


def _come_and_go(place, read):
    connection = tcpros.connect(place)
    try:
        tcpros.send(connection, tcpros.subscription(TOPIC, Pose))
        tcpros.receive_frame(connection)
        if read:
            tcpros.receive(connection, 3)
    finally:
        connection.close()


def _timed(probe, node):
    """Return the time [ms] until ``probe(node)`` got its answer; None without an answer."""
    begun = time.monotonic()
    return 1e3 * (time.monotonic() - begun) if probe(node, PATIENT) else None


def idle(subject, scale, _rng):
    """Connections to the TCPROS and the XML-RPC port that send nothing: one, then 2,000 of each."""
    many = scale.count(2000, 200)
    found = {}
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        place = node.tcpros_place()
        for key, count, where in (('one', 1, place), ('many', many, place),
                                  ('slave', many, tcpros.address(node.uri))):
            opening = functools.partial(tcpros.connect, where, 5.0)
            open_ones = [trial.answered(opening) for _ in _while_answered(trial, count)]
            found[f'idle_{key}_open'] = [len(list(filter(None, open_ones)))]
            for word, probe in scale.count(PROBES, 1) * (('call', answers), ('subscriber', listen)):
                if trial.hung > 2:
                    break
                took = _timed(probe, node)
                trial.inputs += 1
                if took is None:
                    trial.hung += 1
                else:
                    found.setdefault(f'idle_{key}_{word}', []).append(took)
            for one in filter(None, open_ones):
                one.close()
        found.update(trial.samples('idle'))
    return found


def _while_answered(trial, count):
    """Yield numbers up to ``count`` as long as few connections are refused."""
    for number in range(count):
        if trial.hung > 2:  # that is clear, and each costs a deadline
            return
        yield number


def slow(subject, scale, _rng):
    """Headers that come a byte at a time, requests that stop in the middle, and a length of 0xffffffff."""
    count = scale.count(20, 10)
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        hello = tcpros.subscription(TOPIC, Pose)
        open_ones = [trial.answered(lambda: tcpros.connect(node.tcpros_place(), 5.0))
                     for _ in _while_answered(trial, 3 * count)]
        open_ones = [one for one in open_ones if one]
        for one in open_ones[::3]:
            one.sendall(b'\xff\xff\xff\xff')
        for one in open_ones[1::3]:
            one.sendall(hello[:len(hello) // 2])
        found = {'slow_call': [], 'slow_subscriber': []}
        for byte in hello[:scale.count(20, 4)]:
            for one in open_ones[2::3]:
                _send_byte(one, byte)
            for word, probe in (('call', answers), ('subscriber', listen)):
                begun = time.monotonic()
                trial.inputs += 1
                if probe(node):
                    found[f'slow_{word}'].append(1e3 * (time.monotonic() - begun))
                else:
                    trial.hung += 1
            if trial.hung > 2:
                break
            time.sleep(SLOW_PERIOD)
        for one in open_ones:
            one.close()
        found.update(trial.samples('slow'))
    return found


def _send_byte(connection, byte):
    try:
        connection.send(bytes([byte]), socket.MSG_DONTWAIT)
    except TROUBLE:
        pass  # the node has closed it, as it may


ATTACKS = {
    'start': Attack(start, 'memory, descriptors and threads at the start'),
    'unread': Attack(never_reading, '50 and 300 subscribers that never read'),
    'stopped': Attack(stopped, '30 subscribers stopped, then killed'),
    'connects': Attack(coming_and_going, '1,000 subscribers that come and go'),
    'idle': Attack(idle, 'connections that say nothing'),
    'slow': Attack(slow, 'headers a byte at a time'),
}


def _idle_figures():
    words = {'one': '1 idle TCPROS connection', 'many': '2,000 idle TCPROS connections',
             'slave': '2,000 idle connections to the slave port'}
    for key, text in words.items():
        yield Figure(f'{text}: taken', f'idle_{key}_open', 'connections')
        yield Figure(f'{text}: service call', f'idle_{key}_call', 'ms', median, Target('below', 200.0))
        yield Figure(f'{text}: new subscriber', f'idle_{key}_subscriber', 'ms', median, Target('below', 200.0))
    yield from losses('idle', 'idle connections')


FIGURES = (
    Figure('start: memory', 'start_memory', 'MB', median, Target('below', 60.0)),
    Figure('start: descriptors', 'start_descriptors', 'open', median, Target('below', 25.0)),
    Figure('start: threads', 'start_threads', 'running', median, Target('below', 20.0)),
    Figure('rate, 50 subscribers that never read', 'unread_rate_50', 'Hz', median, RATE),
    Figure('CPU, 50 subscribers that never read', 'unread_cpu_50', '% of a core'),
    Figure('rate, 300 subscribers that never read', 'unread_rate_300', 'Hz', median, RATE),
    Figure('CPU, 300 subscribers that never read', 'unread_cpu_300', '% of a core'),
    Figure('memory, 300 subscribers that never read', 'unread_memory_300', 'MB', median, Target('below', 100.0)),
    *losses('unread', 'subscribers that never read'),
    Figure('rate, 30 stopped subscribers', 'stopped_rate', 'Hz', median, RATE),
    Figure('rate, the same killed', 'killed_rate', 'Hz', median, RATE),
    *losses('stopped', 'stopped subscribers'),
    Figure('connect and disconnect', 'connect_time', 'ms'),
    Figure('rate, 1,000 connects', 'connect_rate', 'Hz', median, RATE),
    *losses('connects', 'connects'),
    *_idle_figures(),
    Figure('slow headers: service call', 'slow_call', 'ms', max, Target('below', 200.0)),
    Figure('slow headers: new subscriber', 'slow_subscriber', 'ms', max, Target('below', 200.0)),
    *losses('slow', 'slow headers'),
)
