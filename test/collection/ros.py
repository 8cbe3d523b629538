"""Which packages of this repository are usable here, and why a test cannot run."""
import os
import shutil
from functools import lru_cache
from importlib import util
from pathlib import Path

from collection import kinds

MODULES = ('actionlib', 'actionlib_msgs', 'diagnostic_msgs', 'dynamic_reconfigure', 'genmsg', 'genpy', 'geometry_msgs',
           'message_filters', 'nav_msgs', 'rosgraph', 'rosgraph_msgs', 'roslaunch', 'roslib', 'rosmaster', 'rosnode',
           'rospkg', 'rospy', 'rosservice', 'rostest', 'rostopic', 'rosunit', 'sensor_msgs', 'std_msgs', 'std_srvs',
           'tf', 'tf2_msgs', 'tf2_ros', 'tf2_py', 'visualization_msgs')


@lru_cache(maxsize=None)
def workspace_packages():
    """Return {name: folder} of the packages that ROS finds; empty where no workspace is sourced."""
    if not os.environ.get('ROS_PACKAGE_PATH') or not shutil.which('rostest') or not util.find_spec('rospkg'):
        return {}
    import rospkg
    found = rospkg.RosPack()
    packages = {name: Path(found.get_path(name)).resolve() for name in found.list()}
    return packages if kinds.REPOSITORY in packages.values() else {}


def run_workspace():
    """Return the folder of the workspace of ./run that is used here, or None."""
    folder = Path(os.environ.get('VIRTUAL_ENV', '/')).parent
    return folder if (folder / '.checkout').is_file() else None


@lru_cache(maxsize=None)
def package_of(folder):
    """Return the folder of the package that a folder of this repository lies in."""
    return next((parent for parent in (folder, *folder.parents) if (parent / 'package.xml').is_file()), folder)


def missing(path):
    """Return why the tests of a file cannot run here; an empty text if they can."""
    packages, package = workspace_packages(), package_of(path.parent)
    if not packages:
        return '' if kinds.kind_of(path) in kinds.COMPUTING else 'no workspace with this repository is sourced'
    if package.name in packages and packages[package.name] != package and package != kinds.REPOSITORY:
        return f'the package {package.name} is used from {packages[package.name]}, so this stand-in is not tested'
    if package not in packages.values() and package != kinds.REPOSITORY:
        return f'the package {package.name} is not in this workspace: ./run link FOLDER links it'
    return ''
