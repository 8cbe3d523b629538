"""Renders the marker sequence into a given folder, or once into a cache. Does not use ROS.

The cache is in ROS_HOME (~/.ros), as other files of ROS, with one folder per version of the sequence. A launch file
calls this before the camera's node starts.
"""
import argparse
import os
import shutil
import sys
import tempfile
from typing import Optional, Sequence

from alvar_core.pictures import marker_sequence
from plain_support import unwritten


def cached(ros_home: str) -> str:
    """Return the folder with the sequence below ``ros_home``; render the sequence first if needed. Raises OSError."""
    parent = os.path.join(ros_home, 'turtle_robotont')
    folder = os.path.join(parent, f'marker_sequence_{marker_sequence.VERSION}')
    if os.path.exists(folder):
        return folder
    os.makedirs(parent, exist_ok=True)
    new = tempfile.mkdtemp(prefix='marker_sequence_', dir=parent)
    try:
        marker_sequence.render_to(new)
        os.chmod(new, 0o755)
        os.rename(new, folder)  # appears complete or not at all
    except OSError:
        if not os.path.exists(folder):  # if it does, another launch file was faster
            raise
    finally:
        shutil.rmtree(new, ignore_errors=True)
    return folder


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Render the images; print the folder, without a newline for launch files, or exit with 1 and the reason."""
    parser = argparse.ArgumentParser(prog='marker_sequence.py', description=__doc__.split('\n')[0])
    parser.add_argument('--output', metavar='DIR', help='folder for the images (default: rendered once, in ROS_HOME)')
    options = parser.parse_args(arguments)
    try:
        if options.output:
            folder = os.path.abspath(options.output)
            os.makedirs(folder, exist_ok=True)
            others = marker_sequence.others_of(folder)
            if others:
                sys.exit(f'marker_sequence.py: {folder} has files that would be replaced, such as {others[-1]}. Choose '
                         'another folder with --output')
            marker_sequence.render_to(folder)
        else:
            folder = cached(os.environ.get('ROS_HOME') or os.path.expanduser('~/.ros'))
    except OSError as error:
        sys.exit(f'marker_sequence.py: {unwritten(error, "choose another folder with --output")}')
    print(folder, end='', flush=True)
