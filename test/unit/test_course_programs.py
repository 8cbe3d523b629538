"""The pages of the course: a program that they print is a file of the repository, and each step has its parts.

A comment `<!-- file: PATH -->` above a block of code says which file it is.
"""
import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PAGES = {name: (REPOSITORY / 'docs' / name).read_text(encoding='utf-8')
         for name in ('course.md', 'course_next.md', 'course_markers.md')}
UNGRADED = {11, 33, 34}  # steps without an exercise
NAVIGATION = (REPOSITORY / 'docs' / 'course_navigation.md').read_text(encoding='utf-8')  # not graded yet
PARTS = ('You will learn', 'The program', 'The code explained', 'Run it', 'What you see', 'What goes wrong',
         'Now change it', 'Grade your own')
MARKED = re.compile(r'^<!-- file: (\S+) -->\n```\w+\n(.*?)^```$', re.MULTILINE | re.DOTALL)
PARTS_OF_FILES = re.compile(r'^```(?:python|xml)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
SAVED = re.compile(r'as\s+`(~/ros_ws/src/topic_demo/(?:scripts|launch)/(\w+\.\w+))`')
LINKED = re.compile(r'\]\(\.\./((?:scripts|src)/\S+\.py)\)')
GRADED = re.compile(r'^run grade (\w+) -- ros(?:run|launch) topic_demo (\S+)$', re.MULTILINE)
SAMPLES = 'test/data/submissions'


def sections(text):
    """Return {number: text} of the steps of a page."""
    parts = re.split(r'^## ', text, flags=re.MULTILINE)[1:]
    return {int(part.split('.')[0]): part for part in parts if re.match(r'\d+\. ', part)}


STEPS = {number: text for page in PAGES.values() for number, text in sections(page).items()}
each_step = pytest.mark.parametrize('number', STEPS)


@pytest.mark.parametrize('path, printed', [found for text in (*PAGES.values(), NAVIGATION)
                                           for found in MARKED.findall(text)],
                         ids=lambda value: value if value.count('\n') == 0 else '')
def test_a_printed_program_is_the_file(path, printed):
    assert printed == (REPOSITORY / path).read_text(encoding='utf-8')


def test_the_steps_of_the_pages_are_numbered_through():
    numbers = [number for text in PAGES.values() for number in sections(text)]
    assert numbers == [*range(1, 25), *range(29, 35)]  # 25 to 28: course_navigation.md


@pytest.mark.parametrize('text', PAGES.values(), ids=PAGES)
def test_the_contents_are_the_headings(text):
    headings = re.findall(r'^## (\d+\. .*)$', text, re.MULTILINE)
    listed = re.findall(r'^(\d+)\. \[(.*)\]\(#\d+-', text, re.MULTILINE)
    assert [f'{number}. {title}' for number, title in listed] == headings


@each_step
def test_a_step_has_its_parts_in_order(number):
    bold = re.findall(r'^\*\*([A-Z][\w ]+?)[.,:]?\*\*', STEPS[number], re.MULTILINE)
    assert [part for part in bold if part in PARTS] == list(PARTS)


@each_step
def test_a_step_saves_its_programs_where_they_are_run(number):
    saved = SAVED.findall(STEPS[number])
    printed = [path for path, _ in MARKED.findall(STEPS[number]) if path not in LINKED.findall(STEPS[number])]
    assert len(saved) == len(printed)
    assert saved or LINKED.findall(STEPS[number])
    for _, name in saved:
        program = re.escape(name)
        if name.endswith('.py'):
            assert re.search(rf'^(?:.*&& )?chmod \+x (?:\S+/)?{program}\b', STEPS[number], re.MULTILINE), name
        else:
            assert re.search(rf'^roslaunch topic_demo {program}\b', STEPS[number], re.MULTILINE), name


@each_step
def test_what_is_explained_is_in_the_program(number):
    """Each other block of code is made of whole lines of a program of the step, printed or linked, in their order."""
    programs = [program for _, program in MARKED.findall(STEPS[number])]
    programs += [(REPOSITORY / path).read_text(encoding='utf-8') for path in LINKED.findall(STEPS[number])]
    explained = PARTS_OF_FILES.findall(MARKED.sub('', STEPS[number]))
    assert explained
    for part in explained:
        assert any(part in program for program in programs), part


@each_step
def test_a_saved_program_is_a_right_sample_of_an_exercise_of_its_step(number):
    """./run test grading/ grades it. Other printed programs are those of this package, in scripts/."""
    graded = dict(GRADED.findall(STEPS[number]))
    assert graded or number in UNGRADED
    if not graded:
        return
    files = {path for path, _ in MARKED.findall(STEPS[number]) if path not in LINKED.findall(STEPS[number])}
    folders = {'/'.join(path.split('/')[:4]) for path in files}
    assert folders <= {f'{SAMPLES}/{exercise}' for exercise in graded}
    saved = [name for _, name in SAVED.findall(STEPS[number])]
    assert files or number < 12
    if files:
        assert any(re.match(rf'{SAMPLES}/\w+/right_', path) for path in files)
        assert all(graded[folder.split('/')[-1]] in saved for folder in folders)
