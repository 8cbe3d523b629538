"""The command line of gzserver, and the folders of worlds and models."""
from __future__ import annotations

import argparse
import os
import re
from typing import Sequence

import rospkg

EXPORT = re.compile(r'gazebo_model_path\s*=\s*"([^"]*)"')
WORLDS = 'GAZEBO_RESOURCE_PATH'
DEFAULT_WORLD = 'worlds/empty.world'


def read(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options ``world`` and ``paused``; those of Gazebo that have no effect here are accepted."""
    parser = argparse.ArgumentParser(prog='gzserver', description='The simulator behind the names of Gazebo.')
    parser.add_argument('world', nargs='?', default=DEFAULT_WORLD, help='a .world, .sdf or .yaml file, or a name')
    parser.add_argument('-u', '--pause', dest='paused', action='store_true', help='start paused')
    parser.add_argument('-v', '--version', action='version', version='gzserver of turtle_robotont')
    for names in (('-e', '--physics'), ('-s', '--server-plugin'), ('-o', '--profile'), ('--seed',), ('--iters',),
                  ('--record_path',), ('--record_encoding',), ('-g', '--gui-plugin')):
        parser.add_argument(*names, action='append', help=argparse.SUPPRESS)
    for names in (('-r', '--record'), ('--verbose',), ('-q', '--quiet'), ('--minimal_comms',), ('--lockstep',)):
        parser.add_argument(*names, action='store_true', help=argparse.SUPPRESS)
    options, _ = parser.parse_known_args(arguments)
    return options


def world_folders() -> list[str]:
    """Return the folders in which worlds are searched by name: Gazebo's own, then those of the simulators here."""
    packages = rospkg.RosPack()
    own = [os.path.join(packages.get_path(name), 'worlds') for name in ('gazebo_ros', 'robotont_gazebo')]
    return [*_entries(WORLDS), *own]


def model_folders() -> list[str]:
    """Return the folders in which models are searched: those that packages export to gazebo_ros, and Gazebo's own."""
    packages = rospkg.RosPack()
    folders: list[str] = []
    for name in packages.list():
        path = packages.get_path(name)
        for exported in EXPORT.findall(_manifest(path)):
            folders += [entry.replace('${prefix}', path) for entry in exported.split(':') if entry]
    return [*folders, os.path.expanduser('~/.gazebo/models')]


def _manifest(folder: str) -> str:
    """Return the text of the package.xml in a folder, '' if there is none: old packages have a manifest.xml."""
    try:
        with open(os.path.join(folder, 'package.xml'), encoding='utf-8', errors='replace') as file:
            return file.read()
    except OSError:
        return ''


def _entries(variable: str) -> list[str]:
    return [entry for entry in os.environ.get(variable, '').split(':') if entry]
