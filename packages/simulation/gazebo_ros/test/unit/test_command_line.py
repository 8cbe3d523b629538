"""gazebo_ros.command_line: Gazebo's options, and the folders that packages export."""
import os

import pytest

from gazebo_ros import command_line

EXPORT = '<package><export><gazebo_ros gazebo_model_path="${prefix}/models:${prefix}/more"/></export></package>'


@pytest.mark.parametrize('arguments, world, paused', [
    ([], 'worlds/empty.world', False), (['-u', '-e', 'ode', 'a.world'], 'a.world', True),
    (['--verbose', '-s', 'libplugin.so', '/b/c.world'], '/b/c.world', False),
    (['-r', 'a.world', '--unknown'], 'a.world', False),
])
def test_options_of_gazebo_are_accepted(arguments, world, paused):
    options = command_line.read(arguments)
    assert (options.world, options.paused) == (world, paused)


def test_models_are_searched_where_packages_export_them(tmp_path, monkeypatch):
    """The second package has a manifest.xml, as those of rosbuild."""
    for name in ('new', 'old'):
        (tmp_path / name).mkdir()
    (tmp_path / 'new' / 'package.xml').write_text(EXPORT)

    class RosPack:
        def list(self):
            return ['new', 'old']

        def get_path(self, name):
            return str(tmp_path / name)
    monkeypatch.setattr(command_line.rospkg, 'RosPack', RosPack)
    own = os.path.expanduser('~/.gazebo/models')
    assert command_line.model_folders() == [f'{tmp_path}/new/models', f'{tmp_path}/new/more', own]
