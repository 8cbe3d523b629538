"""Attack the nodes of this project for a long time, and report the losses.

`./run stress [SUITE ...]` calls it in the built workspace. The same seed sends the same inputs. Exit code: 0 nothing
was lost and every target was reached, 1 something was lost, missed or could not be tried, 2 usage error, 130
interrupted.
"""

import argparse
import dataclasses
import importlib
import random
import resource
import sys
import traceback

import report
from command import exit_code, positive, processes_in_folder, progress, write_figures
from figures import OURS, judge
from processes import BenchError
from rostest_support.tcpros import TROUBLE
from session import Subject
from trial import Scale

SUITES = {  # minutes that the full form takes, about
    'web': 3.0, 'interrupts': 12.0, 'soak': 60.0}
DEFAULT = tuple(name for name in SUITES if name != 'soak')
MANY_FILES = 16384
LARGEST_SEED = 2 ** 31 - 1


def parse(arguments):
    """Return the options; exit with code 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='./run stress', description=__doc__.splitlines()[0])
    parser.add_argument('suites', nargs='*', metavar='SUITE',
                        help=f'one or more of {", ".join(SUITES)} (default: all but soak)')
    parser.add_argument('--minutes', type=positive(float), metavar='N',
                        help='approximate length of each suite (default: '
                        + ', '.join(f'{name} {minutes:g}' for name, minutes in SUITES.items()) + ')')
    parser.add_argument('--small', action='store_true', help='a little of everything, as in ./run test, without the '
                        'targets that depend on the speed of the machine')
    parser.add_argument('--seed', type=int, help='send the same inputs as the run that printed this seed')
    parser.add_argument('--only', nargs='+', metavar='NAME', help='only these attacks; --list shows their names')
    parser.add_argument('--json', metavar='FILE', help='also write the figures to this file')
    parser.add_argument('--list', action='store_true', help='list the attacks of the suites and exit')
    options = parser.parse_args(arguments)
    for name in options.suites:
        if name not in SUITES:
            parser.error(f'there is no suite {name!r}; the suites are {", ".join(SUITES)}')
    if options.small and options.minutes:
        parser.error('--small has a fixed length; leave out --minutes')
    if options.seed is not None and not 0 <= options.seed <= LARGEST_SEED:
        parser.error(f'--seed is {options.seed}; it must be 0 to {LARGEST_SEED}')
    options.suites = options.suites or list(DEFAULT)
    if options.seed is None:
        options.seed = random.SystemRandom().randrange(LARGEST_SEED)
    known = [name for suite in options.suites for name in load(suite).ATTACKS]
    for name in options.only or ():
        if name not in known:
            parser.error(f'--only {name}: it must be one of {", ".join(known)}')
    return options


def load(suite):
    """Return the module of a suite: ATTACKS {name: Attack} and FIGURES."""
    return importlib.import_module(f'stress_{suite}')


def scale_of(options, suite):
    """Return the Scale of a suite."""
    return Scale(1.0 if options.minutes is None else options.minutes / SUITES[suite], options.small)


def _new_master(subject):
    """Start a new master, without parameters and registrations of the attack before."""
    subject.master.kill()
    subject.start_master()


def _place(error):
    """Return the functions in which an error was raised, the outermost last."""
    return ' < '.join(frame.name for frame in reversed(traceback.extract_tb(error.__traceback__)[1:]))


def attack_all(options, subject, pool, failures):
    """Fill {key: samples} and [(suite, attack, text of what could not be tried)]."""
    for suite in options.suites:
        for name, attack in load(suite).ATTACKS.items():
            if options.only and name not in options.only:
                continue
            progress(f'{suite}, {name}: {attack.about}')
            try:
                _new_master(subject)
                found = attack.run(subject, scale_of(options, suite), random.Random(f'{options.seed}/{suite}/{name}'))
            except (BenchError, *TROUBLE) as error:
                failures.append((suite, name, f'{type(error).__name__} in {_place(error)}: {error}'))
                progress(f'    FAILED in {_place(error)}: {error}')
                continue
            for key, values in found.items():
                pool.setdefault(key, []).extend(values)


def figures_of(options):
    """Return the figures of all suites; in the small form times and rates have no target."""
    for suite in options.suites:
        for figure in load(suite).FIGURES:
            yield dataclasses.replace(figure, target=None) if options.small and figure.unit else figure


def hand_out(options, pool, failures, facts):
    """Print the table and what failed, write the JSON; return the exit code."""
    rows = [judge(figure, {OURS: pool}) for figure in figures_of(options)]
    print(report.table(rows))
    print(report.verdict([row for row in rows if row.ours is not None]))
    for suite, name, text in failures:
        print(f'Not tried: {suite}, {name}. {text}')
    print(f'The seed was {options.seed}; --seed {options.seed} sends the same inputs.')
    if options.json:
        settings = {'seed': options.seed, 'small': options.small, 'minutes': options.minutes}
        told = [{'suite': suite, 'attack': name, 'error': text.splitlines()[0]} for suite, name, text in failures]
        write_figures(options.json, report.as_json(' '.join(options.suites), rows, told, settings, facts))
    return 1 if failures or any(row.ok is False for row in rows) else 0


def run(options):
    """Run the attacks, print and write the figures, also when interrupted; return the exit code."""
    facts = report.machine()
    progress(f'Seed: {options.seed}')
    pool, failures = {}, []
    try:
        with processes_in_folder() as folder:
            attack_all(options, Subject(OURS, ['unused'], folder), pool, failures)
    except KeyboardInterrupt:
        hand_out(options, pool, failures, facts)
        raise
    return hand_out(options, pool, failures, facts)


def _allow_many_files():
    """Raise the soft limit of open files, often 1,024, for hundreds of connections and clients."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MANY_FILES if hard == resource.RLIM_INFINITY else min(hard, MANY_FILES)
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def main():
    options = parse(sys.argv[1:])
    if options.list:
        for suite in options.suites:
            for name, attack in load(suite).ATTACKS.items():
                print(f'{suite:<8} {name:<14} {attack.about}')
        return 0
    _allow_many_files()
    return exit_code('stress', lambda: run(options))
