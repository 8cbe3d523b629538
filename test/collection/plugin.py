"""The hooks of pytest: options, kinds, timeouts, skipped tests, and the end of left-over processes."""
import collections
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


def pytest_addoption(parser):
    """Add the options of ./run test."""
    group = parser.getgroup('turtle_robotont')
    group.addoption('--fast', action='store_true', help='only units that are not slow, lint and types')
    group.addoption('--all', action='store_true', help='also the nightly tests')
    group.addoption('--select', metavar='NAME', action='append', default=[],
                    help='only tests whose KIND/PATH contains NAME')
    group.addoption('--kinds', metavar='KIND,...', help=f'only these kinds: {", ".join(kinds.TIME_LIMITS)}')
    group.addoption('--results', metavar='FOLDER', help='keep the output of rostests, gradings, ... here')


def pytest_configure(config):
    """Mark the processes of all tests, and choose the folder of the outputs."""
    if not config.getoption('numprocesses', None):  # mark the workers of xdist, not their controller
        os.environ[programs.TESTS] = str(os.getpid())
    if ros.run_workspace():
        os.environ.setdefault('ws', str(ros.run_workspace()))
    config.wanted_kinds = _wanted_kinds(config)
    config.results = Path(config.getoption('results') or tempfile.mkdtemp(prefix='turtle_robotont_tests_')).absolute()
    config.results.mkdir(parents=True, exist_ok=True)
    config.case_folder = lambda item: config.results / kinds.name_of(item)
    if ros.workspace_packages() and 'PYTEST_XDIST_WORKER' not in os.environ:
        ros.answer_rosversion(config.results / 'bin')
    if not _wants_nightly(config):
        os.environ[rostests.CHANGE] = '1'
        if util.find_spec('hypothesis'):
            import hypothesis
            hypothesis.settings.load_profile('change')
    os.environ[programs.CASE] = f'{config.results}/'  # of units; each program has a folder of its own


def _wanted_kinds(config):
    if config.getoption('kinds'):
        return config.getoption('kinds').split(',')
    return kinds.FAST if config.getoption('fast') else list(kinds.TIME_LIMITS)


def pytest_unconfigure(config):
    """End left-over processes; remove outputs in a temporary folder, unless a test failed."""
    programs.end_leftovers(programs.TESTS, os.getpid())
    if not config.getoption('results') and not getattr(config, 'has_failed', False):
        shutil.rmtree(config.results, ignore_errors=True)


def pytest_sessionfinish(session):
    """Note whether a test failed."""
    session.config.has_failed = session.testsfailed > 0


def pytest_ignore_collect(collection_path, config):
    """Ignore files without a selected test: importing them takes longest."""
    if collection_path.suffix not in ('.py', '.test') or not collection_path.is_file():
        return None
    path = collection_path
    if path.name.startswith('test_') or path.suffix == '.test':
        if kinds.kind_of(path) not in config.wanted_kinds:
            return True
        if config.getoption('fast') and path.suffix == '.py' and kinds.is_slow(path):
            return True
        return not kinds.may_hold(path, config.getoption('select')) or None
    return None


def pytest_collect_file(file_path, parent):
    """Collect .test files."""
    return rostests.RostestFile.from_parent(parent, path=file_path) if file_path.suffix == '.test' else None


@pytest.hookimpl(hookwrapper=True)
def pytest_make_collect_report(collector):
    """Skip a module that needs ROS or a Python package that is not installed."""
    outcome = yield
    report = outcome.get_result()
    if report.failed and isinstance(collector, pytest.Module):
        reason = _missing_import(str(report.longrepr))
        if reason:
            report.outcome, report.longrepr = 'skipped', (str(collector.path), 0, f'Skipped: {reason}')


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item):
    """Skip a test that imports a missing module while it runs."""
    outcome = yield
    report = outcome.get_result()
    reason = _missing_import(str(report.longrepr)) if report.failed else ''
    if reason:
        report.outcome, report.longrepr = 'skipped', (str(item.path), 0, f'Skipped: {reason}')


def _missing_import(text):
    """Return the name of the missing module of a failed import if no workspace is sourced; else an empty text."""
    found = NO_MODULE.search(text)
    return f'needs a sourced workspace: {found.group(1)}' if found and not ros.workspace_packages() else ''


def pytest_collection_modifyitems(config, items):
    """Mark the items, take the selected ones, and put those first that take longest."""
    names, kept, left = config.getoption('select'), [], []
    cases = collections.Counter()
    for item in items:
        item.kind = kinds.kind_of(item.path)
        item.add_marker(item.kind)
        if item.get_closest_marker('release'):
            item.add_marker('nightly')
        item.add_marker(pytest.mark.timeout(kinds.TIME_LIMITS[item.kind]))
        one_in = item.get_closest_marker('one_in')
        if one_in:
            test = item.path, item.originalname
            if cases[test] % one_in.args[0]:
                item.add_marker('nightly')
            cases[test] += 1
        (kept if _is_wanted(item, names, config) else left).append(item)
    config.hook.pytest_deselected(items=left)
    items[:] = _longest_first(kept)


def pytest_collection_finish():
    """Keep the collected tests out of garbage collection, which took a tenth of the processor time of the units."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)


def _is_wanted(item, names, config):
    if not kinds.is_selected(kinds.name_of(item), names):
        return False
    return _wants_nightly(config) or not item.get_closest_marker('nightly')


def _wants_nightly(config):
    """Return whether the nightly tests are wanted: with --all, by a name, or by their mark."""
    return bool(config.getoption('all') or config.getoption('select')
                or 'nightly' in (config.getoption('markexpr') or ''))


def _longest_first(items):
    """Return the items in the order of their kinds, rostests by their time limits, dealt to the workers of xdist.

    With ``--dist worksteal`` each worker begins with an equal part of the list.
    """
    order = list(reversed(list(kinds.TIME_LIMITS)))
    waiting = [item for item in items if item.kind not in kinds.COMPUTING]
    waiting.sort(key=lambda item: (order.index(item.kind), -getattr(item, 'time_limit', 0)))
    workers = int(os.environ.get('PYTEST_XDIST_WORKER_COUNT', 1))
    dealt = [item for worker in range(workers) for item in waiting[worker::workers]]
    return dealt + [item for item in items if item.kind in kinds.COMPUTING]


def pytest_runtest_setup(item):
    """Skip tests that cannot run here."""
    reason = ros.missing(kinds.real(item.path))
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
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@pytest.fixture
def run_case(request):
    """Return a function that runs the program of this test, and fails with the end of its output."""
    folder = request.config.case_folder(request.node)

    def run(*command, **environment):
        code, output = programs.run(command, folder, environment)
        if code:
            pytest.fail(f'exit code {code}\n{programs.last_lines(output)}\nThe output: {folder}/output.txt',
                        pytrace=False)
        return output
    return run


@pytest.fixture
def case_folder(request):
    """Return the folder for the files of this test."""
    return request.config.case_folder(request.node)


def pytest_terminal_summary(terminalreporter):
    """Say how many methods the rostests ran, and why some were skipped; add the failed tests to the file failed."""
    failed = {report.nodeid for outcome in ('failed', 'error') for report in terminalreporter.getreports(outcome)}
    with open(terminalreporter.config.results / 'failed', 'a', encoding='utf-8') as file:
        file.writelines(f'{name}\n' for name in sorted(failed))
    found = [(name, value) for outcome in ('passed', 'failed', 'skipped')
             for report in terminalreporter.getreports(outcome) if report.when == 'call'
             for name, value in report.user_properties if name in rostests.OUTCOMES]
    if found:
        counts = {outcome: sum(name == outcome for name, _ in found) for outcome in rostests.OUTCOMES}
        terminalreporter.section('methods of rostests')
        for name, value in found:
            if name == 'skipped':
                terminalreporter.write_line(f'SKIPPED {value}')
        terminalreporter.write_line(', '.join(f'{count} {outcome}' for outcome, count in counts.items() if count))
