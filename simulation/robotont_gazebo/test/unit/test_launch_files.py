"""The launch files of robotont_gazebo: what they have in common is the same in all of them."""
import pathlib
import xml.etree.ElementTree as ElementTree

import pytest

LAUNCH = pathlib.Path(__file__).resolve().parents[4] / 'simulation' / 'robotont_gazebo' / 'launch'
OWN = {'world', 'x_pos'}  # arguments whose defaults are a world's own


def arguments(path):
    """Return {name: (default, doc)} of the arguments that a launch file takes."""
    return {argument.get('name'): (argument.get('default'), argument.get('doc'))
            for argument in ElementTree.parse(path).getroot().findall('arg') if argument.get('value') is None}


@pytest.mark.parametrize('path', sorted(LAUNCH.glob('world_*.launch')), ids=lambda path: path.stem)
def test_world_takes_the_arguments_of_gazebo_launch(path):
    common, here = arguments(LAUNCH / 'gazebo.launch'), arguments(path)
    assert set(here) == set(common)
    assert {name: here[name] for name in set(here) - OWN} == {name: common[name] for name in set(common) - OWN}
    assert here['world'][0] == path.stem[len('world_'):]
    assert {name: here[name][1] for name in OWN} == {name: common[name][1] for name in OWN}
