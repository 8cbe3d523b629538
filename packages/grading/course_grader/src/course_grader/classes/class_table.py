"""The table of a class: students x exercises, the best score of each, and what sums up a row."""
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes.graded import Graded
from course_grader.classes.similarity import Pair
from course_grader.classes.submissions import LeftOut
from course_grader.formats.platforms import Grades, Origin
from course_grader.rules import scoring

Best = Dict[Tuple[str, str], Graded]  # of (student, exercise)


class Class(NamedTuple):
    """A class and its gradings: students and exercises in the order of the table, {exercise: weight}, all gradings.

    An exercise without a weight has the weight 1. ``left_out``: what was handed in and is not graded; ``origin``: the
    platform that the class was downloaded from; ``similar``: programs that resemble each other.
    """

    title: str
    students: Sequence[str]
    exercises: Sequence[str]
    results: Sequence[Graded]
    weights: Mapping[str, float] = {}
    left_out: Sequence[LeftOut] = ()
    origin: Origin = Origin()
    similar: Sequence[Pair] = ()

    def weight(self, exercise: str) -> float:
        return self.weights.get(exercise, 1.0)

    def best(self) -> Best:
        """Return {(student, exercise): the best of the attempts}; one without a verdict is the worst."""
        best: Best = {}
        for graded in self.results:
            key = graded.submission.student, graded.submission.exercise
            if key not in best or _merit(best[key]) < _merit(graded):
                best[key] = graded
        return best


def _merit(graded: Graded) -> Tuple[bool, bool, float]:
    return graded.outcome != scoring.UNDECIDED, graded.outcome == scoring.PASSED, graded.score


def _mean(graded: Class, student: str, best: Best) -> str:
    """Return the weighted mean over all exercises; missing submissions count 0, and it is '' if one is undecided."""
    of_student = {exercise: best.get((student, exercise)) for exercise in graded.exercises}
    if any(one is not None and one.outcome == scoring.UNDECIDED for one in of_student.values()):
        return ''
    points = sum(graded.weight(exercise) * one.score for exercise, one in of_student.items() if one)
    return f'{points / sum(map(graded.weight, graded.exercises)):.1f}'


SUMMARIES = {'mean': _mean}  # heading: what returns the number, as text, or ''; the columns after the exercises


def cells(graded: Class) -> List[List[str]]:
    """Return the table with its headings, as texts: the scores, '' for missing submissions, and the SUMMARIES."""
    best = graded.best()
    return [['student', *graded.exercises, *SUMMARIES],
            *([student, *(_score(best.get((student, exercise))) for exercise in graded.exercises),
               *(summary(graded, student, best) for summary in SUMMARIES.values())] for student in graded.students)]


def _score(graded: Optional[Graded]) -> str:
    if graded is None:
        return ''
    return scoring.UNDECIDED if graded.outcome == scoring.UNDECIDED else f'{graded.score:g}'


def grades(graded: Class) -> List[Grades]:
    """Return the grades of all students for the platform of the class; nothing counts that is undecided or missing."""
    best, found = graded.best(), []
    for student in graded.students:
        own = {exercise: best[student, exercise] for exercise in graded.exercises if (student, exercise) in best}
        scores = {exercise: f'{one.score:g}' for exercise, one in own.items() if one.outcome in scoring.DECIDED}
        found.append(Grades(student, scores, _mean(graded, student, best) if own else '', '; '.join(
            f'{exercise}: {_summary(one)}' for exercise, one in own.items())))
    return found


def _summary(graded: Graded) -> str:
    """Return the verdict of a grading with its main reason."""
    reason = graded.verdict.public(graded.over).main_reason()
    score = f'{graded.score:g} of 100' if graded.outcome in scoring.DECIDED else graded.outcome
    return f'{score}: {reason}' if reason else score
