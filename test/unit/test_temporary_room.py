"""./run where the temporary folder has no room: what needs one gets it in the workspace, and that is said."""
import subprocess

import pytest

from unit_support import REPOSITORY

SCRIPT = '. "$0/tools/environment.bash"; ws=$1; find_temporary_room; echo "$TMPDIR"'


def room(workspace, tmpdir, before=''):
    """Return (TMPDIR afterwards, output)."""
    result = subprocess.run(['bash', '-euc', before + SCRIPT, REPOSITORY, workspace], capture_output=True, text=True,
                            check=True, env={'PATH': '/usr/bin:/bin', 'TMPDIR': str(tmpdir)})
    return result.stdout.strip(), result.stderr


def test_a_folder_with_room_is_used_and_left_empty(tmp_path):
    (tmp_path / 'usual').mkdir()
    assert room(tmp_path / 'ws', tmp_path / 'usual') == (str(tmp_path / 'usual'), '')
    assert list((tmp_path / 'usual').iterdir()) == []
    assert not (tmp_path / 'ws').exists()


@pytest.mark.parametrize('tmpdir, before', [('missing', ''), ('file', ''), ('full', 'ulimit -f 16; ')])
def test_without_room_the_workspace_is_used(tmp_path, tmpdir, before):
    (tmp_path / 'file').write_text('')
    (tmp_path / 'full').mkdir()  # a limit of 16 KB for a file stands for a full disk
    used, message = room(tmp_path / 'ws', tmp_path / tmpdir, before)
    assert used == str(tmp_path / 'ws' / 'tmp') and (tmp_path / 'ws' / 'tmp').is_dir()
    assert str(tmp_path / tmpdir) in message and used in message
    assert list((tmp_path / 'full').iterdir()) == []
