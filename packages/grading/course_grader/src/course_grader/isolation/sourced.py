"""The packages of the catkin workspaces that are sourced in the terminal of a grading.

A grading has its own environment. If its command belongs to one of these packages, it finds all of them as in the
terminal: their folders, and what catkin_make has built of them, such as messages and compiled programs.
"""
import glob
import os
from typing import Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from course_grader.isolation import view

PACKAGE_PATH, PREFIX_PATH = 'TURTLE_ROBOTONT_SOURCED', 'TURTLE_ROBOTONT_SOURCED_PREFIXES'  # set by ./run grade
MODULES = os.path.join('lib', 'python3', 'dist-packages')


class Sourced(NamedTuple):
    """``packages``: (name, folder) of each; ``prefixes``: the devel and install folders, highest priority first."""

    packages: Tuple[Tuple[str, str], ...] = ()
    prefixes: Tuple[str, ...] = ()

    def concern(self, command: Sequence[str]) -> bool:
        """Return whether a command names one of the packages (rosrun, roslaunch), or a file in one."""
        words = [part for part in command[1:] if not part.startswith('-')]
        named = words[0] if words and os.path.basename(command[0]) in ('rosrun', 'roslaunch') else ''
        files = [os.path.realpath(part) for part in command if os.path.isfile(part)]
        return any(name == named or any(view.below(file, [os.path.realpath(folder)]) for file in files)
                   for name, folder in self.packages)

    def folders(self) -> List[str]:
        return [folder for _, folder in self.packages]

    def built(self) -> List[str]:
        """Return the paths of what was built of the packages."""
        made = [os.path.join(prefix, place, name) for prefix in self.prefixes for place in ('lib', MODULES)
                for name, _ in self.packages]
        shared = [path for prefix in self.prefixes for path in (
            os.path.join(prefix, '.catkin'), *sorted(glob.glob(os.path.join(prefix, 'lib', '*.so'))))]
        return [path for path in (*shared, *made) if os.path.exists(path)]

    def environment(self, base: Mapping[str, str]) -> Dict[str, str]:
        """Return the environment ``base`` with the packages in front."""
        added = {'ROS_PACKAGE_PATH': self.folders(), 'CMAKE_PREFIX_PATH': self.prefixes,
                 'PYTHONPATH': [os.path.join(prefix, MODULES) for prefix in self.prefixes],
                 'LD_LIBRARY_PATH': [os.path.join(prefix, 'lib') for prefix in self.prefixes]}
        return {**base, **{name: os.pathsep.join(filter(None, (*places, base.get(name))))
                           for name, places in added.items() if places}}


def folders_in(environment: Mapping[str, str], own: str, usual: str) -> List[str]:
    """Return the folders in the variables ``own`` (of the terminal) and ``usual`` (of the grading)."""
    text = os.pathsep.join(environment.get(name, '') for name in (own, usual))
    return list(dict.fromkeys(path for path in text.split(os.pathsep) if os.path.isdir(path)))


def outside(places: Iterable[str], others: Sequence[str]) -> List[str]:
    """Return the places that, with links resolved, are neither one of ``others`` nor below one."""
    return [place for place in places if not view.below(os.path.realpath(place), others)]
