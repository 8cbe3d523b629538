"""The bench of the page in web/: when it shows something, and how smoothly, in Chromium on one core without a GPU.

There is no peer: the original has no page.
"""


from figures import Figure, Target, median, p95
from rospy_support.ports import free_port
from session import Measurement, Scale, find_node

PACKAGE = 'course_page'
EXECUTABLE = 'browser'
PROBE = 'page_probe'
PATIENCE = 60.0  # [s] more than for other probes: Chromium has to start
TURTLES = 100
FULL, QUICK = Scale(window=5.0), Scale(window=2.0)


def turtles(subject, scale):
    """Measure the page while many turtles draw."""
    port = free_port()
    with subject.other(find_node('turtlesim', 'turtlesim_node')), subject.node(f'--port={port}') as node:
        found = subject.ask(node, PROBE, 'turtles', PATIENCE + scale.window, port=port, seconds=scale.window,
                            count=TURTLES)
    return {'first': [found['first']], 'frames': found['frames'], 'drawing': [found['drawing']],
            'size': [found['size'] / 1e3]}


MEASUREMENTS = {'turtles': Measurement(turtles, f'the canvas with {TURTLES} turtles')}
FIGURES = (
    Figure('first picture after the address was entered', 'first', 'ms', median, Target('below', 1000.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, median', 'frames', 'ms', median, Target('below', 17.0)),
    Figure(f'time between frames, {TURTLES} turtles draw, p95', 'frames', 'ms', p95, Target('below', 25.0)),
    Figure('messages with all poses and strokes', 'drawing', 'Hz', median, Target('at_most', 60.5)),
    Figure('files that were loaded', 'size', 'kB', median, Target('below', 700.0)),
)
