"""Run the tests in the built workspace, as ./run test does: several runs of pytest at once.

The tests that only compute have a run for each processor and one more, as they wait for a fourth of their time. Their
priority is lower than that of the run whose nodes mostly wait. The tools that read the code have another run. With
--all, the run that waits goes first, with fewer tests in parallel: in half an hour at a load of 25, tests wait for a
core beyond their time limits.
"""
import argparse
import os
import signal
import subprocess
import sys
from pathlib import Path

from collection import kinds

MAX_REPEATED = 10  # tests; if more fail, load is not the cause
FEW_FILES = 5  # which run faster in one process
NICE = 10
TESTS_FAILED, NOTHING_COLLECTED = 1, 5  # exit codes of pytest
INTERRUPTED = 130
WAITING = tuple(kind for kind in kinds.TIME_LIMITS if kind not in kinds.COMPUTING)


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
    few = options.names and len(files(options.names)) <= FEW_FILES
    jobs = os.environ.get('TURTLE_ROBOTONT_JOBS') or (1 if options.all else 2) * os.cpu_count() + 1
    if few:
        return {'tests': pytest(options, 'tests', kinds.TIME_LIMITS)}
    # slow ones by size, then the others: shares them well; without xdist, which takes 3 ms for each of 9,000 tests
    tests = sorted((path for path in files(options.names) if kinds.kind_of(path) == 'unit'
                    and not (options.fast and kinds.is_slow(path))),
                   key=lambda path: (kinds.is_slow(path), path.stat().st_size))
    count = os.cpu_count() + (not options.fast)
    shares = [tests[number::count] for number in range(count)]
    runs = {'checks': pytest(options, 'checks', ['check'], kinds.CASES / 'test_check.py'),
            **{f'units_{number}': pytest(options, f'units_{number}', ['unit'], *share)
               for number, share in enumerate(shares) if share}}
    if options.fast:
        return runs
    return {**{name: ['nice', '-n', str(NICE), *command] for name, command in runs.items()},
            'waiting': pytest(options, 'waiting', WAITING, '-v', '-n', jobs, '--dist', 'worksteal')}


def files(names):
    """Return the files of tests that may hold one with a part of its name in ``names``."""
    found = (path for pattern in ('test_*.py', '*.test') for path in kinds.REPOSITORY.rglob(pattern))
    return [path for path in found
            if '/.' not in str(path) and path.parent != kinds.CASES and kinds.may_hold(path, names)]


def pytest(options, name, of_kinds, *more):
    """Return the command of a run of pytest."""
    return [sys.executable, '-m', 'pytest', '-q', '-rs', '--tb=short', f'--kinds={",".join(of_kinds)}',
            f'--results={options.results}', f'--junitxml={options.results / name}.xml', *map(str, more),
            *(['--fast'] if options.fast else []), *(['--all'] if options.all else []),
            *(f'--select={name}' for name in options.names)]


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
    chosen = commands(options)
    options.results.mkdir(parents=True, exist_ok=True)
    try:
        codes = {}
        for names in turns(chosen, options):
            codes.update(finish({name: start(name, chosen[name], options.results, name == list(chosen)[-1])
                                 for name in names}))
        for name in list(chosen)[:-1]:
            if codes[name] != NOTHING_COLLECTED:
                print((options.results / f'{name}.txt').read_text(encoding='utf-8', errors='replace'))
        if repeat(options.results):
            codes = {name: 0 if code == TESTS_FAILED else code for name, code in codes.items()}
    except KeyboardInterrupt:
        return INTERRUPTED
    return tell(codes, options)


def turns(chosen, options):
    """Return the names of the runs that begin together, for each turn."""
    *beside, shown = chosen
    return [[shown], beside] if options.all and beside else [[*beside, shown]]


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


def repeat(results):
    """Run the few tests that failed beside others again, alone, and name them; return whether they pass now."""
    file = results / 'failed'
    failed = sorted(set(file.read_text(encoding='utf-8').splitlines())) if file.exists() else []
    if not 0 < len(failed) <= MAX_REPEATED:
        return False
    print('REPEATED alone, as they failed beside others:', *failed, sep='\n  ', flush=True)
    command = [sys.executable, '-m', 'pytest', '-q', '--tb=short', '--all', f'--results={results / "repeated"}',
               *failed]
    return finish({'repeated': start('repeated', command, results, shown=True)}) == {'repeated': 0}


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
