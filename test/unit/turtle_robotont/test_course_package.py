"""The package's lists and texts agree with its files."""
import re
import xml.etree.ElementTree as ElementTree

import pytest

from turtle_robotont.driving import shapes
from turtle_robotont.driving.control import ENDED, State
from turtle_robotont.driving.vehicle import LIMITS
from unit_support import REPOSITORY


def launch_defaults(name):
    """Return {argument: default} of a launch file."""
    tree = ElementTree.parse(REPOSITORY / 'launch' / name)
    return {argument.get('name'): argument.get('default') for argument in tree.getroot().findall('arg')}


def test_every_script_is_installed():
    installed = re.findall(r'scripts/(\S+\.py)', (REPOSITORY / 'CMakeLists.txt').read_text())
    assert sorted(installed) == sorted(path.name for path in (REPOSITORY / 'scripts').glob('*.py'))


def test_states_are_the_constants_of_the_status_message():
    text = (REPOSITORY / 'msg' / 'DriveStatus.msg').read_text()
    constants = dict(re.findall(r'^uint8 (\w+) = (\d+)', text, re.MULTILINE))
    assert set(constants) == {state.name for state in State} and len(set(constants.values())) == len(State)
    assert all(f'{state.name} = ' in text for state in ENDED)


@pytest.mark.parametrize('launch, argument, value', [
    ('drive_shape.launch', 'corners', str(shapes.DEFAULT_CORNERS)),
    ('drive_shape.launch', 'size', str(shapes.DEFAULT_SIZE)),
    ('drive_shape.launch', 'turn_speed', str(LIMITS.turn_speed)),
    ('stop_at_x.launch', 'turn_speed', str(LIMITS.turn_speed)),
    ('services.launch', 'turn_speed', str(LIMITS.turn_speed)),
    ('services.launch', 'speed', str(LIMITS.speed)),
])
def test_launch_files_have_the_same_defaults_as_the_code(launch, argument, value):
    assert launch_defaults(launch)[argument] == value
