#!/usr/bin/env python3
"""Measure the nodes of this project, and optionally a peer, and compare the figures with their targets.

`./run bench [SUITE] [options]` calls it in the built workspace. Rounds of ours and of the peer alternate, so that a
machine that warms up or is disturbed affects both alike. Exit code: 0 measured (missed targets are only shown), 1
something could not be measured, 2 usage error, 130 interrupted.
"""

import argparse
import fnmatch
import importlib
import json
import os
import pathlib
import platform
import re
import shlex
import shutil
import sys
import tempfile
import time
from types import SimpleNamespace

import figures
from figures import OURS, PEER
from plain_support import write_whole
from plain_support.processes import INTERRUPTED, make_interruptible
from processes import BenchError, stop_all
from session import FULL, QUICK, Subject, find_node

FOLDER = pathlib.Path(__file__).resolve().parent
REPOSITORY = FOLDER.parents[1]
sys.path.append(str(REPOSITORY / 'test'))  # photos, scores and drives of unit_support
DEFAULT_SUITE = 'turtlesim'
ROUNDS = 3
ONLY_FOR = {'folder': ('markers', 'programs'), 'times': ('grading',)}


def positive(text):
    """Convert an argument of the command to a whole number above 0."""
    value = int(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f'it is {text}; it must be above 0')
    return value


def progress(text):
    """Print the progress on stderr; stdout is for the table."""
    print(text, file=sys.stderr, flush=True)


def suites():
    """Return the names of the suites: NAME of each file suite_NAME.py."""
    return sorted(path.stem[len('suite_'):] for path in FOLDER.glob('suite_*.py'))


def parse(arguments):
    """Return the options and the module of the suite; exit with code 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run bench', description=__doc__.splitlines()[0])
    parser.add_argument('suite', nargs='?', default=DEFAULT_SUITE, choices=suites(), help='default: %(default)s')
    parser.add_argument('folder', nargs='?',
                        help='folder with files to measure (only for suites that use files)')
    parser.add_argument('--peer', metavar='COMMAND',
                        help='another node to measure in the same run; the table then has ratios')
    parser.add_argument('--only', nargs='+', metavar='NAME', help='only these measurements; --list shows their names; '
                        'a * stands for any text')
    parser.add_argument('--rounds', type=positive,
                        help=f'rounds of each measurement (default: {ROUNDS}; with --quick: 1)')
    parser.add_argument('--quick', action='store_true',
                        help='short measurements with few samples, to see whether everything works')
    parser.add_argument('--json', metavar='FILE', help='file for the figures (default: output/bench.json)')
    parser.add_argument('--list', action='store_true', help='list the measurements of the suite and exit')
    gradings = parser.add_argument_group('only for the suite grading')
    gradings.add_argument('--times', type=positive, metavar='N',
                          help='how often each program is graded, or how many are')
    options = parser.parse_args(arguments)
    suite = importlib.import_module(f'suite_{options.suite}')
    for name in options.only or ():
        if not fnmatch.filter(suite.MEASUREMENTS, name):
            parser.error(f'--only {name}: it must be one of {", ".join(suite.MEASUREMENTS)}')
    for name, able in ONLY_FOR.items():
        if getattr(options, name) != parser.get_default(name) and options.suite not in able:
            word = name if name == 'folder' else f'--{name}'
            parser.error(f'{word} is only for ./run bench {" and ".join(able)}')
    if options.peer and not getattr(suite, 'NEEDS_NODE', True):
        parser.error(f'the suite {options.suite} measures no node, so it does not accept --peer')
    try:
        if hasattr(suite, 'use'):
            suite.use(options)
    except BenchError as error:
        parser.error(str(error))
    options.rounds = options.rounds or (1 if options.quick else getattr(suite, 'ROUNDS', ROUNDS))
    name = 'bench' if options.suite == DEFAULT_SUITE else f'bench_{options.suite}'
    options.json = options.json or os.path.join(REPOSITORY, 'output', f'{name}.json')
    return options, suite


def subjects(options, suite, names, folder):
    """Return the nodes under test with running masters: ours, then the peer if there is one. It starts no node."""
    if not getattr(suite, 'NEEDS_NODE', True):
        return [SimpleNamespace(side=OURS)]
    needs_node = any(not suite.MEASUREMENTS[name].in_process for name in names)
    commands = {OURS: find_node(suite.PACKAGE, suite.EXECUTABLE) if needs_node else ['unused']}
    if options.peer:
        try:
            commands[PEER] = shlex.split(options.peer)
        except ValueError as error:
            raise BenchError(f'--peer {options.peer} cannot be read: {error}') from error
    return [Subject(side, command, folder) for side, command in commands.items()]


def measure(options, suite, names, under_test):
    """Run every measurement, its rounds in turns for the subjects; return ({side: {key: samples}}, failures)."""
    pools = {subject.side: {} for subject in under_test}
    failures = []
    scale = options.times or (getattr(suite, 'QUICK', QUICK) if options.quick else getattr(suite, 'FULL', FULL))
    for place, name in enumerate(names, 1):
        measurement = suite.MEASUREMENTS[name]
        progress(f'[{place}/{len(names)}] {name}: {measurement.about}')
        sides = under_test[:1] if measurement.in_process else list(under_test)
        for number in range(1, options.rounds + 1):
            for subject in list(sides):
                progress(f'    round {number} of {options.rounds}, {subject.side}')
                try:
                    samples = measurement.run(subject, scale)
                except BenchError as error:
                    failures.append(f'Not measured: {name} of {subject.side} in round {number}. {error}')
                    progress(f'    FAILED: {error}')
                    sides.remove(subject)
                    continue
                for key, values in samples.items():
                    pools[subject.side].setdefault(key, []).extend(values)
    return pools, failures


def machine():
    """Return the facts of this machine that figures depend on; no names, no paths."""
    with open('/proc/cpuinfo', encoding='utf-8', errors='replace') as file:
        model = re.search(r'^(?:model name|Model|Hardware)\s*:\s*(.*)$', file.read(), re.MULTILINE)
    return {'cores': os.cpu_count(), 'cpu': model[1] if model else 'unknown', 'architecture': platform.machine(),
            'python': platform.python_version(), 'load': round(os.getloadavg()[0], 2)}


def as_json(options, rows, failures, facts):
    """Return the whole run as JSON text; rows without samples are null."""
    shown = [{'name': row.figure.name, 'unit': row.figure.unit, 'ours': row.ours, 'peer': row.peer, 'ratio': row.ratio,
              'target': row.figure.target and str(row.figure.target), 'ok': row.ok} for row in rows]
    return json.dumps({'suite': options.suite, 'when': time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime()),
                       'machine': facts, 'rounds': options.rounds, 'quick': options.quick, 'peer': bool(options.peer),
                       'figures': shown, 'failures': failures}, indent=2) + '\n'


def run(options, suite):
    """Measure, print the table and write the figures; return the exit code."""
    facts = machine()
    names = [name for name in suite.MEASUREMENTS
             if not options.only or any(fnmatch.fnmatchcase(name, pattern) for pattern in options.only)]
    folder = tempfile.mkdtemp(prefix='turtle_robotont_bench_')
    try:
        pools, failures = measure(options, suite, names, subjects(options, suite, names, folder))
    finally:
        stop_all()
        shutil.rmtree(folder, ignore_errors=True)
    rows = [figures.judge(figure, pools) for figure in suite.FIGURES]
    if hasattr(suite, 'preface'):
        print(suite.preface(pools))
    print(figures.table(rows), figures.verdict([row for row in rows if row.ours is not None]), *failures, sep='\n')
    try:
        os.makedirs(os.path.dirname(os.path.abspath(options.json)), exist_ok=True)
        write_whole(options.json, as_json(options, rows, failures, facts))
    except OSError as error:
        raise BenchError(f'The figures cannot be written: {error}. Choose another file with --json FILE.') from error
    progress(f'Figures: {options.json}')
    return 1 if failures else 0


def main():
    options, suite = parse(sys.argv[1:])
    if options.list:
        for name, measurement in suite.MEASUREMENTS.items():
            print(f'{name:<12} {measurement.about}')
        return 0
    make_interruptible()
    try:
        return run(options, suite)
    except BenchError as error:
        progress(f'bench: {error}')
        return 1
    except KeyboardInterrupt:
        progress('bench: interrupted; all its processes have ended')
        return INTERRUPTED


if __name__ == '__main__':
    sys.exit(main())
