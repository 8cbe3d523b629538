"""Which packages of this repository are usable here, and why a test cannot run."""
import os
import shutil
import subprocess
from functools import lru_cache
from importlib import util
from pathlib import Path

from collection import kinds


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


def answer_rosversion(folder):
    """Put a script into a folder of PATH that answers as rosversion answers now.

    Each rostest and each check of a launch file asks it twice, and waits for Python to start.
    """
    lines = ['#!/bin/sh', 'case "$*" in']
    for question in '-d', 'roslaunch':
        done = subprocess.run(['rosversion', question], stdout=subprocess.PIPE, text=True, check=True)
        lines.append(f"{question}) echo '{done.stdout.strip()}' ;;")
    lines.append(f'*) exec {shutil.which("rosversion")} "$@" ;;\nesac\n')
    folder.mkdir(exist_ok=True)
    written = folder / f'rosversion.{os.getpid()}'  # two runs may do this at once
    written.write_text('\n'.join(lines), encoding='utf-8')
    written.chmod(0o755)
    written.replace(folder / 'rosversion')
    os.environ['PATH'] = f'{folder}{os.pathsep}{os.environ["PATH"]}'


@lru_cache(maxsize=None)
def package_of(folder):
    """Return the folder of the package that a folder of this repository lies in."""
    return next((parent for parent in (folder, *folder.parents) if (parent / 'package.xml').is_file()), folder)


def missing(path, needs_ros):
    """Return why the tests of a file cannot run here; an empty text if they can."""
    packages, package = workspace_packages(), package_of(path.parent)
    if not packages:
        return 'no workspace with this repository is sourced' if needs_ros else ''
    if package.name in packages and packages[package.name] != package and package != kinds.REPOSITORY:
        return f'the package {package.name} is used from {packages[package.name]}, so this stand-in is not tested'
    if package not in packages.values() and package != kinds.REPOSITORY:
        return f'the package {package.name} is not in this workspace: ./run link FOLDER links it'
    return ''
