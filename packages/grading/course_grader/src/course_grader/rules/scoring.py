"""Computes the score, with its reasons, from the Observed."""
from typing import List, NamedTuple, Tuple

from course_grader.rules import judging
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed

PASSED, FAILED, UNDECIDED = 'passed', 'failed', 'undecided'
DECIDED = PASSED, FAILED
HALF = 0.5  # share below which a rule that must hold fails the exercise
HIDDEN_FAILED = 'a required check failed that is not shown yet'
FULL = 0.97  # share from which a rule counts as fulfilled, because no drawing is exact


class Reason(NamedTuple):
    """One line of the reasons: points given and possible, what was asked and what was seen."""

    check: str  # the name of the rule, as in the exercise file
    points: float
    of: float
    asked: str
    seen: str
    visible: str = judging.ALWAYS  # one of VISIBLE


class Verdict(NamedTuple):
    """outcome: passed, failed or undecided; score 0..100; reasons; shortcuts and trouble, as texts.

    ``hints``: advice to the student, see symptoms.py; ``certain``: whether they name the mistake for sure.
    """

    outcome: str
    score: float
    reasons: List[Reason]
    objections: List[str]
    hints: Tuple[str, ...] = ()
    certain: bool = False

    def advice(self) -> List[str]:
        """Return the hints, each with a word that says how sure it is."""
        return [f'{"Mistake" if self.certain else "Hint"}: {hint}' for hint in self.hints]

    def main_reason(self) -> str:
        """Return why a program did not pass: an objection, or the check that lost most points; '' if it passed."""
        if self.objections:
            return self.objections[0]
        if self.outcome == PASSED or not self.reasons:
            return ''
        worst = max(self.reasons, key=lambda reason: reason.of - reason.points)
        if worst.points >= worst.of:  # what was lost is hidden
            return ''
        return f'{worst.points:g} of {worst.of:g}: asked: {worst.asked}; seen: {worst.seen}'

    def public(self, over: bool = False) -> 'Verdict':
        """Return what the student may see; ``over``: whether the deadline is over."""
        shown = (judging.ALWAYS, judging.LATER) if over else (judging.ALWAYS,)
        return self._replace(reasons=[reason for reason in self.reasons if reason.visible in shown])


def decide(exercise: Exercise, observed: Observed) -> Verdict:
    """Return the Verdict. A program that could not run, or took a shortcut, scores 0."""
    reasons, missing = [], []
    for scored in exercise.rules:
        result = scored.rule.judge(observed.of_robot(scored.robot))
        if scored.robot:
            result = result._replace(asked=f'{scored.robot}: {result.asked}')
        share = 1.0 if result.share >= FULL else max(0.0, result.share)
        reasons.append(Reason(scored.name, round(share * scored.points, 1), scored.points, result.asked, result.seen,
                              scored.visible))
        if scored.must and share < HALF:
            hidden = scored.visible != judging.ALWAYS
            missing.append(HIDDEN_FAILED if hidden else f'required check failed: {result.asked}')
    objections = judging.shortcuts(observed, exercise.allows)
    if observed.problem:
        objections.insert(0, observed.problem.text)
    score = 0.0 if objections else round(sum(reason.points for reason in reasons), 1)
    if not observed.kept_up and not objections and score < 100.0:  # a full score was not affected by lost time
        return Verdict(UNDECIDED, 0.0, reasons, ['the machine or the node was too slow for the simulation; grade '
                                                 'again'])
    passed = not objections and not missing and score >= exercise.pass_score
    return Verdict(PASSED if passed else FAILED, score, reasons, objections or missing)
