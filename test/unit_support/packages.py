"""The packages of this repository: their rooms, the packages that each uses, and its package.xml."""
import functools
import os
import re
from xml.etree import ElementTree

from unit_support import REPOSITORY
from unit_support.imports import imports_of, in_standard_library, nodes_of, strings_in

COURSE = 'turtle_robotont'
ORDER = (('support',), ('vision',), ('simulation',), ('robotont', 'navigation'), ('tutorials', 'utilities', 'web'),
         ('grading',), ('test',))
ROOMS = tuple(room for rooms in ORDER for room in rooms)
OF_THE_COURSE = 'scripts', 'src', 'launch', 'msg', 'srv'  # its folders in the root
LAUNCH_FILES = '.launch', '.xacro', '.urdf'
FOUND = re.compile(r'\$\(find (\w+)\)')
OPENED = {  # (package, package of a later room that one of its launch files starts): why
    ('robotont_description', 'teleop_twist_keyboard'): 'gazebo_teleop_keyboard.launch, as in the original',
    ('robotont_teleop', 'teleop_twist_keyboard'): 'its launch files start it, as in the original',
    ('robotont_gazebo', 'course_page'): 'gazebo.launch browser:=true',
}
COMMAND = re.compile(r'\b(?:rosrun|roslaunch) (\w+)')
PYTHON = b'#!/usr/bin/env python3'
once = functools.lru_cache(maxsize=None)  # of methods: the packages live as long as the tests


class Package:
    """A catkin package: ``folder`` is where its package.xml lies."""

    def __init__(self, folder):
        self.folder = folder
        self.room = room_of(folder)
        self.xml = ElementTree.parse(folder / 'package.xml').getroot()
        self.name = self.xml.findtext('name')

    @property
    def is_stand_in(self):
        return 'stand-in for' in self.xml.findtext('description')

    @once
    def files(self):
        """Return its files, without those of its tests."""
        folders = [self.folder / name for name in OF_THE_COURSE] if self.name == COURSE else [self.folder]
        skipped = {'__pycache__'} if self.name == COURSE else {'__pycache__', 'test'}
        return [path for folder in folders for path in sorted(folder.rglob('*'))
                if path.is_file() and not skipped & set(path.relative_to(self.folder).parts)]

    def libraries(self):
        """Return the names of its importable packages."""
        return {path.name for path in self.folder.glob('src/*')}

    def components(self):
        """Return the packages that its CMakeLists.txt asks catkin for."""
        text = (self.folder / 'CMakeLists.txt').read_text(encoding='utf-8')
        found = re.search(r'find_package\(catkin REQUIRED COMPONENTS ([^)]*)\)', text)
        return set(found.group(1).split()) if found else set()

    @once
    def python(self):
        """Return its Python files: modules and programs."""
        return [path for path in self.files() if path.name != 'setup.py' and is_python(path)]

    @once
    def imports(self):
        """Return the dotted names that its modules and programs import, without the standard library."""
        return {name for path in self.python() for name in imports_of(path) if not in_standard_library(name)}

    @once
    def launched(self):
        """Return the packages that its launch files and robot descriptions start or find."""
        found = set()
        for path in self.files():
            if path.suffix in LAUNCH_FILES:
                found.update(FOUND.findall(path.read_text(encoding='utf-8')))
                found.update(node.get('pkg') for node in ElementTree.parse(path).iter() if node.get('pkg'))
        return found

    def messages(self):
        """Return the packages that its messages, services and actions name."""
        types = {name for path in self.files() if path.suffix in ('.msg', '.srv', '.action')
                 for name in re.findall(r'^(\w+/\w+|Header)\b', path.read_text(encoding='utf-8'), re.MULTILINE)}
        return {'std_msgs' if name == 'Header' else name.partition('/')[0] for name in types}

    @once
    def named(self):
        """Return the names in strings of its Python files: words, modules, types, and programs in commands."""
        strings = {text for path in self.python() for text in strings_in(nodes_of(path))}
        return ({re.split('[./]', text)[0] for text in strings if re.fullmatch(r'\w+(\.\w+)*|\w+/\w+', text)}
                | {name for text in strings for name in COMMAND.findall(text)})

    def depends(self, *tags):
        """Return what its package.xml names in elements of these tags."""
        return {element.text for tag in tags for element in self.xml.findall(tag)}


def room_of(folder):
    """Return the room of a package, '' for the course's."""
    parts = folder.relative_to(REPOSITORY).parts
    return parts[1] if parts[:1] == ('packages',) else parts[0] if parts else ''


def is_python(path):
    if path.suffix:
        return path.suffix in ('.py', '.cfg')
    with open(path, 'rb') as file:
        return file.read(len(PYTHON)) == PYTHON and os.access(path, os.X_OK)


PACKAGES = {package.name: package for package in (
    Package(path.parent) for path in (REPOSITORY / 'package.xml', *sorted(REPOSITORY.glob('packages/**/package.xml')),
                                      REPOSITORY / 'test' / 'rostest_support' / 'package.xml'))}


def later_than(room):
    """Return the names of the packages in rooms that ``room`` must not know."""
    level = next(number for number, rooms in enumerate(ORDER) if room in rooms)
    return {package.name for package in PACKAGES.values()
            if package.room in {name for rooms in ORDER[level + 1:] for name in rooms}}
