"""plain_support.files: files that are there as a whole or not at all. A full disk is a small limit of file sizes."""
import contextlib
import errno
import os
import resource
import signal
import stat
import subprocess
import sys
import threading

import pytest

from plain_support import files

LIMIT = 1000  # [bytes] of a file


@contextlib.contextmanager
def full_disk():
    """Let no file of this process become longer than LIMIT; Python ignores the signal that Linux sends.

    No fixture: pytest would report the test while the limit holds, and its own output may be a file.
    """
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, limits[1]))
    try:
        assert signal.getsignal(signal.SIGXFSZ) == signal.SIG_IGN
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.mark.parametrize('write', [files.write_whole, files.create_whole])
@pytest.mark.parametrize('content, data', [(b'\x00\xff', b'\x00\xff'), ('\u00e4\n', b'\xc3\xa4\n'), ('', b'')])
def test_a_new_file(tmp_path, write, content, data):
    write(tmp_path / 'a', content)
    assert (tmp_path / 'a').read_bytes() == data
    assert os.listdir(tmp_path) == ['a']


def test_rights_are_those_of_any_new_file_or_of_the_old_one(tmp_path):
    (tmp_path / 'usual').write_text('x')
    (tmp_path / 'old').write_text('x')
    (tmp_path / 'old').chmod(0o640)
    files.write_whole(tmp_path / 'new', 'x')
    files.write_whole(tmp_path / 'old', 'y')
    modes = [stat.S_IMODE(os.stat(tmp_path / name).st_mode) for name in ('usual', 'new', 'old')]
    assert modes == [modes[0], modes[0], 0o640]
    assert (tmp_path / 'old').read_text() == 'y'


@pytest.mark.parametrize('write', [files.write_whole, files.create_whole])
def test_a_full_disk_leaves_nothing(tmp_path, write):
    with pytest.raises(OSError, match='File too large.*wanted') as error, full_disk():
        write(str(tmp_path / 'wanted'), b'x' * (LIMIT + 1))
    assert error.value.filename == str(tmp_path / 'wanted')
    assert os.listdir(tmp_path) == []


def test_a_full_disk_leaves_the_old_file(tmp_path):
    (tmp_path / 'a').write_text('old')
    with pytest.raises(OSError), full_disk():
        files.write_whole(tmp_path / 'a', b'x' * (LIMIT + 1))
    assert (tmp_path / 'a').read_text() == 'old'
    assert os.listdir(tmp_path) == ['a']


def test_a_folder_that_does_not_exist(tmp_path):
    for write in (files.write_whole, files.create_whole):
        with pytest.raises(FileNotFoundError, match='none/a'):
            write(tmp_path / 'none' / 'a', 'x')


def test_what_exists_is_not_created_again(tmp_path):
    (tmp_path / 'file').write_text('old')
    (tmp_path / 'dangling').symlink_to(tmp_path / 'nowhere')
    for name in ('file', 'dangling'):
        with pytest.raises(FileExistsError):
            files.create_whole(tmp_path / name, 'new')
    assert (tmp_path / 'file').read_text() == 'old' and not (tmp_path / 'nowhere').exists()
    assert sorted(os.listdir(tmp_path)) == ['dangling', 'file']


def test_a_name_that_is_taken_meanwhile_is_not_overwritten(tmp_path, monkeypatch):
    monkeypatch.setattr(files.os.path, 'lexists', lambda path: False)
    (tmp_path / 'a').write_text('faster')
    with pytest.raises(FileExistsError):
        files.create_whole(tmp_path / 'a', 'new')
    assert (tmp_path / 'a').read_text() == 'faster'
    assert os.listdir(tmp_path) == ['a']


def test_the_next_free_number(tmp_path):
    (tmp_path / 'a_0001.png').write_text('old')
    (tmp_path / 'a_0002.png').symlink_to(tmp_path / 'nowhere')
    (tmp_path / 'a_0003.png').mkdir()
    paths = [files.create_numbered(tmp_path, 'a', '.png', b'new') for _ in range(2)]
    assert paths == [str(tmp_path / 'a_0004.png'), str(tmp_path / 'a_0005.png')]
    assert (tmp_path / 'a_0001.png').read_text() == 'old' and not (tmp_path / 'nowhere').exists()


def test_a_folder_with_too_many_numbers(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'MAX_NUMBERED', 2)
    for _ in range(2):
        files.create_numbered(tmp_path, 'a', '.png', b'')
    with pytest.raises(OSError, match='there are 2 files a_NUMBER.png already'):
        files.create_numbered(tmp_path, 'a', '.png', b'')


def test_a_file_system_without_links(tmp_path, monkeypatch):
    def link(*_):
        raise PermissionError(1, 'Operation not permitted')
    monkeypatch.setattr(files.os, 'link', link)
    files.create_whole(tmp_path / 'a', 'new')
    with pytest.raises(FileExistsError):
        files.name_new(tmp_path / 'a', tmp_path / 'a')
    assert (tmp_path / 'a').read_text() == 'new'


def test_a_link_given_by_the_user_is_followed_and_a_device_stays_one(tmp_path):
    (tmp_path / 'target').write_text('old')
    (tmp_path / 'link').symlink_to(tmp_path / 'target')
    files.write_whole(tmp_path / 'link', 'new')
    assert (tmp_path / 'link').is_symlink() and (tmp_path / 'target').read_text() == 'new'
    files.write_whole('/dev/null', 'x')
    assert stat.S_ISCHR(os.stat('/dev/null').st_mode)
    with pytest.raises(OSError, match='No space left.*/dev/full'):
        files.write_whole('/dev/full', 'x')


def test_files_that_belong_together_are_all_new_or_all_old(tmp_path):
    for name in ('a.pgm', 'a.yaml'):
        (tmp_path / name).write_text('old')
    with pytest.raises(OSError, match='a.yaml'), full_disk():
        files.write_together({tmp_path / 'a.pgm': 'new', tmp_path / 'a.yaml': 'x' * (LIMIT + 1)})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {'a.pgm': 'old', 'a.yaml': 'old'}
    files.write_together({tmp_path / 'a.pgm': 'new', tmp_path / 'a.yaml': 'new'})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {'a.pgm': 'new', 'a.yaml': 'new'}


@pytest.mark.parametrize('code, said', [
    (errno.ENOSPC, "No space left on device. Make room on the disk (df -h {0} says how much is left), or choose -f"),
    (errno.EACCES, 'Permission denied. Choose -f'), (errno.EROFS, 'Read-only file system. Choose -f')])
def test_what_is_said_about_a_file_that_cannot_be_written(tmp_path, code, said):
    error = OSError(code, os.strerror(code), str(tmp_path / 'a'))
    assert files.unwritten(error, 'choose -f') == f'{tmp_path}/a cannot be written: {said.format(tmp_path)}'


def test_what_is_said_about_a_missing_folder_and_a_relative_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileNotFoundError) as missing:
        files.write_whole('maps/a.pgm', 'x')
    assert files.unwritten(missing.value, 'choose -f') == (
        f'{tmp_path}/maps/a.pgm cannot be written: No such file or directory. Type mkdir -p {tmp_path}/maps, or choose '
        '-f')
    assert files.unwritten(OSError('odd'), 'choose -f') == 'a file cannot be written: odd. Choose -f'


def test_a_pipe_is_written_to(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    read = []
    reader = threading.Thread(target=lambda: read.append((tmp_path / 'pipe').read_bytes()), daemon=True)
    reader.start()
    files.write_whole(tmp_path / 'pipe', 'x')
    reader.join(10.0)
    assert read == [b'x']


def test_names_that_are_as_long_as_can_be(tmp_path):
    name = '\U0001f422' * 63  # 252 bytes
    files.write_whole(tmp_path / name, 'x')
    assert os.listdir(tmp_path) == [name]


def test_killed_while_writing_leaves_the_old_file(tmp_path):
    (tmp_path / 'a').write_text('old')
    program = ('import os, signal, sys\nfrom plain_support import files\n'
               'files.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n'
               'files.write_whole(sys.argv[1], "new")')
    ended = subprocess.run([sys.executable, '-c', program, str(tmp_path / 'a')], env=dict(
        os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(files.__file__))), timeout=30)
    assert ended.returncode == -signal.SIGKILL
    assert (tmp_path / 'a').read_text() == 'old'
