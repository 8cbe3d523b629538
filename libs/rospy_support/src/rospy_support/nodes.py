"""How every node of this repository begins and ends.

A node's script::

    def main():
        nodes.init_node('my_node', PARAMETERS)    # instead of rospy.init_node; a parameters.Table
        ...
        rospy.spin()

    if __name__ == '__main__':
        nodes.run(main)

With that a node is registered again with a master that was started anew, its output may be closed, and it ends in
order and in a bounded time: the hooks of rospy.on_shutdown are called (they stop vehicles), it is unregistered, and
nothing is printed that frightens. rospy itself runs all this inside of a signal's handler, in the main thread: where
that holds one of rospy's locks, a call of the master for example, the shutdown waits for that lock for ever. Here a
signal only wakes a thread, which shuts down. And rospy closes topics before it says that it shuts down: an error of
main() that comes from that is none.

Exit codes: what main() gives to sys.exit; 0 when it returns or when the node is shut down; 2 for a ParameterError;
1 for everything else.

Threading contract: ``run`` is called in the main thread; hooks of rospy.on_shutdown are called in any.
"""
import contextlib
import os
import signal
import sys
import threading
import traceback

import rosgraph
import rospy

from rospy_support import console, parameters, registration, rospy_internals, servers
from rospy_support.parameters import MasterAway, ParameterError

SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT
REGISTERING = 0.5  # [s] for a registration that has begun
LONGEST_CALL = 2.0  # [s] for the master to take note of the end
LONGEST_END = 8.0  # [s] from the first sign of the end to that of the process; roslaunch waits 15 s

_ending = threading.Event()  # set once the node shuts down


def init_node(name, declared=(), argv=None, **options):
    """Initialise rospy; ``declared``: the Parameters that the node may read; ``options`` as those of rospy.init_node.

    Raises rospy.exceptions.ROSInitException when it was stopped before a master answered.
    """
    parameters.declare(declared)
    servers.protect()
    with console.log_file_guarded():
        rospy.init_node(name, argv=argv, disable_signals=True, **options)
    if rospy.is_shutdown():
        raise rospy.exceptions.ROSInitException('it was stopped before a master answered')
    rospy_internals.shut_down_by(lambda reason: shut_down(reason))
    rospy_internals.log_without_asking()
    rospy.on_shutdown(_limit_the_end)
    registration.keep_registered(rospy_internals.command_line_parameters(argv))


def run(main):
    """Run a node's main() and end the process with its exit code."""
    console.guard()
    threading.excepthook = _thread_failed
    _catch_signals()
    code = outcome(main)
    shut_down('the node is done').join(LONGEST_END)
    _leave(code)


def outcome(main):
    """Run a node's main(); say what went wrong and return the exit code."""
    try:
        main()
        return 0
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    except ParameterError as error:
        rospy.logfatal('%s', error)
        return 1 if isinstance(error, MasterAway) else 2
    except rospy.exceptions.ROSInitException as error:
        print(f'The node could not start: {error}. Is a ROS master running at {rosgraph.get_master_uri()}? '
              'Start one with roscore.', file=sys.stderr)
        return 1
    except (rospy.ROSInterruptException, KeyboardInterrupt):
        return 0
    except Exception as error:
        if _ending.is_set() or rospy.is_shutdown():  # topics were closed under its hands
            rospy.logdebug('main() ended with %r', error)
            return 0
        traceback.print_exc()
        return 1


def end_when_unread():
    """End the node in order when the reader of its standard output has gone (``node | head``): it only prints."""
    console.when_unread(lambda: shut_down('nothing reads its output any more'))


def shut_down(reason):
    """Shut rospy down in a thread of its own, which is returned; it ends when that is done, whoever does it."""
    _limit_the_end()

    def work():
        rospy.signal_shutdown(reason)
        rospy_internals.wait_for_shutdown()
    thread = threading.Thread(target=work, name='shutdown', daemon=True)
    thread.start()
    threading.Thread(target=rospy_internals.end_registering, args=(REGISTERING,), daemon=True).start()
    return thread


def _limit_the_end():
    """See to it that the process ends in time, even if a master that stands, or a lock, holds the end up."""
    if not _ending.is_set():
        _ending.set()
        rospy_internals.limit_calls_of_master(LONGEST_CALL)
        timer = threading.Timer(LONGEST_END, _give_up)
        timer.daemon = True
        timer.start()


def _give_up():
    print(f'The node did not end within {LONGEST_END:g} s; it is stopped now.', file=sys.stderr)
    _leave(1)


def _leave(code):
    """End the process, without the ways of the interpreter's end: threads that still run make it crash there."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()
    os._exit(code)


def _catch_signals():
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)  # written at once, wherever the main thread is
    for number in SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # nohup
            signal.signal(number, lambda *_: None)
    threading.Thread(target=_await_signals, args=(reader,), name='signals', daemon=True).start()


def _await_signals(reader):
    while True:
        for number in os.read(reader, 64):
            if number in SIGNALS:
                shut_down(f'signal-{number}')


def _thread_failed(failure):
    """Log what ended a thread; while the node ends that is nothing to tell."""
    if not (_ending.is_set() or rospy.is_shutdown()):
        said = ''.join(traceback.format_exception(failure.exc_type, failure.exc_value, failure.exc_traceback))
        rospy.logerr('The thread %s of this node ended with an error; please report it:\n%s',
                     failure.thread.name if failure.thread else '?', said)
