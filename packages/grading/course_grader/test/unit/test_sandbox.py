"""course_grader.isolation.sandbox: what a student's program may do, and that nothing of it remains."""
import os
import re
import signal
import subprocess
import sys

import pytest

from course_grader.isolation import confinement, limits, sandbox
from plain_support import processes
from rostest_support.waiting import until

pytestmark = pytest.mark.slow

FORKS = r'''
import os, signal, sys, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.write(1, b'child %d\n' % os.getpid())
        if sys.argv[1:] == ['nameless']:
            os.execve('/bin/sleep', ['sleep', '1000'], {})
        time.sleep(1000)
    os._exit(0)
os.write(1, b'parent %d\n' % os.getpid())
time.sleep(1000)
'''


def write(folder, text, name='program.py', mode=0o644):
    path = folder / name
    path.write_bytes(text.encode())
    path.chmod(mode)
    return str(path)


def alive(pid):
    try:
        with open(f'/proc/{pid}/stat', encoding='utf-8') as file:
            return file.read().rsplit(')', 1)[1].split()[0] != 'Z'
    except (FileNotFoundError, ProcessLookupError):
        return False


def run(folder, *arguments, then=''):
    """Run a sandbox in a process of its own, as the grader does; return what it prints. ``then``: what it does last."""
    program = (f'import sys; sys.path[:] = {sys.path!r}\nfrom course_grader.isolation import sandbox\n'
               'import os, time\n'
               f'with sandbox.Sandbox({str(folder / "box")!r}, os.environ) as box:\n'
               f'    student = sandbox.Student(box, {[sys.executable, *arguments]!r}, lambda: 1.5)\n'
               '    end = time.monotonic() + 10\n'
               '    while len(student.lines) < 2 and time.monotonic() < end: time.sleep(0.01)\n'
               '    print([line.text for line in student.lines], flush=True)\n'
               f'    {then}\n')
    ended = subprocess.run([sys.executable, '-c', program], stdout=subprocess.PIPE, check=not then, timeout=60)
    return ended.stdout.decode()


def ended(tmp_path, program, clock=lambda: 0.0):
    """Return the Student whose program has ended."""
    with sandbox.Sandbox(tmp_path / 'box', os.environ) as box:
        student = sandbox.Student(box, [sys.executable, program], clock)
        until(lambda: student.exit_code() is not None)
        student.drain()
    return student


@pytest.mark.parametrize('argument', ['marked', 'nameless'])
def test_children_that_hide_are_ended(tmp_path, argument):
    """A grandchild in a session of its own, deaf to signals, also one that has wiped its environment."""
    said = eval(run(tmp_path, write(tmp_path, FORKS), argument))
    pids = [int(line.split()[1]) for line in said]
    assert len(pids) == 2
    until(lambda: not any(map(alive, pids)))
    assert os.listdir(tmp_path / 'box') == []


def test_a_killed_grader_leaves_nothing(tmp_path):
    """The guardian ends what it had started, also what is deaf to gentle signals, and removes its folders."""
    said = eval(run(tmp_path, write(tmp_path, FORKS), then='import os, signal; os.kill(os.getpid(), signal.SIGKILL)'))
    pids = [int(line.split()[1]) for line in said]
    assert len(pids) == 2
    until(lambda: not any(map(alive, pids)))
    until(lambda: os.listdir(tmp_path / 'box') == [])


def test_output_is_cleaned_dated_and_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(sandbox, 'MAX_LINES', 4)
    program = write(tmp_path, r'''
import sys
print('\033[0m[INFO] [1668.25, 3.2]: \u00fcber\033[0m')
print('[WARN] [1668.25]: x: 1')
sys.stdout.buffer.write(b'\xff\n' + b'y' * 5000 + b'\n')
for number in range(100): print(number, file=sys.stderr)
''')
    student = ended(tmp_path, program, lambda: 1.5)
    assert student.exit_code() == 0
    assert [line.text for line in student.lines[:3]] == ['\u00fcber', 'x: 1', '\ufffd']
    assert len(student.lines[3].text) == sandbox.MAX_LINE_LENGTH and student.dropped >= 100
    assert student.lines[0].t == 1.5


def test_lines_that_end_with_a_carriage_return_are_lines(tmp_path):
    program = write(tmp_path, r"""
import time
for number in range(3):
    print(f'x: {number}', end='\r', flush=True)
    time.sleep(0.05)
print('y: 1', end='\r\n')
print('no end', end='', flush=True)
""")
    times = iter(range(100))
    student = ended(tmp_path, program, lambda: next(times))
    assert student.exit_code() == 0
    assert [line.text for line in student.lines] == ['x: 0', 'x: 1', 'x: 2', 'y: 1', 'no end']
    assert [line.t for line in student.lines] == [0, 1, 2, 3, 4]


def test_who_starts_too_many_processes_is_ended_with_all_of_them(tmp_path):
    program = write(tmp_path, """
import os, time
for _ in range(30):
    if os.fork() == 0:
        os.write(1, b'%d\\n' % os.getpid())
        break
time.sleep(1000)
""")
    few = confinement.Isolation(limits=limits.Limits(processes=20))
    with sandbox.Sandbox(tmp_path / 'box', os.environ, isolation=few) as box:
        student = sandbox.Student(box, [sys.executable, program], lambda: 0.0)
        until(lambda: student.exit_code() is not None)
        assert student.problem() == (
            'the program exceeded a limit: processes and threads at a time: 20 (--max-processes)',)
        until(lambda: not any(alive(int(line.text)) for line in student.lines))  # before the sandbox is closed


def test_a_traceback_is_explained(tmp_path):
    program = write(tmp_path, 'import rospy\nimport no_such_module\n', 'crash.py')
    student = ended(tmp_path, program)
    assert student.exit_code() == 1
    assert student.last_output().startswith("ModuleNotFoundError: No module named 'no_such_module' (File \"")
    assert 'crash.py", line 2' in student.last_output()


@pytest.mark.parametrize('text, trouble', [
    ('', ''), ('import sys\nsys.exit(3)\n', 'the program ended with exit code 3: it printed nothing'),
    ('import rospy\nraise rospy.ROSInterruptException("ROS shutdown request")\n', ''),
    ('input("size? ")\n', 'input() does not work here'),
])
def test_an_end_is_no_trouble_unless_it_failed(tmp_path, text, trouble):
    student = ended(tmp_path, write(tmp_path, text))
    assert trouble in student.problem().text if trouble else student.problem() is None


def test_it_is_seen_whether_a_program_and_its_children_work(tmp_path):
    program = write(tmp_path, 'import os, time\nif os.fork(): time.sleep(60)\nprint(os.getpid())\nwhile True: pass\n')
    with sandbox.Sandbox(tmp_path / 'box', os.environ) as box:
        student = sandbox.Student(box, [sys.executable, program], lambda: 0.0)
        until(lambda: student.lines)
        child = int(student.lines[0].text)
        until(lambda: child in processes.descendant_ids(student.process.pid))
        assert student.runs() is None
        os.kill(child, signal.SIGSTOP)
        os.kill(child, signal.SIGKILL)
        until(lambda: student.runs() is not None)


def test_a_node_begins_when_there_is_a_time(tmp_path):
    """What the grader puts first on the path of modules waits in rospy's own function."""
    program = write(tmp_path, """
import threading, time
import rospy.impl.simtime as simtime, rospy.rostime as rostime
simtime._is_use_simtime = lambda: True
simtime.rospy.topics.Subscriber = lambda *_, **__: threading.Timer(0.3, rostime._set_rostime, [rostime.Time(7)]).start()
print(simtime.init_simtime(), rostime.get_time())
""")
    student = ended(tmp_path, program)
    assert [line.text for line in student.lines] == ['True 7.0']


def test_the_distributions_sitecustomize_runs_as_well(tmp_path, monkeypatch):
    write(tmp_path, 'import sys\nprint("of the distribution", type(sys.meta_path[0]).__name__)\n', 'sitecustomize.py')
    monkeypatch.setenv('PYTHONPATH', str(tmp_path))
    student = ended(tmp_path, write(tmp_path, 'print("program")\n'))
    assert student.exit_code() == 0
    assert [line.text for line in student.lines] == ['of the distribution Finder', 'program']


GOOD = '#!/usr/bin/env python3\nprint(1)\n'


@pytest.mark.parametrize('text, name, mode, remarks', [
    (GOOD, 'a.py', 0o755, []),
    (GOOD, 'a.py', 0o644, ['{} is not executable, so rosrun cannot start it; type chmod +x {}']),
    (GOOD, 'no_suffix', 0o755, []),
    ('print(1)\n', 'a.py', 0o755, ['the first line of {} is not #!/usr/bin/env python3']),
    (GOOD.replace('\n', '\r\n'), 'a.py', 0o755, ['the lines of {} end with CR LF (Windows)']),
])
def test_python_runs_whatever_its_mode(tmp_path, text, name, mode, remarks):
    program = write(tmp_path, text, name, mode)
    command, said = sandbox.runnable([program, 'x'])
    assert command == [sys.executable, program, 'x']
    assert len(said) == len(remarks)
    assert all(one.startswith(remark.replace('{}', program)) for one, remark in zip(said, remarks))


@pytest.mark.parametrize('text, name, interpreter', [
    ('#!/bin/sh\n', 'a.sh', ['/bin/sh']), ('#! /usr/bin/env bash\n', 'a', ['/usr/bin/env', 'bash']),
    ('ls\n', 'a.bash', ['bash']),
])
def test_a_script_without_permission_runs_by_its_kind(tmp_path, text, name, interpreter):
    program = write(tmp_path, text, name, 0o644)
    command, said = sandbox.runnable([program, 'x'])
    assert command == [*interpreter, program, 'x']
    assert len(said) == 1 and said[0].startswith(f'{program} is not executable')


@pytest.mark.parametrize('text, name, mode, said', [
    (None, 'none.py', 0, 'none.py does not exist (current folder:'),
    ('print 1\n', 'a.py', 0o755, "a.py, line 1: SyntaxError: Missing parentheses in call to 'print'"),
    ('def f():\nx\n', 'a.py', 0o755, 'a.py, line 2: IndentationError'),
    ('\0', 'a.py', 0o755, 'a.py'),
    ('pass\n' * 400_000, 'a.py', 0o755, 'a.py: it has 1.9 MB; at most 1 MB are read'),
    ('\x7fELF', 'a', 0o644, 'a is not executable, so rosrun cannot start it; type chmod +x'),
    ('#!/bin/sh\r\n', 'a.sh', 0o755, 'the lines of a.sh end with CR LF'),
])
def test_what_cannot_run_is_named(tmp_path, monkeypatch, text, name, mode, said):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        write(tmp_path, text, name, mode)
    with pytest.raises(sandbox.CommandError) as error:
        sandbox.runnable([name if text is None else f'{tmp_path}/{name}'])
    assert str(error.value).replace(f'{tmp_path}/', '').startswith(said)


@pytest.mark.parametrize('argument, said', [
    ('a\0b', 'the command contains the character NUL (its code is 0); remove it'),
    ('ä' * 60_000, 'the command has 120,007 bytes; at most 100,000 can be started')])
def test_a_command_that_linux_cannot_start_is_refused(argument, said):
    with pytest.raises(sandbox.CommandError, match=re.escape(said)):
        sandbox.runnable(['python3', argument])


@pytest.mark.parametrize('command, started', [
    (['python3', 'a.py', '_x:=1'], [sys.executable, '{}/a.py', '_x:=1']),
    (['bash', 'a.sh', 'a.py', 'none.py'], ['bash', '{}/a.sh', '{}/a.py', 'none.py']),
    (['a.launch', 'x:=1'], ['roslaunch', '--screen', '{}/a.launch', 'x:=1']),
    (['roslaunch', 'a.launch', 'x:=1'], ['roslaunch', '--screen', '{}/a.launch', 'x:=1']),
    (['roslaunch', 'package', 'a.launch'], ['roslaunch', '--screen', 'package', 'a.launch']),
    (['rosrun', 'package', 'a.py'], ['rosrun', 'package', 'a.py']),
    (['rosrun', 'dynamic_reconfigure', 'a.py', 'load', '/node', 'a.sh'],
     ['rosrun', 'dynamic_reconfigure', 'a.py', 'load', '/node', '{}/a.sh']),
    (['rosrun', '--debug', 'a.sh', 'a.py', 'a.sh'], ['rosrun', '--debug', 'a.sh', 'a.py', '{}/a.sh']),
    (['a.cmd'], ['rosrun', 'package', 'node', '{}/a.sh']),
])
def test_files_are_meant_where_they_were_typed(tmp_path, monkeypatch, command, started):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sandbox.shutil, 'which', lambda name: f'/usr/bin/{name}')
    for name in ('a.py', 'a.sh', 'a.launch'):
        write(tmp_path, '', name)
    write(tmp_path, '# how it starts\nrosrun package node a.sh\n', 'a.cmd')
    assert sandbox.runnable(command)[0] == [part.replace('{}', str(tmp_path)) for part in started]


@pytest.mark.parametrize('text, said', [('a.cmd', 'a.cmd'), ('', 'it contains 0 command lines'),
                                        ('b "', 'No closing quotation'), ('python3 a.cmd', 'a.cmd')])
def test_a_command_file_without_a_command(tmp_path, text, said):
    with pytest.raises(sandbox.CommandError, match=said):
        sandbox.runnable([write(tmp_path, text, 'a.cmd')])


def test_the_package_of_a_file(tmp_path):
    (tmp_path / 'mine' / 'scripts').mkdir(parents=True)
    program = write(tmp_path / 'mine' / 'scripts', '')
    assert sandbox.package_of(['rosrun', 'a', 'b']) is None
    write(tmp_path / 'mine', '<package/>', 'package.xml')
    assert sandbox.package_of([sys.executable, program]) == str(tmp_path / 'mine')
    assert sandbox.package_of([program, 'x:=1']) == str(tmp_path / 'mine')


def test_commands_folders_and_nothing(tmp_path):
    assert sandbox.runnable(['rosrun', 'a', 'b']) == (['rosrun', 'a', 'b'], []) or not os.path.exists('/usr/bin/rosrun')
    with pytest.raises(sandbox.CommandError, match='is a folder'):
        sandbox.runnable([str(tmp_path)])
    with pytest.raises(sandbox.CommandError, match='the command is missing'):
        sandbox.runnable([])
