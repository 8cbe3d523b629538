"""Start and end a node: master, parameters, signals, errors, exit codes.

A node's script::

    def main():
        nodes.init_node('my_node', PARAMETERS)    # instead of rospy.init_node; a parameters.Table
        ...
        rospy.spin()

    if __name__ == '__main__':
        nodes.run(main)

Such a node registers again after a restart of the master, survives a closed output, and shuts down in order and in a
bounded time: the hooks of rospy.on_shutdown are called (they stop vehicles), the node is unregistered, and no traceback
is printed. rospy itself does all this inside a signal handler, in the main thread: if that thread holds one of rospy's
locks, for example during a call to the master, the shutdown waits for that lock forever. Here a signal only wakes a
thread, which shuts down. rospy also closes topics before it reports the shutdown; errors that main() raises because of
this are ignored.

Exit codes: the argument of sys.exit in main(); 0 when main() returns or the node is shut down; 2 for a ParameterError;
1 for everything else.

Threading contract: ``run`` is called in the main thread; hooks of rospy.on_shutdown are called in any.
"""
import contextlib
import os
import re
import signal
import sys
import threading
import traceback
from typing import Any, Callable, Dict, Iterable, Mapping, NoReturn, Optional, Sequence

import rosgraph
import rosgraph.names
import rospy

from plain_support.doctor import findings
from rospy_support import console, parameters, registration, rospy_internals, servers
from rospy_support.master import Master, NoMaster
from rospy_support.parameters import MasterAway, ParameterError

SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT
REGISTERING = 0.5  # [s] for a registration that has begun
CALL_TIMEOUT = 2.0  # [s] for the master to unregister the node
CLOCK_PATIENCE = 5.0  # [s] for the source of /clock to start, before a warning
SHUTDOWN_TIMEOUT = 8.0  # [s] from the request to shut down to the end of the process; roslaunch waits 15 s
NODE_NAME = re.compile(r'[A-Za-z]\w*', re.ASCII)
GRAPH_NAME = re.compile(r'[~/A-Za-z][\w/]*', re.ASCII)
NAMESPACE = 'ROS_NAMESPACE'

_ending = threading.Event()  # set once the node shuts down
_of_launch: Dict[str, Any] = {}  # {name: value} of parameters that end with the launch of this node


def init_node(name: str, declared: Iterable[parameters.Parameter] = (), argv: Optional[Sequence[str]] = None,
              **options: Any) -> None:
    """Initialise rospy; ``declared``: the Parameters that the node may read; ``options`` as those of rospy.init_node.

    Parameters of the command line are deleted when the node ends. So are those of one run only (see parameters) that a
    launch file has set, when a signal ends the node, as roslaunch does; a node that rosnode kill or an error ends may
    be started again by its launch, with the same parameters.

    Raises rospy.exceptions.ROSInitException when it was stopped before a master answered, and ParameterError for a name
    that ROS does not allow, or a value that no parameter can have.
    """
    check_names(sys.argv if argv is None else argv, os.environ)
    parameters.check_command_line(sys.argv if argv is None else argv)
    parameters.declare(declared)
    servers.protect()
    rospy_internals.poll_for_registration()
    with console.log_file_guarded():
        rospy.init_node(name, argv=argv, disable_signals=True, **options)
    if rospy.is_shutdown():
        raise rospy.exceptions.ROSInitException('it was stopped before a master answered')
    rospy_internals.shut_down_by(lambda reason: shut_down(reason))
    rospy_internals.log_without_asking()
    rospy.on_shutdown(_limit_the_end)
    given = rospy_internals.command_line_parameters(argv)
    registration.keep_registered(given)
    stored = parameters.private()
    if launched(argv):
        _of_launch.update(parameters.of_launch(declared, given, stored))
    else:  # parameters of a launch file look like those of an earlier run
        parameters.warn_of_stale(declared, given)
    parameters.warn_of_unknown(declared, given, stored)
    if not rospy_internals.is_wall_time():
        timer = threading.Timer(CLOCK_PATIENCE, _warn_of_no_clock)
        timer.daemon = True
        timer.start()


def check_names(arguments: Sequence[str], environment: Mapping[str, str]) -> None:
    """Raise ParameterError for a name on the command line ``arguments``, or in ROS_NAMESPACE, that roscpp refuses.

    The fault: with a blank or an umlaut in its name a rospy node registers by half, or in a way that C++ nodes cannot
    read, and reports that the master does not answer.
    """
    given = rosgraph.names.load_mappings(list(arguments))
    name, namespace = given.pop('__name', None), given.pop('__ns', None)
    if name is not None and not NODE_NAME.fullmatch(name):
        raise _name_error(f'__name:={name}', 'a node has only letters a to z, digits and _, and begins with a letter',
                          f'__name:={_legal_name(name.replace("/", "_"))}')
    if namespace is not None:
        _check_graph_name(f'__ns:={namespace}', '__ns:=', namespace)
    if environment.get(NAMESPACE):
        _check_graph_name(f'{NAMESPACE}={environment[NAMESPACE]}', f'export {NAMESPACE}=', environment[NAMESPACE])
    for original, other in given.items():
        if not original.startswith('__'):
            _check_graph_name(f'{original}:={other}', f'{_legal_name(original)}:=', original, other)


def _check_graph_name(given: str, before: str, *names: str) -> None:
    if not all(map(GRAPH_NAME.fullmatch, names)):
        raise _name_error(given, 'it has only letters a to z, digits, _ and /, and begins with a letter, / or ~',
                          f'{before}{_legal_name(names[-1])}')


def _name_error(given: str, allowed: str, better: str) -> ParameterError:
    return ParameterError(f'{given!r} is not a name that ROS allows: {allowed}. Type for example {better}')


def _legal_name(name: str) -> str:
    """Return a similar name that is allowed."""
    cleaned = re.sub(r'[^\w/~]', '_', name, flags=re.ASCII)
    return cleaned if GRAPH_NAME.fullmatch(cleaned) else f'n{cleaned}'


def launched(argv: Optional[Sequence[str]] = None) -> bool:
    """Return whether roslaunch has started this process."""
    return any(argument.startswith('__log:=') for argument in (sys.argv if argv is None else argv))


def _warn_of_no_clock() -> None:
    """Warn if simulated time does not start because no node publishes /clock."""
    with contextlib.suppress(NoMaster, rospy.exceptions.ROSInitException):
        if rospy.get_time() == 0.0 and not _ending.is_set():
            (code, _, state), = Master().request([('getSystemState',)])
            if code == 1 and '/clock' not in dict(state[0]):
                rospy.logwarn('%s', findings.no_clock())


def run(main: Callable[[], Any]) -> NoReturn:
    """Run a node's main() and end the process with its exit code."""
    console.guard()
    threading.excepthook = _thread_failed
    _catch_signals()
    code = outcome(main)
    shut_down('the node is done').join(SHUTDOWN_TIMEOUT)
    registration.unregister_rest()
    _leave(code)


def outcome(main: Callable[[], Any]) -> int:
    """Run a node's main(), report an error, and return the exit code."""
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
        if _ending.is_set() and _master_answers():
            print('The node was stopped while it was starting.', file=sys.stderr)
            return 0
        print(f'The node could not start: {error}. Is a ROS master running at {rosgraph.get_master_uri()}? '
              'Start one with roscore.', file=sys.stderr)
        return 1
    except (rospy.ROSInterruptException, KeyboardInterrupt):
        return 0
    except Exception as error:
        if _ending.is_set() or rospy.is_shutdown():  # the shutdown has closed topics that main() uses
            rospy.logdebug('main() ended with %r', error)
            return 0
        traceback.print_exc()
        return 1


def _master_answers() -> bool:
    try:
        return bool(Master(CALL_TIMEOUT).request([('getPid',)]))
    except NoMaster:
        return False


def shut_down(reason: str) -> threading.Thread:
    """Shut rospy down in a separate thread and return the thread, which ends when the shutdown is complete."""
    _limit_the_end()

    def work() -> None:
        rospy.signal_shutdown(reason)
        rospy_internals.wait_for_shutdown()
    thread = threading.Thread(target=work, name='shutdown', daemon=True)
    thread.start()
    threading.Thread(target=rospy_internals.end_registering, args=(REGISTERING,), daemon=True).start()
    return thread


def _limit_the_end() -> None:
    """End the process after SHUTDOWN_TIMEOUT, even if a master that hangs, or a lock, blocks the shutdown."""
    if not _ending.is_set():
        _ending.set()
        rospy_internals.limit_calls_of_master(CALL_TIMEOUT)
        timer = threading.Timer(SHUTDOWN_TIMEOUT, _give_up)
        timer.daemon = True
        timer.start()


def _give_up() -> None:
    print(f'The node did not end within {SHUTDOWN_TIMEOUT:g} s; it is stopped now.', file=sys.stderr)
    _leave(1)


def _leave(code: int) -> NoReturn:
    """End the process without the interpreter's cleanup, which crashes if threads still run."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()
    os._exit(code)


def _catch_signals() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)  # written at once, even while the main thread is busy
    for number in SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # nohup
            signal.signal(number, lambda *_: None)
    threading.Thread(target=_await_signals, args=(reader,), name='signals', daemon=True).start()


def _await_signals(reader: int) -> None:
    while True:
        for number in os.read(reader, 64):
            if number in SIGNALS:
                registration.delete_at_end(_of_launch)
                shut_down(f'signal-{number}')


def _thread_failed(failure: threading.ExceptHookArgs) -> None:
    """Log the error that ended a thread, unless the node is shutting down."""
    if not (_ending.is_set() or rospy.is_shutdown()):
        error = ''.join(traceback.format_exception(failure.exc_type, failure.exc_value, failure.exc_traceback))
        rospy.logerr('The thread %s of this node ended with an error; please report it:\n%s',
                     failure.thread.name if failure.thread else '?', error)
