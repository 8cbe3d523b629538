"""course_grader.classes.class_page in a real browser: what a teacher sees, filters, sorts and prints."""
import os
import re
import subprocess
import sys

import cv2
import pytest

from course_grader.classes import class_page, class_results
from course_grader.classes.class_table import Class
from course_grader.classes.graded import Graded
from course_grader.classes.submissions import Submission
from course_grader.formats import path_picture, templates
from course_grader.rules import exercise, scoring
from rostest_support import browser as browsers
from unit_support import course_files
from unit_support.graded_turtle import GradedTurtle

pytestmark = pytest.mark.slow

STOP = course_files.EXERCISES['stop_at_x']
EXERCISES = [f'exercise_{letter}' for letter in 'abcdefghij']
STUDENTS = [f'Student {number:02}' for number in range(30)] + ['<script>alert(1)</script>']
HOSTILE = '</td><script>document.title = "stolen"</script>\x00\x1b[31m'


def a_class(folder):
    """Return a Class with its files: each student has two exercises, one with a path, and one of them failed."""
    turtle = GradedTurtle(4.0, 5.0)
    turtle.drive(6.0, 1.0, 0.0)
    drawn = path_picture.svg(path_picture.drawing(exercise.load(STOP), turtle.observed))
    results = []
    for number, student in enumerate(STUDENTS):
        of_both = (EXERCISES[0], 'passed', 100.0), (EXERCISES[number % 10], 'failed', float(number))
        for name, outcome, score in of_both:
            own = os.path.join(folder, student.replace('/', '_'), name)
            os.makedirs(own, exist_ok=True)
            if outcome == 'failed':
                with open(os.path.join(own, 'path.svg'), 'w', encoding='utf-8') as file:
                    file.write(drawn)
                with open(os.path.join(own, 'output.txt'), 'w', encoding='utf-8') as file:
                    file.write(f'    0.10  {HOSTILE}')
            reasons = [scoring.Reason('moves', score, 100.0, 'a path', f'File "/home/teacher/class/{student}/a.py"'),
                       scoring.Reason('prints', 0.0, 0.0, HOSTILE, HOSTILE)]
            verdict = scoring.Verdict(outcome, score, reasons, [HOSTILE] if number == 30 else [],
                                      ('publish zero at x = 10',) if outcome == 'failed' else ())
            results.append(Graded(Submission(student, name, ('a.py',), '/', attempt=outcome), verdict, 2.0, own, 7,
                                  (name, '--seed', '7', '--', f'class/{student}/a.py')))
    return Class('Grades of class', STUDENTS, EXERCISES, results)


@pytest.fixture(scope='module', name='folder')
def written(tmp_path_factory):
    folder = str(tmp_path_factory.mktemp('class'))
    class_results.write(folder, a_class(folder), student_pages=False, anonymous=True)
    return folder


@pytest.fixture(scope='module', name='page')
def opened(folder):
    if browsers.MISSING:
        pytest.skip(browsers.MISSING)
    with browsers.Browser(width=1280, height=900) as page:
        page.get(os.path.join(folder, 'index.html'))
        yield page
        assert page.errors() == []


@pytest.fixture(autouse=True, name='reset')
def shows_all(request):
    yield
    if 'page' in request.fixturenames:
        page = request.getfixturevalue('page')
        page.prefer()
        page.resize(1280, 900)
        page.evaluate("document.querySelector('form').reset(); document.querySelector('.table').scrollTo(0, 0)")


def shown(page, selector):
    return page.evaluate(f"[...document.querySelectorAll('{selector}')].filter(e => e.checkVisibility()).length")


def choose(page, script):
    page.evaluate(f"{script}; document.querySelector('form').dispatchEvent(new Event('input'))")


def test_names_and_headings_stay_when_the_table_is_scrolled(page):
    page.resize(390, 844)
    page.evaluate("document.querySelector('.table').scrollTo(300, 200)")
    left, top, table_left, table_top = page.evaluate('''(() => {
        const table = document.querySelector('.table').getBoundingClientRect();
        return [document.querySelector('tbody tr:nth-child(9) th').getBoundingClientRect().left,
                document.querySelector('thead th:nth-child(5)').getBoundingClientRect().top,
                table.left, table.top] })()''')
    assert abs(left - table_left) <= 2 and abs(top - table_top) <= 2  # [px] of a border
    assert page.evaluate('document.documentElement.scrollWidth') <= 390  # only the table scrolls
    page.screenshot('class_page_phone')


def test_filters_choose_exercise_verdict_and_name(page):
    assert shown(page, 'tbody tr[data-student]') == len(STUDENTS) and shown(page, '.submission') == 2 * len(STUDENTS)
    choose(page, "document.querySelector('[name=exercise]').value = 'exercise_b'")
    assert shown(page, 'thead th[data-column]') == 1 and shown(page, '.submission') == 3  # 1, 11, 21
    choose(page, "document.querySelector('[value=missing]').checked = false")
    assert shown(page, 'tbody tr[data-student]') == 3
    page.evaluate("document.querySelector('form').reset()")
    page.until(lambda: shown(page, '.submission') == 2 * len(STUDENTS), 'everything is shown again')
    choose(page, "document.querySelector('[value=passed]').checked = false")
    assert shown(page, '.submission') == len(STUDENTS)
    choose(page, "document.querySelector('[name=name]').value = 'dent 07'")
    assert shown(page, '.submission') == 1 and shown(page, 'tbody tr[data-student]') == 1


def test_a_heading_sorts_both_ways(page):
    def first(heading):
        page.evaluate(f"document.querySelectorAll('thead button')[{heading}].click()")
        return page.evaluate("document.querySelector('tbody tr').dataset.student")
    means = [first(11), first(11)]
    assert means[0] != means[1]  # the best one first, then the worst one
    assert page.evaluate("document.querySelectorAll('thead th')[11].getAttribute('aria-sort')") == 'ascending'
    assert [first(0), first(0)] == ['<script>alert(1)</script>', 'Student 29']


def test_passes_are_closed_and_a_score_opens_its_submission(page):
    assert page.evaluate("document.querySelectorAll('.submission[open]').length") == len(STUDENTS)
    page.evaluate("document.querySelector('td.passed a').click()")
    page.until(lambda: page.evaluate("document.querySelectorAll('.submission[open]').length") == len(STUDENTS) + 1,
               'the submission is open')
    page.evaluate("document.querySelectorAll('.submission').forEach(e => e.open = e.dataset.verdict === 'failed')")
    page.evaluate("location.hash = ''")


def test_a_hint_comes_first_and_the_command_repeats_the_grading(page):
    text = page.evaluate("document.querySelector('.submission[open]').innerText")
    places = [text.index(part) for part in ('Hint: publish zero', 'points', './run grade exercise_a --seed 7 --')]
    assert places == sorted(places)
    assert 'File "a.py"' in text and '/home/teacher' not in page.evaluate('document.documentElement.outerHTML')


def test_what_students_wrote_is_text(page):
    assert page.evaluate('document.title') == 'Grades of class'
    assert page.evaluate("document.querySelectorAll('script').length") == 1
    assert '</td><script>' in page.evaluate("document.body.innerText")


def lightness(path):
    return cv2.imread(path, cv2.IMREAD_GRAYSCALE).mean()


def test_it_is_dark_where_the_system_is_and_light_on_paper(page):
    light = lightness(page.screenshot('class_page'))
    page.evaluate("document.querySelector('.submission[open]').scrollIntoView()")
    page.prefer(dark=True)
    picture = page.screenshot('class_page_dark')
    assert light > 200 and lightness(picture) < 80
    box = page.evaluate("JSON.stringify(document.querySelector('.submission[open] img').getBoundingClientRect())")
    x, y, width, height = (int(float(re.search(rf'"{name}":([-0-9.]+)', box).group(1)))
                           for name in ('x', 'y', 'width', 'height'))
    inside = cv2.imread(picture)[max(y, 0):y + height, x:x + width]
    assert inside.mean() < 80 and (inside[:, :, 0].astype(int) - inside[:, :, 2] > 80).sum() > 100  # a blue path
    page.prefer(dark=True, media='print')
    assert lightness(page.screenshot('class_page_print')) > 200
    assert shown(page, 'form') == 0


def test_the_page_of_a_student_names_no_other(folder, tmp_path):
    graded = a_class(folder)
    own = [one for one in graded.results if one.submission.student == 'Student 05']
    text = class_page.of_student('Student 05', own)
    (tmp_path / 'student.html').write_text(text, encoding='utf-8')
    assert not re.search('Student (?!05)', text) and 'href' not in text
    assert './run grade exercise_f --seed 7 -- a.py' in text and 'data:image/svg+xml;base64,' in text
    assert '&lt;script&gt;document.title' in text  # what it printed
    assert '\x00' not in text and '\x1b' not in text
    if not browsers.MISSING:
        with browsers.Browser(width=390, height=844, dark=True) as page:
            page.get(str(tmp_path / 'student.html'))
            page.screenshot('student_page')
            assert page.errors() == [] and page.evaluate('document.title') == 'Student 05'
            assert page.evaluate('document.documentElement.scrollWidth') <= 390


def test_templates_are_installed(tmp_path):
    package = course_files.REPOSITORY / 'packages' / 'grading' / 'course_grader'
    subprocess.run([sys.executable, 'setup.py', '-q', 'build', '--build-base', tmp_path], cwd=package, check=True)
    assert {path.name for path in (tmp_path / 'lib' / 'course_grader' / 'templates').iterdir()} == {
        path.name for path in (package / 'src' / 'course_grader' / 'templates').iterdir()}


def test_values_are_escaped_and_characters_that_no_page_can_hold_are_replaced():
    text = templates.rendered('student.html', title='<b>"&\x1b', written='', style='', script='', script_digest='',
                              submissions=[], left_out=[])
    assert '<h1>&lt;b&gt;&#34;&amp;?</h1>' in text
