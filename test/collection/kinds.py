"""The names of tests.

The name of a test is KIND/PATH: unit/test/unit/test_docs.py::test_links, rostest/test/course/lesson_square.test. Tests
in test/cases have no file each; they are parametrized, and the parameter is their name: page/README.md, check/ruff.
"""
from functools import lru_cache

from unit_support import REPOSITORY

CASES = REPOSITORY / 'test' / 'cases'


@lru_cache(maxsize=None)
def real(path):
    """Return a path without symbolic links: a workspace has links to the packages."""
    return path.resolve()


def name_of_file(path):
    """Return KIND/PATH of a file of unit tests or of a .test file."""
    return f'{"rostest" if path.suffix == ".test" else "unit"}/{real(path).relative_to(REPOSITORY).as_posix()}'


def name_of(item):
    """Return the name of the test that is a pytest item."""
    if real(item.path).parent == CASES:
        return item.callspec.id
    function = item.nodeid.partition('::')[2]
    return name_of_file(item.path) + (f'::{function}' if item.path.suffix == '.py' else '')
