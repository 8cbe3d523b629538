"""plain_support runs with plain python3: no ROS, no site-packages. Only ``documents`` and ``course`` take yaml,
``processes`` psutil, ``arrays`` and ``rotations`` numpy."""
import pathlib
import shutil
import subprocess

import pytest

from plain_support import files

pytestmark = pytest.mark.slow

SOURCE = pathlib.Path(files.__file__).resolve().parents[1]
PYTHON = '/usr/bin/python3' if shutil.which('/usr/bin/python3') else shutil.which('python3')
WITH_MORE = {'plain_support.arrays', 'plain_support.course', 'plain_support.documents', 'plain_support.processes',
             'plain_support.rotations'}
MODULES = {'.'.join(path.relative_to(SOURCE).with_suffix('').parts) for path in SOURCE.rglob('[!_]*.py')} - WITH_MORE
TIMEOUT = 20.0  # [s]
PROGRAM = '''
import sys
sys.path = [{source!r}] + [path for path in sys.path if 'packages' not in path]
import {module}
print(*sorted(set(sys.modules) & {{'numpy', 'psutil', 'rospy', 'site', 'yaml'}}))
'''


@pytest.mark.parametrize('module', sorted(MODULES))
def test_module_needs_nothing_but_the_standard_library(module):
    result = subprocess.run([PYTHON, '-I', '-S', '-c', PROGRAM.format(source=str(SOURCE), module=module)],
                            capture_output=True, text=True, timeout=TIMEOUT, env={}, check=False)
    assert (result.returncode, result.stdout.strip()) == (0, ''), result.stderr
