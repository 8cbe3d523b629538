"""On which systems ./run works: where apt offers the packages, whatever the system is called."""
import os
import shutil
import subprocess

import pytest

from unit_support import REPOSITORY

STEP = """repo=$0; . "$0/tools/workspace.bash"; ws=$1 log=$1/run.log ros_dir=
step 1 'Installing Debian packages' install_packages"""
CONTAINER = f'in the folder {REPOSITORY}: docker compose run --rm course ./run demo'
APT_CACHE = r"""shift; for name; do
case $name in
  %s) ;;
  %s) printf '%%s:\n  Installed: (none)\n  Candidate: (none)\n  Version table:\n' "$name" ;;
  *) printf '%%s:\n  Installed: (none)\n  Candidate: 1.17.0+ds-2\n  Version table:\n' "$name" ;;
esac; done"""


@pytest.fixture
def system(tmp_path):
    """Return a function that runs bash on a system whose apt does what its scripts {program: bash} say."""
    programs = tmp_path / 'bin'
    programs.mkdir()
    (tmp_path / 'ws').mkdir()

    def run(script, *arguments, **scripts):
        for name, text in {'sudo': 'shift; exec "$@"', 'dpkg_query': '', 'dpkg': '', **scripts}.items():
            path = programs / name.replace('_', '-')
            path.write_text(f'#!/bin/bash\n{text}\n')
            path.chmod(0o755)
        return subprocess.run(['bash', '-euc', script, *arguments], capture_output=True, text=True, check=False,
                              env={'PATH': f'{programs}:/usr/bin:/bin', 'HOME': str(tmp_path)})
    return run


@pytest.mark.parametrize('unknown, without_candidate, message', [
    ('ros-std-msgs', '-', 'apt does not offer ros-std-msgs.'),
    ('-', 'python3-rospy', 'apt does not offer python3-rospy.'),
    ('ros-std-msgs', 'python3-tf|catkin|rosbash', 'apt does not offer catkin python3-tf ros-std-msgs and 1 more'),
])
def test_a_system_is_refused_for_the_packages_that_apt_lacks(system, tmp_path, unknown, without_candidate, message):
    result = system(STEP, REPOSITORY, tmp_path / 'ws', apt_cache=APT_CACHE % (unknown, without_candidate),
                    apt_get='[[ $* != *install* ]] || touch "$HOME/installed"')
    assert result.returncode == 1
    assert message in result.stderr and CONTAINER in result.stderr
    assert not (tmp_path / 'installed').exists()


@pytest.mark.parametrize('lacking, wanted', [
    ('-', True),
    ('chromium', False),
    ('chromium|bash-completion', True),  # apt has no lists yet, which tells nothing
])
def test_optional_packages_are_wanted_where_apt_has_them(system, tmp_path, lacking, wanted):
    script = '. "$0/tools/workspace.bash"; optional_packages=(chromium); missing_packages'
    result = system(f'repo=$0; ws=$1 ros_dir=; {script}', REPOSITORY, tmp_path / 'ws',
                    apt_cache=APT_CACHE % (lacking, '-'))
    assert result.returncode == 0, result.stderr
    assert ('chromium' in result.stdout.split()) == wanted
    assert 'bash-completion' in result.stdout.split()


def test_a_system_is_taken_whose_apt_offers_all(system, tmp_path):
    result = system(STEP, REPOSITORY, tmp_path / 'ws', apt_cache=APT_CACHE % ('-', '-'), dpkg_query="""
[ ! -f "$HOME/installed" ] || printf 'installed %s\\n' "${@:3}" """, apt_get="""
[[ $* != *install* ]] || touch "$HOME/installed" """)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize('complaint, message', [
    ('The following packages have unmet dependencies:', 'packages.ros.org'),
    ('E: Could not resolve host', 'no network'),
])
def test_what_apt_complains_of_is_explained(system, tmp_path, complaint, message):
    result = system(STEP, REPOSITORY, tmp_path / 'ws', apt_cache=APT_CACHE % ('-', '-'),
                    apt_get=f'echo "{complaint}"; [[ $* != *install* ]]')
    assert result.returncode == 1 and message in result.stderr


def test_a_system_without_apt_gets_the_container_before_anything_is_installed(tmp_path):
    programs = tmp_path / 'bin'
    programs.mkdir()
    for name in os.listdir('/usr/bin'):
        if not name.startswith(('apt', 'dpkg')):
            (programs / name).symlink_to(f'/usr/bin/{name}')
    assert shutil.which('apt-get', path=str(programs)) is None
    result = subprocess.run([REPOSITORY / 'run', 'build'], capture_output=True, text=True, check=False,
                            env={'PATH': str(programs), 'HOME': str(tmp_path)})
    assert result.returncode == 1
    assert 'neither apt' in result.stderr and CONTAINER in result.stderr
    assert 'Installing' not in result.stderr
