"""A .test file as a test: rostest runs it with a master of its own, and its methods are the details of the result."""
import re
import xml.etree.ElementTree as ElementTree

import pytest

from collection import kinds, programs, warm

CHANGE = 'TURTLE_ROBOTONT_CHANGE'  # set in the environment: leave out what is nightly
OUTCOMES = 'passed', 'failed', 'skipped'
TIME_LIMIT = 600  # [s] of a file
UNITTEST_FRAME = re.compile(r'^  File "[^"\n]*/unittest/[^"\n]*".*\n(?:    .*\n)*', re.MULTILINE)


class RostestFile(pytest.File):
    """A .test file; it holds one test, which a comment ``<!-- nightly: why -->`` leaves to --all."""

    def collect(self):
        """Return the test."""
        item, text = Rostest.from_parent(self, name=self.path.stem), self.path.read_text(encoding='utf-8')
        item.add_marker('rostest')
        item.add_marker(pytest.mark.timeout(TIME_LIMIT))
        if '<!-- nightly: ' in text:
            item.add_marker('nightly')
        yield item


class Rostest(pytest.Item):
    """The run of a .test file.

    ``processor_time`` [s] is that of rostest and its nodes. ``user_properties`` has an outcome for each method.
    """

    processor_time = 0.

    def runtest(self):
        """Run the file, and raise ProgramFailed unless it leaves results, all of them good."""
        folder = self.config.case_folder(self)
        code, output = programs.run(['rostest', '--results-base-dir', folder / 'xml', self.path], folder,
                                    start=warm.Rostest)
        self.processor_time = warm.processor_time(folder)
        methods, problems = read_results(folder / 'xml')
        self.user_properties += [(outcome, method) for outcome, names in methods.items() for method in names]
        if code or problems or not self.user_properties:
            if not problems:
                problems = [f'exit code {code}', programs.last_lines(output)]
            raise programs.ProgramFailed('\n'.join([*problems, f'The output: {folder}/output.txt']))
        if not methods['passed']:
            pytest.skip('; '.join(methods['skipped']))

    def repr_failure(self, excinfo, style=None):
        """Return the text of a failure; tracebacks of this plugin say nothing about a rostest."""
        if isinstance(excinfo.value, programs.ProgramFailed):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self):
        """Return (file, line, name) for the report."""
        return self.path, None, kinds.name_of(self)


def read_results(folder):
    """Return ({outcome: [method]}, [text of a problem]) of the result files below a folder.

    rostest writes one case for each <test> into rostest-*.xml, which says whether it ran; each <test> writes its own
    file. A failed subTest or setUpClass is only counted in the attributes of its suite.
    """
    methods, problems = {outcome: [] for outcome in OUTCOMES}, []
    for path in sorted(folder.rglob('*.xml')):
        try:
            suites = list(ElementTree.parse(str(path)).getroot().iter('testsuite'))
        except ElementTree.ParseError as error:  # the process was killed while it wrote
            problems.append(f'{path} cannot be read: {error}')
            continue
        cases = [case for suite in suites for case in suite.iter('testcase')]
        wrong = [found for case in cases for found in case.iter() if found.tag in ('failure', 'error')]
        counted = sum(int(suite.get(key) or 0) for suite in suites for key in ('failures', 'errors'))
        problems += [_without_unittest(found.text or found.get('message') or '') for found in wrong]
        if counted > len(wrong):
            problems.append(f'{counted - len(wrong)} failures without a case of their own (a subTest?): {path}')
        if path.name.startswith('rostest-'):
            continue
        if not cases:
            problems.append(f'{path} holds no test')
        for case in cases:
            _sort(case, methods)
    return methods, problems


def _sort(case, methods):
    """Add a case of a result file to the methods with its outcome."""
    skipped = case.find('skipped')
    if skipped is not None:
        methods['skipped'].append(f'{case.get("name")}: {skipped.get("message") or skipped.text}')
    elif case.find('failure') is not None or case.find('error') is not None:
        methods['failed'].append(case.get('name'))
    else:
        methods['passed'].append(case.get('name'))


def _without_unittest(text):
    """Return a traceback without the lines of Python's own unittest."""
    return UNITTEST_FRAME.sub('', text.strip() + '\n').rstrip()
