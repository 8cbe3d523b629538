"""The bench of turtlesim: the measurements of a turtlesim_node, their probes, and their targets.

A suite is a module suite_NAME.py with PACKAGE and EXECUTABLE (the node that rosrun would start), FIGURES, and
MEASUREMENTS: {name: session.Measurement}, with FULL and QUICK, the scales that their run() gets.
"""

import time
from functools import partial
from statistics import stdev

from figures import Figure, Target, intervals, mean_rate, median, p95
from processes import Cpu, tree, tree_memory
from session import FULL, QUICK, SETTLE, Measurement, answer, listened, seconds_to_first

PACKAGE = 'turtlesim'
EXECUTABLE = 'turtlesim_node'
PROBE = 'turtlesim_probe'
TURTLE_COUNTS = (1, 20, 100)
SERVICES = ('turtle1/set_pen', 'turtle1/teleport_absolute', 'turtle1/teleport_relative', 'clear', 'spawn', 'kill',
            'reset')  # the last: it ends turtles that others need
WAYS = {'back': 'back to back', 'single': 'single', 'together': '4 callers at once'}
MANY = 1000  # turtles
LAST = 50  # of them
RATE = 62.5  # [Hz] turtlesim's

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']


def start(subject, scale):
    """Measure the time from the start of the process to its first pose at a waiting subscriber."""
    return {'start': seconds_to_first(subject, scale, 'turtle1/pose')}


def turtles_in_words(count):
    """Return '1 turtle' or '20 turtles'."""
    return '1 turtle' if count == 1 else f'{count} turtles'


def word(service):
    """Return the last part of a service's name."""
    return service.rpartition('/')[2]


def tick_rate(subject, scale):
    """Measure rate and regularity of one turtle's poses."""
    with subject.node() as node:
        _, stamps = listened(subject, node, scale, topic='turtle1/pose')
    return {'rate': [mean_rate(stamps)], 'jitter': [1e3 * stdev(intervals(stamps))]}


def cmd_vel(subject, scale):
    """Measure the time from a published speed to the pose that shows it."""
    with subject.node() as node:
        times = subject.ask(node, PROBE, 'cmd_vel', 0.1 * scale.samples, count=scale.samples)['times']
    return {'cmd_vel': [1e3 * seconds for seconds in times]}


def calls(subject, scale):
    """Measure the times of all services' calls: back to back, single at any moment, several at once."""
    found = {}
    with subject.node() as node:
        for name in SERVICES:
            said = subject.ask(node, PROBE, 'calls', 0.5 * scale.samples, service=name, count=scale.samples)
            found.update({f'{word(name)}_{way}': [1e3 * seconds for seconds in said[way]] for way in WAYS})
            found[f'{word(name)}_frames'] = said['frames']
    return found


def _descriptors(node):
    return sum(process.num_fds() for process in tree(node.pid))


def _idle(node, scale):
    """Return the CPU [% of a core] of an idle node."""
    time.sleep(SETTLE)
    return Cpu(node.pid).percent_over(scale.window)


def _subscribed(subject, node, task, scale, **arguments):
    """Return (CPU [% of a core], rates [Hz], VmRSS [MB]) of a node while every pose has a subscriber."""
    with subject.probe(PROBE, task, seconds=scale.window, **arguments) as probe:
        answer(probe, 0.1 * MANY, node)
        cpu = Cpu(node.pid)
        rates = answer(probe, scale.window, node)['rates']
        return cpu.percent(), rates, tree_memory(node.pid)[0]


def thousand(subject, scale):
    """Measure spawning a thousand turtles, listening to all of them, and resetting."""
    found = {}
    with subject.node() as node:
        subject.ask(node, PROBE, 'calls', service='turtle1/set_pen', count=2)  # the memory of the first calls stays
        quiet, files = _idle(node, scale), _descriptors(node)
        with subject.probe(PROBE, 'many', turtles=MANY) as probe:
            answer(probe, 0.0, node)
            begun, cpu = time.perf_counter(), Cpu(node.pid)
            said = answer(probe, 0.2 * MANY, node)
            elapsed, used = time.perf_counter() - begun, cpu.seconds()
        found['cpu_idle'] = _idle(node, scale)
        spawns = [1e3 * seconds for seconds in said['times']]
        found.update(spawn=median(spawns), spawn_last=median(spawns[-LAST:]), spawn_gap=1e3 * said['gap'],
                     work=1e3 * (used - elapsed * 0.005 * (quiet + found['cpu_idle'])) / len(spawns))
        found['cpu_subscribed'], rates, found['rss'] = _subscribed(subject, node, 'listen_many', scale, turtles=MANY)
        found.update(rate_mean=sum(rates) / len(rates), rate_worst=min(rates))
        said = subject.ask(node, PROBE, 'reset')
        found.update(reset=said['seconds'], reset_gap=1e3 * said['gap'])
        time.sleep(SETTLE)
        found['files_more'] = _descriptors(node) - files
    return {f'{key}_{MANY}': [value] for key, value in found.items()}


def load(turtles, subject, scale):
    """Measure CPU, memory and received rates with so many turtles, at rest and then driving circles.

    Both, because a node may save work on turtles at rest: alone, they would flatter it.
    """
    found = {}
    with subject.node() as node:
        subject.ask(node, PROBE, 'spawn', 0.2 * turtles, turtles=turtles)
        found['cpu_idle'] = _idle(node, scale)
        found['rss_idle'], _ = tree_memory(node.pid)
        for key, rate, driving in (('subscribed', 'rate', False), ('driving', 'driving', True)):
            cpu, rates, found[f'rss_{key}'] = _subscribed(subject, node, 'listen', scale, turtles=turtles,
                                                          driving=driving)
            found.update({f'cpu_{key}': cpu, f'{rate}_mean': sum(rates) / len(rates), f'{rate}_worst': min(rates)})
        _, found['peak'] = tree_memory(node.pid)
    return {f'{key}_{turtles}': [value] for key, value in found.items()}


def core(subject, scale):
    """Measure the ticks of the turtle world alone and with its canvas, without ROS."""
    with subject.probe('core_probe', 'ticks', seconds=scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first pose'),
    'rate': Measurement(tick_rate, 'tick rate and jitter'),
    'cmd_vel': Measurement(cmd_vel, 'cmd_vel to the pose that shows it'),
    'calls': Measurement(calls, 'all services: back to back, single, several at once'),
    **{f'turtles_{count}': Measurement(partial(load, count), f'CPU, memory and rates with {turtles_in_words(count)}')
       for count in TURTLE_COUNTS},
    f'turtles_{MANY}': Measurement(thousand, f'spawning, listening to and resetting {MANY} turtles'),
    'core': Measurement(core, 'ticks of core and canvas', in_process=True),
}


def _call_figures():
    for name in map(word, SERVICES):
        for way, words in WAYS.items():
            yield Figure(f'{name}, {words}, median', f'{name}_{way}', 'ms', median, Target('ratio', 1.05))
        yield Figure(f'{name}, {WAYS["together"]}, frames', f'{name}_frames', 'frames', median, Target('ratio', 1.05))


def _many_figures():
    for name, key, unit, target in (
            ('spawn, median', 'spawn', 'ms', Target('below', 18.0)),
            (f'spawn, the last {LAST}', 'spawn_last', 'ms', Target('below', 18.0)),
            ('own work of a spawn', 'work', 'ms', Target('below', 2.0)),
            ('longest pose gap while spawning', 'spawn_gap', 'ms', Target('below', 60.0)),
            ('CPU, no subscriber', 'cpu_idle', '% of a core', None),
            ('CPU, all subscribed', 'cpu_subscribed', '% of a core', Target('below', 100.0)),
            ('pose rate, mean', 'rate_mean', 'Hz', Target('at_least', 62.0)),
            ('pose rate, worst', 'rate_worst', 'Hz', None), ('memory', 'rss', 'MB', None),
            ('reset', 'reset', 's', Target('below', 1.0)),
            ('longest pose gap while resetting', 'reset_gap', 'ms', Target('below', 60.0)),
            ('descriptors left after the reset', 'files_more', 'files', Target('below', 3.0))):
        yield Figure(f'{turtles_in_words(MANY)}, {name}', f'{key}_{MANY}', unit, median, target)


def _load_figures():
    cpu_limits = {1: Target('ratio', 1.5), 100: Target('ratio', 2.5)}
    memory = Target('below', 80.0)
    for count in TURTLE_COUNTS:
        who = turtles_in_words(count)
        yield Figure(f'CPU, {who}, no subscriber', f'cpu_idle_{count}', '% of a core')
        yield Figure(f'CPU, {who}, subscribed', f'cpu_subscribed_{count}', '% of a core', median,
                     cpu_limits.get(count))
        yield Figure(f'pose rate, {who}, mean', f'rate_mean_{count}', 'Hz', median, Target('near', RATE))
        yield Figure(f'pose rate, {who}, worst', f'rate_worst_{count}', 'Hz')
        yield Figure(f'CPU, {who} driving, subscribed', f'cpu_driving_{count}', '% of a core', median,
                     cpu_limits.get(count))
        yield Figure(f'pose rate, {who} driving, mean', f'driving_mean_{count}', 'Hz', median, Target('near', RATE))
        yield Figure(f'pose rate, {who} driving, worst', f'driving_worst_{count}', 'Hz')
        yield Figure(f'memory, {who}, no subscriber', f'rss_idle_{count}', 'MB', median, memory)
        yield Figure(f'memory, {who}, subscribed', f'rss_subscribed_{count}', 'MB', median, memory)
        yield Figure(f'memory, {who}, peak', f'peak_{count}', 'MB', median, memory)


def _core_figures():
    for count in (1, 100):
        who = turtles_in_words(count)
        yield Figure(f'core, {who} moving', f'core_{count}', 'turtle ticks/s', median, Target('at_least', 150000.0))
        yield Figure(f'core and canvas, {who} moving', f'canvas_{count}', 'turtle ticks/s', median,
                     Target('at_least', 20000.0))


FIGURES = (
    Figure('start to first pose', 'start', 's', median, Target('below', 0.6)),
    Figure('tick rate', 'rate', 'Hz', median, Target('near', RATE)),
    Figure('tick jitter (std dev)', 'jitter', 'ms', median, Target('ratio', 1.3)),
    Figure('cmd_vel to pose, median', 'cmd_vel', 'ms', median, Target('ratio', 1.05)),
    Figure('cmd_vel to pose, p95', 'cmd_vel', 'ms', p95, Target('ratio', 1.05)),
    *_call_figures(),
    *_load_figures(),
    *_many_figures(),
    *_core_figures(),
)
