"""The libraries without ROS as wheels: they install into a plain Python, and need neither ROS nor catkin there.

That of alvar_core is compiled, so that it is one for this Python and processor.
"""
import importlib.util
import os
import pathlib
import subprocess
import sys
import venv
import zipfile
from xml.etree import ElementTree

import pytest

from unit_support import REPOSITORY
from unit_support.cases import nightly

pytestmark = pytest.mark.slow
FOLDERS = {'plain_support': REPOSITORY / 'packages' / 'support' / 'plain_support',
           'kinematic_core': REPOSITORY / 'packages' / 'simulation' / 'kinematic_core',
           'alvar_core': REPOSITORY / 'packages' / 'vision' / 'alvar_core'}
NEEDED = ('numpy', 'cv2', 'psutil', 'yaml')  # required by the wheels; linked, because pip would have to download them
LIBRARIES = ('numpy.libs', 'opencv_python_headless.libs')
COMPILED = {'alvar_core': {'_native', '_native_avx2'}}  # the second one only on x86
TIMEOUT = 600.0  # [s], of a build on a machine that does other work, too


def run(*command, **more):
    result = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False, **more)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope='module')
def wheels(tmp_path_factory):
    """Return the wheels by the names of their packages."""
    folder = tmp_path_factory.mktemp('wheels')
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-build-isolation', '--no-deps', '--no-index', '-w', folder,
        *FOLDERS.values())
    return {path.name.partition('-')[0]: path for path in folder.iterdir()}


@pytest.fixture(scope='module')
def python(tmp_path_factory, wheels):
    """Return the Python of a fresh virtual environment with the wheels and their requirements."""
    folder = tmp_path_factory.mktemp('fresh') / 'venv'
    venv.create(folder)
    packages, = folder.glob('lib/python*/site-packages')
    run(sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--no-index', '--target', packages, *wheels.values())
    for name in NEEDED:
        source = pathlib.Path(importlib.util.find_spec(name).origin).parent
        (packages / name).symlink_to(source)
        for library in LIBRARIES:
            if (source.parent / library).exists() and not (packages / library).exists():
                (packages / library).symlink_to(source.parent / library)
    return folder / 'bin' / 'python3'


@pytest.mark.nightly
def test_wheels_hold_all_modules_and_the_version_of_the_package(wheels):
    assert set(wheels) == set(FOLDERS)
    for name, path in wheels.items():
        version = ElementTree.parse(FOLDERS[name] / 'package.xml').findtext('version')
        assert path.name.startswith(f'{name}-{version}-')
        assert path.name.endswith('-py3-none-any.whl') != (name in COMPILED)
        source = FOLDERS[name] / 'src'
        modules = {str(module.relative_to(source)) for kind in ('py', 'pyi') for module in source.rglob(f'*.{kind}')}
        inside = {each for each in zipfile.ZipFile(path).namelist() if '.dist-info/' not in each}
        compiled = {each for each in inside if each.endswith('.so')}
        assert modules | {f'{name}/py.typed'} == inside - compiled
        assert {each.partition('/')[2].partition('.')[0] for each in compiled} <= COMPILED.get(name, set())
        assert bool(compiled) == (name in COMPILED)


@pytest.mark.parametrize('name', ['plain_support', *nightly('kinematic_core', 'alvar_core')])
def test_setuptools_which_catkin_install_uses_reads_the_file(name):
    version = ElementTree.parse(FOLDERS[name] / 'package.xml').findtext('version')
    assert run(sys.executable, 'setup.py', '--version', cwd=FOLDERS[name]).split()[-1] == version


@pytest.mark.nightly
def test_every_module_imports_without_ros(python):
    modules = ['.'.join(path.relative_to(FOLDERS[name] / 'src').with_suffix('').parts)
               for name in FOLDERS for path in (FOLDERS[name] / 'src').rglob('[!_]*.py')]
    assert len(modules) > 30
    program = ('import importlib, importlib.util, sys\n'
               'for name in sys.argv[1:]: importlib.import_module(name)\n'
               'print([name for name in ("rospy", "catkin_pkg", "genpy") if importlib.util.find_spec(name)])\n'
               'print(importlib.import_module(sys.argv[1]).__file__)')
    found, file = run(python, '-c', program, *modules, env={'PATH': os.defpath}).splitlines()
    assert found == '[]' and file.startswith(str(python.parents[1]))
