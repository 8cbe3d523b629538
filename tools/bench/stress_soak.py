"""All simulators, camera, tracker, usb_cam and lessons for a long time, beside clients that misbehave: what grows?

Every few seconds each node is called and heard. In between, clients of the simulators take turns to misbehave: they
never read, send half a header, or call services from many threads at once.
"""
import contextlib
import random
import re
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import psutil
from nav_msgs.msg import Odometry
from robotont_gazebo.srv import SetPose
from scipy import stats
from std_srvs.srv import Empty
from turtlesim.msg import Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from figures import Figure, Target
from rostest_support import node_kinds, tcpros
from rostest_support.tcpros import TROUBLE
from trial import NOTHING, running

KEYS = ('turtlesim', 'robotont', 'camera', 'tracker', 'usb_cam', 'goto_pose_server', 'pose_subscriber',
        'velocity_publisher')
TOPICS = {'turtlesim': ('/turtle1/pose', Pose), 'robotont': ('/odom', Odometry)}  # and all messages of these come
RATES = {'turtlesim': 62.5, 'robotont': 30.0}  # [Hz]
SAMPLE = 5.0  # [s]
LOAD_EVERY = 3  # samples between two rounds of calls
HARMLESS = 50.0  # [MB a day] that a node may grow by: a week is less than half a gigabyte
EDGE = 5  # messages more or less at the ends of the count
SETTLE = 5.0  # [s]
DAY = 86400.0  # [s]
WARM_UP = 1.0 / 6.0  # share of a run that is left out: 10 minutes of an hour
BLOCKS = 20  # samples of memory are correlated over minutes; the means of so many blocks are not
MISBEHAVING = 50  # clients at once
CALLERS, STORM = 8, 1.0  # threads that call at once, and how long [s]
NAMES = tuple(f'storm{number}' for number in range(5))
START = -2.0, 0.0, 0.0  # x, y [m], yaw [rad] of the robot
SMALL_BUFFER = 4096  # [bytes] of a subscriber that never reads, so that it is full soon


def call(answers, node, name, kind, *values):
    """Call a service; note in the list ``answers`` whether it is answered. A refusal is an answer, too."""
    try:
        caller = node.caller(name, kind)
        with caller.socket:
            caller.call(*values)
    except socket.timeout:
        answers.append(False)
    except TROUBLE:
        pass  # the turtle is gone in the meantime, or the request was not even one
    else:
        answers.append(True)


def soak(subject, scale, rng):
    """Watch the nodes for an hour times the factor."""
    seconds = scale.seconds(3600.0, 20.0)
    period = min(SAMPLE, seconds / 60.0)
    with running(subject, *KEYS) as nodes:
        time.sleep(min(SETTLE, seconds / 6.0))
        receivers = {key: tcpros.Receiver(tcpros.subscribe(nodes[key].peer.uri, *topic))
                     for key, topic in TOPICS.items()}
        samples = {key: [] for key in nodes}  # time [s], memory [MB], descriptors, threads
        begun, number, deaf, answers, kept = time.monotonic(), 0, 0, [], []
        for receiver in receivers.values():
            receiver.stamps.clear()
        while time.monotonic() - begun < seconds:
            _sample(nodes, samples, time.monotonic() - begun)
            if number % LOAD_EVERY == LOAD_EVERY - 1:
                while kept:
                    kept.pop().close()
            if number % LOAD_EVERY == 0:
                deaf += sum(not node.answers() for node in nodes.values())
                kept = MISUSES[number // LOAD_EVERY % len(MISUSES)](nodes, answers, rng)
            number += 1
            time.sleep(max(0.0, begun + number * period - time.monotonic()))
        elapsed = time.monotonic() - begun
        found = {f'missed_{key}': [max(0.0, RATES[key] * elapsed - len(receiver.stamps) - EDGE)]
                 for key, receiver in receivers.items()}
        found.update({f'rate_{key}': [len(receiver.stamps) / elapsed] for key, receiver in receivers.items()})
        for connection in (*receivers.values(), *kept):
            connection.close()
        found.update(soak_deaf=[deaf], soak_calls=[sum(answers)], soak_unanswered=[answers.count(False)],
                     soak_ended=[sum(not node.child.runs() for node in nodes.values())],
                     soak_changed=[int(_turtles(nodes) != ['/turtle1/pose'])])
        for key, series in samples.items():
            found.update(_judged(key, np.array(series[int(WARM_UP * len(series)):])))
        return found


def _turtles(nodes):
    return sorted(name for name in nodes['turtlesim'].registered()[0] if name.endswith('/pose'))


def never_read(nodes, _answers, _rng):
    """Subscribe and never read; return the connections."""
    kept = [tcpros.subscribe(nodes[key].peer.uri, *topic) for key, topic in TOPICS.items() for _ in range(MISBEHAVING)]
    for connection in kept:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
    return kept


def half_headers(nodes, _answers, rng):
    """Begin connections to both ports of every node and say no more; return the connections."""
    hello = tcpros.header(callerid=tcpros.CALLER, **tcpros.LOG)
    return [tcpros.connect(place, hello[:rng.randrange(len(hello))]) for node in nodes.values()
            for place in (node.peer.address, node.peer.slave_address) for _ in range(MISBEHAVING // 10)]


def storm(nodes, answers, rng):
    """Call the services of both simulators from many threads at once; leave turtle1 alone in the end."""
    turtlesim, robotont = nodes['turtlesim'], nodes['robotont']
    end = time.monotonic() + STORM

    def client(seed):
        own = random.Random(seed)
        while time.monotonic() < end:
            name = own.choice(NAMES)
            call(answers, *own.choice((
                (turtlesim, '/spawn', Spawn, 5.0, 5.0, 0.0, name), (turtlesim, '/kill', Kill, name),
                (turtlesim, '/clear', Empty), (turtlesim, '/reset', Empty),
                (turtlesim, '/turtle1/set_pen', SetPen, own.randrange(256), 0, 0, 3, 0),
                (turtlesim, '/turtle1/teleport_absolute', TeleportAbsolute, own.uniform(1.0, 10.0), 5.0, 0.0),
                (turtlesim, '/turtle1/teleport_relative', TeleportRelative, 1.0, 1.0),
                (robotont, '/robotont_gazebo/set_pose', SetPose, own.uniform(-2.5, -1.5), 0.0, 0.0))))
    with ThreadPoolExecutor(CALLERS) as threads:
        list(threads.map(client, [rng.random() for _ in range(CALLERS)]))
    call(answers, turtlesim, '/reset', Empty)
    call(answers, robotont, '/robotont_gazebo/set_pose', SetPose, *START)
    return []


MISUSES = never_read, half_headers, storm


def _sample(nodes, samples, now):
    for key, node in nodes.items():
        with contextlib.suppress(OSError, psutil.Error):  # it has ended: soak_ended tells
            samples[key].append((now, own_memory(node.pid), node.peer.descriptors(), node.peer.threads()))


def own_memory(pid):
    """Return the memory [MB] that a process has filled itself.

    Its share of files such as libraries is left out: that grows when another program that uses them ends. psutil adds
    up the same from smaps, which takes six times as long.
    """
    with open(f'/proc/{pid}/smaps_rollup', encoding='utf-8') as file:
        found = re.findall(r'^(?:Pss_Anon|Pss_Shmem|SwapPss):\s*(\d+) kB$', file.read(), re.MULTILINE)
    return sum(map(int, found)) * 1024 / 1e6


def growth(samples):
    """Return the slope a day of (time [s], value) samples, and half the width of its 95 % interval."""
    means = np.array([np.mean(block, axis=0) for block in np.array_split(samples, BLOCKS)])
    line = stats.linregress(*means.T)
    return DAY * line.slope, DAY * np.nan_to_num(line.stderr) * stats.t.ppf(0.975, BLOCKS - 2)


def _judged(key, late):
    """Return {figure key: samples} of the samples (n, 4) after the warm-up; none if the node ended early."""
    if len(late) < BLOCKS:
        return {}
    first, last = (np.median(part, axis=0) for part in (late[:len(late) // 4], late[-(len(late) // 4):]))
    slope, margin = growth(late[:, :2])
    return {f'descriptors_{key}': [last[2] - first[2]], f'threads_{key}': [last[3] - first[3]],
            f'memory_{key}': [late[-1, 1]], f'slope_{key}': [slope], f'margin_{key}': [margin],
            f'proven_{key}': [int(slope > margin and slope + margin >= HARMLESS)]}


ATTACKS = {'soak': (soak, 'all simulators, camera, tracker, usb_cam and lessons beside clients that misbehave')}


def _figures():
    for key, word in (('turtlesim', 'poses'), ('robotont', 'odometry')):
        yield Figure(f'{word}: rate', f'rate_{key}', 'Hz', max, Target('near', RATES[key]))
        yield Figure(f'{word}: missed', f'missed_{key}', 'messages', max, NOTHING)
    yield Figure('a new subscriber or a call without an answer', 'soak_deaf', '', sum, NOTHING)
    yield Figure('calls of clients that misbehave', 'soak_calls', '', sum, Target('at_least', 1))
    yield Figure('the same without an answer', 'soak_unanswered', '', sum, NOTHING)
    yield Figure('nodes that ended', 'soak_ended', '', sum, NOTHING)
    yield Figure('turtles that were left or lost', 'soak_changed', '', sum, NOTHING)
    for kind in node_kinds.in_order(KEYS):
        key = kind.key
        yield Figure(f'{key}: memory of its own', f'memory_{key}', 'MB', max)
        yield Figure(f'{key}: memory, slope', f'slope_{key}', 'MB a day', max)
        yield Figure(f'{key}: the same, +- (95 %)', f'margin_{key}', 'MB a day', max)
        yield Figure(f'{key}: memory grows for sure', f'proven_{key}', '1: yes', max, NOTHING)
        yield Figure(f'{key}: descriptors more', f'descriptors_{key}', 'open', max, NOTHING)
        yield Figure(f'{key}: threads more', f'threads_{key}', 'running', max, NOTHING)


FIGURES = tuple(_figures())
