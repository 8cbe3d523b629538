"""Python runs this first in every graded program: rospy.init_node returns when the time is known.

With simulated time rospy.get_time() is 0 until the first message on /clock arrives, some milliseconds after init_node
has returned. A program that reads the time at once, or begins with rate.sleep(), would then see a jump of seconds. On
a robot, where the wall clock is always known, the same program is right.

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
CLOCK_TIMEOUT, POLL = 10.0, 0.3  # [s] of wall time


def wait_for_time(init_simtime: Callable[[], bool]) -> Callable[[], bool]:
    """Return ``init_simtime`` of rospy, made to wait until the time is known."""
    def init_and_wait() -> bool:
        done, deadline = init_simtime(), time.monotonic() + CLOCK_TIMEOUT
        core, rostime = sys.modules['rospy.core'], sys.modules['rospy.rostime']
        come = rostime.get_rostime_cond()
        with come:
            while (not rostime.is_wallclock() and rostime.get_rostime().is_zero() and not core.is_shutdown()
                   and time.monotonic() < deadline):
                come.wait(POLL)
        return done
    return init_and_wait


class Finder(importlib.abc.MetaPathFinder):
    """Replaces ``init_simtime`` when MODULE is imported; leaves all other modules alone."""

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
        spec.loader.exec_module = exec_module  # type: ignore[method-assign]  # on purpose: for this module only
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
