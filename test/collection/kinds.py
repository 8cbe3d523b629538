"""The kinds of tests, their names, and which of them are selected.

The name of a test is KIND/PATH: unit/test/unit/test_docs.py::test_links, rostest/test/course/lesson_square.test. Tests
in test/cases have no file each; they are parametrized, and the parameter is the PATH: page/README.md, check/ruff.
"""
import re
from functools import lru_cache
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
CASES = REPOSITORY / 'test' / 'cases'
TIME_LIMITS = {  # [s] for a test of each kind
    'unit': 300, 'check': 600, 'rostest': 600, 'grading': 900, 'stress': 300, 'page': 1800}
SLOW_MARK = re.compile(r'^pytestmark = .*pytest\.mark\.slow\b', re.MULTILINE)
COMPUTING = 'unit', 'check'  # the others start nodes, and so mostly wait
FAST = COMPUTING


@lru_cache(maxsize=None)
def real(path):
    """Return a path without symbolic links: a workspace has links to the packages."""
    return path.resolve()


def kind_of(path):
    """Return the kind of the tests in a file."""
    path = real(path)
    if path.suffix == '.test':
        return 'rostest'
    return path.stem[len('test_'):] if path.parent == CASES else 'unit'


def is_slow(path):
    """Return whether all tests of a file are marked slow: --fast leaves them out."""
    return SLOW_MARK.search(path.read_text(encoding='utf-8')) is not None


def name_of(item):
    """Return KIND/PATH of a pytest item."""
    path, kind = item.path, kind_of(item.path)
    if kind == 'unit':
        function = item.nodeid.partition('::')[2]
        return f'{kind}/{relative(path)}::{function}'
    return f'{kind}/{relative(path) if kind == "rostest" else item.callspec.id}'


def relative(path):
    """Return the path of a file in the repository, as a text."""
    return real(path).relative_to(REPOSITORY).as_posix()


def may_hold(path, names):
    """Return whether the file ``path`` may hold a test that one of ``names`` selects; without names it may."""
    kind = kind_of(path)
    if not names or kind not in ('unit', 'rostest'):
        return True
    name = f'{kind}/{relative(path)}'
    return any(wanted in name or name in wanted or kind == 'unit' and _holds(path, wanted) for wanted in names)


def _holds(path, wanted):
    """Return whether ``wanted`` names a function of the file: test_corners, test_shapes.py::test_corners[4]."""
    file, _, function = wanted.rpartition('::')
    return file in f'unit/{relative(path)}' and f'def {function.partition("[")[0]}(' in path.read_text(encoding='utf-8')


def is_selected(name, names):
    """Return whether one of ``names`` is a part of ``name``; without names, all are selected."""
    return not names or any(wanted in name for wanted in names)
