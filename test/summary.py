"""Sums up the results of ./run test: failures with their messages, then one closing line with the counts.

usage: summary.py RESULTS
       summary.py --to-repeat RESULTS      prints `KIND<TAB>NAME` of what is to be run again, alone

RESULTS is the folder that run_tests.bash fills:
  expected.tsv              one `KIND<TAB>NAME` a line: what had to run
  unit/pytest.xml           JUnit XML of all cases of kind `unit`, and exit_code and output.txt in unit/pytest/
  unit/FILE/pytest.xml      JUnit XML of one file of them, run again alone
  rostest/NAME/xml/...      rostest's XML, and exit_code and output.txt beside the folder xml
  KIND/NAME/exit_code       of the other kinds; each is one case, passed when the exit code is 0
  repeated.tsv              what --to-repeat printed: what was run again, alone; the second result counts
  KIND/NAME.beside_others   the first results of these, but those of kind `unit`

Exit code 0 only when at least one case passed and none failed. A test that left no result has failed.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections import namedtuple
from pathlib import Path

PASSED, FAILED, SKIPPED = 'passed', 'failed', 'skipped'
REPEATED_KINDS = ('page', 'rostest', 'grading', 'stress', 'unit')  # their processes work against the clock
MOST_REPEATED = 10  # when more have failed, that is no matter of a loaded machine
TIMEOUT_CODES = (124, 137)  # of timeout(1): the limit was reached, and so it was with SIGKILL
LAST_LINES = 25
UNITTEST_FRAME = re.compile(r'^  File "[^"\n]*/unittest/[^"\n]*".*\n(?:    .*\n)*', re.MULTILINE)

Case = namedtuple('Case', 'name outcome message')


def read_junit(path, prefix=''):
    """List of the cases in a JUnit XML file; a file that cannot be read is one failed case.

    rosunit counts a failed subTest or setUpClass only in the attributes of the suite, so what these count beyond the
    cases that carry a message is one failed case more.
    """
    try:
        root = ElementTree.parse(str(path)).getroot()
    except (OSError, ElementTree.ParseError) as error:
        return [Case(prefix + path.name, FAILED, f'unreadable result file {path}: {error}')]
    cases = []
    for suite in root.iter('testsuite'):
        found = [_read_case(element, prefix) for element in suite.findall('testcase')]
        counted = sum(int(suite.get(key) or 0) for key in ('failures', 'errors'))
        unnamed = counted - sum(len(element.findall('failure') + element.findall('error'))
                                for element in suite.iter('testcase'))
        cases += found
        if unnamed > 0:
            text = f'{unnamed} failures without a case of their own (a subTest or setUpClass); see {path}'
            cases.append(Case(prefix + (suite.get('name') or path.name), FAILED, text))
    return cases


def _read_case(element, prefix):
    name = '::'.join(part for part in (element.get('classname'), element.get('name')) if part)
    problems = element.findall('failure') + element.findall('error')
    skips = element.findall('skipped')
    outcome = FAILED if problems else SKIPPED if skips else PASSED
    texts = [_without_unittest((found.text or found.get('message') or '').strip()) for found in problems]
    texts += [found.get('message') or (found.text or '').strip() for found in skips]
    return Case(prefix + name, outcome, '\n'.join(texts))


def _without_unittest(text):
    """The text without the lines of a traceback that lie in Python's own unittest."""
    return UNITTEST_FRAME.sub('', text + '\n').rstrip()


def unit_cases(results, names):
    """Cases of pytest; failed ones are added for files that gave no case.

    names: the test files, relative to the repository, that had to run.
    """
    report = results / 'unit' / 'pytest.xml'
    if not report.is_file():
        text = f'pytest left no results in {report}\n{_last_lines(results / "unit" / "pytest")}'
        return [Case('pytest', FAILED, text)]
    cases = read_junit(report)
    for kind, name in _listed(results / 'repeated.tsv'):
        if kind == 'unit':
            cases = [case for case in cases if not _is_of_file(case, name)] + _cases_of(results, kind, name)
    missing = [name for name in names if not any(_is_of_file(case, name) for case in cases)]
    return cases + [Case(name, FAILED, 'no case of this file ran') for name in missing]


def _is_of_file(case, name):
    module = name[:-len('.py')].replace('/', '.')
    return case.name == module or case.name.startswith((module + '::', module + '.'))


def rostest_cases(results, name):
    """Cases of one .test file; it has failed when it left no result, ran no case or ended with an exit code.

    rostest writes one case for each <test> into rostest-*.xml (did it run?) and each <test> its own cases into another
    file. The former count only when they failed.
    """
    folder = results / 'rostest' / name
    prefix = f'{name}: '
    cases, ran = [], []
    for path in sorted(folder.glob('xml/**/*.xml')):
        if path.name.startswith('rostest-'):
            ran += [case for case in read_junit(path, prefix) if case.outcome == FAILED]
        else:
            found = read_junit(path, prefix)
            cases += found or [Case(prefix + path.name, FAILED, 'ran no test')]
    cases += ran
    code = _exit_code(folder)
    if not cases:
        cases = [Case(name, FAILED, f'left no results ({_describe(code)})\n{_last_lines(folder)}')]
    elif code != 0 and not any(case.outcome == FAILED for case in cases):
        cases.append(Case(name, FAILED, f'{_describe(code)}\n{_last_lines(folder)}'))
    return cases


def check_case(results, kind, name):
    """The one case of a kind that only leaves an exit code."""
    folder = results / kind / name
    code = _exit_code(folder)
    if code == 0:
        return Case(f'{kind} {name}', PASSED, '')
    return Case(f'{kind} {name}', FAILED, f'{_describe(code)}\n{_last_lines(folder)}')


def _exit_code(folder):
    try:
        return int((folder / 'exit_code').read_text())
    except (OSError, ValueError):
        return None


def _describe(code):
    if code is None:
        return 'did not run to its end'
    return f'exit code {code}' + (', stopped at the time limit' if code in TIMEOUT_CODES else '')


def _last_lines(folder):
    try:
        lines = (folder / 'output.txt').read_text(errors='replace').splitlines()
    except OSError:
        return ''
    return '\n'.join(lines[-LAST_LINES:])


def collect(results):
    """All cases of the folder `results`, in the order of expected.tsv."""
    expected = _listed(results / 'expected.tsv')
    units = [name for kind, name in expected if kind == 'unit']
    cases = unit_cases(results, units) if units else []
    for kind, name in expected:
        if kind != 'unit':
            cases += _cases_of(results, kind, name)
    return cases


def _listed(path):
    """The (kind, name) of a file's `KIND<TAB>NAME` lines; none where there is no file."""
    return [tuple(line.split('\t')) for line in path.read_text().splitlines()] if path.is_file() else []


def _cases_of(results, kind, name):
    if kind == 'unit':
        return read_junit(results / 'unit' / name / 'pytest.xml')
    return rostest_cases(results, name) if kind == 'rostest' else [check_case(results, kind, name)]


def _first_cases(results, kind, name):
    """The cases of what was run beside others."""
    if kind == 'unit':
        return [case for case in read_junit(results / 'unit' / 'pytest.xml') if _is_of_file(case, name)]
    again = (kind, name) in _listed(results / 'repeated.tsv')
    return _cases_of(results, kind, f'{name}.beside_others' if again else name)


def _may_pass_alone(results, kind, name):
    """Whether this worked against the clock; what met its time limit did, whatever its kind."""
    code = _exit_code(results / kind / ('pytest' if kind == 'unit' else name))
    return code is not None and (kind in REPEATED_KINDS or code in TIMEOUT_CODES)


def to_repeat(results):
    """The (kind, name) of what failed beside others and is to be run again alone; none when that can be no help."""
    ran = _listed(results / 'expected.tsv')
    failed = [(kind, name) for kind, name in ran
              if _may_pass_alone(results, kind, name) and
              any(case.outcome == FAILED for case in _first_cases(results, kind, name))]
    return failed if len(ran) > 1 and len(failed) <= MOST_REPEATED else []


def repeated_lines(results):
    """What was run again, how that ended, and what the first run said."""
    lines = []
    for kind, name in _listed(results / 'repeated.tsv'):
        first = 'pytest' if kind == 'unit' else f'{name}.beside_others'
        failed = any(case.outcome == FAILED for case in _cases_of(results, kind, name))
        lines += [f'REPEATED {name}: failed beside others, {"failed" if failed else "passed"} alone',
                  f'    the first output: {results / kind / first / "output.txt"}']
        for case in _first_cases(results, kind, name):
            if case.outcome == FAILED:
                lines += [f'    {line}' for line in case.message.splitlines()]
    return lines


def closing_line(cases):
    """`N passed, N failed`, and `, N skipped` where some were."""
    count = {outcome: sum(case.outcome == outcome for case in cases) for outcome in (PASSED, FAILED, SKIPPED)}
    line = f'{count[PASSED]} passed, {count[FAILED]} failed'
    return line + (f', {count[SKIPPED]} skipped' if count[SKIPPED] else '')


def report(cases, results):
    """The text to print: repeated, skipped and failed cases with messages, where the details are, the closing line."""
    lines = ['', *repeated_lines(results)]
    lines += [f'SKIPPED {case.name}: {case.message}' for case in cases if case.outcome == SKIPPED]
    for case in cases:
        if case.outcome == FAILED:
            lines += [f'FAILED  {case.name}'] + ['    ' + line for line in case.message.splitlines()]
    lines += [f'Details: {results}', closing_line(cases)]
    return '\n'.join(lines)


def main(arguments):
    """Prints the report, or what is to be repeated, and returns the exit code."""
    if len(arguments) == 2 and arguments[0] == '--to-repeat':
        for kind, name in to_repeat(Path(arguments[1])):
            print(f'{kind}\t{name}')
        return 0
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    results = Path(arguments[0])
    cases = collect(results)
    print(report(cases, results), flush=True)
    failed = any(case.outcome == FAILED for case in cases)
    return 0 if cases and not failed and any(case.outcome == PASSED for case in cases) else 1


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
