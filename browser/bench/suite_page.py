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
PAGES = 30
VISITORS = 200
SOAK = 60  # windows that many pages stay open unless --minutes is given: 5 minutes of a full round
FULL, QUICK = Scale(window=5.0), Scale(window=2.0)
_length = {'minutes': None}  # of the soak


def use(options):
    """Take the length of the soak."""
    _length.update(minutes=options.minutes)


def _asked(subject, task, seconds, more=0.0, core=(), **arguments):
    """Return what a task of the probe says of a page of turtlesim after ``seconds``; ``more``: patience [s]."""
    port = free_port()
    with subject.other([*core, *find_node('turtlesim', 'turtlesim_node')]), \
            subject.node(f'--port={port}', before=core) as node:
        return subject.ask(node, PROBE, task, PATIENCE + seconds + more, port=port, seconds=seconds, **arguments)


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


def soak(subject, scale):
    """Measure the memory of many pages, half of them with plots, and whether a client beside them gets all poses."""
    seconds = 60.0 * _length['minutes'] if _length['minutes'] else SOAK * scale.window
    found = _asked(subject, 'soak', seconds, 10.0 * PAGES, count=PAGES)
    return {'heap': found['heap'], 'grown': found['grown'], 'lost': [found['lost']]}


def visitors(subject, scale):
    """Measure the poses at a page while others connect and close, stall without reading, or vanish."""
    stamps = _asked(subject, 'visitors', 2.0 * scale.window, count=VISITORS)['stamps']
    return {'visited': [mean_rate(stamps)], 'visit_gap': [1e3 * gap for gap in intervals(stamps)]}


MEASUREMENTS = {'turtles': Measurement(turtles, f'the canvas with {TURTLES} turtles'),
                'panels': Measurement(panels, 'turtlesim while all panels are open'),
                'soak': Measurement(soak, f'{PAGES} pages for minutes'),
                'visitors': Measurement(visitors, f'{VISITORS} clients that close, stall or vanish')}
FIGURES = (
    Figure('first picture after the address was entered', 'first', 'ms', median, Target('below', 1000.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, median', 'frames', 'ms', median, Target('below', 17.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, p95', 'frames', 'ms', p95, Target('below', 25.0)),
    Figure('messages with all poses and strokes', 'drawing', 'Hz', median, Target('at_most', 60.5)),
    Figure('poses of turtlesim with all panels open, all on one core', 'poses', 'Hz', median, Target('at_least', 62.0)),
    Figure('time between two of them, p99', 'gaps', 'ms', p99),
    Figure(f'{PAGES} pages, heap of one at the end, median', 'heap', 'MB', median),
    Figure(f'{PAGES} pages, growth of a heap in the second half, median', 'grown', 'MB', median, Target('below', 0.2)),
    Figure(f'{PAGES} pages, poses that a client beside them lost', 'lost', '', max, Target('at_most', 0.0)),
    Figure(f'poses at a page while {VISITORS} clients come and go', 'visited', 'Hz', median, Target('at_least', 62.0)),
    Figure('longest time between two of them', 'visit_gap', 'ms', max, Target('below', 500.0)),
    Figure('files that were loaded', 'size', 'kB', median, Target('below', 700.0)),
)
