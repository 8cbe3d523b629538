"""All pages of the documentation: links, anchors, names of files and nodes, exercises, the parameters of checks."""
import fnmatch
import functools
import os
import re

import pytest
import yaml

from course_grader.rules import exercise, reference
from plain_support.doctor import findings
from unit_support import REPOSITORY
from unit_support.course_files import EXERCISES

PAGES = [REPOSITORY / 'README.md', REPOSITORY / 'CONTRIBUTING.md', *sorted(REPOSITORY.glob('docs/*.md')),
         *sorted(REPOSITORY.glob('course/README.md')),
         *sorted(REPOSITORY.glob('packages/**/README.md'))]
README = REPOSITORY / 'README.md'
STEPS = sorted(REPOSITORY.glob('course/*/README.md'))
MAX_LINES, MAX_LINE = 140, 120  # of README.md
MAX_BYTES = 1.5e6  # of the moving picture in README.md
MAX_PROSE = 120  # [columns] of other pages, but for tables and code
MADE_BY_RUNNING = {'path.png', 'output.txt', 'scores.csv', 'grades.csv', 'path.svg', 'index.html', 'codes.csv',
                   'moodle.csv', 'canvas.csv', 'similar.csv', 'marks.csv', 'deadlines.csv',
                   'anonymous.csv', 'junit.xml', 'result.json', 'results.json',
                   'release-body.md', 'autograder.zip', 'camera.yaml', 'frames.json', 'output/', 'mymap.yaml'}
OF_DEBIAN = {'cameracalibrator.py', 'dynparam', 'static_transform_publisher', 'tf_echo', 'view_frames',
             'view_frames.py'}
SAVED = re.compile(r'as\s+`~/[\w/]+/(\w+\.\w+)`')  # a page says where the reader saves a file
GRADED = re.compile(r'rosrun topic_demo (\w+\.py)')
OWN = re.compile(r'`(\w+\.py)`\s+of\s+your\s+own|[Cc]opy\s.{1,99}?\bto\s+`(\w+\.py)`', re.DOTALL)
OF_THE_READER = {'turtlebot3_world.launch', 'publish_circle.py', 'poses.bag.active', '...', *OF_DEBIAN,
                 *(name for page in STEPS
                   for pattern in (SAVED, GRADED, OWN) for found in pattern.finditer(page.read_text(encoding='utf-8'))
                   for name in found.groups())}
FILE_NAME = re.compile(r'\.(py|launch|bash|txt|md|rst|png|csv|xml|test|toml|yaml)$|[A-Z]\w*\.(msg|srv)$|/$')
NUMBERED = list(REPOSITORY.glob('packages/tutorials/rospy_tutorials/[0-9]*'))
NODES = {path.name for folder in (REPOSITORY / 'scripts', *REPOSITORY.glob('packages/**/scripts'), *NUMBERED)
         for path in folder.iterdir()}
LAUNCH_FILES = {path.name for pattern in ('launch/*.launch', 'packages/**/launch/*.launch')
                for path in REPOSITORY.glob(pattern)}
LAUNCH_FILES |= {name for name in NODES if name.endswith('.launch')}

each_page = pytest.mark.parametrize('path', PAGES, ids=lambda path: str(path.relative_to(REPOSITORY)))


def text_of(path):
    return path.read_text(encoding='utf-8')


def without_code(text):
    return re.sub(r'^```.*?^```$', '', text, flags=re.MULTILINE | re.DOTALL)


def anchors(text):
    """Return the anchors that code hosts make of the headings of a page."""
    headings = re.findall(r'^#{1,6} +(.+?) *$', without_code(text), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


def dead_links(text, folder):
    """Return the links of a page in ``folder`` to missing files or headings."""
    dead = []
    for link in re.findall(r'\]\(([^)\s]+)\)', without_code(text)):
        name, _, anchor = link.partition('#')
        target = folder / name
        if '://' in link:
            continue
        if name and not target.exists():
            dead.append(link)
        elif anchor and anchor not in anchors(text_of(target) if name else text):
            dead.append(link)
    return dead


@functools.lru_cache(maxsize=None)
def names_below(root):
    """Return the names of all files and folders below a folder."""
    return {name for _, folders, files in os.walk(root) for name in (*folders, *files)}


def dead_names(text, folder, root=REPOSITORY):
    """Return the file names in backticks that do not exist below the folder of the page or the repository."""
    dead = []
    for name in re.findall(r'(?<!`)`([^`\s]+)`(?!`)', without_code(text)):
        stands_for_many = re.search('[A-Z]{4}', name)  # NAME.yaml
        if not FILE_NAME.search(name) or stands_for_many or name in MADE_BY_RUNNING or name.startswith(('~', '/', '.')):
            continue
        path = name.rstrip('/')
        below = fnmatch.filter(names_below(root), path)
        if name not in OF_THE_READER and not below and not [*folder.glob(path), *root.glob(path)]:
            dead.append(name)
    return dead


@each_page
def test_links_lead_somewhere(path):
    assert dead_links(text_of(path), path.parent) == []


@each_page
def test_file_names_are_those_of_files(path):
    assert dead_names(text_of(path), path.parent) == []


@each_page
def test_nodes_and_launch_files_that_are_typed_exist(path):
    code = '\n'.join(re.findall(r'^```.*?^```$|`[^`]+`', text_of(path), re.MULTILINE | re.DOTALL))
    typed = set(re.findall(r'(?<![A-Za-z] )ros(?:run|launch) (?:--\S+ )?\w+ ([\w.-]+)', code))
    assert {name for name in typed if not name.isupper()} - OF_THE_READER <= NODES | LAUNCH_FILES


@pytest.mark.parametrize('path', [path for path in PAGES if path in STEPS
                                             or path.parent in (REPOSITORY, REPOSITORY / 'docs')], ids=str)
def test_lines_can_be_read(path):
    long = [line for line in without_code(text_of(path)).splitlines()
            if len(line) > MAX_PROSE and not line.startswith(('|', '!'))]
    assert long == []


def test_readme_is_one_page():
    lines = text_of(README).splitlines()
    assert len(lines) <= MAX_LINES
    assert [line for line in lines if len(line) > MAX_LINE] == []


def test_the_moving_picture_moves_and_is_small():
    picture = (REPOSITORY / re.search(r'!\[[^]]*\]\(([^)]+)\)', text_of(README)).group(1)).read_bytes()
    assert picture[:4] == b'RIFF' and picture[8:12] == b'WEBP'
    assert picture.count(b'ANMF') > 50 and len(picture) < MAX_BYTES  # a frame each


def test_every_page_is_linked_from_the_readme():
    linked = set(re.findall(r'\]\(([^)#\s]+)', text_of(README)))
    moved = {'course.md', 'course_next.md', 'course_navigation.md', 'course_markers.md'}  # for links that people have
    assert {f'docs/{path.name}' for path in REPOSITORY.glob('docs/*.md') if path.name not in moved} <= linked
    assert 'course/README.md' in linked


def test_every_picture_is_shown():
    shown = {(path.parent / name).resolve() for path in PAGES
             for name in re.findall(r'!\[[^]]*\]\(([^)]+)\)', text_of(path))}
    assert set(REPOSITORY.glob('docs/images/*')) <= shown


def test_every_finding_of_the_doctor_has_its_row():
    text = text_of(REPOSITORY / 'docs' / 'troubleshooting.md')
    section = re.search(r'^## What the doctor says\n(.*?)^## ', text, re.MULTILINE | re.DOTALL).group(1)
    rows = re.findall(r'^\| `(\w+)` \|', section, re.MULTILINE)
    assert sorted(rows) == sorted(name for name, function in vars(findings).items() if getattr(
        function, '__annotations__', {}).get('return') is findings.Finding)


def test_worlds_of_the_course_are_those_of_exercises():
    worlds = [world for page in STEPS
              for world in re.findall(r'^```yaml\n(.*?)^```$', text_of(page), re.MULTILINE | re.DOTALL)]
    graded = [exercise.load(path).world for path in EXERCISES.values()]
    assert worlds and all(yaml.safe_load(world) in graded for world in worlds)


@pytest.mark.parametrize('section', reference.SECTIONS)
def test_parameters_of_exercise_files_are_described(section):
    text = text_of(REPOSITORY / 'docs' / 'exercise_files.md')
    below = re.search(rf'^## {section}\n(.*?)(?=^## |\Z)', text, re.MULTILINE | re.DOTALL).group(1)
    table = ''.join(re.findall(r'^\|.*\n', below, re.MULTILINE))
    assert table == reference.markdown(section), f'replace the table below {section} by the one on the right'


def test_keys_of_exercise_files_are_described():
    text = text_of(REPOSITORY / 'docs' / 'exercise_files.md')
    keys = re.search(r'^## Keys\n(.*?)^## ', text, re.MULTILINE | re.DOTALL).group(1)
    assert set(re.findall(r'^\| `(\w+)`', keys, re.MULTILINE)) == set(exercise.KEYS)
    assert text_of(EXERCISES['stop_at_x']) in text


@pytest.mark.parametrize('text, dead', [
    ('![a](doc/a.png) [b](https://x.org/b.png) [c](b.md#two-words) [d](#here)\n## Here', []),
    ('![a](doc/b.png)', ['doc/b.png']),
    ('[c](b.md#three) [d](#there)\n# Here', ['b.md#three', '#there']),
    ('```\n[a](b)\n```', []),
])
def test_dead_links_are_found(text, dead, tmp_path):
    os.makedirs(tmp_path / 'doc')
    (tmp_path / 'doc' / 'a.png').touch()
    (tmp_path / 'b.md').write_text('# Two words\n', encoding='utf-8')
    assert dead_links(text, tmp_path) == dead


@pytest.mark.parametrize('text, dead', [
    ('`a.png` and `doc/a.png` and `doc/`, `no file`, `*.png`, `output/`', []),
    ('`b.png` `doc/b.png` `docs/` `doc/*.csv`', ['b.png', 'doc/b.png', 'docs/', 'doc/*.csv']),
])
def test_dead_names_are_found(text, dead, tmp_path):
    os.makedirs(tmp_path / 'doc')
    (tmp_path / 'doc' / 'a.png').touch()
    assert dead_names(text, tmp_path, tmp_path) == dead


def test_the_page_on_security_has_each_hostile_program():
    page = text_of(REPOSITORY / 'docs' / 'grading_security.md')
    programs = sorted(path.stem for path in REPOSITORY.glob('test/data/red_team/*.*'))
    assert programs and [name for name in programs if f'| `{name}` |' not in page] == []
