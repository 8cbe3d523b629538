"""The launch files of robotont_gazebo: their common parts are the same."""
import xml.etree.ElementTree as ElementTree

import pytest

from unit_support.packages import PACKAGES

LAUNCH = PACKAGES['robotont_gazebo'].folder / 'launch'
VARYING = {'world', 'x_pos'}  # arguments whose defaults depend on the world


def arguments(path):
    """Return {name: (default, doc)} of the arguments that a launch file takes."""
    return {argument.get('name'): (argument.get('default'), argument.get('doc'))
            for argument in ElementTree.parse(path).getroot().findall('arg') if argument.get('value') is None}


@pytest.mark.parametrize('path', sorted(LAUNCH.glob('world_*.launch')), ids=lambda path: path.stem)
def test_world_takes_the_arguments_of_gazebo_launch(path):
    common, here = arguments(LAUNCH / 'gazebo.launch'), arguments(path)
    assert set(here) == set(common)
    assert {name: here[name] for name in set(here) - VARYING} == {name: common[name] for name in set(common) - VARYING}
    assert here['world'][0] == path.stem[len('world_'):]
    assert {name: here[name][1] for name in VARYING} == {name: common[name][1] for name in VARYING}
