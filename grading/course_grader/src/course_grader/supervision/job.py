"""What a grading is given and what it returns: plain data that travels between processes. Without ROS."""
from typing import NamedTuple, Optional, Tuple

from course_grader.isolation.confinement import Isolation
from course_grader.isolation.sourced import Sourced
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.scoring import Verdict

RECORD = 'record.csv'  # what the simulator records; it is there before a program starts


class Job(NamedTuple):
    """A program to grade.

    ``command`` was typed in ``folder``; ``output`` takes all files; ``packages``: folder with the program's packages,
    by default that of the package in which its file lies; ``real_time``: at the speed of the wall clock, whatever the
    program does; ``mark``: the value by which all processes of the grading are found;
    ``isolation``: what the program may see and use; ``sourced``: what else rosrun finds.
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


class Attempted(NamedTuple):
    """What one attempt at a Job returned.

    ``remarks`` are notes for the student; ``lockstep``: whether the simulator waited for the nodes; ``busy``: the nodes
    that never slept, for which it did not; ``flooded``: whether it was busy with what they sent;
    ``broken``: the grading broke down while the program ran.
    """

    verdict: Verdict
    observed: Observed
    remarks: Tuple[str, ...] = ()
    lockstep: bool = False
    busy: str = ''
    flooded: bool = False
    broken: bool = False
