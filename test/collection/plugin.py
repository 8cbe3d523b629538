"""The hooks of pytest: options, kinds, timeouts, skipped tests, and the end of left-over processes."""
import gc
import os
import re
import shutil
import tempfile
import time
from importlib import util
from pathlib import Path

import pytest

from collection import kinds, programs, ros, rostests

NO_MODULE = re.compile(r'((?:ModuleNotFoundError|ImportError): [^\n]*)')  # also in the quoted output of a program
NIGHTLY = re.compile(r'(?<!not )\bnightly\b')  # in the expression of -m
TIME_LIMIT = 300  # [s] for a test that has no mark with another one


def pytest_addoption(parser):
    """Add the options of ./run test."""
    group = parser.getgroup('turtle_robotont')
    group.addoption('--all', action='store_true', help='also the nightly tests')
    group.addoption('--results', metavar='FOLDER', help='keep the output of rostests, gradings, ... here')


def pytest_configure(config):
    """Leave out the nightly tests, mark the processes of all tests, and choose the folder of the outputs."""
    if not config.getoption('numprocesses', None):  # mark the workers of xdist, not their controller
        os.environ[programs.TESTS] = str(os.getpid())
    if ros.run_workspace():
        os.environ.setdefault('ws', str(ros.run_workspace()))
    config.results = Path(config.getoption('results') or tempfile.mkdtemp(prefix='turtle_robotont_tests_')).absolute()
    config.results.mkdir(parents=True, exist_ok=True)
    config.case_folder = lambda item: config.results / kinds.name_of(item)
    if ros.workspace_packages() and 'PYTEST_XDIST_WORKER' not in os.environ:
        ros.answer_rosversion(config.results / 'bin')
    if not config.getoption('all') and not NIGHTLY.search(config.option.markexpr):
        _leave_out_nightly(config)
    os.environ[programs.CASE] = f'{config.results}/'  # of units; each program has a folder of its own


def _leave_out_nightly(config):
    asked = config.option.markexpr
    config.option.markexpr = f'({asked}) and not nightly' if asked else 'not nightly'
    os.environ[rostests.CHANGE] = '1'
    if util.find_spec('hypothesis'):
        import hypothesis
        hypothesis.settings.load_profile('change')


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """End left-over processes; remove outputs in a temporary folder, unless a test failed."""
    programs.end_leftovers(programs.TESTS, os.getpid())
    if not session.config.getoption('results') and not session.testsfailed:
        shutil.rmtree(session.config.results, ignore_errors=True)


def pytest_collect_file(file_path, parent):
    """Collect .test files."""
    return rostests.RostestFile.from_parent(parent, path=file_path) if file_path.suffix == '.test' else None


def pytest_itemcollected(item):
    """Mark an item with its kind and time limit, and let -k find its name."""
    item.extra_keyword_matches.add(kinds.name_of(item))
    if item.path.suffix == '.py' and kinds.real(item.path).parent != kinds.CASES:
        item.add_marker('unit')
    if not item.get_closest_marker('timeout'):
        item.add_marker(pytest.mark.timeout(TIME_LIMIT))


def pytest_collection_finish():
    """Keep the collected tests out of garbage collection, which took a tenth of the processor time of the units."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)


@pytest.hookimpl(hookwrapper=True)
def pytest_make_collect_report(collector):
    """Skip a module that needs ROS or a Python package that is not installed."""
    outcome = yield
    _skip_without_ros(outcome.get_result(), collector)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item):
    """Skip a test that imports a missing module while it runs."""
    outcome = yield
    _skip_without_ros(outcome.get_result(), item)


def _skip_without_ros(report, node):
    """Make a failed import a skip if no workspace is sourced."""
    found = NO_MODULE.search(str(report.longrepr)) if report.failed and not ros.workspace_packages() else None
    if found:
        reason = f'Skipped: needs a sourced workspace: {found.group(1)}'
        report.outcome, report.longrepr = 'skipped', (str(node.path), 0, reason)


def pytest_runtest_setup(item):
    """Skip tests that cannot run here."""
    computes = item.get_closest_marker('unit') or item.get_closest_marker('check')  # the others start nodes
    reason = ros.missing(kinds.real(item.path), needs_ros=not computes)
    if reason:
        pytest.skip(reason)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """Add what a test took to the file times.tsv of the results: processor time and time [s], name."""
    processor, begin = _processor_time(), time.monotonic()
    yield
    used = _processor_time() - processor + getattr(item, 'processor_time', 0)
    with open(item.config.results / 'times.tsv', 'a', encoding='utf-8') as file:
        file.write(f'{used:.2f}\t{time.monotonic() - begin:.2f}\t{item.nodeid}\n')


def _processor_time():
    """Return the processor time [s] of this process and of those that it has started and that have ended."""
    return sum(os.times()[:4])


@pytest.fixture
def run_case(case_folder):
    """Return a function that runs the program of this test, and fails with the end of its output."""
    def run(*command):
        code, output = programs.run(command, case_folder)
        if code:
            pytest.fail(f'exit code {code}\n{programs.last_lines(output)}\nThe output: {case_folder}/output.txt',
                        pytrace=False)
    return run


@pytest.fixture
def case_folder(request):
    """Return the folder for the files of this test."""
    return request.config.case_folder(request.node)


def pytest_terminal_summary(terminalreporter):
    """Say which methods of rostests were skipped, and why."""
    for report in terminalreporter.getreports('passed') + terminalreporter.getreports('failed'):
        for outcome, method in report.user_properties:
            if outcome == 'skipped':
                terminalreporter.write_line(f'SKIPPED {method}')
