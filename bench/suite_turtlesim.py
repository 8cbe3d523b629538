"""The bench of turtlesim: what is measured at a turtlesim_node, how, and what it has to reach.

A suite is a module suite_NAME.py with PACKAGE and EXECUTABLE (the node that rosrun would start), FIGURES, and
MEASUREMENTS: {name: Measurement}. `Measurement.run(subject, scale)` starts what it needs, ends it, and returns
{figure key: samples}. Measurements without a node (in_process) run once a round, for ours only.
"""

import time
from dataclasses import dataclass
from statistics import stdev

from figures import Figure, Target, intervals, mean_rate, median, p95
from processes import cpu_between, tree, tree_cpu, tree_memory
from session import answer

PACKAGE = 'turtlesim'
EXECUTABLE = 'turtlesim_node'

COME_UP = 30.0  # [s] until a node answers; probes give up before that with a better text
TURTLE_COUNTS = (1, 20, 100)
SERVICES = ('set_pen', 'teleport_absolute')
ALL_SERVICES = ('set_pen', 'teleport_absolute', 'teleport_relative', 'clear', 'spawn', 'kill', 'reset')
WAYS = {'back': 'back to back', 'single': 'single', 'together': '4 callers at once'}
MANY = 1000  # turtles
RAW = 'turtlesim_raw_probe.py'
LAST = 50  # of them
RATE = 62.5  # [Hz] turtlesim's
SETTLE = 1.0  # [s] after a change before a window opens


@dataclass(frozen=True)
class Scale:
    """How long to measure: windows [s], samples of a kind a round, starts a round."""

    window: float
    samples: int
    starts: int


FULL = Scale(window=5.0, samples=150, starts=3)
QUICK = Scale(window=1.5, samples=30, starts=1)


@dataclass(frozen=True)
class Measurement:
    """run(subject, scale) -> {figure key: samples}; in_process: needs no node, subject is any."""

    run: object
    about: str
    in_process: bool = False


def start(subject, scale):
    """Measure the time from the start of the process to its first pose at a waiting subscriber."""
    seconds = []
    for _ in range(scale.starts):
        with subject.probe('turtlesim_probe.py', 'first_pose') as probe:
            answer(probe, COME_UP)
            begun = time.perf_counter()
            with subject.node() as node:
                seconds.append(answer(probe, COME_UP, [node])['stamp'] - begun)
    return {'start': seconds}


def turtles_in_words(count):
    """Return '1 turtle' or '20 turtles'."""
    return '1 turtle' if count == 1 else f'{count} turtles'


def _asked(subject, node, patience, task, *arguments, module='turtlesim_probe.py'):
    """Run a probe at a node that runs, and return its one answer."""
    with subject.probe(module, task, *arguments) as probe:
        return answer(probe, COME_UP + patience, [node])


def tick_rate(subject, scale):
    """Measure rate and regularity of one turtle's poses."""
    with subject.node() as node:
        stamps = _asked(subject, node, scale.window, 'rate', '--seconds', scale.window)['stamps']
    return {'rate': [mean_rate(stamps)], 'jitter': [1e3 * stdev(intervals(stamps))]}


def cmd_vel(subject, scale):
    """Measure the time from a published speed to the pose that shows it."""
    with subject.node() as node:
        times = _asked(subject, node, 0.1 * scale.samples, 'cmd_vel', '--count', scale.samples)['times']
    return {'cmd_vel': [1e3 * seconds for seconds in times]}


def service(subject, scale):
    """Measure service calls back to back, with a connection for each and with one for all."""
    found = {}
    with subject.node() as node:
        for name in SERVICES:
            for kept, option in (('fresh', ()), ('kept', ('--persistent',))):
                times = _asked(subject, node, 0.2 * scale.samples, 'service', '--service', name,
                               '--count', scale.samples, *option)['times']
                found[f'{name}_{kept}'] = [1e3 * seconds for seconds in times]
    return found


def calls(subject, scale):
    """Times of all services' calls: back to back, single at any moment, several at once. reset is the last."""
    found = {}
    with subject.node() as node:
        for name in ALL_SERVICES:
            said = _asked(subject, node, 0.5 * scale.samples, 'calls', '--service', name, '--count', scale.samples,
                          module=RAW)
            found.update({f'{name}_{way}': [1e3 * seconds for seconds in said[way]] for way in WAYS})
            found[f'{name}_frames'] = said['frames']
    return found


def _descriptors(node):
    return sum(process.num_fds() for process in tree(node.pid))


def _idle(node, scale):
    """Return the CPU time per second of a node that nobody uses."""
    time.sleep(SETTLE)
    begun, before = time.perf_counter(), tree_cpu(node.pid)
    time.sleep(scale.window)
    return _cpu_percent(node, begun, before) / 100.0


def thousand(subject, scale):
    """Measure spawning a thousand turtles, listening to all of them, and resetting."""
    found = {}
    with subject.node() as node:
        _asked(subject, node, 0.0, 'calls', '--count', 2, module=RAW)  # what the first calls make stays
        quiet, found['files_before'] = _idle(node, scale), _descriptors(node)
        with subject.probe(RAW, 'many', '--turtles', MANY) as probe:
            answer(probe, COME_UP, [node])
            begun, before = time.perf_counter(), tree_cpu(node.pid)
            said = answer(probe, COME_UP + 0.2 * MANY, [node])
            elapsed, used = time.perf_counter() - begun, cpu_between(before, tree_cpu(node.pid))
        found['cpu_idle'] = 100.0 * (busy := _idle(node, scale))
        spawns = [1e3 * seconds for seconds in said['times']]
        found.update(spawn=median(spawns), spawn_last=median(spawns[-LAST:]), spawn_gap=1e3 * said['gap'],
                     work=1e3 * (used - elapsed * 0.5 * (quiet + busy)) / len(spawns))
        with subject.probe(RAW, 'listen_many', '--turtles', MANY, '--seconds', scale.window) as probe:
            answer(probe, 2.0 * COME_UP, [node])
            begun, before = time.perf_counter(), tree_cpu(node.pid)
            rates = answer(probe, COME_UP + scale.window, [node])['rates']
            found['cpu_subscribed'] = _cpu_percent(node, begun, before)
        found.update(rate_mean=sum(rates) / len(rates), rate_worst=min(rates), rss=tree_memory(node.pid)[0])
        said = _asked(subject, node, COME_UP, 'reset', module=RAW)
        found.update(reset=said['seconds'], reset_gap=1e3 * said['gap'])
        time.sleep(SETTLE)
        found['files_more'] = _descriptors(node) - found.pop('files_before')
    return {f'{key}_{MANY}': [value] for key, value in found.items()}


def _cpu_percent(node, begun, before):
    return 100.0 * cpu_between(before, tree_cpu(node.pid)) / (time.perf_counter() - begun)


def load(turtles):
    """The measurement of CPU, memory and received rates with so many turtles, at rest and then driving circles.

    Both, because a node may save work on turtles at rest: those alone would show it too good.
    """
    def run(subject, scale):
        found = {}
        with subject.node() as node:
            _asked(subject, node, 0.2 * turtles, 'spawn', '--turtles', turtles)
            time.sleep(SETTLE)
            begun, before = time.perf_counter(), tree_cpu(node.pid)
            time.sleep(scale.window)
            found['cpu_idle'] = _cpu_percent(node, begun, before)
            found['rss_idle'], _ = tree_memory(node.pid)
            found.update(_subscribed(subject, node, turtles, scale))
            found.update(_driving(subject, node, turtles, scale))
            _, found['peak'] = tree_memory(node.pid)
        return {f'{key}_{turtles}': [value] for key, value in found.items()}
    return run


def _listened(subject, node, turtles, scale, *arguments):
    """Return (CPU [% of a core], rates [Hz], VmRSS [MB]) of a node while every pose has a subscriber."""
    with subject.probe('turtlesim_probe.py', 'listen', '--turtles', turtles, '--seconds', scale.window,
                       '--settle', SETTLE, *arguments) as probe:
        answer(probe, COME_UP, [node])
        begun, before = time.perf_counter(), tree_cpu(node.pid)
        rates = answer(probe, COME_UP + scale.window, [node])['rates']
        return _cpu_percent(node, begun, before), rates, tree_memory(node.pid)[0]


def _subscribed(subject, node, turtles, scale):
    cpu, rates, rss = _listened(subject, node, turtles, scale)
    return {'cpu_subscribed': cpu, 'rss_subscribed': rss,
            'rate_mean': sum(rates) / len(rates), 'rate_worst': min(rates)}


def _driving(subject, node, turtles, scale):
    cpu, rates, _ = _listened(subject, node, turtles, scale, '--drive')
    return {'cpu_driving': cpu, 'driving_mean': sum(rates) / len(rates), 'driving_worst': min(rates)}


def core(subject, scale):
    """Measure the ticks of the turtle world alone and with its canvas, without ROS."""
    with subject.probe('core_probe.py', scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, COME_UP + 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first pose'),
    'rate': Measurement(tick_rate, 'tick rate and jitter'),
    'cmd_vel': Measurement(cmd_vel, 'cmd_vel to the pose that shows it'),
    'service': Measurement(service, 'service calls'),
    'calls': Measurement(calls, 'all services: back to back, single, several at once'),
    **{f'turtles_{count}': Measurement(load(count), f'CPU, memory and rates with {turtles_in_words(count)}')
       for count in TURTLE_COUNTS},
    f'turtles_{MANY}': Measurement(thousand, f'spawning, listening to and resetting {MANY} turtles'),
    'core': Measurement(core, 'ticks of core and canvas', in_process=True),
}


def _service_figures():
    for name in SERVICES:
        for kept, words in (('fresh', 'a connection a call'), ('kept', 'persistent')):
            for reduce, word in ((median, 'median'), (p95, 'p95')):
                yield Figure(f'{name}, {words}, {word}', f'{name}_{kept}', 'ms', reduce, Target('ratio', 1.05))


def _call_figures():
    for name in ALL_SERVICES:
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
    *_service_figures(),
    *_call_figures(),
    *_load_figures(),
    *_many_figures(),
    *_core_figures(),
)
