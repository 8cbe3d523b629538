"""The bench of turtlesim: the measurements of a turtlesim_node, their probes, and their targets.

A suite is a module suite_NAME.py with PACKAGE and EXECUTABLE (the node that rosrun would start), FIGURES, and
MEASUREMENTS: {name: session.Measurement}; FULL and QUICK are the scales that their run() gets, else session's.
"""

from functools import partial
from statistics import stdev

from figures import Figure, Target, intervals, mean_rate, median, p95
from processes import Cpu, tree_memory
from session import Measurement, answer, listened, seconds_to_first

PACKAGE = 'turtlesim'
EXECUTABLE = 'turtlesim_node'
PROBE = 'turtlesim_probe'
TURTLE_COUNTS = (1, 100)
RATE = 62.5  # [Hz] turtlesim's


def start(subject, scale):
    """Measure the time from the start of the process to its first pose at a waiting subscriber."""
    return {'start': seconds_to_first(subject, scale, 'turtle1/pose')}


def in_words(count):
    """Return '1 turtle' or '100 turtles'."""
    return '1 turtle' if count == 1 else f'{count} turtles'


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


def teleport(subject, scale):
    """Measure the times of calls, back to back."""
    with subject.node() as node:
        times = subject.ask(node, PROBE, 'teleport', 0.5 * scale.samples, count=scale.samples)['back']
    return {'teleport': [1e3 * seconds for seconds in times]}


def load(turtles, subject, scale):
    """Measure CPU, memory and received rates while so many turtles drive circles; one at rest may cost less."""
    with subject.node() as node:
        subject.ask(node, PROBE, 'many', 0.2 * turtles, turtles=turtles)
        with subject.probe(PROBE, 'listen', seconds=scale.window, turtles=turtles) as probe:
            answer(probe, 0.1 * turtles, node)
            cpu = Cpu(node.pid)
            rates = answer(probe, scale.window, node)['rates']
            found = {'cpu_driving': cpu.percent(), 'driving_mean': sum(rates) / len(rates),
                     'driving_worst': min(rates), 'peak': tree_memory(node.pid)[1]}
    return {f'{key}_{turtles}': [value] for key, value in found.items()}


def core(subject, scale):
    """Measure the ticks of the turtle world alone and with its canvas, without ROS."""
    with subject.probe('core_probe', 'ticks', seconds=scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first pose'),
    'rate': Measurement(tick_rate, 'tick rate and jitter'),
    'cmd_vel': Measurement(cmd_vel, 'cmd_vel to the pose that shows it'),
    'teleport': Measurement(teleport, 'teleport calls, back to back'),
    **{f'turtles_{count}': Measurement(partial(load, count), f'CPU, memory and rates with {in_words(count)}')
       for count in TURTLE_COUNTS},
    'core': Measurement(core, 'ticks of core and canvas', in_process=True),
}


def _load_figures():
    for count, limit in zip(TURTLE_COUNTS, (1.5, 2.5)):
        who = in_words(count)
        yield Figure(f'CPU, {who} driving, subscribed', f'cpu_driving_{count}', '% of a core', median,
                     Target('ratio', limit))
        yield Figure(f'pose rate, {who} driving, mean', f'driving_mean_{count}', 'Hz', median, Target('near', RATE))
        yield Figure(f'pose rate, {who} driving, worst', f'driving_worst_{count}', 'Hz')
        yield Figure(f'memory, {who}, peak', f'peak_{count}', 'MB', median, Target('below', 80.0))


def _core_figures():
    for count in TURTLE_COUNTS:
        who = in_words(count)
        yield Figure(f'core, {who} moving', f'core_{count}', 'turtle ticks/s', median, Target('at_least', 150000.0))
        yield Figure(f'core and canvas, {who} moving', f'canvas_{count}', 'turtle ticks/s', median,
                     Target('at_least', 20000.0))


FIGURES = (
    Figure('start to first pose', 'start', 's', median, Target('below', 0.6)),
    Figure('tick rate', 'rate', 'Hz', median, Target('near', RATE)),
    Figure('tick jitter (std dev)', 'jitter', 'ms', median, Target('ratio', 1.3)),
    Figure('cmd_vel to pose, median', 'cmd_vel', 'ms', median, Target('ratio', 1.05)),
    Figure('cmd_vel to pose, p95', 'cmd_vel', 'ms', p95, Target('ratio', 1.05)),
    Figure('teleport call, median', 'teleport', 'ms', median, Target('ratio', 1.05)),
    *_load_figures(),
    *_core_figures(),
)
