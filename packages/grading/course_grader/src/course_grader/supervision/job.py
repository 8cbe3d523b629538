"""The input and the result of a grading: plain data that is sent between processes. Without ROS."""
import math
from typing import NamedTuple, Optional, Tuple

from course_grader.isolation.confinement import Isolation
from course_grader.isolation.sourced import Sourced
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.scoring import Verdict

MASTER_LOG, SIMULATOR_LOG = 'master.txt', 'simulator.txt'  # their output
RECORD = 'record.csv'  # the simulator's recording, which exists before a program starts


class Job(NamedTuple):
    """A program to grade.

    ``command`` was typed in ``folder``; ``output``: folder for all files; ``packages``: folder with the program's
    packages, by default the package of its file; ``real_time``: always at the speed of the wall clock; ``mark``: the
    value by which all processes of the grading are found; ``isolation``: what the program may see and use;
    ``sourced``: packages that rosrun finds, too; ``limit`` [s] of wall time for the attempt; ``solution``: the path
    [(x, y)] [m] of the exercise's solution from the same start; ``tried``: whether an earlier attempt has tried what
    programs need of this machine.
    """

    exercise: Exercise
    command: Tuple[str, ...]
    folder: str
    output: str
    seed: int
    packages: Optional[str] = None
    real_time: bool = False
    mark: str = ''
    isolation: Isolation = Isolation()
    sourced: Sourced = Sourced()
    limit: float = math.inf
    solution: Tuple[Tuple[float, float], ...] = ()
    tried: bool = False


class Attempted(NamedTuple):
    """The result of one attempt at a Job.

    ``remarks`` are notes for the student; ``lockstep``: whether the simulator waited for the nodes; ``busy``: the nodes
    that never slept, for which it did not wait; ``flooded``: whether their messages kept it busy; ``broken``: the
    grading broke down while the program ran.
    """

    verdict: Verdict
    observed: Observed
    remarks: Tuple[str, ...] = ()
    lockstep: bool = False
    busy: str = ''
    flooded: bool = False
    broken: bool = False
