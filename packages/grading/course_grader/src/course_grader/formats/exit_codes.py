"""The exit codes of ``./run grade``, for one program and for a class."""
from course_grader.rules import scoring

OF_OUTCOME = {scoring.PASSED: 0, scoring.FAILED: 1, scoring.UNDECIDED: 3}
USAGE = 2  # wrong arguments, a wrong exercise file, or results that cannot be written
UNDECIDED = OF_OUTCOME[scoring.UNDECIDED]
INTERRUPTED = 130  # as of a shell after Ctrl-C
