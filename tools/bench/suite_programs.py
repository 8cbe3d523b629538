"""The bench of public programs: packages that others wrote run as they are, headless, until their end condition.

programs.yaml lists the repositories, by commit, and for each program what is typed and which condition ends it. None of
their code is in this repository, and nothing of it is built: the programs are Python, launch files and robot models,
and the checkouts of a program are a workspace that overlays ours, as catkin_make would make it. ``./run bench programs
FOLDER`` takes the checkouts in FOLDER (FOLDER/NAME, a name as in the list) and fetches missing ones with git; without
FOLDER they are in output/checkouts. Each program has a ROS master of its own; --quick changes nothing.
"""

import contextlib
import os
import re
import shlex
import subprocess
import tempfile
import time
import uuid
import xmlrpc.client
from pathlib import Path

import yaml

from figures import Figure, Target
from processes import BenchError
from session import Measurement, Subject, answer

NEEDS_NODE = False
ROUNDS = 1
REPOSITORY = Path(__file__).resolve().parents[2]
LIST = yaml.safe_load(Path(__file__).with_name('programs.yaml').read_text(encoding='utf-8'))
HOST = 'https://github.com/'
FETCH_DEADLINE = 600.0  # [s]
WITHIN = 120.0  # [s] of simulated time for a condition, unless the list says otherwise
SLOWEST = 2.0  # [s] of wall time for each second of simulated time
TOPIC_DEADLINE = 180.0  # [s] until a program has what it starts after
POLL = 0.1  # [s]
_folder = [REPOSITORY / 'output' / 'checkouts']


def use(options):
    """Take the checkouts in the folder of the options; raise BenchError if it is none."""
    if options.folder and not os.path.isdir(options.folder):
        raise BenchError(f'{options.folder} is not a folder. Make it: missing checkouts are fetched into it.')
    if options.folder:
        _folder[:] = [Path(options.folder).resolve()]


def checkout(name, folder):
    """Return the path of a repository of the list, at its commit, fetched if it is missing; raise BenchError."""
    path, (source, wanted) = folder / name, LIST['repositories'][name].split()
    if not path.is_dir():
        path.mkdir(parents=True)
        try:
            _git(path, 'init', '--quiet')
            _git(path, 'fetch', '--quiet', '--depth', '1', HOST + source, wanted)
            _git(path, 'checkout', '--quiet', 'FETCH_HEAD')
        except BenchError as error:
            subprocess.run(['rm', '-rf', str(path)], check=True)
            raise BenchError(f'{name} cannot be fetched from {HOST + source}: {error}. Without a network, name a '
                             'folder with the checkouts: ./run bench programs FOLDER') from error
    commit = _git(path, 'rev-parse', 'HEAD')
    if commit != wanted:
        raise BenchError(f'{path} is at commit {commit[:12]}, the list names {wanted[:12]}. Type: '
                         f'git -C {path} checkout {wanted}')
    return path


def _git(path, *arguments):
    try:
        done = subprocess.run(['git', '-C', str(path), *arguments], capture_output=True, text=True, check=True,
                              timeout=FETCH_DEADLINE, env={**os.environ, 'GIT_TERMINAL_PROMPT': '0'})
    except subprocess.CalledProcessError as error:
        raise BenchError((error.stderr.strip().splitlines() or ['git failed'])[-1]) from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(str(error)) from error
    return done.stdout.strip()


def run_program(name):
    """Return the measurement of a program: the time [s] until its end condition; BenchError if that is not met."""
    program = LIST['programs'][name]

    def run(_subject, _scale):
        paths = {repository: checkout(repository, _folder[0]) for repository in program['of']}
        with tempfile.TemporaryDirectory(prefix='turtle_robotont_bench_') as folder, contextlib.ExitStack() as stack:
            subject = Subject(name, ['unused'], folder)
            stack.callback(subject.master.stop)
            # As roscore does: two roslaunch that start at once would choose two, and one of them would end.
            xmlrpc.client.ServerProxy(subject.uri).setParam('/bench', '/run_id', str(uuid.uuid4()))
            environment = {**_overlay(Path(folder, 'devel'), list(map(str, paths.values()))),
                           **program.get('environment', {})}
            children = []
            for command in program['run']:
                children.append(_start(stack, subject, children, command, paths, environment))
            seconds = _await_end(stack, subject, program, children)
        return {name: [seconds], 'ended': [name]}
    return run


def _overlay(devel, paths):
    """Make the devel space of a workspace with packages in these folders; return the variables that add it."""
    devel.mkdir()
    (devel / '.catkin').write_text(';'.join(paths), encoding='utf-8')
    return {name: os.pathsep.join(filter(None, (*first, os.environ.get(name))))
            for name, first in (('CMAKE_PREFIX_PATH', [str(devel)]), ('ROS_PACKAGE_PATH', paths))}


def _start(stack, subject, children, command, paths, environment):
    if isinstance(command, dict):
        _await_topic(subject, command['after'], children)
    words = shlex.split(command['run'] if isinstance(command, dict) else command)
    words = [word.format(**paths) for word in words]
    return stack.enter_context(subject.start(f'{len(children) + 1} {Path(words[0]).name}', words, **environment))


def _await_topic(subject, topic, children):
    deadline = time.monotonic() + TOPIC_DEADLINE
    while time.monotonic() < deadline:
        _, _, published = xmlrpc.client.ServerProxy(subject.uri).getPublishedTopics('/bench', '')
        if topic in (name for name, _ in published):
            return
        time.sleep(POLL)
    raise BenchError('\n'.join([f'nothing was published on {topic} within {TOPIC_DEADLINE:g} s.', *_tails(children)]))


def _tails(children):
    return [f'Last lines of {child.name}:\n{child.tail()}' for child in children]


def _await_end(stack, subject, program, children):
    """Return the time [s] until all conditions of the end hold; raise BenchError with what does not hold."""
    within = program.get('within', WITHIN)
    begun, patience = time.monotonic(), SLOWEST * within
    seconds, missing = 0.0, []
    topics = [condition for condition in program['end'] if 'output' not in condition]
    if topics:
        probe = stack.enter_context(subject.probe('programs_probe', 'watch', conditions=topics, within=within,
                                                  patience=patience))
        told = answer(probe, patience)
        seconds, missing = told['seconds'], told['missing']
    for pattern in [condition['output'] for condition in program['end'] if 'output' in condition]:
        while not any(re.search(pattern, child.output()) for child in children):
            if time.monotonic() - begun > patience:
                missing.append(f'no program printed {pattern!r}')
                break
            time.sleep(POLL)
        else:
            seconds = max(seconds, time.monotonic() - begun if not topics else 0.0)
    if missing:
        raise BenchError('\n'.join([f'Its end condition was not met within {within:g} s:', *missing,
                                    *_tails(children)]))
    return seconds


def different(names):
    return len(set(names))


MEASUREMENTS = {name: Measurement(run_program(name), program['about']) for name, program in LIST['programs'].items()}
FIGURES = (*(Figure(f'{name}: {program["about"]}', name, 's') for name, program in LIST['programs'].items()),
           Figure('programs that reach their end condition', 'ended', '', different,
                  Target('at_least', len(LIST['programs']))))
