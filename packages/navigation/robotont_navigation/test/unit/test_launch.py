"""move_base.launch in a namespace, as public launch files include it: with the argument __ns."""
import pathlib

import pytest
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

LAUNCH_FILE = pathlib.Path(__file__).resolve().parents[2] / 'launch' / 'move_base.launch'


@pytest.mark.parametrize('namespace, prefix', [('', ''), ('robot1', 'robot1/'), ('/robot1/', 'robot1/')])
def test_the_frames_have_the_prefix_of_the_namespace(tmp_path, namespace, prefix):
    path = tmp_path / 'includes.launch'
    path.write_text(f'<launch><include file="{LAUNCH_FILE}"><arg name="__ns" value="{namespace}"/></include></launch>')
    config = ROSLaunchConfig()
    XmlLoader(resolve_anon=False).load(str(path), config, argv=[], verbose=False)
    frames = {name: config.params[f'/move_base/{name}'].value for name in (
        'global_costmap/global_frame', 'global_costmap/robot_base_frame', 'local_costmap/global_frame',
        'local_costmap/robot_base_frame')}
    assert list(frames.values()) == ['map', f'{prefix}base_footprint', f'{prefix}odom', f'{prefix}base_footprint']
