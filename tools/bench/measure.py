#!/usr/bin/env python3
"""Measure the nodes of this project, and optionally a peer, and compare the figures with their targets.

`./run bench [SUITE] [options]` calls it in the built workspace. Rounds of ours and of the peer alternate, so that a
machine that warms up or is disturbed affects both alike. Exit code: 0 measured (missed targets are only shown), 1
something could not be measured, 2 usage error, 130 interrupted.
"""

import argparse
import fnmatch
import importlib
import os
import pathlib
import sys
from types import SimpleNamespace

import report
from command import exit_code, positive, processes_in_folder, progress, write_figures
from figures import OURS, PEER, judge
from processes import BenchError, Child
from session import Subject, find_node, split_command

FOLDER = pathlib.Path(__file__).resolve().parent
REPOSITORY = FOLDER.parents[1]
sys.path.append(str(REPOSITORY / 'test'))  # photos, scores and drives of unit_support
DEFAULT_SUITE = 'turtlesim'
ROUNDS = 3
ONLY_FOR = {'folder': ('markers', 'programs'), 'times': ('grading',), 'none': ('markers',)}
BUSY_LOOP = [sys.executable, '-c', 'while True: pass']


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
    parser.add_argument('--rounds', type=positive(int),
                        help=f'rounds of each measurement (default: {ROUNDS}; with --quick: 1)')
    parser.add_argument('--quick', action='store_true',
                        help='short measurements with few samples, to see whether everything works')
    parser.add_argument('--busy', type=positive(int), default=0, metavar='N', help='measure beside N busy loops')
    parser.add_argument('--json', metavar='FILE', help='file for the figures (default: output/bench.json)')
    parser.add_argument('--list', action='store_true', help='list the measurements of the suite and exit')
    gradings = parser.add_argument_group('only for the suite grading')
    gradings.add_argument('--times', type=positive(int), metavar='N',
                          help='how often each program is graded, or how many are')
    markers = parser.add_argument_group('only for the suite markers')
    markers.add_argument('--none', action='store_true', help='count what is found in the images of the folder and its '
                         'subfolders, in which there is no marker')
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
        commands[PEER] = split_command(options.peer)
    return [Subject(side, command, folder) for side, command in commands.items()]


def measure(options, suite, names, under_test):
    """Run every measurement, its rounds in turns for the subjects; return ({side: {key: samples}}, failures)."""
    pools = {subject.side: {} for subject in under_test}
    failures = []
    scale = options.times or (suite.QUICK if options.quick else suite.FULL)
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
                    failures.append((name, subject.side, number, str(error)))
                    progress(f'    FAILED: {error}')
                    sides.remove(subject)
                    continue
                for key, values in samples.items():
                    pools[subject.side].setdefault(key, []).extend(values)
    return pools, failures


def hand_out(options, suite, pools, failures, facts):
    """Print the table and write the JSON; return the exit code."""
    rows = [judge(figure, pools) for figure in suite.FIGURES]
    if hasattr(suite, 'preface'):
        print(suite.preface(pools))
    print(report.table(rows))
    print(report.verdict([row for row in rows if row.ours is not None]))
    for name, side, number, text in failures:
        rest = f'its figures are of {number - 1} of {options.rounds} rounds' if number > 1 else 'it has no figures'
        print(f'Not measured: {name} of {side} in round {number} ({rest}). {text}')
    settings = {'rounds': options.rounds, 'quick': options.quick, 'peer': bool(options.peer), 'busy': options.busy,
                **({'seed': options.seed} if hasattr(options, 'seed') else {})}
    facts = {**facts, 'load_after': round(os.getloadavg()[0], 2)}
    told = [{'measurement': name, 'side': side, 'round': number, 'error': text.splitlines()[0]}
            for name, side, number, text in failures]
    write_figures(options.json, report.as_json(options.suite, rows, told, settings, facts))
    return 1 if failures else 0


def list_measurements(suite):
    """Print the names of the measurements; return the exit code."""
    for name, measurement in suite.MEASUREMENTS.items():
        print(f'{name:<12} {measurement.about}')
    return 0


def run(options, suite):
    """Measure, print and write the figures; return the exit code."""
    facts = report.machine()
    names = [name for name in suite.MEASUREMENTS
             if not options.only or any(fnmatch.fnmatchcase(name, pattern) for pattern in options.only)]
    with processes_in_folder() as folder:
        for number in range(options.busy):
            Child(f'busy loop {number}', BUSY_LOOP, dict(os.environ), folder)
        pools, failures = measure(options, suite, names, subjects(options, suite, names, folder))
    return hand_out(options, suite, pools, failures, facts)


def main():
    options, suite = parse(sys.argv[1:])
    if options.list:
        return list_measurements(suite)
    return exit_code('bench', lambda: run(options, suite))


if __name__ == '__main__':
    sys.exit(main())
