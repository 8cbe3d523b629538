"""Each package.xml is true: its dependencies are those that its files use, its licence and version are ours.

ROS: rosdep's names; see ``ROSDEP``. Dependencies of tests are not compared, because helpers of tests know all packages.
"""
import hashlib
import re

import pytest

from unit_support.imports import imports_of, in_standard_library, top
from unit_support.packages import COURSE, OPENED, PACKAGES, REPOSITORY

VERSION = '0.2.0'  # of all packages that stand for nothing else
ROSDEP = {name: f'python3-{name}' for name in (
    'cairo', 'cbor2', 'jinja2', 'numpy', 'psutil', 'rospkg', 'scipy', 'selenium',
    'tornado', 'tqdm')}  # module: rosdep's name
ROSDEP.update(cv2='python3-opencv', tkinter='python3-tk', yaml='python3-yaml')
OPTIONAL = {'dask', 'distributed', 'jupyter_server',  # installed for the commands that need them
            'ament_index_python'}  # a part of ROS 2 that our xacro brings along
PROVENANCE = re.compile(r'A stand-in for (?:the [\w ]+ )?(\w+) (\d+\.\d+\.\d+)\b.*'
                        r'\. It behaves like that version; no code is copied from it\.$')
each_package = pytest.mark.parametrize('package', PACKAGES.values(), ids=list(PACKAGES))


def required(package):
    """Return the rosdep keys of the packages that a package's files import, launch and use in messages."""
    modules = {top(name) for name in package.imports()}
    modules |= {top(name) for path in package.python() for name in imports_of(path)} & {'tkinter'}
    own = {package.name, *(path.stem for path in package.python()), *package.libraries()} | OPTIONAL
    found = {ROSDEP.get(name, name) for name in modules - own} | package.launched() | package.messages()
    found -= {named for name, named in OPENED if name == package.name}
    if package.name == COURSE:  # the demo, the page and cameras are in the rooms: its launch files say who needs which
        found -= {other.name for other in PACKAGES.values() if other.room} - {'turtlesim', 'ar_track_alvar_msgs'}
    kinds = {path.suffix for path in package.files()}
    if kinds & {'.msg', '.srv', '.action'}:
        found.add('message_runtime')
    if '.action' in kinds:
        found.add('actionlib_msgs')
    return found - {package.name}


@each_package
def test_dependencies_are_what_is_used_and_nothing_else(package):
    declared, needed = package.depends('depend', 'exec_depend'), required(package)
    used = needed | package.launched() | package.named() | package.components()
    assert needed - declared == set(), f'missing in the package.xml of {package.name}'
    assert declared - used == set(), f'not used by {package.name}'


def test_the_course_names_what_its_tests_import():
    package = PACKAGES[COURSE]
    paths = sorted((REPOSITORY / 'test' / 'course').glob('*.py'))
    names = {top(name) for path in paths for name in imports_of(path) if not in_standard_library(name)}
    assert package.depends('test_depend') == names - {path.stem for path in paths} - package.depends(
        'depend', 'exec_depend')


@each_package
def test_what_builds_a_package_is_named(package):
    kinds = {path.suffix for path in package.files()}
    messages = bool(kinds & {'.msg', '.srv', '.action'})
    assert ('message_generation' in package.depends('build_depend')) == messages
    assert package.depends('buildtool_depend') == {'catkin'} | (
        {'python3-setuptools'} if (package.folder / 'setup.py').exists() else set())


@each_package
def test_no_dependency_stands_twice(package):
    names = [element.text for element in package.xml if element.tag in ('depend', 'build_depend', 'exec_depend')]
    assert sorted(names) == sorted(set(names))


@each_package
def test_licence_and_address(package):
    """A stand-in names the website of the original. This project has no public address, so it states none."""
    assert package.xml.findtext('license') == 'BSD-3-Clause'
    addresses = [(element.get('type'), element.text.split('/')[2]) for element in package.xml.findall('url')]
    expected = [[('website', site)] for site in ('wiki.ros.org', 'github.com')] if package.is_stand_in else [[]]
    assert addresses in expected


@each_package
def test_version_is_ours_or_that_of_the_original(package):
    """rosversion tells programs which turtlesim it is, so a stand-in has the version that it behaves like."""
    if package.is_stand_in:
        match = PROVENANCE.match(package.xml.findtext('description'))
        assert match, 'the description says which version it stands in for, and that no code of it is here'
        assert match.groups() == (package.name, package.xml.findtext('version'))
    else:
        assert package.xml.findtext('version') == VERSION


def test_the_changelog_has_the_version():
    changes = (REPOSITORY / 'CHANGELOG.rst').read_text(encoding='utf-8')
    assert re.search(rf'^(Upcoming \()?{re.escape(VERSION)}\b', changes, re.MULTILINE)


# ------------------------------------------------------------------------------------------------- files of others

VENDORED = 'vendor'  # a folder of this name holds files of others, listed in its README.md
ROW = re.compile(r'^\| `([^`|]+)` \|.*\| `([0-9a-f]{64})` \|$', re.MULTILINE)


def test_every_vendored_file_is_listed_with_its_hash():
    folders = [path for package in PACKAGES.values() if package.name != COURSE
               for path in package.folder.rglob(VENDORED) if path.is_dir()]
    assert folders
    for folder in folders:
        listed = dict(ROW.findall((folder / 'README.md').read_text()))
        files = {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
                 for path in folder.rglob('*') if path.is_file() and path.parent != folder}
        assert listed == files


def test_minified_files_are_vendored():
    """Files that were not written here lie beside the table of their sources and licences."""
    strange = [path for package in PACKAGES.values() for path in package.files() if path.suffix in ('.js', '.css')
               and max(map(len, path.read_text(encoding='utf-8').splitlines()), default=0) > 1000]
    assert strange and all(VENDORED in path.parts for path in strange)
