"""./run link: linking packages into a catkin workspace of the user; skipped packages; refused folders."""
import os
import re
import shutil
import subprocess
import venv

import pytest

from unit_support import REPOSITORY
from unit_support.cases import nightly

pytestmark = pytest.mark.slow
ALL_PACKAGES = {path.parent.name: path.parent for pattern in ('packages/**/package.xml', 'test/*/package.xml')
                for path in REPOSITORY.glob(pattern)}
ROS = next((folder for folder in (os.environ.get('TURTLE_ROBOTONT_ROS'), '/opt/ros/noetic', '/opt/ros/one')
            if folder and os.path.isfile(f'{folder}/setup.bash')), None)  # what ./run finds beside Debian's
INSTALLED = {name for name in ALL_PACKAGES if os.path.isfile(f'{ROS or "/usr"}/share/{name}/package.xml')}
LEFT_OUT = INSTALLED - (set() if ROS else {'cv_bridge'})  # libcv-bridge-dev has no Python part
PACKAGES = {name: path for name, path in ALL_PACKAGES.items() if name not in LEFT_OUT}


@pytest.fixture
def src(tmp_path):
    folder = tmp_path / 'catkin_ws' / 'src'
    folder.mkdir(parents=True)
    return folder


def link(folder):
    """Return (exit code, output) of ./run link."""
    result = subprocess.run([REPOSITORY / 'run', 'link', folder], capture_output=True, text=True, check=False)
    return result.returncode, result.stderr


def left_out(output):
    return set(re.findall('Left out: the stand-in ([a-z0-9_]+),', output))


def links_of(src):
    return {path.name: path.resolve() for path in src.iterdir() if path.is_symlink()}


@pytest.mark.parametrize('inner', ['', 'src'])
def test_every_package_is_linked_once_however_often(src, inner):
    for _ in range(2):
        code, output = link(src.parent / inner)
        assert code == 0, output
    assert links_of(src) == {**PACKAGES, 'turtle_robotont': REPOSITORY}, f'installed are {INSTALLED}'
    assert left_out(output) == LEFT_OUT and f'plain_support {PACKAGES["plain_support"]}' in output
    assert output.endswith(f'Build it: cd {src.parent} && catkin_make\n')
    lacks_opencv = bool(subprocess.run(['/usr/bin/python3', '-c', 'import cv2'], capture_output=True,
                                       check=False).returncode)
    line = re.search(r'\n  sudo apt-get install --no-install-recommends (.*)\n', output)
    assert bool(line and 'python3-opencv' in line[1].split()) == lacks_opencv


@pytest.mark.parametrize('place', ['turtlesim', 'ros_tutorials/turtlesim'])
def test_a_package_of_the_users_own_stays_and_wins(src, place):
    (src / place).mkdir(parents=True)
    (src / place / 'package.xml').write_text('<package><name>turtlesim</name></package>')
    code, output = link(src.parent)
    assert code == 0 and 'Left out: the stand-in turtlesim' in output
    assert set(links_of(src)) == {*PACKAGES, 'turtle_robotont'} - {'turtlesim'}


def test_links_of_the_users_own_stay(src, tmp_path):
    (src / 'elsewhere').symlink_to(tmp_path / 'unplugged')
    (src / 'CMakeLists.txt').symlink_to(tmp_path / 'toplevel.cmake')
    assert link(src.parent)[0] == 0
    assert {'elsewhere', 'CMakeLists.txt'} < set(links_of(src))


@pytest.mark.parametrize('folder, message', [
    ('{tmp}/nowhere', 'mkdir -p {tmp}/nowhere/src'), (str(REPOSITORY / 'test'), 'is not a catkin workspace')])
def test_other_folders_are_refused(tmp_path, folder, message):
    code, text = link(folder.format(tmp=tmp_path))
    assert code == 1 and message.format(tmp=tmp_path) in text


@pytest.fixture
def clone(src, request):
    """Return a clone of what ./run link needs, in a catkin workspace itself."""
    folder = src / request.param
    shutil.copytree(REPOSITORY / 'tools', folder / 'tools')
    for path in (REPOSITORY / 'run', *(folder / 'package.xml' for folder in (REPOSITORY, *ALL_PACKAGES.values()))):
        copied = folder / path.relative_to(REPOSITORY)
        copied.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copied)
    return folder


@pytest.mark.parametrize('clone', [
    'github/turtle_robotont', *nightly('turtle_robotont', 'my_course')], indirect=True)
def test_a_clone_in_the_workspace_itself_gets_all_other_packages_beside_it(src, clone):
    for _ in range(2):
        done = subprocess.run([clone / 'run', 'link', src.parent], capture_output=True, text=True, check=False)
        assert done.returncode == 0 and left_out(done.stderr) == LEFT_OUT, done.stderr
        assert links_of(src) == {name: clone / path.relative_to(REPOSITORY) for name, path in PACKAGES.items()}
        assert links_of(clone) == {}
    assert f'turtle_robotont {clone}\n' in done.stderr


def test_another_clone_in_the_workspace_stays_as_it_is(src):
    (src / 'turtle_robotont').mkdir()
    (src / 'turtle_robotont' / 'package.xml').write_text('<package><name>turtle_robotont</name></package>')
    code, output = link(src.parent)
    assert code == 0 and 'turtle_robotont is your own package' in output
    assert links_of(src / 'turtle_robotont') == {} and set(links_of(src)) == set(PACKAGES)


def test_a_workspace_inside_the_repository_is_refused():
    code, text = link(REPOSITORY)
    assert code == 1 and 'inside the repository' in text


BUILD_TIMEOUT = 100.0  # [s]; it takes 5
NODE = 'robotont_urdf'  # a program of a package without messages, whose build takes long
ENVIRONMENT = {'PATH': os.defpath, 'HOME': os.environ.get('HOME', '/'), 'LANG': 'C.UTF-8'}


@pytest.fixture(scope='module')
def built(tmp_path_factory):
    """Return a workspace of the user's own with a few packages, installed, and the folder of its Python."""
    workspace = tmp_path_factory.mktemp('own') / 'catkin_ws'
    (workspace / 'src').mkdir(parents=True)
    assert link(workspace)[0] == 0
    for path in (workspace / 'src').iterdir():
        if path.name not in ('plain_support', 'robotont_description', 'rospy_support'):
            path.unlink()
    programs = workspace.parent / 'ros_venv' / 'bin'
    venv.EnvBuilder(system_site_packages=True, symlinks=True).create(programs.parent)
    python = [f'-D{name}_EXECUTABLE={programs / "python3"}' for name in ('PYTHON', 'Python')]
    result = subprocess.run(['catkin_make', 'install', *python], cwd=workspace,
                            env=ENVIRONMENT, capture_output=True, text=True, timeout=BUILD_TIMEOUT, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return workspace, programs


@pytest.mark.nightly
@pytest.mark.parametrize('space', ['devel', 'install'])
@pytest.mark.parametrize('first', ['', 'conda/bin:'])
def test_setup_puts_the_python_of_the_nodes_first(built, tmp_path, space, first):
    workspace, programs = built
    (tmp_path / 'conda' / 'bin').mkdir(parents=True)
    (tmp_path / 'conda' / 'bin' / 'python3').symlink_to('/bin/false')
    path = first and f'{tmp_path}/{first}'
    node, setup = workspace / space / 'lib' / 'robotont_description' / NODE, workspace / space / 'setup.sh'
    result = subprocess.run(['sh', '-c', f'. {setup} && . {setup} && echo "$PATH" && {node} --help'], text=True,
                            env={**ENVIRONMENT, 'PATH': path + os.defpath}, capture_output=True, check=False)
    assert result.returncode == 0, result.stderr
    folders = result.stdout.splitlines()[0].split(':')
    assert folders[0] == str(programs) and folders.count(str(programs)) == 1
    assert 'usage' in result.stdout
