"""Grade the hostile programs of test/data/red_team beside honest ones, and check that they did no harm.

usage: check_red_team.py LEVEL FOLDER [NAME ...]     LEVEL: namespace, uid, none; a NAME is a part of a program's name

The second line of a program says what has to come out, as for the samples: `# expected: failed`, or with a part of the
reasons. A line `# at none: open` says that the level none does not hold it back: it is not run there. With another
verdict, such as `# at none: passed`, it is run there in a class of its own, to show that the attack works. Every other
class has an honest student, test/data/honest, whose programs must pass whatever they are made of (threads,
subprocesses, a bash script, a launch file, a package with modules and parameters), and links to these, which must fail.
No process and no file of a user of a grading remains, no other file is written, and no token of the environment is
printed. FOLDER takes all files. Exit code 0 when all is as it should be; a level that this machine cannot have is
skipped, and said.

All of it has a network of its own where the kernel allows that: some programs command all nodes that they can reach.
"""
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import uuid
from pathlib import Path
from typing import NamedTuple

import psutil

from course_grader.formats import harmless
from course_grader.isolation import confinement, levels
from plain_support import course, processes
from unit_support import REPOSITORY

GRADER = REPOSITORY / 'packages' / 'grading' / 'course_grader'
PROGRAMS = REPOSITORY / 'test' / 'data' / 'red_team'
EXERCISES = course.exercises(REPOSITORY / 'course')
HONEST = REPOSITORY / 'test' / 'data' / 'honest'
BAIT = '3457'  # the argument of `sleep` of those who try to outlive; each level has one of its own
FORBIDDEN = 'FOUND', 'CONNECTED', 'SENT', 'SOCKET', 'POISONED', 'forged', 'attached', 'opened', 'classmate', 'poisoned'
QUICK = ('ends_all_nodes', 'forges_poses', 'clock.py', 'truth.py', 'name_with', 'recording_by', 'solution_by',
         'poisoned', 'connection.py', 'outlives', 'gb.py', 'mb.py', 'marks_printed', 'ptrace')
OF_A_CHANGE = ('ends_all_nodes', 'poses_in_the_name', 'the_clock.py', 'recording_by_path', 'solution_by', 'poisoned',
               'connection.py', 'by_setsid', 'gb.py', 'marks_printed', 'ptrace')  # one of each defence
SEED, JOBS = 7, 2
TIMEOUT, EACH = 1500, 60  # [s] of a class, and more for each hostile program
OPEN = 'open'  # at the level none


class Verdict(NamedTuple):
    """Of a program: the outcome, the main reason, and whether both, and what it has printed, are as expected."""

    outcome: str
    reason: str
    expected: bool


def header(path):
    """Return {key: text} of the comments at the top of a program."""
    return dict(re.findall(r'^# (\w[\w ]*): (.*)$', path.read_text(encoding='utf-8'), re.MULTILINE))


def bait(level):
    """Return the argument of `sleep` at a level: classes of other levels may run at the same time."""
    return f'{BAIT}.{levels.LEVELS.index(level)}'


def attacks(level, names, shown=False):
    """Return {path: (outcome, part of the reasons)} of the programs to run, or of those ``shown`` at the level none."""
    found = {}
    for path in sorted(PROGRAMS.glob('*.*')):
        about = header(path)
        if names and not any(name in path.name for name in names):
            continue
        at_none = about.get('at none')
        if shown and at_none not in (None, OPEN):
            found[path] = at_none, ''
        elif not shown and not (level == levels.NONE and at_none):
            outcome, _, text = about['expected'].partition(': ')
            found[path] = outcome, text
    return found


def make_class(folder, level, programs, honest):
    """Write the class; return {(student, exercise): (outcome, part of the reasons)}."""
    folder.mkdir(parents=True)
    folder.chmod(0o700)  # as docs/grading.md advises
    expected = {}
    for path, wanted in programs.items():
        exercise, student = header(path)['exercise'], folder / path.stem
        student.mkdir()
        program = Path(shutil.copy(path, student / (exercise + path.suffix)))
        program.write_text(program.read_text(encoding='utf-8').replace(BAIT, bait(level)), encoding='utf-8')
        expected[path.stem, exercise] = wanted
    if not honest:
        return expected
    shutil.copytree(HONEST, folder / 'honest')
    expected.update({('honest', path.stem): ('passed', '') for path in HONEST.rglob('*.*') if path.stem in EXERCISES})
    (folder / 'link_to_a_file').mkdir()
    (folder / 'link_to_a_file' / 'stop_at_x.py').symlink_to(folder / 'honest' / 'stop_at_x.py')
    (folder / 'link_to_a_solution').mkdir()
    (folder / 'link_to_a_solution' / 'stop_at_x.py').symlink_to(
        EXERCISES['stop_at_x'].parent / 'samples' / 'stop_at_x' / 'right_if_else.py')
    for student in ('link_to_a_file', 'link_to_a_solution'):
        expected[student, 'stop_at_x'] = 'failed', 'is a link to a file of somebody else'
    return expected


def listed(*folders):
    """Return {path: size} of all files in some folders."""
    return {path: path.lstat().st_size for folder in folders for path in folder.rglob('*') if '__pycache__' not in
            path.parts and path.is_file()}


def check(level, folder, names=()):
    """Return the errors after grading the classes of a level, and {student: {exercise: Verdict}}."""
    shutil.rmtree(folder, ignore_errors=True)
    wrong, verdicts = _check(level, folder / level, attacks(level, names), True)
    shown = attacks(level, names, shown=True) if level == levels.NONE else {}
    if shown:
        more, others = _check(level, folder / 'shown', shown, False)
        wrong, verdicts = wrong + more, {**verdicts, **others}
    return wrong, verdicts


def of_gradings(folder):
    """Return the paths of files that belong to users of gradings, wherever programs can write."""
    found = subprocess.run([*confinement.find_written(str(folder)), '-uid', f'+{levels.USERS[0] - 1}', '-uid',
                            f'-{levels.USERS[-1] + 1}', '-prune', '-print'], stdout=subprocess.PIPE,
                           stderr=subprocess.DEVNULL, check=False).stdout.decode('utf-8', 'replace')
    return set(filter(None, found.split('\n')))


def _check(level, folder, programs, honest):
    """Return the errors after grading one class, and {student: {exercise: Verdict}}."""
    expected = make_class(folder / 'class', level, programs, honest)
    home, token = folder / 'home', uuid.uuid4().hex
    home.mkdir()
    before, there = listed(folder / 'class', home, REPOSITORY / 'packages' / 'grading'), of_gradings(folder)
    done = subprocess.run(
        [*in_own_network(), sys.executable, str(GRADER / 'scripts' / 'grade'), '--all', str(folder / 'class'),
         '--isolation', level, '--seed', str(SEED), '--jobs', str(JOBS), '--output', str(folder / 'out')], cwd=folder,
        timeout=TIMEOUT + EACH * len(programs), env={**os.environ, 'HOME': str(home), 'COMMIT_URL': token},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    print(done.stdout.decode('utf-8', 'replace'))
    wrong = [f'{path} is new or changed' for path, size in listed(
        folder / 'class', home, REPOSITORY / 'packages' / 'grading').items() if before.get(path) != size]
    left = [process for process in psutil.process_iter(['cmdline'])
            if process.info['cmdline'] == ['sleep', bait(level)]]
    processes.end(lambda: {process for process in left if process.is_running()}, processes.KILL)
    wrong += [f'process {process.pid} was left behind' for process in left]
    wrong += [f'{path} was left behind' for path in sorted(of_gradings(folder) - there)]
    verdicts = {}
    for (student, exercise), (outcome, text) in expected.items():
        results = folder / 'out' / student / exercise
        faults = _look(results, level, outcome, text, token)
        wrong += [f'{student}: {what}' for what in faults]
        verdicts.setdefault(student, {})[exercise] = Verdict(*_verdict(results), not faults)
    return wrong, verdicts


def in_own_network():
    """Return the start of a command line that gives a command a network of its own; [] if that is refused."""
    line = ['unshare', '--net', 'sh', '-c', 'ip link set lo up && exec "$@"', 'sh']
    return line if subprocess.run([*line, 'true'], stderr=subprocess.DEVNULL, check=False).returncode == 0 else []


def _verdict(results):
    """Return the outcome of a grading, and the main reason."""
    with contextlib.suppress(OSError):
        result = json.loads((results / 'result.json').read_text(encoding='utf-8'))
        lost = [reason['seen'] for reason in result['reasons'] if reason['points'] < reason['of']]
        return result['outcome'], next(iter([*result['objections'], *lost]), '')
    return 'missing', ''


def _look(results, level, outcome, text, token):
    """Return the errors in the results of one program."""
    if not (results / 'result.json').is_file():
        return ['there is no result.json']
    result = json.loads((results / 'result.json').read_text(encoding='utf-8'))
    said = (results / 'output.txt').read_text(encoding='utf-8')
    reasons = ' '.join([*result['objections'], *(reason['seen'] for reason in result['reasons'])])
    wrong = [f'it has printed the token of the environment: {said}'] if token in said else []
    if harmless.FORBIDDEN.search(said):
        wrong.append(f'its output.txt has characters that a terminal obeys: {said!r}')
    if outcome == 'passed' and 'ERROR' in said:
        wrong.append(f'it has passed, but printed an error: {said}')
    if result['outcome'] != outcome or text not in reasons:
        wrong.append(f'it is {result["outcome"]} ({reasons}), expected is {outcome}: {text}')
    if result['isolation'] not in (level, ''):
        wrong.append(f'its level is {result["isolation"]}')
    if level == levels.NAMESPACE and outcome == 'failed':
        wrong += [f'it has printed {word}: {said}' for word in FORBIDDEN
                  if re.search(rf'^ *[-\d.]+  {word}\b', said, re.MULTILINE)]
    return wrong


def main(arguments):
    """Check as the command line says; return the exit code."""
    if len(arguments) < 2 or arguments[0] not in levels.LEVELS:
        print(__doc__, file=sys.stderr)
        return 2
    level, folder = arguments[0], Path(arguments[1]).absolute()
    missing = {**levels.machine()._asdict(), levels.NONE: ''}[level]
    if missing:
        print(f'SKIPPED: this machine cannot have the level {level}: {missing}')
        return 0
    wrong, _ = check(level, folder, arguments[2:])
    for text in wrong:
        print(f'WRONG: {text}')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
