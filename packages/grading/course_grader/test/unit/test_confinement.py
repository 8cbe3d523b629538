"""Confinement: user ids that no program can take, and what a user has written anywhere."""
import os
import subprocess
import sys

import pytest

from course_grader.isolation import confinement, levels
from course_grader.isolation.confinement import User

needs_root = pytest.mark.skipif(os.geteuid() != 0, reason='only root can become another user')
RESERVE = ('import sys\nfrom course_grader.isolation import confinement\nconfinement.LOCKS = sys.argv[1:]\n'
           'print(confinement.User().number, flush=True)\nsys.stdin.read()')

MAKE_DEEP = """
import os
for _ in range(1500):
    os.mkdir('deep')
    os.chdir('deep')
open('file', 'wb').write(bytes(1 << 20))
"""


@pytest.fixture
def locks(tmp_path, monkeypatch):
    monkeypatch.setattr(confinement, 'LOCKS', (str(tmp_path / 'locks'),))
    return tmp_path / 'locks'


def test_each_grading_has_a_user_of_its_own_until_it_ends(locks, monkeypatch):
    monkeypatch.setattr(levels, 'USERS', range(60_706, 60_708))
    first, second = User(), User()
    assert {first.number, second.number} == {60_706, 60_707} and locks.stat().st_mode & 0o777 == 0o700
    with pytest.raises(OSError, match='no user id is free'):
        User()
    first.close()
    third = User()
    assert third.number == first.number
    second.close(), third.close()


def test_lock_holds_in_other_processes_and_ends_with_them(locks, monkeypatch):
    with subprocess.Popen([sys.executable, '-c', RESERVE, str(locks)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}) as other:
        number = int(other.stdout.readline())
        monkeypatch.setattr(levels, 'USERS', range(number, number + 1))
        with pytest.raises(OSError, match='no user id is free'):
            User()
        other.kill()
        other.wait()
    User().close()


def test_folder_that_others_can_write_to_is_not_used(tmp_path, monkeypatch):
    (tmp_path / 'open').mkdir(mode=0o777)
    (tmp_path / 'open').chmod(0o777)
    (tmp_path / 'link').symlink_to(tmp_path)
    monkeypatch.setattr(confinement, 'LOCKS', (str(tmp_path / 'open'), str(tmp_path / 'link'), str(tmp_path / 'own')))
    User().close()
    assert list((tmp_path / 'own').iterdir()) and not list((tmp_path / 'open').iterdir())
    monkeypatch.setattr(confinement, 'LOCKS', (str(tmp_path / 'open'),))
    with pytest.raises(OSError, match='no folder for the locks of user ids can be made'):
        User()


def test_user_ids_are_nobody_elses():
    """systemd.io/UIDS-GIDS: homes, containers and greeters end at 60705, dynamic users begin at 61184."""
    assert levels.USERS[0] > 60_705 and levels.USERS[-1] < 61_184


@needs_root
def test_files_of_a_user_are_counted_and_removed_wherever_they_are(tmp_path, monkeypatch):
    shared, private, own = tmp_path / 'shared', tmp_path / 'shared' / 'private', tmp_path / 'own'
    for folder, mode in ((shared, 0o1777), (private, 0o700), (own, 0o755)):
        folder.mkdir()
        folder.chmod(mode)
    monkeypatch.setattr(confinement, 'WRITABLE', (str(shared), str(tmp_path / 'none')))
    user = levels.USERS[-1]
    subprocess.run([sys.executable, '-c', MAKE_DEEP], cwd=shared, check=True)
    subprocess.run(['chown', '-R', f'{user}:{user}', 'deep'], cwd=shared, check=True)
    for path in (own / 'mine', shared / 'mine', shared / 'other'):
        path.write_bytes(os.urandom(1 << 20))
    for path in (own / 'mine', shared / 'mine'):
        os.chown(path, user, user)
    size = confinement.written(str(own), user)
    assert 3.0 <= size < 10.0 and confinement.written(str(own), None) >= 1.0  # with 1500 folders of 4 kB
    confinement.remove_written(str(own), user)
    assert sorted(path.name for path in (*own.iterdir(), *shared.iterdir())) == ['other', 'private']
    assert confinement.written(str(own), user) == 0.0
