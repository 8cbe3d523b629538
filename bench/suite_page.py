"""The bench of the page in web/: when it shows something, and how smoothly, in Chromium on one core without a GPU.

There is no peer: the original has no page. The form of a suite: suite_turtlesim.py.
"""

from dataclasses import dataclass

from figures import Figure, Target, median, p95
from rospy_support.ports import free_port
from session import answer, find_node
from suite_turtlesim import Measurement

PACKAGE = 'turtle_robotont'
EXECUTABLE = 'browser.py'

COME_UP = 120.0  # [s] until the probe has an answer beside its window
TURTLES = 100


@dataclass(frozen=True)
class Scale:
    """How long to count frames [s]."""

    window: float


FULL = Scale(window=5.0)
QUICK = Scale(window=2.0)


def turtles(subject, scale):
    """Measure the page while many turtles draw."""
    port = free_port()
    with subject.other(find_node('turtlesim', 'turtlesim_node')) as simulator, \
            subject.node(f'--port={port}') as node, \
            subject.probe('page_probe.py', 'turtles', '--port', port, '--count', TURTLES, '--seconds',
                          scale.window) as probe:
        found = answer(probe, COME_UP + scale.window, [node, simulator])
    return {'first': [found['first']], 'frames': found['frames'], 'drawing': [found['drawing']],
            'size': [found['size'] / 1e3]}


MEASUREMENTS = {'turtles': Measurement(turtles, f'the canvas with {TURTLES} turtles')}
FIGURES = (
    Figure('first picture after the address was entered', 'first', 'ms', median, Target('below', 1000.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, median', 'frames', 'ms', median, Target('below', 17.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, p95', 'frames', 'ms', p95, Target('below', 25.0)),
    Figure('messages with all poses and strokes', 'drawing', 'Hz', median, Target('at_most', 60.5)),
    Figure('files that were loaded', 'size', 'kB', median, Target('below', 500.0)),
)
