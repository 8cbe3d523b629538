"""The bench of the rosbridge server: how fast it answers pages, idle and under load, and whether it keeps up.

The peer may be the original: --peer 'FOLDER/devel/env.sh rosrun rosbridge_server rosbridge_websocket' where it was
built. A round trip is from a page to a topic and back to the same page.
"""

from typing import NamedTuple

from figures import Figure, Target, median, p99
from processes import tree_memory
from session import Measurement, answer

PACKAGE = 'rosbridge_server'
EXECUTABLE = 'rosbridge_websocket'

PROBE = 'rosbridge_probe'
SLOWEST = 300.0  # [messages/s] at which a server that shares messages out is not given up
ONE_CORE = 'taskset', '--cpu-list', '0'
ARGUMENTS = '_port:=0', '_address:=127.0.0.1'
PAGES = 60


class Scale(NamedTuple):
    """How much to measure: round trips, windows [s], messages, stops."""

    trips: int
    window: float
    messages: int
    stops: int


FULL = Scale(trips=300, window=2.0, messages=1_000_000, stops=3)
QUICK = Scale(trips=50, window=0.5, messages=20_000, stops=1)


def round_trip(subject, scale):
    """Measure round trips, alone and beside a stream of images."""
    with subject.node(*ARGUMENTS) as node, subject.probe(PROBE, 'images') as images:
        answer(images)
        alone = subject.ask(node, PROBE, 'round_trip', scale.trips, count=scale.trips)
        beside = subject.ask(node, PROBE, 'round_trip', scale.trips, count=scale.trips, beside_images=True)
    return {'alone': [1e3 * seconds for seconds in alone['times']],
            'beside': [1e3 * seconds for seconds in beside['times']], 'images': [beside['images']]}


def rate(subject, scale):
    """Measure how many messages a second go there and back."""
    with subject.node(*ARGUMENTS) as node:
        return {'rate': [subject.ask(node, PROBE, 'rate', 60.0 * scale.window, seconds=scale.window)['rate']]}


def memory(subject, scale):
    """Measure the growth of the server's memory while it delivers many messages."""
    with subject.node(*ARGUMENTS) as node, subject.probe(PROBE, 'memory', count=scale.messages) as probe:
        answer(probe, scale.messages / SLOWEST, node)
        before = tree_memory(node.pid)[0]
        answer(probe, scale.messages / SLOWEST, node)
        after = tree_memory(node.pid)[0]
    return {'growth': [after - before], 'memory': [after]}


def zero(subject, scale):
    """Measure when a zero velocity arrives that follows a flood of messages."""
    with subject.node(*ARGUMENTS) as node:
        return {'zero': [1e3 * subject.ask(node, PROBE, 'zero', 60.0)['seconds'] for _ in range(scale.stops)]}


def pages(subject, scale):
    """Measure many pages that get poses from a server that may use one core."""
    with subject.node(*ARGUMENTS, before=ONE_CORE) as node, subject.probe(PROBE, 'poses') as poses, \
            subject.probe(PROBE, 'pages', count=PAGES, seconds=3.0 * scale.window) as probe:
        answer(poses)
        answer(probe, 0.0, node)
        return {'worst': [min(answer(probe, 3.0 * scale.window, node)['rates'])]}


MEASUREMENTS = {
    'round_trip': Measurement(round_trip, 'round trips, alone and beside images'),
    'rate': Measurement(rate, 'messages a second'),
    'memory': Measurement(memory, 'memory after many messages'),
    'zero': Measurement(zero, 'a zero velocity behind a flood'),
    'pages': Measurement(pages, f'{PAGES} pages on one core'),
}
FIGURES = (
    Figure('round trip, alone, median', 'alone', 'ms', median, Target('ratio', 0.7)),
    Figure('round trip, alone, p99', 'alone', 'ms', p99, Target('ratio', 0.5)),
    Figure('round trip beside 640x480 images, median', 'beside', 'ms', median, Target('ratio', 0.7)),
    Figure('round trip beside 640x480 images, p99', 'beside', 'ms', p99, Target('ratio', 0.5)),
    Figure('images meanwhile, of 30 Hz', 'images', 'Hz', median),
    Figure('messages a second of which 1 % are late', 'rate', 'Hz', median, Target('times', 2.0)),
    Figure('memory grown while messages are delivered', 'growth', 'MB', median, Target('below', 3.0)),
    Figure('memory then', 'memory', 'MB', median),
    Figure('zero velocity behind a flood', 'zero', 'ms', max, Target('below', 50.0)),
    Figure(f'{PAGES} pages on one core, poses at 10 Hz, worst', 'worst', 'Hz', median, Target('at_least', 9.5)),
)
