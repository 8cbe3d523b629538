"""Python runs this first in every program that is graded: rospy.init_node returns when there is a time.

With simulated time rospy.get_time() is 0 until the first message on /clock has come, some milliseconds after init_node
has returned. A program that notes the time at once, or begins with a rate.sleep(), would find seconds gone with the
next look at the time: right on a robot, where the wall clock is there from the beginning, and wrong here.

The sitecustomize that Python would have run without this one (a distribution may bring its own) runs afterwards.
"""
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
import time
from types import ModuleType
from typing import Any, Callable, Optional, Sequence

MODULE = 'rospy.impl.simtime'
PATIENCE, LOOK_PERIOD = 10.0, 0.3  # [s] of wall time


def wait_for_time(init_simtime: Callable[[], bool]) -> Callable[[], bool]:
    """Return ``init_simtime`` of rospy, which waits now until there is a time."""
    def init_and_wait() -> bool:
        done, deadline = init_simtime(), time.monotonic() + PATIENCE
        core, rostime = sys.modules['rospy.core'], sys.modules['rospy.rostime']
        come = rostime.get_rostime_cond()
        with come:
            while (not rostime.is_wallclock() and rostime.get_rostime().is_zero() and not core.is_shutdown()
                   and time.monotonic() < deadline):
                come.wait(LOOK_PERIOD)
        return done
    return init_and_wait


class Finder(importlib.abc.MetaPathFinder):
    """Changes the module when it is imported; nothing else is touched."""

    def find_spec(self, name: str, path: Optional[Sequence[str]] = None, target: Optional[ModuleType] = None
                  ) -> Optional[importlib.machinery.ModuleSpec]:
        """Return the spec of the module, or None for all others."""
        if name != MODULE:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            return spec
        run = spec.loader.exec_module

        def exec_module(module: ModuleType) -> None:
            run(module)
            changed: Any = module
            changed.init_simtime = wait_for_time(changed.init_simtime)
        spec.loader.exec_module = exec_module  # type: ignore[method-assign]  # as meant: this module alone changes
        return spec


def run_next() -> None:
    """Run the sitecustomize that comes after this one on Python's path, if there is one."""
    own = os.path.dirname(os.path.abspath(__file__))
    spec = importlib.machinery.PathFinder.find_spec(
        'sitecustomize', [folder for folder in sys.path if os.path.abspath(folder) != own])
    if spec is not None and spec.loader is not None:
        spec.loader.exec_module(importlib.util.module_from_spec(spec))


sys.meta_path.insert(0, Finder())
run_next()
