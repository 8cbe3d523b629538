"""rospy_support.nodes: the ways in which main() and its process end, for all signals at all times."""
import os
import signal
import subprocess
import sys
import textwrap
import threading

import pytest
import rospy

from rospy_support import nodes, parameters
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

DEADLINE = 30.0  # [s] for a process that has nothing to do, on a busy machine


def raising(error):
    def main():
        raise error
    return main


@pytest.mark.parametrize('error, code', [
    (SystemExit(), 0), (SystemExit(0), 0), (SystemExit(3), 3), (SystemExit('a reason'), 1),
    (parameters.ParameterError('parameter /a is 100%; it must be less'), 2),
    (parameters.MasterAway('no answer'), 1), (rospy.exceptions.ROSInitException('no time'), 1),
    (rospy.ROSInterruptException('shutdown'), 0), (KeyboardInterrupt(), 0),
    (ZeroDivisionError('mine'), 1),
])
def test_the_exit_code_of_an_error(error, code, logged):
    assert nodes.outcome(raising(error)) == code


def test_a_bad_parameter_is_logged(logged):
    nodes.outcome(raising(parameters.ParameterError('parameter /a is 100%; it must be less')))
    assert logged == ['parameter /a is 100%; it must be less']


def test_a_text_for_sys_exit_is_printed(capsys):
    nodes.outcome(raising(SystemExit('a reason')))
    assert capsys.readouterr().err == 'a reason\n'


def test_an_error_is_told_with_where_it_was(capsys):
    nodes.outcome(raising(ZeroDivisionError('mine')))
    said = capsys.readouterr().err
    assert 'Traceback' in said and 'ZeroDivisionError: mine' in said


def test_an_error_during_the_shutdown_is_none(monkeypatch, capsys):
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: True)
    assert nodes.outcome(raising(rospy.ROSException('publish() to a closed topic'))) == 0
    assert capsys.readouterr() == ('', '')


def program(body):
    """Start a Python program that runs main() as a node does, without a master; it prints a line when it is ready."""
    source = 'import rospy, threading, time\nfrom rospy_support import nodes, rospy_internals\n' + textwrap.dedent(body)
    return subprocess.Popen([sys.executable, '-c', source + '\nnodes.run(main)'], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE)


def ended(process, *signals):
    """Send signals once the program is ready; return (exit code, output after that, errors)."""
    assert process.stdout.readline() == 'ready\n'
    for number in signals:
        process.send_signal(number)
    with process:  # not communicate(): it would miss what readline() has buffered already
        out, err = process.stdout.read(), process.stderr.read()
    return process.wait(DEADLINE), out, err


SPIN = """
    def main():
        rospy.on_shutdown(lambda: print('stopped'))
        print('ready')
        while not rospy.is_shutdown():
            time.sleep(0.01)
"""


@pytest.mark.parametrize('signals', [[signal.SIGHUP], [signal.SIGINT, signal.SIGTERM, signal.SIGINT],
                                     *nightly([signal.SIGINT], [signal.SIGTERM])])
def test_signals_shut_down_once_and_quietly(signals):
    assert ended(program(SPIN), *signals) == (0, 'stopped\n', '')


def test_a_signal_while_main_holds_a_lock_that_the_shutdown_needs():
    body = """
        lock = threading.Lock()
        def stop():
            with lock:
                print('stopped')
        def main():
            rospy.on_shutdown(stop)
            print('ready')
            while not rospy.is_shutdown():
                with lock:
                    time.sleep(0.02)
                time.sleep(0.001)
    """
    assert ended(program(body), signal.SIGINT) == (0, 'stopped\n', '')


def test_a_main_that_returns_shuts_down():
    body = """
        def main():
            rospy.on_shutdown(lambda: print('stopped'))
            print('ready')
    """
    assert ended(program(body)) == (0, 'stopped\n', '')


def test_a_shutdown_by_another_thread_is_waited_for():
    body = """
        def stop():
            print('ready')
            time.sleep(0.3)
            print('stopped')
        def main():
            rospy.on_shutdown(stop)
            threading.Thread(target=rospy.signal_shutdown, args=('test',)).start()
            while not rospy_internals.shutting_down():
                time.sleep(0.001)
    """
    assert ended(program(body)) == (0, 'stopped\n', '')


def test_a_main_that_never_returns_is_left_and_that_is_told():
    body = """
        nodes.SHUTDOWN_TIMEOUT = 0.3
        def main():
            print('ready')
            while True:
                time.sleep(1.0)
    """
    code, _, err = ended(program(body), signal.SIGTERM)
    assert code == 1 and 'did not end within 0.3 s' in err and 'Traceback' not in err


def test_a_shutdown_that_never_ends_is_left():
    body = """
        nodes.SHUTDOWN_TIMEOUT = 0.3
        def main():
            rospy.on_shutdown(lambda: time.sleep(1000.0))
            print('ready')
    """
    code, _, err = ended(program(body))
    assert code in (0, 1) and 'Traceback' not in err


def test_an_error_of_a_thread_is_told_and_ends_nothing():
    body = """
        def fail():
            raise ValueError('mine')
        def main():
            thread = threading.Thread(target=fail, name='worker')
            thread.start()
            thread.join()
            print('ready')
    """
    code, _, err = ended(program(body))
    assert code == 0 and 'The thread worker of this node' in err and 'ValueError: mine' in err


def test_a_node_that_waits_for_a_master_is_ended_at_once(monkeypatch):
    monkeypatch.setenv('ROS_MASTER_URI', 'http://localhost:1')
    process = program("""
        def main():
            nodes.init_node('waiting')
    """)
    assert 'There is no ROS master at http://localhost:1. Waiting' in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 1 and err == 'Stopped while waiting for the ROS master.\n'


def test_nohup_is_respected():
    process = subprocess.Popen(['nohup', sys.executable, '-c', 'import rospy, time\nfrom rospy_support import nodes\n'
                                + textwrap.dedent(SPIN) + 'nodes.run(main)'],
                               text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert process.stdout.readline() == 'ready\n'
    os.kill(process.pid, signal.SIGHUP)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.3)
    process.send_signal(signal.SIGINT)
    assert process.wait(DEADLINE) == 0


def test_ctrl_c_during_the_start_does_not_doubt_a_master_that_answers(monkeypatch, capsys):
    class Master:
        def __init__(self, timeout):
            pass

        def request(self, calls):
            return [[1, '', 4711]]
    monkeypatch.setattr(nodes, 'Master', Master)
    monkeypatch.setattr(nodes, '_ending', threading.Event())
    nodes._ending.set()
    assert nodes.outcome(raising(rospy.exceptions.ROSInitException('stopped'))) == 0
    assert capsys.readouterr().err == 'The node was stopped while it was starting.\n'
