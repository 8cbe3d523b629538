"""The pages of the course and the README: everything that they tell a reader to type is typed."""
import sys

import pytest

from collection import ros
from collection.kinds import REPOSITORY

PAGES = 'docs/course_next.md', 'docs/course.md', 'docs/course_markers.md', 'README.md'


@pytest.mark.release
@pytest.mark.parametrize('page', PAGES)
def test_page(page, run_case, case_folder):
    if not ros.run_workspace():
        pytest.skip('a page is followed with the workspace of ./run: type ./run test page/')
    run_case(sys.executable, REPOSITORY / 'test' / 'pages' / 'check_page.py', page, case_folder)
