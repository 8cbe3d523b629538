"""kinematic_core runs with plain python3: no ROS, no site-packages; rays, camera and sectors take numpy, a map
OpenCV."""
import shutil
import subprocess

import pytest

from unit_support.packages import PACKAGES

CORE, SUPPORT = (PACKAGES[name].folder / 'src' for name in ('kinematic_core', 'plain_support'))
PYTHON = '/usr/bin/python3' if shutil.which('/usr/bin/python3') else shutil.which('python3')
WITH_MORE = {'camera', 'overhead', 'rays', 'sectors'}
MODULES = sorted('.'.join(path.relative_to(CORE).with_suffix('').parts) for path in CORE.rglob('[!_]*.py')
                 if path.stem not in WITH_MORE)
TIMEOUT = 20.0  # [s]
PROGRAM = '''
import sys
sys.path = [{core!r}, {support!r}] + [path for path in sys.path if 'packages' not in path]
import {module}
from kinematic_core.worlds.turtle_world import TurtleWorld
world = TurtleWorld()
world.command('turtle1', 1.0, 0.0, 0.0)
world.step()
print(world.turtles['turtle1'].pose().x, *sorted(set(sys.modules) & {{'numpy', 'rospy', 'site', 'genpy'}}))
'''


@pytest.mark.parametrize('module', MODULES)
def test_module_needs_nothing_but_the_standard_library(module):
    program = PROGRAM.format(core=str(CORE), support=str(SUPPORT), module=module)
    result = subprocess.run([PYTHON, '-I', '-S', '-c', program],
                            capture_output=True, text=True, timeout=TIMEOUT, env={}, check=False)
    assert result.returncode == 0, result.stderr
    # one step of 0.016 s at 1 m/s from the middle, float32(499 / 45) / 2; and none of the modules asked for
    x, *loaded = result.stdout.split()
    assert float(x) == pytest.approx(499.0 / 45.0 / 2.0 + 0.016, abs=1e-6)  # [m] float32 of the arena's size
    assert loaded == []
