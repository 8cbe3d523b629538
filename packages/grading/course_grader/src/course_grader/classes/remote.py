"""./run grade --all FOLDER --dask SCHEDULER: sends gradings to a Dask cluster, whose workers may be other machines.

A submission is sent with its exercise; ./run grade EXERCISE grades it there, isolated as on that machine, and its files
are sent back. Dask gives the gradings of a lost worker to another one. Anyone who reaches a scheduler without TLS can
run programs on its workers, so such a scheduler is used on this machine only, and only with programs that have a
network of their own. Without ROS.
"""
import argparse
import asyncio
import contextlib
import importlib
import ipaddress
import os
import platform
import subprocess
import sys
import tempfile
import time
from typing import Any, Callable, Mapping, NamedTuple, Sequence, Tuple
from urllib.parse import urlsplit

import psutil

from course_grader.classes import class_grader, graded
from course_grader.classes.class_grader import Answer, Work
from course_grader.classes.graded import Graded
from course_grader.formats import exit_codes
from course_grader.isolation import levels
from course_grader.supervision.supervisor import EXTRA, PATIENCE, RESULTS
from plain_support import processes

GRADER = [sys.executable, '-c', 'import sys; from course_grader.cli import main; sys.exit(main())']
MAX_SUBMISSION = 50_000_000  # [bytes] of a submission
SCHEDULER_TIMEOUT = 15.0  # [s] for a scheduler to answer
SLACK = 60.0  # [s] of wall time beyond that of the grader, which should end a grading itself
MAX_ERROR = 500  # characters of the output of a grader that failed
FOLDER = '{folder}/'  # stands for the submission's folder in a command that is sent


class RemoteError(Exception):
    """The cluster cannot be used; the text says why and what to do."""


class Parcel(NamedTuple):
    """A submission that is sent: {name: (mode, content)} of its files, its command, the exercise and its text.

    ``inside``: the folder in which the command was typed, below that of the student; ``packages``: whether packages
    are searched there; ``limit`` [s] of wall time; ``version`` of the grader that packed it; ``isolated_by``: options.
    """

    student: str
    files: Mapping[str, Tuple[int, bytes]]
    command: Tuple[str, ...]
    inside: str
    packages: bool
    exercise: str
    exercise_text: bytes
    seed: int
    limit: float
    version: str
    isolated_by: Tuple[str, ...] = ()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--dask', metavar='SCHEDULER', type=_address, help='grade on the workers of a Dask cluster: '
                        'tcp://127.0.0.1:8786 on this machine, else tls://HOST:8786 with --dask-key; see '
                        'docs/grading.md')
    parser.add_argument('--dask-key', metavar='FILE', help='key and certificate of the cluster, in one PEM file')


def _address(text: str) -> str:
    parts = urlsplit(text)
    try:
        complete = parts.scheme in ('tcp', 'tls') and parts.hostname and parts.port
    except ValueError:
        complete = None
    if not complete:
        raise argparse.ArgumentTypeError(f'{text!r} is not the address of a scheduler; write tcp://127.0.0.1:8786 or '
                                         'tls://HOST:8786')
    if parts.scheme == 'tcp' and not _is_here(str(parts.hostname)):
        raise argparse.ArgumentTypeError(f'{text} is another machine, and whoever reaches a scheduler without TLS can '
                                         f'run programs there: write tls://{parts.netloc}, and add --dask-key FILE')
    return text


def _is_here(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def require_isolation(options: argparse.Namespace) -> None:
    """Let workers of a scheduler without a key grade at the level namespace only; raise RemoteError if none can.

    A program at another level reaches the scheduler, and could run code on the workers as their user. Call this while
    the process has one thread.
    """
    if not options.dask or urlsplit(options.dask).scheme != 'tcp':
        return
    missing = levels.machine().namespace
    if missing or options.isolation not in (None, levels.NAMESPACE):
        why = f'the level namespace is not possible here: {missing}' if missing else f'--isolation {options.isolation}'
        raise RemoteError(f'--dask {options.dask} has no key, so a program that reaches it could run code on its '
                          f'workers ({why}). Make a key, and write tls://{urlsplit(options.dask).netloc} with '
                          '--dask-key FILE, as docs/grading.md says; or grade without --dask')
    options.require_isolation = levels.NAMESPACE


def grade(options: argparse.Namespace, works: Sequence[Work], done: Callable[[Graded], None]) -> None:
    """Grade all on the cluster of the options; ``done(graded)`` is called for each. Raise RemoteError."""
    try:
        distributed = importlib.import_module('distributed')
    except ImportError:
        raise RemoteError('--dask needs the Python package distributed; ./run grade installs it') from None
    with _client(distributed, options) as client:
        try:
            client.wait_for_workers(1, timeout=SCHEDULER_TIMEOUT)
        except (TimeoutError, asyncio.TimeoutError):  # one class since Python 3.11
            raise RemoteError(f'{options.dask} has no workers; start one or more in ./run shell: '
                              f'dask worker --nthreads 1 {options.dask}') from None
        class_grader.grade(works, client.get_executor(pure=False), grade_parcel, done, pack=pack)


def _client(distributed: Any, options: argparse.Namespace) -> Any:
    security = None
    if urlsplit(options.dask).scheme == 'tls':
        if not options.dask_key:
            raise RemoteError(f'{options.dask} needs --dask-key FILE, the key with which the scheduler was started')
        if not os.path.isfile(options.dask_key):
            raise RemoteError(f'--dask-key: there is no file {options.dask_key}')
        security = distributed.Security(tls_ca_file=options.dask_key, tls_client_cert=options.dask_key,
                                        tls_client_key=options.dask_key, require_encryption=True)
    try:
        return distributed.Client(options.dask, security=security, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise RemoteError(f'{options.dask} does not answer as a scheduler: {error}') from None


def pack(work: Work) -> Parcel:
    """Return the Parcel of a submission; raise OSError or ValueError."""
    submission, root = work.submission, graded.root_of(work.submission) + os.sep
    size = sum(os.path.getsize(path) for path in work.files.values())
    if size > MAX_SUBMISSION:
        raise ValueError(f'the submission has {size / 1e6:.0f} MB; at most {MAX_SUBMISSION / 1e6:.0f} MB can be sent '
                         'to another machine: grade it without --dask')
    files = {}
    for name, path in work.files.items():
        with open(path, 'rb') as file:
            files[name] = os.fstat(file.fileno()).st_mode & 0o777, file.read()
    with open(work.path, 'rb') as file:
        text = file.read()
    return Parcel(submission.student, files, tuple(part.replace(root, FOLDER) for part in submission.command),
                  os.path.relpath(submission.folder, root), bool(submission.packages), work.exercise.name, text,
                  work.seed, (1.0 + PATIENCE) * (work.exercise.time + EXTRA) if work.limit is None else work.limit,
                  graded.version(), work.isolated_by)


def grade_parcel(parcel: Parcel) -> Answer:
    """Grade a submission on this machine, in a folder that is removed; return its files. Raise RuntimeError."""
    here = platform.node()
    if parcel.version != graded.version():
        raise RuntimeError(f'{here} has another version of the grader; update it, and start its workers again')
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_grading_') as folder:
        own = _below(folder, os.path.join('submission', parcel.student))
        for name, (mode, content) in parcel.files.items():
            path = _below(own, name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, 'wb') as file:
                file.write(content)
            os.chmod(path, mode)
        exercise = _below(folder, f'{parcel.exercise}.yaml')
        with open(exercise, 'wb') as file:
            file.write(parcel.exercise_text)
        output = os.path.join(folder, 'results')
        packages = ['--packages', own] if parcel.packages else []
        _run([*GRADER, exercise, '--seed', str(parcel.seed), f'--student={parcel.student}', '--output', output,
              *packages,
              *parcel.isolated_by, '--',
              *(part.replace(FOLDER, own + os.sep) for part in parcel.command)], os.path.join(own, parcel.inside),
             parcel.limit)
        files = {}
        for name in RESULTS:
            with contextlib.suppress(FileNotFoundError), open(os.path.join(output, name), 'rb') as file:
                files[name] = file.read()
    return Answer(time.monotonic() - start, files)


def _below(folder: str, name: str) -> str:
    """Return the path of a name below a folder; raise RuntimeError if it leads elsewhere."""
    path = os.path.normpath(os.path.join(folder, name))
    if not path.startswith(folder + os.sep):
        raise RuntimeError(f'{name!r} leads out of the submission')
    return path


def _run(command: Sequence[str], folder: str, limit: float) -> None:
    """Run the grader, which ends with this process; raise RuntimeError unless it has graded."""
    graders = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, start_new_session=True, preexec_fn=processes.end_with_parent)
    try:
        errors = graders.communicate(timeout=limit + SLACK)[1]
    except subprocess.TimeoutExpired:
        raise RuntimeError(f'the grading took more than {limit + SLACK:.0f} s on {platform.node()}') from None
    finally:
        if graders.poll() is None:
            processes.end(lambda: set(processes.tree(psutil.Process(graders.pid))))
    if graders.returncode not in exit_codes.OF_OUTCOME.values():
        raise RuntimeError(f'the grader ended with exit code {graders.returncode} on {platform.node()}: '
                           f'{errors.decode(errors="replace")[-MAX_ERROR:].strip()}')
