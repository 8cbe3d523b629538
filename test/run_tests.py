"""Run the tests in the built workspace, as ./run test does: several runs of pytest at once.

The tests that only compute have a run for each processor and one more, as they wait for a fourth of their time. Their
priority is lower than that of the run whose nodes mostly wait. The tools that read the code have another run. With
--all, the run that waits goes first, with fewer tests in parallel: in half an hour at a load of 25, tests wait for a
core beyond their time limits.
"""
import argparse
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from collection import kinds

FEW_FILES = 5  # which run faster in one process
NICE = 10
NOTHING_COLLECTED = 5  # exit code of pytest
INTERRUPTED = 130
SLOW = re.compile(r'^pytestmark = .*pytest\.mark\.slow\b', re.MULTILINE)
TIME_LIMIT = re.compile(r'time-limit="(\d+)"')  # [s]
KEYWORD = re.compile(r'(?!(?:and|or|not)\b)[\w:+\-.\[\]\\/]+')  # what -k takes


def parse(arguments):
    """Return the options; exit with code 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run test', description='Run the tests.', allow_abbrev=False)
    parser.add_argument('names', nargs='*', metavar='NAME', help='only tests whose KIND/PATH contains a NAME')
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument('--fast', action='store_true', help='only units that are not slow, lint and types')
    amount.add_argument('--all', action='store_true', help='also the nightly tests')
    parser.add_argument('--results', type=Path, required=True, help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


def commands(options):
    """Return {name of a run: its command}; the last one is the run that the terminal shows."""
    units, rostests = files('test_*.py', options.names), files('*.test', options.names)
    checks, *others = sorted(kinds.CASES.glob('test_*.py'))
    if options.fast:
        rostests, others = [], []
    rostests.sort(key=lambda path: -sum(map(int, TIME_LIMIT.findall(path.read_text(encoding='utf-8')))))
    if options.names and len(units) + len(rostests) <= FEW_FILES:
        return {'tests': pytest(options, 'tests', checks, *others, *rostests, *units)}
    runs = {'checks': pytest(options, 'checks', checks),
            **{f'units_{number}': pytest(options, f'units_{number}', *share)
               for number, share in enumerate(shares(units, options.fast)) if share}}
    if options.fast:
        return runs
    jobs = os.environ.get('TURTLE_ROBOTONT_JOBS') or (1 if options.all else 2) * os.cpu_count() + 1
    return {**{name: ['nice', '-n', str(NICE), *command] for name, command in runs.items()},
            'waiting': pytest(options, 'waiting', '-v', '-n', jobs, '--maxschedchunk', 1, *others, *rostests)}


def files(pattern, names):
    """Return the files that match a pattern, and may hold a test with a part of its name in ``names``."""
    found = (path for path in kinds.REPOSITORY.rglob(pattern) if '/.' not in str(path) and path.parent != kinds.CASES)
    return [path for path in found if not names or any(may_hold(path, name) for name in names)]


def may_hold(path, name):
    """Return whether ``name`` is a part of the name of a file, holds it, or names a function of it."""
    own, (file, _, function) = kinds.name_of_file(path), name.rpartition('::')
    return (name in own or own in name
            or file in own and f'def {function.partition("[")[0]}' in path.read_text(encoding='utf-8'))


def shares(units, fast):
    """Return the files of each run: slow ones by size, then the others. xdist takes 3 ms for each of 8,000 tests."""
    slow = {path: bool(SLOW.search(path.read_text(encoding='utf-8'))) for path in units}
    order = sorted((path for path in units if not fast or not slow[path]),
                   key=lambda path: (slow[path], path.stat().st_size), reverse=True)
    count = os.cpu_count() + (not fast)
    return [order[number::count] for number in range(count)]


def pytest(options, name, *more):
    """Return the command of a run of pytest."""
    return [sys.executable, '-m', 'pytest', '-q', '-rs', '--tb=short', f'--results={options.results}',
            f'--junitxml={options.results / name}.xml', *(['-m', 'not slow'] if options.fast else []),
            *(['-k', ' or '.join(map(keywords, options.names))] if options.names else []),
            *(['--all'] if options.all or options.names else []), *map(str, more)]


def keywords(name):
    """Return the expression of -k for tests whose names hold a name, which may have characters that -k refuses."""
    return ' and '.join(KEYWORD.findall(name)) or name


def start(name, command, results, shown):
    """Start a run; only one that is shown prints into the terminal.

    The tests start hundreds of nodes: these keep the compiled modules, outside the repository, whatever the shell says.
    """
    environment = {**os.environ, 'PYTHONPYCACHEPREFIX': str(results.parent / 'pycache')}
    environment.pop('PYTHONDONTWRITEBYTECODE', None)
    with open(results / f'{name}.txt', 'wb') as file:
        return subprocess.Popen(command, cwd=kinds.REPOSITORY, stdin=subprocess.DEVNULL, env=environment,
                                stdout=None if shown else file, stderr=None if shown else subprocess.STDOUT)


def main(arguments):
    """Run the tests; return the exit code."""
    options = parse(arguments)
    # Tests send these signals. Under nohup or in the background, all nodes would inherit that they are ignored.
    for number in (signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_DFL)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    runs, codes = commands(options), {}
    *beside, shown = runs
    options.results.mkdir(parents=True, exist_ok=True)
    try:
        for names in [[shown], beside] if options.all else [[*beside, shown]]:
            codes.update(finish({name: start(name, runs[name], options.results, name == shown) for name in names}))
    except KeyboardInterrupt:
        return INTERRUPTED
    for name in beside:
        if codes[name] != NOTHING_COLLECTED:
            print((options.results / f'{name}.txt').read_text(encoding='utf-8', errors='replace'))
    return tell(codes, options)


def finish(runs):
    """Return {name: exit code} once all runs have ended; an interrupt ends them, too."""
    try:
        return {name: process.wait() for name, process in reversed(list(runs.items()))}
    except KeyboardInterrupt:
        for process in runs.values():
            process.send_signal(signal.SIGINT)
        for process in runs.values():
            process.wait()
        raise


def tell(codes, options):
    """Print how the runs ended; return the exit code."""
    if set(codes.values()) == {NOTHING_COLLECTED}:
        print(f'./run test: no test\'s name contains: {" ".join(options.names)}. Names look like '
              'rostest/test/course/lesson_square.test or unit/test/unit/test_docs.py.', file=sys.stderr)
        return 2
    failed = [name for name, code in codes.items() if code not in (0, NOTHING_COLLECTED)]
    print(f'Details: {options.results}')
    print(f'./run test: FAILED ({", ".join(failed)})' if failed else './run test: passed')
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
