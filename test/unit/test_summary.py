"""The summary of ./run test: what counts as passed, failed and skipped, and that nothing missing is overlooked."""
import importlib.util
import pathlib

import pytest

_SPEC = importlib.util.spec_from_file_location('summary', pathlib.Path(__file__).parents[1] / 'summary.py')
summary = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(summary)

RAN = '<testsuite tests="1" failures="0" errors="0"><testcase classname="RosTest" name="testx"/></testsuite>'
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
ROSTEST = 'test/rostest/x.test'


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def outcomes(cases):
    return [case.outcome for case in cases]


@pytest.mark.parametrize('text, expected', [
    (PASSES, ['passed']),
    (f'<testsuites>{PASSES}{SKIPS}</testsuites>', ['passed', 'skipped']),
    (FAILS, ['failed', 'failed']),
    (SKIPS, ['skipped']),
    (NO_TESTS, []),
    (SUBTEST_FAILS, ['passed', 'failed']),
    ('<testsuite', ['failed']),
    ('', ['failed']),
])
def test_junit_file(tmp_path, text, expected):
    write(tmp_path / 'x.xml', text)
    assert outcomes(summary.read_junit(tmp_path / 'x.xml')) == expected


def test_messages_are_kept_without_the_frames_of_unittest(tmp_path):
    write(tmp_path / 'x.xml', FAILS)
    first, second = summary.read_junit(tmp_path / 'x.xml')
    assert first.message == '1 != 2\n  File "/x/test.py", line 9, in a\n    self.fail()'
    assert second.message == 'broke'


@pytest.mark.parametrize('files, code, expected', [
    ({'rostest-x.xml': RAN, 'rosunit-a.xml': PASSES}, 0, ['passed']),
    ({'rostest-x.xml': RAN, 'rosunit-a.xml': PASSES, 'rosunit-b.xml': FAILS}, 2, ['passed', 'failed', 'failed']),
    ({'rostest-x.xml': RAN, 'rosunit-a.xml': NO_TESTS}, 0, ['failed']),  # a test node without a test
    ({'rostest-x.xml': NO_TESTS}, 0, ['failed']),  # a .test file without a <test>
    ({'rostest-x.xml': FAILS}, 1, ['failed', 'failed']),  # the test node crashed
    ({}, 1, ['failed']),
    ({}, None, ['failed']),
    ({'rostest-x.xml': RAN, 'rosunit-a.xml': PASSES}, 124, ['passed', 'failed']),
    ({'rostest-x.xml': RAN, 'rosunit-a.xml': PASSES}, None, ['passed', 'failed']),
])
def test_rostest(tmp_path, files, code, expected):
    folder = tmp_path / 'rostest' / ROSTEST
    for name, text in files.items():
        write(folder / 'xml' / 'package' / name, text)
    if code is not None:
        write(folder / 'exit_code', f'{code}\n')
    assert outcomes(summary.rostest_cases(tmp_path, ROSTEST)) == expected


def test_the_time_limit_is_named(tmp_path):
    write(tmp_path / 'rostest' / ROSTEST / 'exit_code', '124\n')
    (case,) = summary.rostest_cases(tmp_path, ROSTEST)
    assert 'time limit' in case.message


def test_a_unit_test_file_without_a_case_has_failed(tmp_path):
    names = ['test/unit/test_a.py', 'test/unit/test_ab.py', 'test/unit/test_b.py']
    write(tmp_path / 'unit' / 'pytest.xml', '<testsuite tests="2"><testcase classname="test.unit.test_ab" name="a"/>'
          '<testcase classname="test.unit.test_b.TestB" name="b"/></testsuite>')
    cases = summary.unit_cases(tmp_path, names)
    assert [case.name for case in cases if case.outcome == 'failed'] == ['test/unit/test_a.py']


def test_pytest_without_results_has_failed(tmp_path):
    assert outcomes(summary.unit_cases(tmp_path, ['test/unit/test_a.py'])) == ['failed']


@pytest.mark.parametrize('code, expected', [('0', 'passed'), ('1', 'failed'), ('', 'failed'), (None, 'failed')])
def test_checks_go_by_their_exit_code(tmp_path, code, expected):
    if code is not None:
        write(tmp_path / 'ruff' / 'check' / 'exit_code', code)
    assert summary.check_case(tmp_path, 'ruff', 'check').outcome == expected


@pytest.mark.parametrize('names, line', [
    ('', '0 passed, 0 failed'),
    ('pp', '2 passed, 0 failed'),
    ('pfp', '2 passed, 1 failed'),
    ('psf', '1 passed, 1 failed, 1 skipped'),
])
def test_closing_line(names, line):
    kinds = {'p': 'passed', 'f': 'failed', 's': 'skipped'}
    assert summary.closing_line([summary.Case('x', kinds[name], '') for name in names]) == line


@pytest.mark.parametrize('unit, code, last_line', [
    (PASSES, 0, '2 passed, 0 failed'),
    (FAILS, 1, '1 passed, 2 failed'),
    (SKIPS, 0, '1 passed, 0 failed, 1 skipped'),
])
def test_main_prints_the_closing_line_alone_and_last(tmp_path, capsys, unit, code, last_line):
    write(tmp_path / 'expected.tsv', 'unit\tA.py\nruff\tcheck\n')
    write(tmp_path / 'unit' / 'pytest.xml', unit)
    write(tmp_path / 'ruff' / 'check' / 'exit_code', '0')
    assert summary.main([str(tmp_path)]) == code
    assert capsys.readouterr().out.splitlines()[-1] == last_line


@pytest.mark.parametrize('expected', ['', 'unit\tA.py\n'])
def test_a_run_in_which_nothing_passed_has_failed(tmp_path, expected):
    write(tmp_path / 'expected.tsv', expected)
    write(tmp_path / 'unit' / 'pytest.xml', SKIPS)
    assert summary.main([str(tmp_path)]) == 1


def write_results(results, codes, folder='{}'):
    """Write the results of rostests and gradings, {name: exit code}; `folder` makes a folder's name of a name."""
    for name, code in codes.items():
        kind = 'grading' if name.startswith('grade') else 'rostest'
        write(results / kind / folder.format(name) / 'exit_code', f'{code}\n')
        write(results / kind / folder.format(name) / 'output.txt', f'{name} said this\n')
        if kind == 'rostest':
            write(results / kind / folder.format(name) / 'xml' / 'rosunit-x.xml', FAILS if code else PASSES)


@pytest.mark.parametrize('codes, expected', [
    ({'a': 0, 'b': 0, 'grade_c': 0}, ''),
    ({'a': 0, 'b': 1, 'grade_c': 124}, 'rostest\tb\ngrading\tgrade_c\n'),
    ({'b': 1}, ''),  # nothing was beside it
    ({**dict.fromkeys('abcdefghij', 1), 'k': 0}, ''.join(f'rostest\t{name}\n' for name in 'abcdefghij')),
    (dict.fromkeys('abcdefghijk', 1), ''),  # so many: no matter of load
])
def test_what_is_repeated(tmp_path, capsys, codes, expected):
    write(tmp_path / 'expected.tsv', ''.join(f'{"grading" if name.startswith("grade") else "rostest"}\t{name}\n'
                                             for name in codes))
    write_results(tmp_path, codes)
    assert summary.main(['--to-repeat', str(tmp_path)]) == 0
    assert capsys.readouterr().out == expected


def test_only_what_ran_and_works_against_the_clock_is_repeated(tmp_path):
    write(tmp_path / 'expected.tsv', 'unit\tA.py\nrostest\ta\nrostest\tb\nruff\tcheck\n')
    write_results(tmp_path, {'a': 0})
    write(tmp_path / 'ruff' / 'check' / 'exit_code', '1')
    assert summary.to_repeat(tmp_path) == []


@pytest.mark.parametrize('second, alone, code, last_line', [
    (0, 'passed', 0, '2 passed, 0 failed'),
    (1, 'failed', 1, '1 passed, 2 failed'),
])
def test_the_second_result_counts_and_the_first_is_shown(tmp_path, capsys, second, alone, code, last_line):
    write(tmp_path / 'expected.tsv', 'rostest\ta\nrostest\tb\n')
    write(tmp_path / 'repeated.tsv', 'rostest\ta\n')
    write_results(tmp_path, {'a': second, 'b': 0})
    write_results(tmp_path, {'a': 1}, '{}.beside_others')
    assert summary.main([str(tmp_path)]) == code
    lines = capsys.readouterr().out.splitlines()
    begin = lines.index(f'REPEATED a: failed beside others, {alone} alone')
    assert lines[begin + 1] == f'    the first output: {tmp_path}/rostest/a.beside_others/output.txt'
    assert lines[begin + 2] == '    1 != 2'
    assert lines[-1] == last_line


def test_a_repeated_grading_shows_its_first_output(tmp_path):
    write(tmp_path / 'repeated.tsv', 'grading\tgrade_a\n')
    write_results(tmp_path, {'grade_a': 0})
    write_results(tmp_path, {'grade_a': 124}, '{}.beside_others')
    assert summary.repeated_lines(tmp_path)[2:] == ['    exit code 124, stopped at the time limit',
                                                    '    grade_a said this']


def test_a_check_is_repeated_only_when_it_met_its_time_limit(tmp_path):
    write(tmp_path / 'expected.tsv', 'ruff\tcheck\ncatkin_lint\tlibs/a\nrostest\ta\n')
    write_results(tmp_path, {'a': 0})
    write(tmp_path / 'ruff' / 'check' / 'exit_code', '1')
    write(tmp_path / 'catkin_lint' / 'libs' / 'a' / 'exit_code', '124')
    assert summary.to_repeat(tmp_path) == [('catkin_lint', 'libs/a')]


@pytest.mark.parametrize('alone, code, last_line', [
    (PASSES.replace('"A"', '"unit.test_b"'), 0, '2 passed, 0 failed'),
    (FAILS.replace('"A"', '"unit.test_b"'), 1, '1 passed, 2 failed'),
])
def test_a_file_of_unit_tests_that_failed_beside_others_is_repeated(tmp_path, capsys, alone, code, last_line):
    write(tmp_path / 'expected.tsv', 'unit\tunit/test_a.py\nunit\tunit/test_b.py\n')
    write(tmp_path / 'unit' / 'pytest.xml', '<testsuites>' + PASSES.replace('"A"', '"unit.test_a"') +
          FAILS.replace('"A"', '"unit.test_b.TestB"') + '</testsuites>')
    write(tmp_path / 'unit' / 'pytest' / 'exit_code', '1')
    assert summary.to_repeat(tmp_path) == [('unit', 'unit/test_b.py')]
    write(tmp_path / 'repeated.tsv', 'unit\tunit/test_b.py\n')
    write(tmp_path / 'unit' / 'unit' / 'test_b.py' / 'pytest.xml', alone)
    assert summary.main([str(tmp_path)]) == code
    lines = capsys.readouterr().out.splitlines()
    begin = lines.index(f'REPEATED unit/test_b.py: failed beside others, {"failed" if code else "passed"} alone')
    assert lines[begin + 2] == '    1 != 2'
    assert lines[-1] == last_line
