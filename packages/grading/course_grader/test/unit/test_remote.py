"""Gradings on a Dask cluster: a scheduler and three workers, with TLS, of which one is killed while it grades."""
import argparse
import contextlib
import csv
import os
import pathlib
import re
import signal
import subprocess
import sys

import pytest

from course_grader.classes import graded, remote
from course_grader.classes.class_grader import Work
from course_grader.classes.submissions import Submission
from course_grader.isolation import isolate, levels
from course_grader.rules import exercise
from plain_support import processes
from rospy_support.ports import free_port
from rostest_support.waiting import until
from unit_support.cases import nightly

distributed = pytest.importorskip('distributed')

pytestmark = pytest.mark.slow

SCHEDULER_TIMEOUT = 90.0  # [s]
ATTEMPT = r'''
import os, time
from course_grader.rules import scoring
from course_grader.rules.observation import Observed
from course_grader.supervision.job import Attempted
def run(job):
    names = {**globals(), 'job': job}
    exec(open(job.command[0]).read(), names)
    reasons = [scoring.Reason('moves', 100.0, 100.0, 'a path', f'{names["seen"]}, seed {job.seed}')]
    return Attempted(scoring.Verdict('passed', 100.0, reasons, []), Observed())
'''
GRADER = '''
import functools, sys
sys.path[:0] = {path!r}
from course_grader import cli
cli.Supervisor = functools.partial(cli.Supervisor, 'obedient_attempt')
sys.exit(cli.main())
'''
PROGRAM = '''
folder = {folder!r}
with open(os.path.join(folder, 'started'), 'a') as file:
    file.write(job.exercise.name + ' ' + str(os.getpid()) + '\\n')
while not os.path.exists(os.path.join(folder, 'go')):
    time.sleep(0.02)
seen = open(os.path.join(os.path.dirname(job.command[0]), 'helper.txt')).read()
'''
EXERCISE = '{title: X, time: 5 s, checks: [{check: moves, length: 1 m, points: 100}]}'


@pytest.fixture(name='cluster')
def started(tmp_path):
    """Start a scheduler and three workers with a key of this test; return (address, key, processes of the workers)."""
    key = tmp_path / 'key.pem'
    subprocess.run(['openssl', 'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=grading',
                    '-keyout', key, '-out', key], check=True, capture_output=True)
    (tmp_path / 'obedient_attempt.py').write_text(ATTEMPT)
    (tmp_path / 'grader.py').write_text(GRADER.format(path=[str(tmp_path), *sys.path]))
    (tmp_path / 'preload.py').write_text('import sys\nfrom course_grader.classes import remote\n'
                                         f'remote.GRADER = [sys.executable, {str(tmp_path / "grader.py")!r}]\n')
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    address, tls = f'tls://127.0.0.1:{free_port()}', []
    for name in ('ca-file', 'cert', 'key'):
        tls += [f'--tls-{name}', str(key)]
    roles = [['dask_scheduler', '--host', address, '--no-dashboard', '--no-show']]
    roles += [['dask_worker', address, '--nthreads', '1', '--no-nanny', '--no-dashboard', '--name', f'worker{number}',
               '--preload', str(tmp_path / 'preload.py'), '--local-directory', str(tmp_path)] for number in range(3)]
    with open(tmp_path / 'dask.txt', 'wb') as log:
        running = [subprocess.Popen([sys.executable, '-m', f'distributed.cli.{role[0]}', *role[1:], *tls], stdout=log,
                                    stderr=log, env=environment, start_new_session=True,
                                    preexec_fn=processes.end_with_parent) for role in roles]
    try:
        until(lambda: (tmp_path / 'dask.txt').read_text().count('Registered to') >= 3,
              'three workers are there', SCHEDULER_TIMEOUT)
        yield address, str(key), running[1:]
    finally:
        for process in running:
            process.kill()
            process.wait()


def runs(pid):
    try:
        return pathlib.Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[0] != 'Z'
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.nightly
def test_the_gradings_of_a_lost_worker_go_to_another(tmp_path, cluster):
    address, key, workers = cluster
    students = [f'student {number}' for number in range(6)]
    for student in students:
        (tmp_path / 'class' / student).mkdir(parents=True)
        (tmp_path / 'class' / student / 'x.py').write_text(PROGRAM.format(folder=str(tmp_path)))
        (tmp_path / 'class' / student / 'helper.txt').write_text(f'beside {student}')
    (tmp_path / 'class' / 'x.yaml').write_text(EXERCISE)
    program = 'import sys; from course_grader import cli; sys.exit(cli.main(["--all", *sys.argv[1:]]))'
    command = [sys.executable, '-c', program, str(tmp_path / 'class'), '--output', str(tmp_path / 'out'), '--dask',
               address, '--dask-key', key, '--seed', '9']
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
                          ) as teacher, contextlib.ExitStack() as leaving:
        leaving.callback(teacher.kill)  # if an assertion fails
        said = tmp_path / 'started'
        until(lambda: said.exists() and said.read_text().count('\n') == 3, 'each worker grades', SCHEDULER_TIMEOUT)
        workers[0].send_signal(signal.SIGKILL)
        workers[0].wait()
        (tmp_path / 'go').touch()
        output, errors = teacher.communicate(timeout=SCHEDULER_TIMEOUT)
    assert teacher.returncode == 0, (output, errors, (tmp_path / 'dask.txt').read_text())
    assert said.read_text().count('\n') == 7  # one of the six began twice
    with open(tmp_path / 'out' / 'scores.csv', encoding='utf-8', newline='') as file:
        assert [row[1] for row in csv.reader(file)] == ['x', *['100'] * 6]
    for student in students:
        result = (tmp_path / 'out' / student / 'x' / 'result.json').read_text()
        assert f'beside {student}, seed 9' in result
    until(lambda: not any(runs(pid) for pid in re.findall(r' (\d+)', said.read_text())),
          'no grading goes on', SCHEDULER_TIMEOUT)


@pytest.mark.parametrize('address, options, said', [
    ('tcp://127.0.0.1:{}', [], 'has no key' if levels.machine().namespace else 'does not answer as a scheduler'),
    ('tls://127.0.0.1:1', [], 'needs --dask-key FILE, the key with which the'),
    *nightly(('tcp://127.0.0.1:{}', ['--isolation', 'uid'], 'has no key, so a program'),
             ('tls://127.0.0.1:1', ['--dask-key', 'no.pem'], 'there is no file no.pem'))])
def test_it_says_what_is_wrong_with_a_cluster(tmp_path, address, options, said):
    (tmp_path / 'class' / 'anna').mkdir(parents=True)
    (tmp_path / 'class' / 'anna' / 'x.py').write_text('')
    (tmp_path / 'class' / 'x.yaml').write_text(EXERCISE)
    program = ('import sys; from course_grader import cli; from course_grader.classes import remote; '
               'remote.SCHEDULER_TIMEOUT = 0.5; sys.exit(cli.main(["--all", *sys.argv[1:]]))')
    done = subprocess.run([sys.executable, '-c', program, str(tmp_path / 'class'), '--output', str(tmp_path), '--dask',
                           address.format(free_port()), *options], capture_output=True, text=True,
                          timeout=SCHEDULER_TIMEOUT, check=False,
                          env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)})
    assert (done.returncode, 'Traceback' in done.stderr) == (2, False) and said in done.stderr, done.stderr


def test_every_worker_of_a_scheduler_without_a_key_must_isolate(monkeypatch):
    monkeypatch.setattr(levels, 'machine', lambda: levels.CAPABLE)
    parser = argparse.ArgumentParser()
    isolate.add_options(parser)
    remote.add_options(parser)
    options = parser.parse_args(['--dask', 'tcp://127.0.0.1:8786'])
    remote.require_isolation(options)
    assert isolate.line(options)[:2] == (levels.REQUIRED, levels.NAMESPACE)  # travels with each submission


def a_work(tmp_path, content=b'print(1)'):
    folder = tmp_path / 'anna'
    folder.mkdir(exist_ok=True)
    (folder / 'x.py').write_bytes(content)
    (tmp_path / 'x.yaml').write_text(EXERCISE)
    submission = Submission('anna', 'x', (str(folder / 'x.py'),), str(folder), packages=str(folder),
                            program=str(folder / 'x.py'))
    return Work(submission, exercise.load(tmp_path / 'x.yaml'), str(tmp_path / 'out'), 1,
                path=str(tmp_path / 'x.yaml'), files=graded.files_of(submission, {submission.program}))


def test_only_the_submission_travels(tmp_path, monkeypatch):
    work = a_work(tmp_path)
    (tmp_path / 'anna' / 'linked').symlink_to('/etc/hostname')
    parcel = remote.pack(work._replace(files=graded.files_of(work.submission, set())))
    assert parcel.command == (remote.FOLDER + 'x.py',) and list(parcel.files) == ['x.py']
    monkeypatch.setattr(remote, 'MAX_SUBMISSION', 4)
    with pytest.raises(ValueError, match='at most 0 MB can be sent to another machine'):
        remote.pack(work)


@pytest.mark.parametrize('change, said', [
    ({'version': 'old'}, 'has another version of the grader; update it'),
    ({'files': {'../../out.py': (0o644, b'')}}, 'leads out of the submission'),
    ({'files': {'/tmp/out.py': (0o644, b'')}}, 'leads out of the submission'),
    ({'student': '../..'}, 'leads out of the submission')])
def test_a_worker_refuses_what_it_cannot_grade(tmp_path, change, said):
    with pytest.raises(RuntimeError, match=said):
        remote.grade_parcel(remote.pack(a_work(tmp_path))._replace(**change))
