#!/usr/bin/env python3
"""Attack the nodes of this project for a long time, and report the losses.

`./run stress [SUITE ...]` calls it in the built workspace. The same seed sends the same inputs. Exit code: 0 nothing
was lost and every target was reached, 1 something was lost, missed or could not be tried, 2 usage error, 130
interrupted.
"""

import argparse
import importlib
import os
import random
import resource
import sys
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import measure
import report
from command import exit_code, positive, processes_in_folder, progress
from figures import OURS
from plain_support.processes import KILL
from processes import BenchError
from rostest_support.tcpros import TROUBLE
from session import Measurement, Subject
from trial import Scale

SUITES = {  # minutes that the full form takes, about
    'web': 3.0, 'interrupts': 12.0, 'soak': 60.0}
DEFAULT = [name for name in SUITES if name != 'soak']
MANY_FILES = 16384


def parse(arguments):
    """Return the options and the suites as one; exit with code 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run stress', description=__doc__.splitlines()[0])
    parser.add_argument('suites', nargs='*', metavar='SUITE',
                        help=f'one or more of {", ".join(SUITES)} (default: all but soak)')
    length = parser.add_mutually_exclusive_group()
    length.add_argument('--minutes', type=positive(float), metavar='N',
                        help='approximate length of each suite (default: '
                        + ', '.join(f'{name} {minutes:g}' for name, minutes in SUITES.items()) + ')')
    length.add_argument('--small', action='store_true', help='a little of everything, as in ./run test, without the '
                        'targets that depend on the speed of the machine')
    parser.add_argument('--seed', type=int, default=random.randrange(2 ** 31),
                        help='send the same inputs as the run that printed this seed')
    parser.add_argument('--only', nargs='+', metavar='NAME', help='only these attacks; --list shows their names')
    parser.add_argument('--json', metavar='FILE', help='file for the figures (default: output/stress.json)')
    parser.add_argument('--list', action='store_true', help='list the attacks of the suites and exit')
    options = parser.parse_args(arguments)
    for name in options.suites:
        if name not in SUITES:
            parser.error(f'there is no suite {name!r}; the suites are {", ".join(SUITES)}')
    options.suites = options.suites or DEFAULT
    options.json = options.json or os.path.join(measure.REPOSITORY, 'output', 'stress.json')
    options.suite = ' '.join(options.suites)
    options.rounds, options.times, options.quick, options.peer, options.busy = 1, None, options.small, None, 0
    suite = attacks(options)
    for name in options.only or ():
        if name not in suite.MEASUREMENTS:
            parser.error(f'--only {name}: it must be one of {", ".join(suite.MEASUREMENTS)}')
    return options, suite


def attacks(options):
    """Return the suites as one suite of measurements; in the small form times and rates have no target."""
    found = SimpleNamespace(MEASUREMENTS={}, FIGURES=[], FULL=None, QUICK=None)
    for name in options.suites:
        module = importlib.import_module(f'stress_{name}')
        scale = Scale(options.minutes / SUITES[name] if options.minutes else 1.0, options.small)
        for attack, (run, about) in module.ATTACKS.items():
            found.MEASUREMENTS[attack] = Measurement(partial(_tried, run, scale, f'{options.seed}/{name}/{attack}'),
                                                     f'{name}: {about}')
        found.FIGURES += [replace(figure, required=True,
                                  target=None if options.small and figure.unit else figure.target)
                          for figure in module.FIGURES]
    return found


def _tried(attack, scale, seed, subject, _scale):
    """Return {key: samples} of an attack beside a new master, without registrations of the one before."""
    subject.master.stop(KILL)
    subject.start_master()
    try:
        return attack(subject, scale, random.Random(seed))
    except TROUBLE as error:
        raise BenchError(f'{type(error).__name__}: {error}') from error


def run(options, suite):
    """Run the attacks, print and write the figures; return the exit code."""
    progress(f'Seed: {options.seed}; --seed {options.seed} sends the same inputs.')
    facts = report.machine()
    with processes_in_folder() as folder:
        names = [name for name in suite.MEASUREMENTS if not options.only or name in options.only]
        pools, failures = measure.measure(options, suite, names, [Subject(OURS, ['unused'], folder)])
    return measure.hand_out(options, suite, pools, failures, facts)


def main():
    options, suite = parse(sys.argv[1:])
    if options.list:
        return measure.list_measurements(suite)
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)  # the soft limit, often 1,024, is too low for many clients
    wanted = MANY_FILES if hard == resource.RLIM_INFINITY else min(hard, MANY_FILES)
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    return exit_code('stress', lambda: run(options, suite))


if __name__ == '__main__':
    sys.exit(main())
