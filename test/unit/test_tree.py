"""tools/tree, which runs README's two commands on a bare Debian: its arguments, and what it refuses."""
import fcntl
import os
import shutil
import subprocess

import pytest

from unit_support import REPOSITORY

needs_root = pytest.mark.skipif(os.geteuid() != 0 or not shutil.which('dpkg'), reason='only root of a Debian makes one')


@pytest.fixture
def tree(tmp_path):
    """Return a function that calls tools/tree with a debootstrap that fails: (exit code, output)."""
    programs = tmp_path / 'programs'
    programs.mkdir()
    (programs / 'debootstrap').write_text('#!/bin/sh\necho "E: no network: $*"\nexit 1\n')
    (programs / 'debootstrap').chmod(0o755)

    def call(*arguments):
        environment = {
            'PATH': f'{programs}:/usr/sbin:/usr/bin:/bin', 'HOME': str(tmp_path),
            'TURTLE_ROBOTONT_TREES': str(tmp_path / 'trees'), 'TURTLE_ROBOTONT_MIRROR': 'http://localhost/debian'}
        done = subprocess.run([REPOSITORY / 'tools' / 'tree', *arguments], env=environment, capture_output=True,
                              text=True, check=False)
        return done.returncode, done.stdout + done.stderr
    return call


@pytest.mark.parametrize('arguments, code, message', [
    (['--help'], 0, 'usage: tools/tree'), ([], 2, 'usage: tools/tree'), (['--fly', 'trixie'], 1, "no option '--fly'"),
    (['../trixie'], 1, "'../trixie' is no suite of Debian"), (['trixie', 'sid'], 1, "not 'trixie' and 'sid'"),
    (['trixie', '--umask', '9'], 1, '--umask 9 is no umask'), (['trixie', '--umask'], 1, '--umask needs a value'),
    (['trixie', '--with'], 1, '--with needs a value'), (['trixie', '--'], 1, 'there is no command after --'),
    (['--remove'], 2, 'usage: tools/tree')])
def test_arguments(tree, tmp_path, arguments, code, message):
    got, output = tree(*arguments)
    assert (got, message in output) == (code, True), output
    assert not (tmp_path / 'trees').exists()


@pytest.mark.skipif(os.geteuid() == 0, reason='root may')
def test_only_root_makes_a_system(tree):
    code, output = tree('trixie')
    assert code == 1 and 'Type: sudo tools/tree trixie' in output


@needs_root
def test_a_system_that_cannot_be_made_is_not_taken_for_one(tree, tmp_path):
    for _ in range(2):
        code, output = tree('trixie', '--user', '--with', 'nginx less')
        log, = (tmp_path / 'trees').glob('trixie-*-user.log')
        assert code == 1 and f'debootstrap failed; {log} has its output' in output
        assert 'E: no network' in log.read_text() and 'http://localhost/debian' in log.read_text()
        assert not [*(tmp_path / 'trees').glob('*.tar*')]


@needs_root
def test_two_do_not_run_in_one_system(tree, tmp_path):
    tree('trixie')
    lock, = (tmp_path / 'trees').glob('trixie-*-root.lock')
    with lock.open('a') as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        for more in ([], ['--remove']):
            code, output = tree('trixie', *more)
            assert code == 1 and 'another tools/tree runs in' in output
        assert 'debootstrap failed' in tree('trixie', '--user')[1]
    assert tree('trixie', '--remove')[0] == 0
    assert [path.name for path in (tmp_path / 'trees').glob('trixie-*-root*')] == []
