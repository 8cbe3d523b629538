"""doctor.terminal_checks and packages: which packages a terminal finds, which files are programs, what hangs."""
import os
import subprocess
import sys
import time

import pytest

from plain_support.doctor import packages, processes, programs, terminal_checks
from plain_support.doctor.machine import Machine
from rostest_support.waiting import until

PROGRAM = '#!/usr/bin/env python3\nimport rospy\nrospy.init_node("a")\n'



def write(path, text='', mode=0o644):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(mode)
    return str(path)


def machine(tmp_path, **environment):
    return Machine({'PATH': os.environ['PATH'], **environment}, str(tmp_path / 'repository'), str(tmp_path / 'ws'))


def test_packages_are_found_as_rospack_does(tmp_path):
    for folder in ('a', 'more/b', 'a/inside', '.hidden/c', 'ignored/d'):
        write(tmp_path / 'src' / folder / 'package.xml', f'<name>{folder[-1]}_package</name>')
    write(tmp_path / 'src' / 'ignored' / 'CATKIN_IGNORE')
    (tmp_path / 'src' / 'loop').symlink_to(tmp_path / 'src')
    (tmp_path / 'other').mkdir()
    (tmp_path / 'other' / 'linked').symlink_to(tmp_path / 'src' / 'ignored' / 'd')
    path = os.pathsep.join([f'{tmp_path}/src', '/usr/share', f'{tmp_path}/other', f'{tmp_path}/none'])
    found = packages.found({'ROS_PACKAGE_PATH': path})
    assert [(package.name, package.folder[len(str(tmp_path)):]) for package in found] == [
        ('a_package', '/src/a'), ('b_package', '/src/more/b'), ('d_package', '/other/linked')]


def named(tmp_path, **environment):
    return sorted((finding.name, finding.text.split()[0]) for finding in
                  terminal_checks.student_programs(machine(tmp_path, **environment)))


@pytest.mark.parametrize('name, text, mode, found', [
    ('scripts/a.py', PROGRAM, 0o755, []), ('scripts/a.py', PROGRAM, 0o644, ['not_executable']),
    ('a', PROGRAM, 0o644, ['not_executable']), ('src/a.py', PROGRAM[:-1], 0o644, ['not_executable']),
    ('scripts/a.py', 'import rospy\nif __name__ == "__main__":\n    pass\n', 0o755, ['no_shebang']),
    ('scripts/helper.py', 'def helper():\n    pass\n', 0o644, []),  # a module
    ('setup.py', PROGRAM, 0o644, []), ('test/a.py', PROGRAM, 0o644, []), ('scripts/.a.py', PROGRAM, 0o644, []),
    ('launch/a.launch', '<launch/>', 0o644, []), ('scripts/a.txt', 'a note about rospy\n', 0o644, []),
    ('scripts/a.txt', PROGRAM, 0o644, ['wrong_extension']), ('scripts/a.sh', '#!/bin/sh\n', 0o644, []),
])
def test_programs_are_told_from_other_files(tmp_path, name, text, mode, found):
    write(tmp_path / 'src' / 'mine' / 'package.xml', '<name>mine</name>')
    write(tmp_path / 'src' / 'mine' / name, text, mode)
    assert [kind for kind, _ in named(tmp_path, ROS_PACKAGE_PATH=f'{tmp_path}/src')] == found


def test_modules_of_a_package_and_what_catkin_installs_are_no_matter_of_mode(tmp_path):
    write(tmp_path / 'src' / 'mine' / 'package.xml', '<name>mine</name>')
    write(tmp_path / 'src' / 'mine' / 'src' / 'mine' / '__init__.py')
    write(tmp_path / 'src' / 'mine' / 'src' / 'mine' / 'node.py', PROGRAM)
    write(tmp_path / 'src' / 'mine' / 'scripts' / 'a.py', PROGRAM)
    path = {'ROS_PACKAGE_PATH': f'{tmp_path}/src', 'CMAKE_PREFIX_PATH': f'{tmp_path}/devel'}
    assert [kind for kind, _ in named(tmp_path, **path)] == ['not_executable']
    write(tmp_path / 'devel' / 'lib' / 'mine' / 'a.py')
    assert named(tmp_path, **path) == []


def test_packages_of_this_repository_are_not_the_students(tmp_path):
    write(tmp_path / 'repository' / 'ours' / 'package.xml', '<name>ours</name>')
    write(tmp_path / 'repository' / 'ours' / 'scripts' / 'a.py', PROGRAM)
    (tmp_path / 'src').mkdir()
    (tmp_path / 'src' / 'ours').symlink_to(tmp_path / 'repository' / 'ours')
    assert named(tmp_path, ROS_PACKAGE_PATH=f'{tmp_path}/src') == []


@pytest.mark.parametrize('line, why', [
    ('#!/usr/bin/env python3', ''), ('#! /usr/bin/env  python3', ''), ('#!/bin/python3', ''),
    ('#!/usr/bin/env python', ''), ('#!/usr/bin/env -S python3 -u', ''),
    ('#!/usr/bin/env python3 -u', 'there is no python3 -u here'), ('#!/usr/bin/env python2', 'python2 is Python 2'),
    ('#!/bin/python2.7', 'there is no /bin/python2.7 here'), ('#!/no/env python3', 'there is no /no/env here'),
    ('#!/bin/bash', '/bin/bash is not Python'), ('#!', 'there is no '), ('#!/usr/bin/env', 'there is no '),
    ('#!/usr/bin/env python4', 'there is no python4 here'),
])
def test_first_lines(tmp_path, line, why):
    for name in ('python', 'python2', 'python3'):
        write(tmp_path / 'bin' / name, mode=0o755)
    program = write(tmp_path / 'a.py', mode=0o755)
    found = list(programs.faults(program, f'{line}\n'.encode(), {'PATH': f'{tmp_path}/bin'}))
    assert [finding.name for finding in found] == ['wrong_shebang'] * bool(why)
    assert all(why in finding.text and line in finding.text for finding in found)


def test_the_first_line_of_windows_is_read_without_its_end(tmp_path):
    program = write(tmp_path / 'a.py', mode=0o755)
    content = b'\xef\xbb\xbf' + PROGRAM.replace('\n', '\r\n').encode()
    assert [finding.name for finding in programs.faults(program, content)] == ['byte_order_mark', 'windows_line_ends']


@pytest.fixture
def node(tmp_path):
    """A process that has a log open, as a node of rospy; yield (process, its log)."""
    log = tmp_path / 'node-1.log'
    program = write(tmp_path / 'student.py', 'import sys, time\nlog = open(sys.argv[1], "a")\ntime.sleep(1e6)\n')
    process = subprocess.Popen([sys.executable, program, str(log)],
                               env={**os.environ, 'ROS_MASTER_URI': 'http://localhost:1'})
    until(log.exists)
    yield process, log
    process.kill()
    process.wait()


def told(log, ago, why='signal-2'):
    """Write the lines of rospy, ``ago`` [s] before now."""
    moment = time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(time.time() - ago))
    with open(log, 'a', encoding='utf-8') as file:
        file.write(f'[rospy.core][INFO] {moment},123: signal_shutdown [{why}]\n')


def mine(process):
    return [finding for finding in terminal_checks.hanging(Machine({}, '', '')) if str(process.pid) in finding.text]


def test_a_node_that_lives_on_is_named(node, monkeypatch):
    process, log = node
    monkeypatch.setattr(terminal_checks.processes, 'age', lambda pid: 100.0)
    assert mine(process) == []
    told(log, 200.0)  # an earlier node of the same name
    told(log, 3.0)  # it may still be ending
    told(log, 50.0, 'atexit')
    assert mine(process) == []
    told(log, 50.0)
    found, = mine(process)
    assert found.name == 'does_not_end' and found.text.startswith(
        f'student.py (process {process.pid}) was told to end 5')  # 50 s and the time of this test
    assert f'Ctrl-\\ in its terminal, or type kill -9 {process.pid};' in found.cure


def test_a_log_of_two_nodes_says_nothing(node, monkeypatch):
    process, log = node
    monkeypatch.setattr(terminal_checks.processes, 'age', lambda pid: 100.0)
    told(log, 50.0)
    other = subprocess.Popen(process.args, env={**os.environ, 'ROS_MASTER_URI': 'http://localhost:1'})
    try:
        until(lambda: terminal_checks._logs(other.pid) == [str(log)])
        assert mine(process) == []
    finally:
        other.kill()
        other.wait()


def test_age_of_a_process():
    before = time.monotonic()
    with subprocess.Popen(['sleep', '1000']) as process:
        until(lambda: processes.age(process.pid) > 0.3)
        assert processes.age(process.pid) <= time.monotonic() - before + 0.05  # the clock's ticks are 10 ms long
        process.kill()
    assert processes.age(process.pid) == 0.0
