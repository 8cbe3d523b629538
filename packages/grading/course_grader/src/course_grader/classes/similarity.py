"""Which programs of a class resemble each other, or a solution of this repository. Without ROS.

Programs are compared as lists of tokens, without comments, layout, and the names of variables: what two have in common
is the share of runs of RUN tokens of the shorter one. Runs that many students have are the task's, such as those of a
program that was shown in the course, and do not count (as moss and others do it). It is a reason to look at both, and
not a proof: two short programs for one task may be equal by chance.
"""
import collections
import difflib
import html
import io
import itertools
import keyword
import re
import tokenize
from pathlib import Path
from typing import Dict, FrozenSet, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes.submissions import Submission
from course_grader.formats import harmless
from course_grader.isolation import student_files
from plain_support import course

RUN = 10  # tokens
LEAST = 0.8  # share from which a pair is reported: of 889 pairs of programs by five authors two have more, and one of
             # them was derived from the other; the next has 0.64, and with 0.6 four have more
ENOUGH = 40  # runs that count, of a program that is compared
COMMON, COMMON_SHARE = 3, 0.1  # students, and share of them, from which on a run is the task's
SKIPPED = tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.ENCODING, tokenize.ENDMARKER
LAYOUT = {tokenize.INDENT: '{', tokenize.DEDENT: '}'}
COLUMNS = 80  # of each of two texts beside each other
MAX_LINES, MAX_LINE = 1000, 1000  # lines, and characters of one, that are shown beside each other
SOLUTION = 'solution '  # what precedes the names of those of this repository
Runs = FrozenSet[int]


class Pair(NamedTuple):
    """Two programs for an exercise, whose they are, the share that they have in common, and their texts."""

    exercise: str
    first: str
    second: str
    share: float
    texts: Tuple[str, str] = ('', '')

    def text(self) -> str:
        return f'{self.exercise}: {self.first} and {self.second} have {self.share:.0%} in common'


def tokens(source: str) -> List[str]:
    """Return the tokens of a program, with ``v`` for each name; of another language, its words and signs."""
    found: List[str] = []
    try:
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.NAME and not keyword.iskeyword(token.string):
                attribute = found[-1:] == ['.']  # the name of an interface stays
                found.append(token.string if attribute else 'v')
            elif token.type not in SKIPPED:
                found.append(LAYOUT.get(token.type, token.string))
    except (tokenize.TokenError, SyntaxError, ValueError):  # not Python, or incomplete
        return re.findall(r'\w+|\S', source)
    return found


def pairs(exercise: str, programs: Mapping[str, str], given: Mapping[str, str]) -> List[Pair]:
    """Return the pairs with LEAST in common, the most similar first; ``programs``: {student: text of the program}.

    ``given``: {name: text} of solutions, which are compared with the students' programs only.
    """
    runs = {name: _runs(text) for name, text in programs.items()}
    counted = collections.Counter(itertools.chain.from_iterable(runs.values()))
    many = max(COMMON, COMMON_SHARE * len(programs))
    shared = frozenset(run for run, count in counted.items() if count > many)
    own = {name: one - shared for name, one in runs.items()}
    others = {name: _runs(text) - shared for name, text in given.items()}
    found = [Pair(exercise, first, second, _share(own[first], own[second]), (programs[first], programs[second]))
             for first, second in itertools.combinations(sorted(own), 2)]
    found += [Pair(exercise, first, second, _share(own[first], others[second]), (programs[first], given[second]))
              for first in sorted(own) for second in sorted(others)]
    return sorted((pair for pair in found if pair.share >= LEAST), key=lambda pair: -pair.share)


def _runs(source: str) -> Runs:
    words = tokens(source)
    return frozenset(hash(tuple(words[start:start + RUN])) for start in range(len(words) - RUN + 1))


def _share(first: Runs, second: Runs) -> float:
    """Return the share of the shorter one; 0 if too little is left to compare."""
    shorter = min(len(first), len(second))
    return len(first & second) / shorter if shorter >= ENOUGH else 0.0


def side_by_side(pair: Pair) -> Optional[str]:
    """Return a page with both programs beside each other and their differences marked, None if they are too long."""
    lines = [harmless.plain(text).splitlines() for text in pair.texts]
    if any(len(one) > MAX_LINES or max(map(len, one), default=0) > MAX_LINE for one in lines):
        return None
    first, second = lines
    return difflib.HtmlDiff(tabsize=4, wrapcolumn=COLUMNS).make_file(
        first, second, harmless.plain(html.escape(pair.first)), harmless.plain(html.escape(pair.second)))


def table(found: Sequence[Pair], files: Sequence[str]) -> List[Sequence[str]]:
    """Return the rows of a table of pairs, with the name of the file that shows each."""
    return [('exercise', 'student', 'similar to', 'in common', 'side by side'),
            *((pair.exercise, pair.first, pair.second, f'{pair.share:.0%}', file)
              for pair, file in zip(found, files))]


def of_class(found: Sequence[Submission]) -> List[Pair]:
    """Return the pairs of all exercises of a class, which are compared with the solutions of this repository, too."""
    programs: Dict[str, Dict[str, str]] = collections.defaultdict(dict)
    for submission in found:
        programs[submission.exercise][submission.student] = _text(submission.program)
    known = course.exercises(course.installed())
    return [pair for exercise, own in programs.items() for pair in pairs(exercise, own, {
        f'{SOLUTION}{path.name}': _text(str(path)) for path in _solutions(known.get(exercise))})]


def _solutions(exercise: Optional[Path]) -> List[Path]:
    """Return the right programs for the exercise in a file."""
    if exercise is None:
        return []
    return [path for path in course.answers(exercise) if path.suffix == '.py' and not path.name.startswith('wrong_')]


def _text(path: str) -> str:
    return student_files.read(path).decode('utf-8', 'replace')
