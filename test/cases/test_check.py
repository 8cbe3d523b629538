"""Tools that read the code: ruff, catkin_lint, and mypy with the settings of mypy.ini."""
import os
import shutil
import sys

import pytest

from collection import ros
from collection.kinds import REPOSITORY
from unit_support.packages import PACKAGES

numpy = pytest.importorskip('numpy')

pytestmark = [pytest.mark.check, pytest.mark.timeout(600)]

ROOMS = sorted({package.room for package in PACKAGES.values() if package.room})
COMPLETE_TYPES = 2, 3  # the version of numpy; the types of earlier ones, as in Debian 13, are incomplete
NUMPY_TYPES = 'numpy==2.4.*'


@pytest.fixture(name='cache')
def _cache(tmp_path):
    """A folder that lasts as long as the workspace, if there is one."""
    return ros.run_workspace() or tmp_path


def _require(program):
    if not shutil.which(program):
        pytest.skip(f'{program} is not installed')


@pytest.mark.parametrize('_name', ['check/ruff'])
def test_style(_name, run_case, cache):
    _require('ruff')
    run_case('ruff', 'check', '--output-format', 'concise', '--cache-dir', cache / 'ruff_cache', REPOSITORY)


@pytest.mark.parametrize('room', ['.', *ROOMS], ids=lambda room: f'check/catkin_lint/{room}')
def test_packages(room, run_case):
    _require('catkin_lint')
    # The root package holds the stand-ins' scripts too, which the stand-ins install themselves.
    more = ['--ignore', 'uninstalled_script'] if room == '.' else []
    folders = [REPOSITORY] if room == '.' else [package.folder for package in PACKAGES.values() if package.room == room]
    run_case('catkin_lint', '-q', '-W1', '--strict', *more, *folders)


@pytest.mark.timeout(3600)  # half a minute of processor time without a cache, which at a load of 78 took over 600 s
@pytest.mark.parametrize('_name', ['check/mypy'])
def test_types(_name, run_case, cache, monkeypatch):
    _require('mypy')
    if tuple(map(int, numpy.__version__.split('.')[:2])) < COMPLETE_TYPES:
        types = cache / 'numpy_types'  # beside the installed numpy, for mypy alone to read
        if not types.is_dir():
            run_case(sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--target', types, NUMPY_TYPES)
        monkeypatch.setenv('PYTHONPATH', f'{types}:{os.environ.get("PYTHONPATH", "")}')
    monkeypatch.setenv('MYPYPATH', ':'.join(str(package.folder / 'src') for package in PACKAGES.values()))
    monkeypatch.chdir(REPOSITORY)
    run_case('mypy', '--cache-dir', cache / 'mypy_cache')
