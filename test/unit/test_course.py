"""The course: each step is one folder, its page has the parts of every page, and prints the programs in the folder."""
import ast
import itertools
import os
import re

import pytest

from plain_support import course
from unit_support import REPOSITORY

COURSE = REPOSITORY / 'course'
STEPS = course.steps(COURSE)
WITH_PROGRAM = [step for step in STEPS if step.number != '0']
FIRST_DAYS = [step for step in STEPS if int(re.match(r'\d+', step.number).group()) <= 11]
MAX_LINES = 250  # of a page
MAX_PROGRAM, MAX_NEW = 35, 2  # lines of a program of the first days, and ideas that a step brings
PARTS = ('You will be able to', 'Why a robot needs it', 'Time', 'What must run', 'The program', 'The code explained',
         'Run it', 'What you see', 'What goes wrong', 'Why?', 'Now change it', 'Grade your own', 'Summary', 'Next')
OF_PROGRAMS = 'The program', 'The code explained', 'Grade your own'  # parts that step 0 does not have
MARKED = re.compile(r'^<!-- file: (\S+) -->\n```\w+\n(.*?)^```$', re.MULTILINE | re.DOTALL)
PARTS_OF_FILES = re.compile(r'^```(?:python|xml)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
SAVED = re.compile(r'as\s+`(~/ros_ws/src/topic_demo/(?:scripts|launch)/(\w+\.\w+))`')
LINKED = re.compile(r'\]\((\S+/(?:scripts|src)/\S+\.py)\)')
GRADED = re.compile(r'^run grade (\w+) -- (?:ros(?:run|launch) topic_demo )?(\S+)$', re.MULTILINE)


def text_of(step):
    return step.page.read_text(encoding='utf-8')


def name_of(step):
    return step.folder.name


def programs_of(step):
    """Return {path seen from the page: text} of the programs that a page prints."""
    return {path: course.printed((step.folder / path).read_text(encoding='utf-8'))
            for path, _ in MARKED.findall(text_of(step))}


each_step = pytest.mark.parametrize('step', STEPS, ids=name_of)
each_program = pytest.mark.parametrize('step', WITH_PROGRAM, ids=name_of)


def test_each_folder_is_a_step():
    folders = {path for path in COURSE.iterdir() if path.is_dir() and path.name != course.MORE}
    assert {step.folder for step in STEPS} == folders and len(STEPS) > 30


@each_step
def test_the_page_begins_with_the_number_the_title_and_the_minutes_of_the_step(step):
    text = text_of(step)
    assert text.startswith(f'# {step.number}. {step.title}\n')
    assert f'\n**Time:** {step.minutes} minutes.' in text


@each_step
def test_a_page_is_short_and_brings_at_most_two_ideas(step):
    assert len(text_of(step).splitlines()) <= MAX_LINES
    assert len(step.new) <= MAX_NEW


@each_step
def test_a_page_has_its_parts_in_order(step):
    bold = re.findall(r'^\*\*([A-Z][\w ]+?\??)[.,:]?\*\*', text_of(step), re.MULTILINE)
    expected = [part for part in PARTS if step in WITH_PROGRAM or part not in OF_PROGRAMS]
    assert [part for part in bold if part in PARTS] == expected


@each_step
def test_a_printed_program_is_the_file(step):
    for path, shown in MARKED.findall(text_of(step)):
        assert shown == programs_of(step)[path], path


@each_step
def test_a_program_is_what_a_student_types(step):
    """It is plain rospy, without a module of this repository; those of the first days fit on a screen."""
    for path, text in programs_of(step).items():
        assert 'turtle_robotont' not in text or path.endswith('.launch'), path
        assert step not in FIRST_DAYS or len(text.splitlines()) <= MAX_PROGRAM, path


@each_step
def test_programs_in_the_folder_are_printed(step):
    files = {path.name for kind in ('*.py', '*.launch') for path in step.folder.glob(kind)}
    assert files == {path for path in programs_of(step) if '/' not in path}


def test_the_program_of_robotont_navigation_is_that_of_the_page():
    """catkin installs no links, and the grader follows none out of a program's folder."""
    installed = REPOSITORY / 'packages' / 'navigation' / 'robotont_navigation' / 'scripts' / 'patrol.py'
    assert course.printed((COURSE / '28_patrol' / 'patrol.py').read_text()) == installed.read_text()


def test_rosrun_finds_each_program_of_the_package_once():
    """It looks for executable files in all folders of a package, and asks which one is meant."""
    scripts = {path.name for path in (REPOSITORY / 'scripts').iterdir()}
    assert not [path for path in COURSE.rglob('*') if path.name in scripts and os.access(path, os.X_OK)]


@each_program
def test_a_page_says_where_programs_are_saved_and_runs_them(step):
    text = text_of(step)
    saved = {name for _, name in SAVED.findall(text)}
    assert saved == {path.split('/')[-1] for path in programs_of(step)} and saved or step.number == '34'
    for name in saved:
        if name.endswith('.py'):
            assert re.search(rf'^(?:.*&& )?chmod \+x (?:\S+ )*(?:\S+/)?{re.escape(name)}\b', text, re.MULTILINE), name
        else:
            assert re.search(rf'^roslaunch topic_demo {re.escape(name)}\b', text, re.MULTILINE), name


@each_program
def test_what_is_explained_is_in_the_program(step):
    """Each other block of code is made of whole lines of a program of the step, printed or linked, in their order."""
    text = text_of(step)
    programs = [*programs_of(step).values(),
                *((step.folder / path).read_text(encoding='utf-8') for path in LINKED.findall(text))]
    explained = PARTS_OF_FILES.findall(MARKED.sub('', text))
    assert explained
    for part in explained:
        assert any(part in program for program in programs), part


@each_program
def test_exercise_program_and_step_have_one_name(step):
    names = [path.stem for path in course.exercises_of(step.folder)]
    graded = dict(GRADED.findall(text_of(step)))
    assert sorted(graded) == sorted(names)
    for exercise, file in graded.items():
        assert file.split('/')[-1].split('.')[0] == exercise
    assert not names or step.folder.name.split('_', 1)[1] == names[0]


@each_step
def test_a_copy_for_students_has_a_gap_in_each_answer(step):
    for exercise in course.exercises_of(step.folder):
        answer = course.printed_answer(exercise)
        if answer is None:
            continue
        text = answer.read_text(encoding='utf-8')
        gap = course.without_solution(text)
        assert course.solution_lines(text) and 'your code' in gap, answer
        if answer.suffix == '.py':
            ast.parse(gap)


def test_the_index_lists_the_steps():
    index = (COURSE / 'README.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| \[(\w+)\. (.*?)\]\((\S+)\) \| (\d+) \| (.*?) \| (.*?) \|$', index, re.MULTILINE)
    assert rows == [(step.number, step.title, f'{step.folder.name}/README.md', str(step.minutes), step.needs,
                     ', '.join(f'`{path.stem}`' for path in course.exercises_of(step.folder))) for step in STEPS]


@pytest.mark.parametrize('step, following', list(itertools.zip_longest(STEPS, STEPS[1:]))[:-1],
                         ids=lambda step: getattr(step, 'number', ''))
def test_a_page_leads_to_the_next_one(step, following):
    last = text_of(step).split('**Next:**')[-1]
    assert f'](../{following.folder.name}/README.md)' in last


@pytest.mark.parametrize('text, printed, gap', [
    ('a\n  # solution\n  b\n  # end of solution\nc\n', 'a\n  b\nc\n', 'a\n  # your code\nc\n'),
    ('<x>\n <!-- solution -->\n <y/>\n <!-- end of solution -->\n</x>\n', '<x>\n <y/>\n</x>\n',
     '<x>\n <!-- your code -->\n</x>\n'),
    ('# solution:\na\n', '# solution:\na\n', '# solution:\na\n')])
def test_a_solution_is_cut_out(text, printed, gap):
    assert (course.printed(text), course.without_solution(text)) == (printed, gap)
