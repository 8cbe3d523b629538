"""Python runs this when it starts in a workspace with rospy_support: rospy is repaired wherever it is imported.

rospy_repair.py says what is repaired and why. It has to reach students' programs, which import nothing of ours and may
start with ``#!/usr/bin/python3``. That Python reads no .pth file of a virtual environment, but it reads PYTHONPATH, to
which the setup file of the workspace appends this folder. (A package named rospy here would hide rospy from editors.)

The sitecustomize that Python would have run without this one, such as the distribution's, runs as well. With the
environment variable TURTLE_ROBOTONT_REPAIR_ROSPY=0, rospy stays as it is.
"""
import os
import sys
from importlib.machinery import PathFinder


class Finder:
    """Finds rospy as Python does, and lets rospy_repair repair it once it is imported."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        """Return the spec of rospy; None for every other module."""
        spec = PathFinder.find_spec(name, path, target) if name == 'rospy' else None
        if spec is not None and spec.loader is not None:
            run = spec.loader.exec_module

            def exec_module(module):
                run(module)
                try:
                    import rospy_repair
                    rospy_repair.repair()
                except Exception:  # a repair that fails must not end a program
                    pass
            spec.loader.exec_module = exec_module
        return spec


def run_next():
    """Run the sitecustomize that comes after this one on Python's path, if there is one."""
    folders = [os.path.abspath(folder) for folder in sys.path]
    own = os.path.dirname(os.path.abspath(__file__))
    spec = PathFinder.find_spec('sitecustomize', folders[folders.index(own) + 1:] if own in folders else [])
    if spec is not None and spec.loader is not None:
        exec(spec.loader.get_code(spec.name), {'__name__': spec.name, '__file__': spec.origin})


if os.environ.get('TURTLE_ROBOTONT_REPAIR_ROSPY') != '0':
    sys.meta_path.insert(0, Finder)
run_next()
