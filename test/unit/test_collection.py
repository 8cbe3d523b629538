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


@pytest.mark.parametrize('options, names', [
    (['--select=test_an_interrupt_ends_every_run'],
     ['test/unit/test_collection.py::test_an_interrupt_ends_every_run']),
    (['--select=test_collection.py::test_all_runs_the_nightly_tests_too'],
     ['test/unit/test_collection.py::test_all_runs_the_nightly_tests_too']),
    (['--select=lesson_square.test'], ['test/course/lesson_square.test::lesson_square']),
    (['--select=check/ruff', '--fast'], ['test/cases/test_check.py::test_style[ruff]']),
    (['--select=lesson_square.test', '--fast'], []),
    (['--select=page/course/03_'], ['test/cases/test_page.py::test_page[course/03_stop_at_x/README.md]']),
    (['test/cases/test_page.py'], []),
    (['-m', 'rostest', 'test/course/lesson_square.test'], ['test/course/lesson_square.test::lesson_square']),
], ids=['function', 'of a file', 'rostest', 'check', 'rostest not fast', 'page', 'page not nightly', 'mark'])
@pytest.mark.one_in(3)
def test_selection(options, names):
    assert collected(*options) == names


def test_all_runs_the_nightly_tests_too():
    pages = collected('--all', 'test/cases/test_page.py')
    assert len(pages) > 35 and pages == collected('-m', 'nightly', 'test/cases/test_page.py')


def test_a_change_runs_some_of_the_cases():
    file, test = 'test/unit/test_root_package.py', 'test_without_turtlesim_cmake_stops_and_says_what_to_type'
    some, every = ([name for name in collected(*options, file) if test in name] for options in ([], ['--all']))
    assert some == every[::2] and len(every) == 2


@pytest.mark.parametrize('options', [[], ['--fast'], ['unit/'], ['turtlesim']])
def test_the_runs_share_the_files_of_units(options):
    commands = run_tests.commands(run_tests.parse(['--results', '/x', *options]))
    shared = [path for name, command in commands.items() if name != 'waiting' for path in command if '/test_' in path]
    wanted = [str(path) for path in run_tests.files([name for name in options if name != '--fast'])
              if path.suffix == '.py' and not ('--fast' in options and kinds.is_slow(path))]
    assert ('waiting' in commands) == ('--fast' not in options)
    assert sorted(shared) == sorted([*wanted, str(kinds.CASES / 'test_check.py')]) and len(wanted) > 10


def run_of(code, *failed):
    """Return the command of a run of pytest that adds failed tests to its results, and ends with an exit code."""
    return [sys.executable, '-c', 'import sys; open("failed", "a").write(sys.argv[2]); sys.exit(int(sys.argv[1]))',
            str(code), ''.join(f'{name}\n' for name in failed)]


@pytest.mark.parametrize('waiting, computing, alone, repeated, code', [
    ((0,), (0,), 1, [], 0),
    ((1, 'a'), (1, 'b'), 0, ['a', 'b'], 0),
    ((1, 'a'), (0,), 1, ['a'], 1),
    ((1, 'a'), (3,), 0, ['a'], 1),  # pytest itself broke
    ((1, *map(str, range(run_tests.MAX_REPEATED + 1))), (0,), 0, [], 1),
], ids=['passed', 'load', 'fault', 'broken', 'many'])
def test_few_failed_tests_are_repeated_alone(tmp_path, monkeypatch, capfd, waiting, computing, alone, repeated, code):
    asked = []

    def start(name, command, results, shown):
        if name == 'repeated':
            asked.extend(part for part in command if len(part) <= 2 and part[0] != '-')
            command = run_of(alone)
        return subprocess.Popen(command, cwd=results)
    monkeypatch.setattr(run_tests, 'start', start)
    monkeypatch.setattr(run_tests.signal, 'signal', lambda *_: None)  # not of this process
    monkeypatch.setattr(run_tests, 'commands', lambda _: {'computing': run_of(*computing), 'waiting': run_of(*waiting)})
    (tmp_path / 'computing.txt').touch()
    assert run_tests.main(['--results', str(tmp_path)]) == code
    assert asked == repeated
    printed = capfd.readouterr().out
    assert ('REPEATED alone' in printed) == bool(repeated) and all(f'\n  {name}\n' in printed for name in repeated)


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
