"""What ./run test and pytest select, how the result of a rostest is read, that all of it is run, and how runs end."""
import ast
import os
import re
import signal
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree

import pytest

import run_tests
from collection import kinds, programs, rostests
from rostest_support.waiting import until
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

RAN = '<testsuite tests="1" failures="0" errors="0"><testcase classname="RosTest" name="testx"/></testsuite>'
DIED = RAN.replace('/></testsuite>', '><failure>test max time allotted</failure></testcase></testsuite>')
PASSES = '<testsuite tests="1" failures="0" errors="0" name="s"><testcase classname="A" name="a"/></testsuite>'
FAILS = """<testsuite tests="2" failures="1" errors="1" name="s"><testcase classname="A" name="a">
  <failure type="AssertionError">1 != 2
  File "/usr/lib/python3.11/unittest/case.py", line 57, in testPartExecutor
    yield
  File "/x/test.py", line 9, in a
    self.fail()</failure></testcase><testcase classname="A" name="b"><error message="broke"/></testcase></testsuite>"""
SUBTEST_FAILS = PASSES.replace('failures="0"', 'failures="2"')
SKIPS = '<testsuite tests="1"><testcase classname="A" name="a"><skipped message="no data"/></testcase></testsuite>'
NO_TESTS = '<testsuite tests="0" failures="0" errors="0" name="s"/>'


def read(folder, *texts):
    """Return the result of result files with these texts, beside that of rostest itself."""
    for number, text in enumerate(texts):
        name = 'rostest-x.xml' if text in (RAN, DIED) else f'{number}.xml'
        (folder / name).write_text(text)
    methods, problems = rostests.read_results(folder)
    return {outcome: names for outcome, names in methods.items() if names}, problems


@pytest.mark.parametrize('texts, methods, problems', [
    ((), {}, []),
    ((RAN, PASSES), {'passed': ['a']}, []),
    ((RAN, SKIPS), {'skipped': ['a: no data']}, []),
    ((RAN, FAILS), {'failed': ['a', 'b']}, ['1 != 2\n  File "/x/test.py", line 9, in a\n    self.fail()', 'broke']),
    ((DIED, PASSES), {'passed': ['a']}, ['test max time allotted']),
], ids=['nothing', 'passed', 'skipped', 'failed', 'died'])
def test_result_files(tmp_path, texts, methods, problems):
    assert read(tmp_path, *texts) == (methods, problems)


@pytest.mark.parametrize('text, problem', [
    (SUBTEST_FAILS, '2 failures without a case'), (NO_TESTS, 'holds no test'), ('<testsuite', 'cannot be read')])
def test_what_a_result_file_only_counts_is_a_problem(tmp_path, text, problem):
    _, problems = read(tmp_path, RAN, text)
    assert len(problems) == 1 and problem in problems[0]


def collected(*options):
    """Return what pytest collects, as `path::name` lines."""
    done = subprocess.run([sys.executable, '-m', 'pytest', '--collect-only', '-q', *options], cwd=kinds.REPOSITORY,
                          stdout=subprocess.PIPE, text=True, check=False)
    return [line for line in done.stdout.splitlines() if '::' in line]


@pytest.mark.parametrize('arguments, names', [
    (['test_collection.py::test_an_interrupt'], ['test/unit/test_collection.py::test_an_interrupt_ends_every_run']),
    (['page/course/03_'], ['test/cases/test_page.py::test_page[page/course/03_stop_at_x/README.md]']),
    (['test_pages_pictures.py::test_differences_from_the_page[saved3-it lacks 45 %]'],
     ['test/unit/test_pages_pictures.py::test_differences_from_the_page[saved3-it lacks 45 %]']),
    *nightly((['test_an_interrupt_ends_every_run'],
              ['test/unit/test_collection.py::test_an_interrupt_ends_every_run']),
             (['lesson_square.test'], ['test/course/lesson_square.test::lesson_square']),
             (['ruff'], ['test/cases/test_check.py::test_style[check/ruff]']),
             (['--fast', 'page/course/03_'], [])),
], ids=['of a file', 'page', 'spaces', 'function', 'rostest', 'check', 'page not fast'])
def test_names_select_tests(arguments, names):
    *_, command = run_tests.commands(run_tests.parse(['--results', '/x', *arguments])).values()
    options = command[command.index('pytest') + 1:]
    assert collected(*(option for option in options if not option.startswith(('-q', '--res', '--junit')))) == names


def test_nightly_tests_are_left_out_unless_they_are_asked_for():
    file = 'test/cases/test_page.py'
    pages = collected('--all', file)
    assert collected('-m', 'page and not nightly', file) == []
    assert len(pages) > 35 and pages == collected('-m', 'nightly', file)


@pytest.mark.parametrize('options', [[], ['--fast'], ['unit/'], ['turtlesim']])
def test_the_runs_share_the_files(options):
    commands = run_tests.commands(run_tests.parse(['--results', '/x', *options]))
    shared = [path for command in commands.values() for path in command if path.endswith(('.py', '.test'))]
    names = [name for name in options if name != '--fast']
    wanted = [str(path) for path in run_tests.files('test_*.py', names)
              if '--fast' not in options or not run_tests.SLOW.search(path.read_text(encoding='utf-8'))]
    waiting = [] if '--fast' in options else run_tests.files('*.test', names)
    cases = [kinds.CASES / 'test_check.py'] if '--fast' in options else kinds.CASES.glob('test_*.py')
    assert sorted(shared) == sorted([*wanted, *map(str, waiting), *map(str, cases)]) and len(wanted) > 10


def test_an_interrupt_ends_every_run():
    runs = {name: subprocess.Popen(['bash', '-c', 'trap "exit 7" INT; echo; while :; do sleep 0.05; done'],
                                   stdout=subprocess.PIPE) for name in ('computing', 'waiting')}
    for process in runs.values():
        process.stdout.readline()  # the trap is set
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
        run_tests.finish(runs)
    assert [process.poll() for process in runs.values()] == [7, 7]


def is_running(number):
    return os.path.exists(f'/proc/{number}')


def test_a_program_leaves_nothing_running(tmp_path):
    script = 'setsid sleep 97 & echo $!; until grep -q sleep /proc/$!/comm; do :; done; exit 3'
    code, output = programs.run(['bash', '-c', script], tmp_path / 'case')
    number = int(output.split()[0])
    until(lambda: not is_running(number) or open(f'/proc/{number}/stat').read().split()[2] == 'Z')
    assert code == 3 and f'ended left-over process {number}' in output


def test_without_ros_packages_are_found():
    """Modules that need no ROS are tested without a sourced workspace, and others name the missing part."""
    environment = {name: value for name, value in os.environ.items() if 'ROS' not in name and name != 'PYTHONPATH'}
    done = subprocess.run([sys.executable, '-m', 'pytest', '-q', '-rs', 'test/course/lesson_square.test',
                           'test/unit/turtle_robotont/test_shapes.py'], cwd=kinds.REPOSITORY, env=environment,
                          stdout=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0 and ' passed, 1 skipped' in done.stdout, done.stdout
    assert 'no workspace with this repository is sourced' in done.stdout


TESTED = [element.attrib for path in kinds.REPOSITORY.rglob('*.test') if '/.' not in str(path)
          for element in ElementTree.parse(str(path)).iter('test')]
PROGRAMS = [path for path in sorted(kinds.REPOSITORY.rglob('*_test.py')) if '/.' not in str(path)]


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.name)
def test_each_method_of_a_rostest_is_run_by_a_test_file(path):
    """A .test names some methods of its program, or runs them all; a method that none names is never run."""
    methods = {node.name for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
               if isinstance(node, ast.FunctionDef) and node.name.startswith('test_')}
    named = [set(re.findall(r'\btest_\w+', attributes.get('args', ''))) for attributes in TESTED
             if attributes['type'] == path.name]
    assert named, f'no .test file runs {path.name}'
    assert methods - set().union(*(names or methods for names in named)) == set()
    assert set().union(*named) <= methods
