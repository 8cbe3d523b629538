"""The repair of rospy: programs are interrupted where rospy waits for itself, and started without a master."""
import contextlib
import importlib.metadata
import os
import pathlib
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time
import types
import xmlrpc.client

import pytest
import rospy.core
import rospy.impl.init
import rospy.impl.registration
import rospy_repair

from rospy_support.own_master import own_master
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

DEADLINE = 30.0  # [s] for a process that has nothing to do, on a busy machine
HANG = 3.0  # [s] after which a program that should hang does
SWITCH = 'TURTLE_ROBOTONT_REPAIR_ROSPY'
FOLDER = pathlib.Path(rospy_repair.__file__).parent
NO_MASTER = 'http://localhost:1'
SIGINT, SIGTERM = signal.SIGINT, signal.SIGTERM

# a node without a master: rospy catches signals, and has a connection to a subscriber that has been sent `sent`
NODE = textwrap.dedent("""
    import os, signal, sys, threading, time
    import rospy, rospy.core
    from rospy.impl import tcpros_pubsub
    sent = []
    class Subscriber:
        done = False
        def set_cleanup_callback(self, function):
            self.closed = function
        def write_data(self, data):
            sent.append(data)
    class Interrupting(list):
        def append(self, data):  # is called while write_data holds the lock of the connection
            super().append(data)
            if interrupted.acquire(False):
                os.kill(os.getpid(), signal.SIGINT)
                while_locked()
    interrupted, while_locked = threading.Lock(), lambda: None
    subscriber = Subscriber()
    connection = tcpros_pubsub.QueuedConnection(subscriber, 0)
    connection._thread.join = lambda *_: None
    connection._queue = Interrupting()
    def close(reason=''):
        connection.write_data('stop')
        subscriber.done = True
        subscriber.closed(connection)
        print('closed in the', threading.current_thread().name, flush=True)
    rospy.on_shutdown(close)
    rospy.core.register_signals()
""")


def program(body, python=sys.executable, **environment):
    """Start a Python program."""
    return subprocess.Popen([python, '-u', '-c', textwrap.dedent(body)], text=True, stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, **environment})


def ended(process, deadline=DEADLINE):
    """Wait for the end of a program; return (exit code, output, errors)."""
    try:
        out, err = process.communicate(timeout=deadline)
    finally:
        process.kill()
    return process.returncode, out, err


def interrupted(process, *numbers):
    """Send signals to a program that has printed that it is ready; return (exit code, output, errors)."""
    assert process.stdout.readline() == 'ready\n', process.communicate()
    for number in numbers:
        process.send_signal(number)
    return ended(process)


def interrupted_until_it_ends(process):
    """Send SIGINT until a program ends; return (exit code, output, errors).

    One may come too early: before the end of a shutdown, or while rospy logs, which swallows it.
    """
    until = time.monotonic() + DEADLINE
    while process.poll() is None and time.monotonic() < until:
        process.send_signal(SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(1.0)  # another one while it ends would change its exit code
    return ended(process)


LOCKED = NODE + """
connection.write_data('drive')
print('shut down:', rospy.is_shutdown())
"""


def test_ctrl_c_while_publish_holds_its_lock():
    assert ended(program(LOCKED)) == (0, 'closed in the MainThread\nshut down: True\n', '')


def test_rospy_waits_for_itself_without_the_repair():
    with pytest.raises(subprocess.TimeoutExpired):
        ended(program(LOCKED, **{SWITCH: '0'}), HANG)


def test_ctrl_c_while_the_proxy_of_the_master_holds_its_lock():
    """As in loginfo, which asks the master for a parameter; the shutdown calls the master to unregister."""
    body = """
        import os, signal, xmlrpc.client
        import rospy, rospy.core
        master, calls = rospy.core.xmlrpcapi('http://localhost:1'), []
        def request(self, name, parameters):
            calls.append(name)
            if len(calls) == 1:
                os.kill(os.getpid(), signal.SIGINT)
        xmlrpc.client.ServerProxy._ServerProxy__request = request
        rospy.core.add_preshutdown_hook(lambda reason: master.unregister())
        rospy.core.register_signals()
        master.subscribe()
        print(calls, rospy.is_shutdown())
    """
    assert ended(program(body)) == (0, "['subscribe', 'unregister'] True\n", '')


def test_nothing_is_published_after_the_hook():
    """A publisher in a busy loop: the shutdown comes when it leaves publish, so that the last command is stop."""
    code, out, err = ended(program(NODE + textwrap.dedent("""
        while not rospy.is_shutdown():
            connection.write_data('drive')
        while not sent or sent[-1] != 'stop':
            time.sleep(0.01)
        print(sent.count('stop'), sent[-1])
    """)))
    assert (code, out, err) == (0, 'closed in the MainThread\n1 stop\n', '')


def test_a_thread_that_stays_in_rospy_is_not_waited_for():
    """Another thread shuts down; when the main thread leaves rospy, it waits for the hooks."""
    code, out, err = ended(program(NODE + textwrap.dedent("""
        def until_shut_down():
            connection._lock.release()  # as a call that waits for its answer holds none
            while not rospy.core.is_shutdown_requested():
                time.sleep(0.01)
            connection._lock.acquire()
        while_locked = until_shut_down
        rospy.on_shutdown(lambda: time.sleep(0.5))
        rospy.on_shutdown(lambda: print('last hook'))
        connection.write_data('drive')
        print('shut down:', rospy.is_shutdown())
    """)))
    assert code == 0 and err == '' and re.fullmatch(
        r'closed in the (?!Main)\S+( .*)?\nlast hook\nshut down: True\n', out), (out, err)


@pytest.mark.parametrize('number', [SIGINT, *nightly(SIGTERM)])
@pytest.mark.parametrize('wait', ['rospy.spin()', 'time.sleep(1.0)', 'input()', *nightly(
    'rospy.rostime.wallsleep(1.0)', 'while not rospy.is_shutdown(): pass')])
@pytest.mark.parametrize('repair', ['1', *nightly('0')])
def test_programs_end_as_with_the_original(wait, number, repair):
    process = program(f"""
        import threading, time
        import rospy, rospy.core
        rospy.core.register_signals()
        rospy.core.set_initialized(True)
        rospy.on_shutdown(lambda: print('hook in the', threading.current_thread().name))
        print('ready')
        {wait}
        print('end', rospy.is_shutdown())
    """, **{SWITCH: repair})
    if wait == 'input()':
        assert process.stdout.readline() == 'ready\n'
        process.send_signal(number)
        assert process.stdout.readline() == 'hook in the MainThread\n'
        assert process.communicate('\n', timeout=DEADLINE) == ('end True\n', '')
        assert process.returncode == 0
    else:
        assert interrupted(process, number) == (0, 'hook in the MainThread\nend True\n', '')


def test_more_ctrl_c_at_once_change_nothing():
    process = program("""
        import time
        import rospy, rospy.core
        rospy.core.register_signals()
        def slow():
            time.sleep(0.5)
            print('hook')
        rospy.on_shutdown(slow)
        print('ready')
        while not rospy.is_shutdown():
            time.sleep(0.1)
    """)
    assert interrupted(process, SIGINT, SIGINT, SIGINT) == (0, 'hook\n', '')


def test_a_later_ctrl_c_is_a_keyboard_interrupt():
    """It ends a program whose loop does not ask rospy.is_shutdown."""
    process = program("""
        import rospy, rospy.core, rospy_repair
        rospy_repair.GRACE = 0.0
        rospy.core.register_signals()
        rospy.on_shutdown(lambda: print('hook'))
        print('ready')
        while True:
            input()
    """)
    assert process.stdout.readline() == 'ready\n'
    process.send_signal(SIGINT)
    assert process.stdout.readline() == 'hook\n'
    code, _, err = interrupted_until_it_ends(process)
    assert code == -SIGINT and err.endswith('KeyboardInterrupt\n')


def test_a_handler_of_the_program_is_called_as_well():
    process = program("""
        import signal
        import rospy, rospy.core
        signal.signal(signal.SIGINT, lambda number, frame: print('own handler'))
        rospy.core.register_signals()
        print('ready')
        while not rospy.is_shutdown():
            pass
    """)
    assert interrupted(process, SIGINT) == (0, 'own handler\n', '')


INIT = """
    import sys
    import rospy
    print('ready')
    rospy.init_node('waiting', argv=sys.argv + {arguments!r}, disable_signals={own})
"""


@pytest.mark.parametrize('arguments, python', [
    ([], sys.executable), (['_linear:=2'], '/usr/bin/python3'),
    *nightly(([], '/usr/bin/python3'), (['_linear:=2'], sys.executable))])
def test_a_program_waits_for_the_master_and_says_so(arguments, python):
    process = program(INIT.format(arguments=arguments, own=False), python, ROS_MASTER_URI=NO_MASTER)
    said = process.stderr.readline()
    assert f'There is no ROS master at {NO_MASTER}. Waiting for it: type roscore' in said
    code, _, err = interrupted(process, SIGINT)
    assert (code, err) == (1, 'Stopped while waiting for the ROS master.\n')


def test_the_master_that_does_run_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'home'))  # not one of a ./run test
    with own_master(str(tmp_path / 'log')):
        process = program(INIT.format(arguments=[], own=False), ROS_MASTER_URI=NO_MASTER)
        said = process.stderr.readline()
        interrupted(process, SIGINT)
    assert f'There is no ROS master at {NO_MASTER}.' in said and 'type export ROS_MASTER_URI=http://localhost:' in said


@pytest.mark.parametrize('simulated, published, imports, warns', [
    (True, False, 'rospy', True), *nightly((False, False, 'rospy', False), (True, True, 'rospy', False)),
    (True, False, 'rospy_support.nodes', False),  # these warn by themselves
])
def test_a_program_that_waits_for_a_clock_says_so(tmp_path, simulated, published, imports, warns):
    with own_master(str(tmp_path / 'log')) as master:
        proxy = xmlrpc.client.ServerProxy(master.uri)
        proxy.setParam('/test', '/use_sim_time', simulated)
        if published:
            proxy.registerPublisher('/sim', '/clock', 'rosgraph_msgs/Clock', 'http://localhost:1')
        process = program(f"""
            import time
            import rospy.impl.simtime, {imports}
            rospy.impl.simtime.init_simtime.__globals__['CLOCK_PATIENCE'] = 0.1
            rospy.init_node('waits')
            time.sleep(0.5)
            rospy.signal_shutdown('done')
        """, ROS_MASTER_URI=master.uri)
        code, _, said = ended(process)
    assert code == 0 and ('no node publishes /clock' in said) is warns, said


def test_ctrl_c_while_waiting_is_a_keyboard_interrupt_for_a_program_with_its_own_signals():
    process = program(INIT.format(arguments=[], own=True), ROS_MASTER_URI=NO_MASTER)
    assert 'Waiting for it' in process.stderr.readline()
    code, _, err = interrupted_until_it_ends(process)
    assert code == -SIGINT and err.endswith('KeyboardInterrupt\n')


def test_the_reason_is_told_if_it_is_not_just_a_missing_roscore():
    process = program(INIT.format(arguments=[], own=False), ROS_MASTER_URI='http://no.such.host.invalid:11311')
    assert re.search(r'no.such.host.invalid:11311 \(.*[Nn]ame.*\)\. Waiting', process.stderr.readline())
    assert interrupted(process, SIGTERM)[0] == 1


def refused(function, *arguments):
    with pytest.raises(SystemExit) as refusal:
        function(*arguments)
    return refusal.value.code


@pytest.mark.parametrize('uri', ['localhost:11311', 'localhost', 'http//localhost:11311'])
def test_a_uri_that_is_none_is_refused(monkeypatch, uri):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    assert refused(rospy_repair._wait_for_master) == (
        f'ROS_MASTER_URI is {uri!r}, but must look like http://localhost:11311')


@pytest.mark.parametrize('value', [
    '99999999999', '{1: 2}', 'null', '[1', '-2147483649', '2026-01-31', '2026-01-31 10:00:00', '[1, {2.5: a}]', '"\\0"',
    '"\\x01"', '~', '[a, [b, null]]', '!!set {a}', '{a', 'a:=b', '"\\ud800"'])
def test_values_that_no_master_can_have_are_refused_by_name(value):
    assert refused(rospy_repair._check_parameters, ['program', '_good:=1', f'_x:={value}']).startswith(
        f"The parameter {'_x:=' + value!r} cannot be used. Its value must be ")


def test_a_program_with_such_a_value_ends_at_its_start():
    code, _, err = ended(program(INIT.format(arguments=['_x:=[1'], own=False), ROS_MASTER_URI='no URI'))
    assert code == 1 and 'Traceback' not in err and "The parameter '_x:=[1' cannot be used" in err


@pytest.mark.parametrize('value', [
    '2147483647', '-2147483648', '99999999999.0', '.inf', '.nan', 'true', 'text', '"2026-01-31"', "''", '', ' ',
    '[1, [2, b]]', '{a: {b: 1}}', '[]', '{}', 'ä', '"line\\nline"', '/a/b', '<&>', '<dateTime>'])
def test_all_others_are_not(value):
    rospy_repair._check_parameters(['program', '_first:=1', f'_x:={value}', 'topic:=/other', '__name:=me'])


def test_an_unknown_rospy_stays_as_it_is(monkeypatch):
    monkeypatch.setattr(rospy.core, '_ros_signal', rospy_repair._original_signal)
    monkeypatch.setattr(rospy.impl.init, 'start_node', rospy_repair._original_start)
    monkeypatch.setattr(importlib.metadata, 'version', lambda name: '1.18.0')
    rospy_repair.repair()
    assert rospy.core._ros_signal == rospy_repair._original_signal
    monkeypatch.setattr(importlib.metadata, 'version', lambda name: '1.17.3')
    rospy_repair.repair()
    assert rospy.core._ros_signal == rospy_repair._on_signal
    assert rospy.impl.init.start_node == rospy_repair._start_node


ASK = 'import rospy.core; print(rospy.core._ros_signal.__module__)'


@pytest.mark.parametrize('python', ['/usr/bin/python3', *nightly(sys.executable)])
@pytest.mark.parametrize('setting, module', [
    ('', 'rospy_repair'), ('0', 'rospy.core'), *nightly(('1', 'rospy_repair'))])
def test_every_program_of_the_workspace_gets_the_repair(python, setting, module):
    assert ended(program(ASK, python, **{SWITCH: setting})) == (0, f'{module}\n', '')


def test_a_program_without_rospy_imports_nothing_of_it():
    assert ended(program('import sys; print("rospy_repair" in sys.modules, "rospy" in sys.modules)'))[1] == (
        'False False\n')


def test_the_next_sitecustomize_runs_too(tmp_path):
    (tmp_path / 'sitecustomize.py').write_text('import sys\nsys.next = __file__\n')
    path = os.pathsep.join([str(FOLDER), str(tmp_path), os.environ['PYTHONPATH']])
    assert ended(program('import sys; print(sys.next)', PYTHONPATH=path)) == (0, f'{tmp_path}/sitecustomize.py\n', '')


def test_a_sitecustomize_before_it_hides_it_without_harm(tmp_path):
    (tmp_path / 'sitecustomize.py').write_text('')
    path = os.pathsep.join([str(tmp_path), os.environ['PYTHONPATH']])
    assert ended(program(ASK, PYTHONPATH=path)) == (0, 'rospy.core\n', '')


def test_a_repair_that_fails_ends_no_program(tmp_path):
    (tmp_path / 'rospy_repair.py').write_text('raise ValueError\n')
    path = os.pathsep.join([str(tmp_path), os.environ['PYTHONPATH']])
    assert ended(program(ASK, PYTHONPATH=path)) == (0, 'rospy.core\n', '')


@pytest.mark.parametrize('shutting_down', [True, False])
def test_publishing_on_a_closed_topic_is_an_error_unless_the_node_ends(monkeypatch, shutting_down):
    def closed(*_):
        raise rospy.ROSException('publish() to a closed topic')
    monkeypatch.setattr(rospy_repair, '_original_publish', closed)
    monkeypatch.setattr(rospy.core, '_in_shutdown', shutting_down)
    monkeypatch.setattr(rospy.core, '_client_shutdown_hooks', [print])
    if shutting_down:
        assert rospy_repair._publish(None, 'message') is None
    else:
        with pytest.raises(rospy.ROSException):
            rospy_repair._publish(None, 'message')


def test_nothing_is_published_after_the_hooks(monkeypatch):
    """Such as a velocity of the main thread after the hook's stop, when rosnode kill ends the node."""
    published = []
    monkeypatch.setattr(rospy_repair, '_original_publish', lambda publisher, message: published.append(message))
    monkeypatch.setattr(rospy.core, '_in_shutdown', True)
    monkeypatch.setattr(rospy.core, '_client_shutdown_hooks', [print])
    rospy_repair._publish(None, 'stop')
    rospy.core._client_shutdown_hooks.clear()
    rospy_repair._publish(None, 'drive')
    assert published == ['stop']


def test_the_thread_for_registrations_ends_with_the_node(monkeypatch):
    hooks, down = [], threading.Event()
    monkeypatch.setattr(rospy.impl.registration, 'add_preshutdown_hook', lambda hook: None)
    monkeypatch.setattr(rospy.impl.registration, 'is_shutdown', down.is_set)
    monkeypatch.setattr(rospy.core, 'add_shutdown_hook', hooks.append)
    registering = rospy.impl.registration.RegManager(types.SimpleNamespace(done=False))
    waits, wait = [], registering.cond.wait
    monkeypatch.setattr(registering.cond, 'wait', lambda seconds: waits.append(seconds) or wait(DEADLINE))
    monkeypatch.setattr(rospy_repair, '_wait_for_master', lambda: None)
    monkeypatch.setattr(rospy_repair, '_original_start', lambda: types.SimpleNamespace(
        handler=types.SimpleNamespace(reg_man=registering)))
    rospy_repair._start_node()
    thread = threading.Thread(target=registering.run, daemon=True)
    thread.start()
    end = time.monotonic() + DEADLINE
    while not waits and time.monotonic() < end:
        time.sleep(0.001)
    down.set()
    hooks[0]('the node ends')
    thread.join(DEADLINE / 2.0)
    assert waits and not thread.is_alive()
