#!/usr/bin/env python3
"""Measure the nodes of this project, and optionally a peer, and compare the figures with their targets.

`./run bench [SUITE] [options]` calls it in the built workspace. Rounds of ours and of the peer alternate, so that a
machine that warms up or is disturbed affects both alike. Exit code: 0 measured (whatever the targets say), 1 something
could not be measured, 2 usage error, 130 interrupted.
"""

import argparse
import fnmatch
import glob
import importlib
import json
import os
import re
import shutil
import sys
import tempfile
from contextlib import ExitStack
from types import SimpleNamespace

import report
from figures import OURS, PEER, judge
from plain_support import write_whole
from plain_support.processes import INTERRUPTED, make_interruptible
from processes import BenchError, Child, stop_all
from session import Subject, find_node, split_command

REPOSITORY = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDERS = sorted(glob.glob(os.path.join(REPOSITORY, '*', 'bench')))  # each beside the code that it measures
sys.path += FOLDERS
DEFAULT_SUITE = 'turtlesim'
ROUNDS = 3
BUSY_LOOP = [sys.executable, '-c', 'while True: pass']


def suites():
    """Return the names of the suites: NAME of each file suite_NAME.py in FOLDERS."""
    files = [name for folder in FOLDERS for name in os.listdir(folder)]
    return sorted(found.group(1) for found in map(re.compile(r'suite_(\w+)\.py').fullmatch, files) if found)


def default_json(suite):
    """Return the path of a suite's JSON, in output/ of the repository."""
    name = 'bench.json' if suite == DEFAULT_SUITE else f'bench_{suite}.json'
    return os.path.join(REPOSITORY, 'output', name)


def positive(text):
    """Return an integer of at least 1, for argparse."""
    value = int(text)
    if value < 1:
        raise ValueError(text)
    return value


def parse(arguments):
    """Return the options and the module of the suite; exit with code 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run bench', description=__doc__.splitlines()[0])
    parser.add_argument('suite', nargs='?', default=DEFAULT_SUITE, choices=suites(), help='default: %(default)s')
    parser.add_argument('folder', nargs='?',
                        help='folder with files to measure (only for suites that use files), or a bag of images')
    parser.add_argument('--peer', metavar='COMMAND',
                        help='another node to measure in the same run; the table then has ratios')
    parser.add_argument('--node', metavar='COMMAND', help="measure this node instead of that in the workspace")
    parser.add_argument('--only', nargs='+', metavar='NAME', help='only these measurements; --list shows their names; '
                        'a * stands for any text')
    parser.add_argument('--rounds', type=positive, default=None,
                        help=f'rounds of each measurement (default: {ROUNDS}; with --quick: 1)')
    parser.add_argument('--quick', action='store_true',
                        help='short measurements with few samples, to see whether everything works')
    parser.add_argument('--times', type=positive, default=None, metavar='N',
                        help='only for the suites grading and hints: how often each program is graded, or how many are')
    parser.add_argument('--busy', type=positive, default=0, metavar='N', help='measure beside N busy loops')
    parser.add_argument('--json', metavar='FILE', help='file for the figures (default: output/bench.json)')
    parser.add_argument('--sensitivity', action='store_true',
                        help='only for the suite markers: show what -10 %% and +10 %% of each threshold change')
    parser.add_argument('--half', choices=('development', 'test'), default='development',
                        help='only for the suite markers: photos by class, of this half (default: %(default)s)')
    parser.add_argument('--peers', action='store_true', help='only for the suite markers: score detectors from PyPI, '
                        'too, on the photos by class; they are installed for this measurement only')
    parser.add_argument('--none', action='store_true', help='only for the suite markers: count what is found in the '
                        'images of the folder and its subfolders, in which there is no marker')
    parser.add_argument('--list', action='store_true', help='list the measurements of the suite and exit')
    options = parser.parse_args(arguments)
    suite = importlib.import_module(f'suite_{options.suite}')
    for name in options.only or ():
        if not fnmatch.filter(suite.MEASUREMENTS, name):
            parser.error(f'--only {name}: it must be one of {", ".join(suite.MEASUREMENTS)}')
    _use_classes(parser, options, suite)
    options.bag = options.folder if (options.folder or '').endswith('.bag') and hasattr(suite, 'of_bag') else None
    if options.none and not (options.folder and hasattr(suite, 'of_none')):
        parser.error('--none needs the suite markers and a folder of images: ./run bench markers FOLDER --none')
    if options.folder and not options.bag and not options.none:
        if not hasattr(suite, 'use_folder'):
            parser.error(f'{options.folder}: the suite {options.suite} takes no folder')
        try:
            suite.use_folder(options.folder)
        except BenchError as error:
            parser.error(str(error))
    if (options.peer or options.node) and not getattr(suite, 'NEEDS_NODE', True):
        parser.error(f'the suite {options.suite} measures no node, so it does not accept --peer and --node')
    if options.times and not isinstance(suite.QUICK, int):
        parser.error(f'--times: the suite {options.suite} repeats nothing that often; use the suites grading and hints')
    if options.sensitivity and not hasattr(suite, 'sensitivity'):
        parser.error(f'--sensitivity: the suite {options.suite} has no thresholds; use the suite markers')
    options.rounds = options.rounds or (1 if options.quick else getattr(suite, 'ROUNDS', ROUNDS))
    about = f'{options.suite}_sensitivity' if options.sensitivity else options.suite
    options.json = options.json or default_json(about)
    return options, suite


def _use_classes(parser, options, suite):
    if hasattr(suite, 'use_classes'):
        suite.use_classes(options.half, options.peers)
    elif options.peers or options.half != 'development':
        parser.error(f'--half and --peers: the suite {options.suite} has no photos by class; use the suite markers')


def subjects(options, suite, names, folder):
    """Return the nodes under test with running masters: ours, then the peer if there is one. It starts no node."""
    if not getattr(suite, 'NEEDS_NODE', True):
        return [SimpleNamespace(side=OURS)]
    needs_node = any(not suite.MEASUREMENTS[name].in_process for name in names)
    commands = {}
    if options.node:
        commands[OURS] = split_command(options.node)
    else:
        commands[OURS] = find_node(suite.PACKAGE, suite.EXECUTABLE) if needs_node else ['unused']
    if options.peer:
        commands[PEER] = split_command(options.peer)
    return [Subject(side, command, folder) for side, command in commands.items()]


def measure(options, suite, names, under_test):
    """Run every measurement, its rounds in turns for the subjects; return ({side: {key: samples}}, failures)."""
    pools = {subject.side: {} for subject in under_test}
    failures = []
    scale = options.times or (suite.QUICK if options.quick else suite.FULL)
    for place, name in enumerate(names, 1):
        measurement = suite.MEASUREMENTS[name]
        report_progress(f'[{place}/{len(names)}] {name}: {measurement.about}')
        sides = under_test[:1] if measurement.in_process else list(under_test)
        for number in range(1, options.rounds + 1):
            for subject in list(sides):
                report_progress(f'    round {number} of {options.rounds}, {subject.side}')
                try:
                    samples = measurement.run(subject, scale)
                except BenchError as error:
                    failures.append((name, subject.side, number, str(error)))
                    report_progress(f'    FAILED: {error}')
                    sides.remove(subject)
                    continue
                for key, values in samples.items():
                    pools[subject.side].setdefault(key, []).extend(values)
    return pools, failures


def report_progress(text):
    """Print the progress on stderr; stdout is for the table."""
    print(text, file=sys.stderr, flush=True)


def hand_out(options, suite, pools, failures, facts):
    """Print the table and write the JSON."""
    rows = [judge(figure, pools) for figure in suite.FIGURES]
    if hasattr(suite, 'preface'):
        print(suite.preface(pools))
    print(report.table(rows))
    print(report.verdict([row for row in rows if row.ours is not None]))
    for name, side, number, text in failures:
        rest = f'its figures are of {number - 1} of {options.rounds} rounds' if number > 1 else 'it has no figures'
        print(f'Not measured: {name} of {side} in round {number} ({rest}). {text}')
    settings = {'rounds': options.rounds, 'quick': options.quick, 'peer': bool(options.peer), 'busy': options.busy}
    facts = {**facts, 'load_after': round(os.getloadavg()[0], 2)}
    told = [{'measurement': name, 'side': side, 'round': number, 'error': text.splitlines()[0]}
            for name, side, number, text in failures]
    write_figures(options.json, report.as_json(options.suite, rows, told, settings, facts))


def write_figures(path, text):
    """Write the JSON of a run; raise BenchError if that is impossible."""
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        raise BenchError(f'The figures cannot be written: {error}. Choose another file with --json FILE.') from error
    report_progress(f'Figures: {path}')


def run_sensitivity(options, suite):
    """Print and write as JSON what other thresholds would change; return the exit code."""
    text, figures = suite.sensitivity(report_progress)
    print(text)
    write_figures(options.json, json.dumps(figures, indent=1))
    return 0


def run(options, suite):
    """Measure, print and write the figures; return the exit code."""
    facts = report.machine()
    names = [name for name in suite.MEASUREMENTS
             if not options.only or any(fnmatch.fnmatchcase(name, pattern) for pattern in options.only)]
    with ExitStack() as stack:
        folder = tempfile.mkdtemp(prefix='turtle_robotont_bench_')
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        stack.callback(stop_all)
        for number in range(options.busy):
            stack.enter_context(Child(f'busy loop {number}', BUSY_LOOP, dict(os.environ), folder))
        pools, failures = measure(options, suite, names, subjects(options, suite, names, folder))
    hand_out(options, suite, pools, failures, facts)
    return 1 if failures else 0


def main():
    options, suite = parse(sys.argv[1:])
    if options.list:
        for name, measurement in suite.MEASUREMENTS.items():
            print(f'{name:<12} {measurement.about}')
        return 0
    make_interruptible()
    try:
        if options.bag:
            print(suite.of_bag(options.bag))
            return 0
        if options.none:
            print(suite.of_none(options.folder))
            return 0
        return run_sensitivity(options, suite) if options.sensitivity else run(options, suite)
    except BenchError as error:
        report_progress(f'bench: {error}')
        return 1
    except KeyboardInterrupt:
        report_progress('bench: interrupted; all its processes have ended')
        return INTERRUPTED


if __name__ == '__main__':
    sys.exit(main())
