"""A probe: a client of the node under test in a process of its own, so that nothing else disturbs its clock.

``Subject.probe('turtlesim_probe', 'listen', seconds=5.0)`` starts this module, which calls ``listen(seconds=5.0)`` of
turtlesim_probe.py, as a node of ROS if that module imports rospy. Each answer is one line of JSON (``say``). rospy
calls back in one thread per topic; these only append to lists and set events, the main thread does the rest.
"""
import gc
import importlib
import json
import sys
import threading
import time

clock = time.perf_counter  # CLOCK_MONOTONIC on Linux: one clock for all processes
COME_UP = 20.0  # [s] until a node is seen
POLL = 0.005  # [s]


class Silent(RuntimeError):
    """The node did not react as the probe expected."""


def say(**document):
    """Print one answer."""
    print(json.dumps(document), flush=True)


def await_true(condition, patience, what):
    """Return once condition() is true; raise Silent after ``patience`` [s]."""
    deadline = clock() + patience
    while not condition():
        if clock() > deadline:
            raise Silent(f'{what}: not within {patience:g} s')
        time.sleep(POLL)


def repeat(period, call):
    """Call a function every ``period`` [s] from a thread that ends with the probe."""
    def run():
        due = clock()
        while True:
            due = max(clock(), due + period)
            time.sleep(max(0.0, due - clock()))
            call()
    threading.Thread(target=run, daemon=True).start()


def run_in_node(rospy, task, arguments):
    """Run a task in a node of its own."""
    gc.disable()
    rospy.init_node('bench_probe', anonymous=True, disable_rosout=True, disable_signals=True)
    try:
        task(**arguments)
    finally:
        rospy.signal_shutdown('done')


def main():
    """Run ``MODULE TASK ARGUMENTS``, the arguments as JSON; exit with 1 and a text if it fails."""
    name, task, arguments = sys.argv[1:]
    module, arguments = importlib.import_module(name), json.loads(arguments)
    try:
        if hasattr(module, 'rospy'):
            run_in_node(module.rospy, getattr(module, task), arguments)
        else:
            getattr(module, task)(**arguments)
    except Exception as error:
        sys.exit(f'{task}: {type(error).__name__}: {error}')
