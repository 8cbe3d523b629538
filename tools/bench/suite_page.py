"""The bench of the page in web/: when it shows something, and how smoothly, in Chromium on one core without a GPU.

There is no peer: the original has no page.
"""

import os

from figures import Figure, Target, intervals, mean_rate, median, p95, p99
from rospy_support.ports import free_port
from session import Measurement, Scale, find_node

PACKAGE = 'course_page'
EXECUTABLE = 'browser'
PROBE = 'page_probe'
PATIENCE = 60.0  # [s] more than for other probes: Chromium has to start
TURTLES = 100
FULL, QUICK = Scale(window=5.0), Scale(window=2.0)


def _asked(subject, task, seconds, core=(), **arguments):
    """Return what a task of the probe says of a page of turtlesim after ``seconds``."""
    port = free_port()
    with subject.other([*core, *find_node('turtlesim', 'turtlesim_node')]), \
            subject.node(f'--port={port}', before=core) as node:
        return subject.ask(node, PROBE, task, PATIENCE + seconds, port=port, seconds=seconds, **arguments)


def turtles(subject, scale):
    """Measure the page while many turtles draw."""
    found = _asked(subject, 'turtles', scale.window, count=TURTLES)
    return {'first': [found['first']], 'frames': found['frames'], 'drawing': [found['drawing']],
            'size': [found['size'] / 1e3]}


def panels(subject, scale):
    """Measure turtlesim while all panels are open; simulator, server and Chromium share one core."""
    core = 'taskset', '--cpu-list', str(max(os.sched_getaffinity(0)))
    stamps = _asked(subject, 'panels', 2.0 * scale.window, core=core)['stamps']
    return {'poses': [mean_rate(stamps)], 'gaps': [1e3 * gap for gap in intervals(stamps)]}


MEASUREMENTS = {'turtles': Measurement(turtles, f'the canvas with {TURTLES} turtles'),
                'panels': Measurement(panels, 'turtlesim while all panels are open')}
FIGURES = (
    Figure('first picture after the address was entered', 'first', 'ms', median, Target('below', 1000.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, median', 'frames', 'ms', median, Target('below', 17.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, p95', 'frames', 'ms', p95, Target('below', 25.0)),
    Figure('messages with all poses and strokes', 'drawing', 'Hz', median, Target('at_most', 60.5)),
    Figure('poses of turtlesim with all panels open, all on one core', 'poses', 'Hz', median, Target('at_least', 62.0)),
    Figure('time between two of them, p99', 'gaps', 'ms', p99),
    Figure('files that were loaded', 'size', 'kB', median, Target('below', 700.0)),
)
