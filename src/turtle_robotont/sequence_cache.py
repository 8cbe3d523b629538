"""The marker sequence as a command: into a folder that is asked for, or once and for all into a cache. ROS-free.

The cache lies in ROS_HOME (~/.ros), as ROS's other files do, in a folder of its own for each version of the sequence.
A launch file asks for it before the camera's node starts.
"""
import argparse
import hashlib
import os
import shutil
import sys
import tempfile

from alvar_core import camera, code, drawing, rotations
from turtle_robotont import marker_sequence


def cached(ros_home):
    """Return the folder with the sequence below ``ros_home``, rendering it if it is not there; raise OSError."""
    version = hashlib.sha256()
    for module in (marker_sequence, drawing, rotations, code, camera):
        with open(module.__file__, 'rb') as file:
            version.update(file.read())
    parent = os.path.join(ros_home, 'turtle_robotont')
    folder = os.path.join(parent, f'marker_sequence_{version.hexdigest()[:12]}')
    if os.path.exists(folder):
        return folder
    os.makedirs(parent, exist_ok=True)
    new = tempfile.mkdtemp(prefix='marker_sequence_', dir=parent)
    try:
        marker_sequence.render_to(new)
        os.chmod(new, 0o755)
        os.rename(new, folder)  # whole or not at all
    except OSError:
        if not os.path.exists(folder):  # otherwise another launch file was faster
            raise
    finally:
        shutil.rmtree(new, ignore_errors=True)
    return folder


def main(arguments=None):
    """Render, print the folder without an end of line, as a launch file takes it; exit 1 with the reason if not."""
    parser = argparse.ArgumentParser(prog='marker_sequence.py', description=__doc__.split('\n')[0])
    parser.add_argument('--output', metavar='DIR', help='render into this folder (default: once into ROS_HOME)')
    options = parser.parse_args(arguments)
    try:
        if options.output:
            folder = os.path.abspath(options.output)
            os.makedirs(folder, exist_ok=True)
            marker_sequence.render_to(folder)
        else:
            folder = cached(os.environ.get('ROS_HOME') or os.path.expanduser('~/.ros'))
    except OSError as error:
        sys.exit(f'marker_sequence.py: the pictures could not be written: {error}')
    print(folder, end='', flush=True)
