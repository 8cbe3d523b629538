"""The pages of the course, the README and public course texts: everything that they tell a reader to type is typed."""
import sys

import pytest

from collection import ros
from collection.kinds import REPOSITORY
from plain_support import course

pytestmark = [pytest.mark.page, pytest.mark.nightly, pytest.mark.timeout(1800)]  # a browser is slow

CHECK = REPOSITORY / 'test' / 'pages' / 'check_page.py'
CHECK_SEED = CHECK.with_name('check_seed.py')
STEPS = [step.page.relative_to(REPOSITORY).as_posix() for step in course.steps(REPOSITORY / 'course')]
IN_A_BROWSER = [name for name in STEPS if name.split('/')[1] < '12']  # a day's course, in one tab


@pytest.mark.parametrize('page', ['README.md', *STEPS], ids='page/{}'.format)
def test_page(page, run_case, case_folder):
    needs_workspace()
    run_case(sys.executable, CHECK, page, case_folder)


@pytest.mark.parametrize('pages', [IN_A_BROWSER], ids=['page/browser/course'])
def test_pages_in_one_tab_of_a_browser(pages, run_case, case_folder):
    needs_workspace()
    from rostest_support import browser
    if browser.MISSING:
        pytest.skip(browser.MISSING)
    run_case(sys.executable, CHECK, *pages, case_folder, '--browser')


@pytest.mark.parametrize('number', range(3), ids='page/seeds/{}'.format)
def test_seed(number, run_case, case_folder):
    needs_workspace()
    from rostest_support import course_texts
    if not course_texts.FOLDER.is_dir():
        pytest.skip(course_texts.MISSING)
    run_case(sys.executable, CHECK_SEED, number, case_folder)


def needs_workspace():
    if not ros.run_workspace():
        pytest.skip('a page is followed with the workspace of ./run: type ./run test page/')
