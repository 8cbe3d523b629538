"""All simulators, camera, tracker, usb_cam and a service server for a long time at light load: does anything grow?"""

import time

from nav_msgs.msg import Odometry

from figures import Figure, Target
from growth import after_warm_up, growth, step
from rostest_support import node_kinds
from trial import NOTHING, PEN, Attack, answers, listen
from under_test import TROUBLE, running

KEYS = ('turtlesim', 'robotont', 'camera', 'tracker', 'usb_cam', 'goto_pose_server', 'pose_subscriber',
        'velocity_publisher')
RATES = {'turtlesim': 62.5, 'robotont': 30.0}  # [Hz]
SAMPLE = 5.0  # [s]
LOAD_EVERY = 3  # samples between two rounds of calls
HARMLESS = 50.0  # [MB a day] that a node may grow by: a week is less than half a gigabyte
EDGE = 5  # messages more or less at the ends of the count
SETTLE = 5.0  # [s]
OWN = 'Pss_Anon', 'Pss_Shmem', 'SwapPss'  # of /proc/PID/smaps_rollup


def soak(subject, scale, _rng):
    """Watch the nodes for an hour times the factor."""
    seconds = scale.seconds(3600.0, 20.0)
    period = min(SAMPLE, seconds / 60.0)
    with running(subject, *KEYS) as nodes:
        time.sleep(min(SETTLE, seconds / 6.0))
        receivers = {'turtlesim': nodes['turtlesim'].receiver(),
                     'robotont': nodes['robotont'].receiver('/odom', Odometry)}
        state = _world(nodes)
        samples = {key: {'memory': [], 'descriptors': [], 'threads': []} for key in nodes}
        begun, number, lost = time.monotonic(), 0, 0
        for receiver in receivers.values():
            receiver.stamps.clear()
        while time.monotonic() - begun < seconds:
            _sample(nodes, samples, time.monotonic() - begun)
            if number % LOAD_EVERY == 0:
                lost += _load(nodes)
            number += 1
            time.sleep(max(0.0, begun + number * period - time.monotonic()))
        elapsed = time.monotonic() - begun
        found = {f'missed_{key}': [max(0.0, RATES[key] * elapsed - len(receiver.stamps) - EDGE)]
                 for key, receiver in receivers.items()}
        found.update({f'rate_{key}': [len(receiver.stamps) / elapsed] for key, receiver in receivers.items()})
        for receiver in receivers.values():
            receiver.close()
        found['soak_lost'] = [lost]
        found['soak_ended'] = [sum(not node.runs() for node in nodes.values())]
        found['soak_changed'] = [int(_world(nodes) != state)]
        for key, series in samples.items():
            found.update(_judged(key, series))
        return found


def _world(nodes):
    """Return what light load must not change: the robot's pose and world, and the names of the turtles."""
    return nodes['robotont'].state(), sorted(name for name in nodes['turtlesim'].registered()[0]
                                             if name.endswith('/pose'))


def _sample(nodes, samples, now):
    for key, node in nodes.items():
        try:
            values = own_memory(node.pid), node.descriptors(), node.threads()
        except OSError:
            continue  # it has ended: soak_ended tells
        for name, value in zip(('memory', 'descriptors', 'threads'), values):
            samples[key][name].append((now, value))


def own_memory(pid):
    """Return the memory [MB] that a process has filled itself.

    Its share of files such as libraries is left out: that grows when another program that uses them ends.
    """
    with open(f'/proc/{pid}/smaps_rollup', encoding='utf-8') as file:
        sizes = dict(line.split(':', 1) for line in file if line.split(':', 1)[0] in OWN)
    return sum(int(size.split()[0]) for size in sizes.values()) * 1024 / 1e6


def _load(nodes):
    """Make calls and new subscribers; return how many were not answered."""
    lost = 0
    for node in nodes.values():
        lost += not answers(node)
        lost += not listen(node)
    node = nodes['turtlesim']
    for name, values in (('/turtle1/teleport_absolute', (5.5, 5.5, 0.0)), ('/clear', ()),
                         ('/spawn', (5.0, 5.0, 0.0, 'x')), ('/kill', ('x',)), ('/turtle1/set_pen', PEN)):
        try:
            lost += not node.call(name, *values)[0]
        except TROUBLE:
            lost += 1
    return lost


def _judged(key, series):
    found = {}
    for name in ('descriptors', 'threads'):
        found[f'{name}_{key}'] = [step(after_warm_up(series[name]))]
    memory = after_warm_up(series['memory'])
    try:
        grown = growth(memory)
    except ValueError:
        return found  # it ended early
    found.update({f'memory_{key}': [memory[-1][1]], f'slope_{key}': [grown.slope], f'margin_{key}': [grown.margin],
                  f'proven_{key}': [int(grown.is_proven(HARMLESS))]})
    return found


ATTACKS = {'soak': Attack(soak, 'all simulators, camera, tracker, usb_cam and a server at light load', peer=False)}


def _figures():
    for key, word in (('turtlesim', 'poses'), ('robotont', 'odometry')):
        yield Figure(f'{word}: rate', f'rate_{key}', 'Hz', max, Target('near', RATES[key]))
        yield Figure(f'{word}: missed', f'missed_{key}', 'messages', max, NOTHING)
    yield Figure('calls and subscribers without an answer', 'soak_lost', '', sum, NOTHING)
    yield Figure('nodes that ended', 'soak_ended', '', sum, NOTHING)
    yield Figure("the robot's pose, the world or the turtles changed", 'soak_changed', '', sum, NOTHING)
    for kind in node_kinds.in_order(KEYS):
        key = kind.key
        yield Figure(f'{key}: memory of its own', f'memory_{key}', 'MB', max)
        yield Figure(f'{key}: memory, slope', f'slope_{key}', 'MB a day', max)
        yield Figure(f'{key}: the same, +- (95 %)', f'margin_{key}', 'MB a day', max)
        yield Figure(f'{key}: memory grows for sure', f'proven_{key}', '1: yes', max, NOTHING)
        yield Figure(f'{key}: descriptors more', f'descriptors_{key}', 'open', max, NOTHING)
        yield Figure(f'{key}: threads more', f'threads_{key}', 'running', max, NOTHING)


FIGURES = tuple(_figures())
