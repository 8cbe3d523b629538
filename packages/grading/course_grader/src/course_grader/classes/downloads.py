"""Reads what a learning platform gives to download: a ZIP, or the folder into which it was unpacked. Without ROS.

The files of each student are copied into a folder of that student, where submissions.py finds them::

    Moodle      Anna Berg_1234_assignsubmission_file_/stop_at_x.py
                Anna Berg_1234_assignsubmission_file_stop_at_x.py       without "Download submissions in folders"
    Canvas      berganna_LATE_1234_5678_stop_at_x.py                    a file that was handed in again: stop_at_x-1.py
    Gradescope  assignment_12_export/submission_34/stop_at_x.py         submission_metadata.yml has the names
    others      anna/stop_at_x.py                                       as submissions.py describes it

A ZIP may be hostile: nothing is written outside of the folder, and sizes are limited.
"""
import collections
import contextlib
import datetime
import os
import re
import shutil
import stat
import zipfile
import zlib
from typing import IO, Any, Callable, Dict, List, NamedTuple, Optional, Set, Tuple

from course_grader.classes.graded import CLASS, HANDED_IN, LONGEST_NAME
from course_grader.classes.submissions import NOBODYS, LeftOut
from course_grader.formats import platforms
from course_grader.formats.platforms import Origin
from course_grader.isolation import student_files
from course_grader.isolation.limits import MEGABYTE
from plain_support import documents

MOODLE = re.compile(r'(?P<name>.+?)_(?P<id>\d+)_assignsubmission_[a-z]+(_(?P<rest>.*))?', re.DOTALL)
CANVAS = re.compile(r'(?P<name>[^_/]+)_(?P<late>LATE_|late_)?(?P<id>\d+)_\d+_(?P<rest>[^/]+)', re.DOTALL)
AGAIN = re.compile(r'-\d+(?=\.\w+$)')  # Canvas numbers a file that replaces one of the same name
SUBMISSION = re.compile(r'submission_(?P<id>\d+)')
ZIP = '.zip'
UNPACKED = '.handed_in'  # file beside the folder HANDED_IN: it is made by folder_of_class(), and may be replaced
METADATA = 'submission_metadata.yml'  # of Gradescope
MAX_FILE, MAX_ALL = 64 * MEGABYTE, 2048 * MEGABYTE  # [bytes] of a file, and of all together
MAX_FILES = 100_000
CHUNK = 1 << 20  # [bytes]
UNREADABLE = zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, ValueError


class DownloadError(ValueError):
    """A download cannot be read; the text says why and what to do."""


class File(NamedTuple):
    """A file of a download: its path with ``/``, its size [bytes], its mode, what opens it, its date [s since 1970]."""

    name: str
    size: int
    mode: int
    open: Callable[[], IO[bytes]]
    date: float = 0.0


def folder_of_class(path: str, output: str) -> Tuple[str, List[LeftOut], Origin]:
    """Return the folder of a class with a folder for each student, what could not be read, and where it comes from.

    It is ``path`` itself, unless that is a ZIP or has the layout of a platform: then a new one in ``output``. Raise
    DownloadError or OSError.
    """
    is_folder = os.path.isdir(path)
    files = _in_folder(path) if is_folder else _in_zip(path)
    owners, origin = _owners(files)
    if is_folder and not owners:
        return path, [], origin
    target = os.path.join(output, HANDED_IN)
    _check_target(path, target, output)
    shutil.rmtree(target, ignore_errors=True)
    os.makedirs(target)
    with open(os.path.join(output, UNPACKED), 'ab'):
        pass
    left_out, room = [], MAX_ALL
    for file in files[:MAX_FILES]:
        student, rest = owners.get(file.name, ('', file.name))
        if owners and _is_metadata(file.name):
            continue
        reason = NOBODYS if owners and not student else _refusal(file, rest, room)
        try:
            if not reason:
                room -= _write(file, os.path.join(target, student, rest))
        except UNREADABLE as error:
            reason = f'it cannot be unpacked: {error}'
        if reason:
            left_out.append(LeftOut(student, rest, reason))
    if len(files) > MAX_FILES:
        left_out.append(LeftOut('', '', f'{len(files) - MAX_FILES} more files: at most {MAX_FILES:,} are read'))
    return target if owners else _inner(target), left_out, origin


def _check_target(path: str, target: str, output: str) -> None:
    """Raise DownloadError if the folder that is unpacked into has files of the teacher."""
    if os.path.join(os.path.realpath(path), '').startswith(os.path.join(os.path.realpath(target), '')):
        raise DownloadError(f'{path} lies in {target}, where it would be unpacked and replaced. Choose another folder '
                            'with --output DIR')
    if os.path.exists(target) and not any(os.path.exists(os.path.join(output, name)) for name in (UNPACKED, CLASS)):
        raise DownloadError(f'{target} would be replaced, and was not unpacked by ./run grade. Choose another folder '
                            'with --output DIR')


def _inner(folder: str) -> str:
    """Return the folder that holds those of the students: many programs zip a folder, and not what is in it."""
    names = os.listdir(folder)
    inner = os.path.join(folder, names[0]) if len(names) == 1 else ''
    has_folders = inner and os.path.isdir(inner) and any(
        os.path.isdir(os.path.join(inner, name)) for name in os.listdir(inner))
    return inner if has_folders else folder


def _in_zip(path: str) -> List[File]:
    try:
        archive = zipfile.ZipFile(path)
    except UNREADABLE as error:
        raise DownloadError(f'{path} cannot be read as a ZIP: {error}; download it again, or name the folder into '
                            'which you have unpacked it') from None

    def opener(info: zipfile.ZipInfo) -> Callable[[], IO[bytes]]:
        return lambda: archive.open(info)
    return [File(info.filename, info.file_size, info.external_attr >> 16, opener(info), _date(info))
            for info in archive.infolist() if not info.is_dir()]


def _in_folder(path: str) -> List[File]:
    files: List[File] = []

    def opener(file_path: str) -> Callable[[], IO[bytes]]:
        return lambda: open(file_path, 'rb')
    for parent, folders, names in student_files.walk(path):
        folders[:] = [name for name in folders if not name.startswith('.')]
        for name in names:
            file_path = os.path.join(parent, name)
            about = os.lstat(file_path)
            files.append(File(os.path.relpath(file_path, path), about.st_size, about.st_mode, opener(file_path),
                              about.st_mtime))
    return files


def _date(info: zipfile.ZipInfo) -> float:
    """Return the date of a file in a ZIP [s since 1970], which has no time zone; 0 if it is impossible."""
    try:
        return datetime.datetime(*info.date_time).timestamp()
    except (ValueError, OverflowError, OSError):
        return 0.0


def _owners(files: List[File]) -> Tuple[Dict[str, Tuple[str, str]], Origin]:
    """Return {name of a file: (student, path in the student's folder)} if the files have the layout of a platform.

    And the Origin.
    """
    for platform, layout in LAYOUTS.items():
        found, times = layout(files)
        if found:
            owners = _with_unique_students(found)
            return owners, Origin(platform, {owners[name][0]: number for name, (_, number, _) in found.items()},
                                  {'/'.join(owners[name]): time for name, time in times.items()})
    return {}, Origin()


Found = Dict[str, Tuple[str, str, str]]  # {name of a file: (student, id, path in the student's folder)}
Times = Dict[str, str]  # {name of a file: when it was handed in}, as in Origin


def _moodle(files: List[File]) -> Tuple[Found, Times]:
    found: Found = {}
    for file in files:
        first, slash, inside = file.name.partition('/')
        match = MOODLE.fullmatch(first)
        if match and (slash or match['rest']):
            found[file.name] = match['name'], match['id'], inside if slash else match['rest']
    return found, {}


def _canvas(files: List[File]) -> Tuple[Found, Times]:
    matches = {file.name: CANVAS.fullmatch(file.name) for file in files}
    found: Found = {name: (match['name'], match['id'], match['rest']) for name, match in matches.items() if match}
    if len(found) < len(files):  # a single file with such a name may be anything
        return {}, {}
    taken = set(found.values())
    for name, (student, number, rest) in list(found.items()):
        first = student, number, AGAIN.sub('', rest)
        if first not in taken:
            found[name] = first
            taken.add(first)
    return found, {name: platforms.LATE for name, match in matches.items() if match and match['late']}


def _gradescope(files: List[File]) -> Tuple[Found, Times]:
    about = next((file for file in files if _is_metadata(file.name)), None)
    if about is None:
        return {}, {}
    try:
        with about.open() as opened:
            metadata = documents.parse_yaml(opened.read(documents.MAX_YAML))
    except (*UNREADABLE, documents.DocumentError) as error:
        raise DownloadError(f'{about.name} cannot be read: {error}') from None
    root = about.name[:-len(METADATA)]
    found: Found = {}
    times: Times = {}
    for file in files:
        first, _, inside = file.name[len(root):].partition('/')
        match = SUBMISSION.fullmatch(first)
        if file.name.startswith(root) and match and inside:
            found[file.name] = _submitters(metadata, first), match['id'], inside
            with contextlib.suppress(TypeError, KeyError, AttributeError, ValueError, OverflowError):
                times[file.name] = local_time(metadata[first][':created_at'])
    return found, times


def local_time(when: datetime.datetime) -> str:
    """Return a time, without a zone that of UTC, in the zone of this machine, as Origin has it."""
    zone = when.tzinfo or datetime.timezone.utc
    return when.replace(tzinfo=zone).astimezone().replace(tzinfo=None).isoformat(' ', 'minutes')


LAYOUTS: Dict[str, Callable[[List[File]], Tuple[Found, Times]]] = {
    platforms.GRADESCOPE: _gradescope, platforms.MOODLE: _moodle, platforms.CANVAS: _canvas}


def _is_metadata(name: str) -> bool:
    return name.rpartition('/')[2] == METADATA and name.count('/') < 2


def _submitters(metadata: Any, submission: str) -> str:
    """Return the names of those who have handed in a submission, which may be a group."""
    try:
        return ' and '.join(str(one[':name']) for one in metadata[submission][':submitters']) or submission
    except (TypeError, KeyError):
        return submission


def _with_unique_students(found: Found) -> Dict[str, Tuple[str, str]]:
    """Return {name of a file: (student, path)}; of students with the same name, the id is added to it."""
    ids: Dict[str, Set[str]] = collections.defaultdict(set)
    for student, number, _ in found.values():
        ids[_as_folder(student)].add(number)
    return {name: (_as_folder(student) + (f' {number}' if len(ids[_as_folder(student)]) > 1 else ''), rest)
            for name, (student, number, rest) in found.items()}


def _as_folder(name: str) -> str:
    """Return the name of a student as that of a folder, which is not hidden."""
    plain = re.sub(r'[/\0]', '_', name).lstrip('._ ') or '_'
    return os.fsencode(plain)[:LONGEST_NAME].decode('utf-8', 'ignore')


def _refusal(file: File, rest: str, room: int) -> Optional[str]:
    """Return why a file is not copied to the path ``rest``, or None; ``room`` [bytes] is left for it."""
    parts = rest.replace('\\', '/').split('/')
    if file.mode and stat.S_IFMT(file.mode) not in (0, stat.S_IFREG):
        return 'it is a link, or no file'
    if '..' in parts or '' in parts or '\0' in rest:
        return 'its path leads to another folder'
    if len(parts) > student_files.MAX_DEPTH or any(len(os.fsencode(part)) > 255 for part in parts):
        return 'its path is too long'
    if file.size > MAX_FILE:
        return f'it has {file.size / MEGABYTE:.0f} MB; at most {MAX_FILE / MEGABYTE:.0f} MB are read'
    return None if file.size <= room else f'all files together have more than {MAX_ALL / MEGABYTE:.0f} MB'


def _write(file: File, path: str) -> int:
    """Copy a file; return its size [bytes]. Raise one of UNREADABLE."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    size = 0
    with file.open() as source, open(path, 'xb') as target:
        for content in iter(lambda: source.read(CHUNK), b''):
            size += len(content)
            if size > MAX_FILE:  # the archive may say something else
                raise ValueError('it is longer than it says')
            target.write(content)
    os.chmod(path, 0o755 if file.mode & 0o111 else 0o644)
    os.utime(path, (file.date, file.date))
    return size
