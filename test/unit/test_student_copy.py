"""./run link --without-solutions: what students get has no solution in it, and what it promises works."""
import ast
import os
import re
import shutil
import subprocess

import pytest

from plain_support import course
from unit_support import REPOSITORY
from unit_support.course_files import COURSE, EXERCISES, programs

pytestmark = pytest.mark.slow
WINDOW = 6  # statements in a row that only a solution has
BUILD_TIMEOUT = 300.0  # [s]; it takes 40


def link(*arguments):
    result = subprocess.run([REPOSITORY / 'run', 'link', *arguments], capture_output=True, text=True, check=False)
    return result.returncode, result.stderr


@pytest.fixture(scope='module')
def src(tmp_path_factory):
    folder = tmp_path_factory.mktemp('student') / 'catkin_ws' / 'src'
    folder.mkdir(parents=True)
    code, output = link('--without-solutions', folder.parent)
    assert code == 0, output
    assert 'all commands but demo, test and bench work' in output and output.endswith('&& catkin_make\n')
    return folder


@pytest.fixture(scope='module')
def copy(src):
    return src / 'turtle_robotont'


def lines_of(text):
    return [line.strip() for line in text.splitlines() if line.strip() and not re.match(r'\s*(#|import|from)\b', line)]


def windows_of(lines):
    return {tuple(lines[first:first + WINDOW]) for first in range(len(lines) - WINDOW + 1)}


def test_no_solution_is_in_it(copy):
    nodes = [path for path in (REPOSITORY / 'scripts').glob('*.py') if 'elsewhere' not in path.read_text()]
    nodes += [path for path in (REPOSITORY / 'src' / 'turtle_robotont').glob('*/*.py') if path.stem != '__init__']
    answers = [path for path in programs('right') if path.suffix not in ('.pgm', '.yaml')]  # maps
    assert len(nodes) > 15 and len(answers) > 50
    solved = {window: path for path in nodes + answers for window in windows_of(lines_of(path.read_text()))}
    for path in (REPOSITORY / 'course').glob('*/*.*'):  # what a page shows in any case
        if path.suffix in ('.py', '.launch'):
            for window in windows_of(lines_of(course.without_solution(path.read_text()))):
                solved.pop(window, None)
    lessons = set()  # ROS's own tutorials, which everybody can read, begin and end like them
    for path in (REPOSITORY / 'packages' / 'tutorials').rglob('*.py'):
        lessons |= windows_of(lines_of(path.read_text()))
    for path in copy.rglob('*'):
        if path.suffix in ('.py', '.md', '.launch', '.bash', '') and path.is_file():
            found = (windows_of(lines_of(path.read_text(errors='ignore'))) & set(solved)) - lessons
            assert not found, f'{path} has lines of {solved[found.pop()]}'


def solutions():
    """Yield (step, line): each line of the solutions that is in no other program of the course."""
    for step in course.steps(COURSE):
        for path in (*step.folder.glob('*.py'), *step.folder.glob('*.launch')):
            for line in course.solution_lines(path.read_text()):
                if len(line.strip()) > 25:
                    yield step, line


def test_pages_show_the_gap_and_not_the_solution(copy):
    gaps = 0
    for step, line in solutions():
        page = (copy / 'course' / step.folder.name / 'README.md').read_text()
        assert f'\n{line}' not in page, line
        gaps += 'your code' in page
    assert gaps > 100


def test_nothing_leads_back_to_the_solutions(copy, src):
    assert not (copy / '.git').exists() and not (copy / 'test' / 'data').exists()
    for path in (*src.iterdir(), *copy.rglob('*')):
        assert REPOSITORY not in path.resolve().parents and path.resolve() != REPOSITORY, path
    assert {path.name for path in src.iterdir() if path.is_symlink()} >= {'turtlesim', 'course_grader'}


def test_its_programs_and_pages_are_there(copy):
    listed = re.findall(r'scripts/(\w+\.py)', (copy / 'CMakeLists.txt').read_text())
    scripts = sorted(path.name for path in (copy / 'scripts').iterdir())
    assert sorted(listed) == scripts == ['browser.py', 'grade.py', 'marker_sequence.py']
    for page in [copy / 'README.md', *(copy / 'docs').glob('*.md')]:
        for target in re.findall(r'\]\(([^)#\s]+)', page.read_text()):
            assert '://' in target or (page.parent / target).exists(), f'{page.name}: {target}'
    assert list(course.exercises(copy / 'course')) == list(EXERCISES)
    assert [step.title for step in course.steps(copy / 'course')] == [step.title for step in course.steps(COURSE)]
    assert not list(copy.rglob('samples'))
    for path in copy.rglob('*.py'):
        ast.parse(path.read_text(encoding='utf-8'))


@pytest.mark.parametrize('command', ['demo', 'test', 'bench'])
def test_commands_that_it_lacks_say_so(copy, command):
    done = subprocess.run([copy / 'run', command], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and f'it has no ./run {command}.' in done.stderr
    assert './run grade EXERCISE -- PROGRAM' in done.stderr


def test_what_is_there_already_stays(src, tmp_path):
    code, output = link('--without-solutions', src)
    assert code == 1 and f'Move it out of the workspace (mv {src}/turtle_robotont ~)' in output
    (tmp_path / 'src').mkdir()
    (tmp_path / 'src' / 'turtle_robotont').symlink_to(REPOSITORY)
    code, output = link('--without-solutions', tmp_path)
    assert code == 1 and 'is a link to the solutions' in output
    assert (tmp_path / 'src' / 'turtle_robotont').is_symlink()


def test_a_full_disk_leaves_no_half_of_it(tmp_path):
    (tmp_path / 'src').mkdir()
    done = subprocess.run(['bash', '-c', 'ulimit -f 16; exec "$@"', 'bash', REPOSITORY / 'run', 'link',
                           '--without-solutions', tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and f'{tmp_path}/src/turtle_robotont cannot be written: ' in done.stderr
    assert 'File too large' in done.stderr and f'(df -h {tmp_path}/src says' in done.stderr
    assert 'Traceback' not in done.stderr and os.listdir(tmp_path / 'src') == []


def test_a_copy_that_is_interrupted_leaves_nothing(tmp_path):
    (tmp_path / 'src').mkdir()
    program = ('import sys; sys.path.insert(0, sys.argv[1]); import pathlib, student_copy\n'
               'def stop(*_): raise KeyboardInterrupt\n'
               'student_copy._without_dead_links = stop\n'
               'student_copy.copy(pathlib.Path(sys.argv[2]))')
    done = subprocess.run(['python3', '-c', program, REPOSITORY / 'tools', tmp_path / 'src' / 'turtle_robotont'],
                          capture_output=True, text=True, check=False)
    assert 'KeyboardInterrupt' in done.stderr and os.listdir(tmp_path / 'src') == []


@pytest.mark.nightly
def test_the_package_is_built_with_catkin_make(src, tmp_path):
    (tmp_path / 'src').mkdir()
    for name in ('turtle_robotont', 'turtlesim', 'ar_track_alvar_msgs'):
        shutil.copytree((src / name).resolve(), tmp_path / 'src' / name, symlinks=True, ignore=shutil.ignore_patterns(
            *(['packages']
              if name == 'turtle_robotont' else [])))
    environment = {'PATH': os.defpath, 'HOME': os.environ.get('HOME', '/'), 'LANG': 'C.UTF-8',
                   'ROS_LANG_DISABLE': 'geneus:genlisp:gennodejs:gencpp'}
    done = subprocess.run(['catkin_make', '-j2'], cwd=tmp_path, env=environment, capture_output=True, text=True,
                          timeout=BUILD_TIMEOUT, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / 'devel' / 'lib' / 'turtle_robotont' / 'grade.py').exists()
