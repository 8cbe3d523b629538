"""What ends an attempt early: the program's own fault fails it, that of anything else decides nothing."""


class ProgramFault(Exception):
    """The program could not run, or did what no program may do; ``problem`` says what."""

    def __init__(self, problem):
        super().__init__(problem.text)
        self.problem = problem


class AttemptError(RuntimeError):
    """The grading failed for a reason that is not the student's; the text says why."""


class MachineError(AttemptError):
    """The machine lacks what a program needs; the program is no cause."""


class TooSlow(AttemptError):
    """The machine was too slow to begin a grading."""
