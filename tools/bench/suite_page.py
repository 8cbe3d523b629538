"""The bench of the page in web/: when it shows something, and how smoothly, in Chromium on one core without a GPU.

There is no peer: the original has no page.
"""

import os

from command import progress
from figures import Figure, Target, intervals, mean_rate, median, p95, p99
from processes import Cpu, tree_memory
from rospy_support.ports import free_port
from session import Measurement, Scale, answer, find_node

PACKAGE = 'course_page'
EXECUTABLE = 'browser'
PROBE = 'page_probe'
PATIENCE = 60.0  # [s] more than for other probes: Chromium has to start
OPENING = 120.0  # [s] until many pages are open
STEP = 120.0  # [s] between two reports of the soak, at most
TURTLES = 100
PAGES = 30
VISITORS = 200
SOAK = 60  # windows of measurement that many pages stay open unless --minutes is given: 5 minutes of a full round
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
    """Measure what many pages get, what two of them keep in memory, and what they cost the server."""
    seconds = 60.0 * _length['minutes'] if _length['minutes'] else SOAK * scale.window
    port, ended = free_port(), False
    with subject.other(find_node('turtlesim', 'turtlesim_node')), subject.node(f'--port={port}') as node, \
            subject.probe(PROBE, 'soak', port=port, count=PAGES, seconds=seconds) as probe:
        while not ended:
            found = answer(probe, PATIENCE + OPENING + STEP, node)
            memory, ended = tree_memory(node.pid)[0], found['ended']
            heaps = ' and '.join(f'{heap:.2f}' for heap in found['heaps'])
            why = f'; the last one that was closed: {found["why"]}' if found['why'] else ''
            progress(f'    {found["minutes"]:.1f} of {seconds / 60:g} min: {found["connected"]} of {PAGES} pages open, '
                     f'{_total(found["lost"])} poses lost, heap {heaps} MB, server {memory:.1f} MB{why}')
            if found['half']:
                half, used, server = found['heaps'], Cpu(node.pid), memory
        cpu = used.percent()
    return {'heap': found['heaps'], 'grown': [late - early for early, late in zip(half, found['heaps'])],
            'open': [found['connected']], 'lost': found['lost'], 'unanswered': [found['unanswered']],
            'server': [cpu], 'server_grown': [memory - server]}


def visitors(subject, scale):
    """Measure the poses at a page while others connect and close, stall without reading, or vanish."""
    stamps = _asked(subject, 'visitors', 2.0 * scale.window, count=VISITORS)['stamps']
    return {'visited': [mean_rate(stamps)], 'visit_gap': [1e3 * gap for gap in intervals(stamps)]}


def _total(losses):
    return sum(map(abs, losses))


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
    Figure(f'{PAGES} pages, connected all the time', 'open', '', min, Target('at_least', PAGES), True),
    Figure('poses and drawings that they lost, sum', 'lost', '', _total, Target('at_most', 0.0), True),
    Figure('requests of theirs without an answer', 'unanswered', '', max, Target('at_most', 0.0), True),
    Figure('heap of a page in Chromium at the end, the larger of two', 'heap', 'MB', max),
    Figure('growth of a heap in the second half, the larger of two', 'grown', 'MB', max, Target('below', 0.2), True),
    Figure('processor time of the server in the second half', 'server', '%', median),
    Figure('growth of its memory in the second half', 'server_grown', 'MB', max, Target('below', 3.0), True),
    Figure(f'poses at a page while {VISITORS} clients come and go', 'visited', 'Hz', median, Target('at_least', 62.0),
           True),
    Figure('longest time between two of them', 'visit_gap', 'ms', max, Target('below', 500.0), True),
    Figure('files that were loaded', 'size', 'kB', median, Target('below', 700.0)),
)
