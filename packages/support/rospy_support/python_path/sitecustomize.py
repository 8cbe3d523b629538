"""Python runs this when it starts in a workspace with rospy_support: rospy is repaired wherever it is imported, and
an OpenCV without windows gets some.

rospy_repair.py and cv2_windows.py say what is repaired and why. It has to reach students' programs, which import
nothing of ours and may start with ``#!/usr/bin/python3``. That Python reads no .pth file of a virtual environment, but
it reads PYTHONPATH, to which the setup file of the workspace appends this folder. (A package named rospy here would
hide rospy from editors.)

The sitecustomize that Python would have run without this one, such as the distribution's, runs as well. With the
environment variable TURTLE_ROBOTONT_REPAIR_ROSPY=0, rospy stays as it is, with TURTLE_ROBOTONT_CV2_WINDOWS=0 OpenCV.
"""
import os
import sys
from importlib.machinery import PathFinder

REPAIRS = {module: repair for module, repair, switch in (
    ('rospy', 'rospy_repair', 'TURTLE_ROBOTONT_REPAIR_ROSPY'),
    ('cv2', 'cv2_windows', 'TURTLE_ROBOTONT_CV2_WINDOWS')) if os.environ.get(switch) != '0'}


class Finder:
    """Finds these modules as Python does, and lets them be repaired once they are imported."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        """Return the spec of a module of REPAIRS; None for every other module."""
        spec = PathFinder.find_spec(name, path, target) if name in REPAIRS else None
        if spec is not None and spec.loader is not None:
            run = spec.loader.exec_module

            def exec_module(module):
                run(module)
                try:
                    __import__(REPAIRS[name]).repair()
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


if REPAIRS:
    sys.meta_path.insert(0, Finder)
run_next()
