"""The pages of the course and the README: everything that they tell a reader to type is typed."""
import sys

import pytest

from collection import ros
from collection.kinds import REPOSITORY

CHECK = REPOSITORY / 'test' / 'pages' / 'check_page.py'
PAGES = 'docs/course_next.md', 'docs/course.md', 'docs/course_markers.md', 'README.md'


@pytest.mark.release
@pytest.mark.parametrize('page', PAGES)
def test_page(page, run_case, case_folder):
    needs_workspace()
    run_case(sys.executable, CHECK, page, case_folder)


@pytest.mark.release
@pytest.mark.timeout(1800)  # the terminals and the picture of a browser are slower, too
@pytest.mark.parametrize('page', ['docs/course.md'], ids='browser/{}'.format)
def test_page_in_one_tab_of_a_browser(page, run_case, case_folder):
    needs_workspace()
    from rostest_support import browser
    if browser.MISSING:
        pytest.skip(browser.MISSING)
    run_case(sys.executable, CHECK, page, case_folder, '--browser')


def needs_workspace():
    if not ros.run_workspace():
        pytest.skip('a page is followed with the workspace of ./run: type ./run test page/')
