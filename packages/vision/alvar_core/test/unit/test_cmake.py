"""The compiled module is configured where catkin has looked for Python's interpreter alone, as on Debian 13."""
import pathlib
import shutil
import subprocess

import pytest

pytestmark = pytest.mark.slow

PACKAGE = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.nightly
@pytest.mark.skipif(not shutil.which('cmake'), reason='cmake is not installed')
def test_pybind11_finds_the_rest_of_python(tmp_path):
    before = tmp_path / 'catkin.cmake'
    before.write_text('find_package(Python REQUIRED COMPONENTS Interpreter)\n')
    done = subprocess.run(['cmake', '-S', PACKAGE, '-B', tmp_path / 'build', '-DSKBUILD=ON',
                           f'-DCMAKE_PROJECT_INCLUDE={before}', '-DPython_EXECUTABLE=/usr/bin/python3'],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
