"""What holds the repository together: layers, folders without ROS, launch arguments' texts, scripts.

A module's folder tells what it may import: see ``LAYERS`` and ``ROS_FREE``. No list here names a single module.
"""
import ast
import functools
import importlib.metadata
import importlib.util
import os
import pathlib
import re
import sysconfig
import xml.etree.ElementTree as ElementTree

import pytest

from unit_support.imports import imported, in_standard_library, top

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ('support', 'simulation', 'vision', 'lessons', 'browser', 'grading', 'demo')  # a package of ours is ROOM/NAME
PACKAGES = {path.name: path for path in sorted(REPOSITORY.glob('*/*/src/*'))
            if path.parts[-4] in ROOMS and (path / '__init__.py').exists()}
PACKAGES['turtle_robotont'] = REPOSITORY / 'src' / 'turtle_robotont'
BASES = [{'plain_support'}, {'rospy_support'}, {'kinematic_core', 'alvar_core', 'rosbridge_core'},
         {'sim_ros'}]  # before all rooms, in this order: what programs and nodes need, libraries, what simulators need
LAST = {'rostest_support'}


def rest_of(*rooms):
    return {name for name, path in PACKAGES.items() if path.relative_to(REPOSITORY).parts[0] in rooms
            and name not in set.union(LAST, *BASES)}


LAYERS = [*BASES, rest_of('support', 'simulation', 'vision'), rest_of('lessons', 'browser'), rest_of('grading'),
          {'turtle_robotont'}, rest_of('demo'), LAST]  # each imports from itself and from those before

PLAIN, IMAGES = set(), {'cv2', 'numpy'}
ROS_FREE = {'simulation/kinematic_core/src': {'numpy', 'gymnasium'},  # most do without: test_core_import.py
            'vision/alvar_core/src': IMAGES | {'cairo'},
            'vision/marker_pictures/src': IMAGES,
            'support/plain_support/src': {'psutil', 'yaml'},  # most do without: test_plain_import.py
            'support/plain_support/src/plain_support/doctor': PLAIN,
            'browser/rosbridge_core/src': IMAGES | {'cbor2', 'tornado'},
            'grading/course_grader/src/course_grader/isolation': {'psutil'},
            'grading/course_grader/src/course_grader/rules': IMAGES | {'yaml'},
            'grading/course_grader/src/course_grader/classes': {'psutil', 'tqdm'},
            'grading/course_grader/src/course_grader/formats': IMAGES | {'jinja2'},
            'grading/course_grader/src/course_grader/supervision': {'psutil'},
            'src/turtle_robotont/driving': PLAIN,
            'src/turtle_robotont/markers': PLAIN,
            '*/*/src/*/core': IMAGES | {'yaml'}}  # folder: what it may use beside the standard library and us
INTERNALS = 'support/rospy_support/src/rospy_support/rospy_internals.py'  # may use private parts of rospy
REPAIR = 'support/rospy_support/python_path/rospy_repair.py'  # too: it is loaded where rospy_support is not
PRIVATE_MODULES = [f'rospy.{name}' for name in ('core', 'impl', 'msg', 'names', 'rostime', 'service', 'topics')]
PRIVATE_ATTRIBUTES = {'impl', '_connection_header', '_set_rostime'}
REQUIREMENTS = {'stress': ('requirements.txt', 'stress/requirements.txt')}  # folder: what its command installs
REQUIREMENTS.update(dict.fromkeys(('bench', 'scripts', 'src', *ROOMS), ('requirements.txt',)))
EXTRAS = {'gymnasium'}  # of kinematic_core; ./run bench environments installs it, too
NUMBERED = 'lessons/rospy_tutorials/[0-9]*'  # its folders of programs and launch files
OLDEST_PYTHON = (3, 8)  # that of Ubuntu 20.04, where ROS Noetic comes from


def name_of(path):
    return str(path.relative_to(REPOSITORY))


def each(paths):
    return pytest.mark.parametrize('path', paths, ids=name_of)


SCRIPTS = sorted(path for pattern in ('scripts/*', '*/*/scripts/*', f'{NUMBERED}/*')
                 for path in REPOSITORY.glob(pattern) if path.is_file() and path.suffix != '.launch')
MODULES = sorted({path for folder in ('src', *ROOMS, 'scripts', 'bench', 'stress', 'test')
                  for path in (REPOSITORY / folder).rglob('*.py')} | set(SCRIPTS))
PACKAGED = [path for folder in PACKAGES.values() for path in sorted(folder.rglob('*.py'))]
LESSON_PATTERNS = (*(f'lessons/{name}/scripts/*' for name in ('actionlib_tutorials', 'turtle_actionlib', 'turtle_tf',
                                                               'turtle_tf2')), f'{NUMBERED}/*')
FORWARDERS = 'browser.py', 'demo.py', 'grade.py', 'marker_sequence.py'  # of the root: they start another package's
CONTROLLED = 'ar_maze.py', 'drive_server.py', 'drive_shape.py'  # their controllers, without ROS, lie in the package
LESSONS = [path for path in SCRIPTS if any(path.match(pattern) for pattern in LESSON_PATTERNS)
           or path.parent == REPOSITORY / 'scripts' and path.name not in FORWARDERS]  # students read and copy these
OF_LESSONS = {'rospy', 'tf', 'tf2_ros', 'tf2_geometry_msgs', 'tf_conversions', 'actionlib', 'numpy',
              'sensor_msgs.point_cloud2'}  # and messages, the standard library, one module of the own package
OWN_MODULES = 1
LAUNCH_FILES = sorted([*REPOSITORY.glob('launch/*.launch'), *REPOSITORY.glob('*/*/launch/*.launch'),
                       *REPOSITORY.glob(f'{NUMBERED}/*.launch')])
WITHOUT_ROS = [(path, allowed) for pattern, allowed in ROS_FREE.items() for folder in REPOSITORY.glob(pattern)
               for path in sorted(folder.rglob('*.py'))]


def imports_of(path):
    return imported(path.read_text(encoding='utf-8'), path.parent.name)


def package_of(path):
    return next(name for name, folder in PACKAGES.items() if folder in path.parents)


def folder_of(name):
    """Return the folder of a module of this repository by its dotted name, or by the name of something in it."""
    parts = name.split('.')
    path = PACKAGES[parts[0]]
    for part in parts[1:]:
        if (path / f'{part}.py').exists():
            return path
        if not (path / part).is_dir():
            break
        path = path / part
    return path


@pytest.mark.parametrize('source, names', [
    ('import os', {'os'}),
    ('import os.path as p, sys', {'os.path', 'sys'}),
    ('from a.b import c, d', {'a.b.c', 'a.b.d'}),
    ('def f():\n    import rospy', {'rospy'}),
    ('try:\n    from tf import x\nexcept ImportError:\n    pass', {'tf.x'}),
    ('from . import a\nfrom .b import c', {'own.a', 'own.b.c'}),
    ('x = "import rospy"  # import tf', set()),
])
def test_imports_are_found_wherever_they_stand(source, names):
    assert imported(source, 'own') == names


@pytest.mark.parametrize('name, known', [
    ('os', True), ('sys', True), ('xml.etree', True), ('math', True),
    ('rospy', False), ('numpy', False), ('pytest', False), ('geometry_msgs.msg', False), ('no_such_module', False),
])
def test_standard_library_is_told_from_the_rest(name, known):
    assert in_standard_library(name) is known


@pytest.mark.parametrize('name, folder', [
    ('plain_support.validation.InvalidInput', 'support/plain_support/src/plain_support'),
    ('kinematic_core.timing.pacing', 'simulation/kinematic_core/src/kinematic_core/timing'),
    ('turtle_robotont.driving.control.Goal', 'src/turtle_robotont/driving'),
    ('turtle_robotont.msg.DriveStatus', 'src/turtle_robotont'),
])
def test_folder_of_an_import_is_found(name, folder):
    assert folder_of(name) == REPOSITORY / folder


def test_every_package_has_its_layer():
    assert set.union(*LAYERS) == set(PACKAGES)


@each(PACKAGED)
def test_imports_go_one_way(path):
    package = package_of(path)
    layer = next(number for number, names in enumerate(LAYERS) if package in names)
    later = set.union(set(), *LAYERS[layer + 1:])
    assert {name for name in imports_of(path) if top(name) in later} == set()


@pytest.mark.parametrize('path, allowed', WITHOUT_ROS, ids=[name_of(path) for path, _ in WITHOUT_ROS])
def test_folder_without_ros_imports_none(path, allowed):
    ours = {name for name in imports_of(path) if top(name) in PACKAGES}
    foreign = {name for name in imports_of(path) - ours if top(name) not in allowed}
    assert {name for name in foreign if not in_standard_library(name)} == set()
    free = {other.parent for other, _ in WITHOUT_ROS}
    assert {name for name in ours if folder_of(name) not in free} == set()


@each(LAUNCH_FILES)
def test_every_launch_argument_has_a_text(path):
    silent = [argument.get('name') for parent in ElementTree.parse(path).iter() if parent.tag != 'include'
              for argument in parent.findall('arg') if not (argument.get('doc') or '').strip()]
    assert silent == []


@each(SCRIPTS)
def test_script_is_executable_and_finds_its_python(path):
    assert os.access(path, os.X_OK)
    assert path.read_text(encoding='utf-8').startswith('#!/usr/bin/env python3\n')


@each(MODULES)
def test_module_parses_with_the_oldest_python(path):
    ast.parse(path.read_text(encoding='utf-8'), feature_version=OLDEST_PYTHON)


def dotted(node):
    """Return a.b.c of the expression a.b.c, '' of anything else."""
    if isinstance(node, ast.Attribute):
        before = dotted(node.value)
        return before and f'{before}.{node.attr}'
    return node.id if isinstance(node, ast.Name) else ''


@functools.lru_cache(maxsize=None)
def distributions():
    """Return {module: distribution} of what pip has installed into the virtual environment, and {distribution: names
    of those that it requires}.
    """
    found = {each.metadata['Name']: each for each in
             importlib.metadata.distributions(path=[sysconfig.get_path('purelib')])}
    return ({top(re.split('[/,]', line)[0]): name for name, each in found.items()
             for line in (each.read_text('RECORD') or '').splitlines()},
            {name: names_in(each.requires or ()) for name, each in found.items()})


def names_in(requirements):
    return {re.match('[A-Za-z0-9_.-]+', line).group() for line in requirements}


@pytest.mark.parametrize('folder', REQUIREMENTS)
def test_a_command_installs_what_its_modules_import(folder):
    """Other commands' requirements, which are installed here, would hide what is missing."""
    distribution_of, requires = distributions()
    required = names_in(line for file in REQUIREMENTS[folder]
                        for line in (REPOSITORY / file).read_text().splitlines())
    required |= set().union(*(requires[name] for name in required))
    names = {top(name) for path in MODULES if path.relative_to(REPOSITORY).parts[0] == folder
             and path.name != 'setup.py' and 'test' not in path.relative_to(REPOSITORY).parts
             for name in imports_of(path)}
    assert {name: distribution_of[name] for name in names if name in distribution_of
            and distribution_of[name] not in required | EXTRAS} == {}


def are_messages(name):
    return name.split('.')[1:2] in (['msg'], ['srv'])


def not_for_a_lesson(names, package, own_modules=OWN_MODULES):
    """Return which of the dotted names a lesson of a package may not import."""
    foreign = {name for name in names if not are_messages(name) and not in_standard_library(name)
               and not any(f'{name}.'.startswith(f'{known}.') for known in OF_LESSONS)}
    own = {name for name in foreign if top(name) == package}
    modules = {name.rpartition('.')[0] for name in own}
    return foreign if len(modules) > own_modules else foreign - own


@pytest.mark.parametrize('names, wrong', [
    ({'rospy', 'math', 'tf.transformations.quaternion_matrix', 'turtlesim.srv.Spawn', 'course.msg.Pose'}, set()),
    ({'rospy', 'rospy_support.nodes'}, {'rospy_support.nodes'}),
    ({'sensor_msgs.point_cloud2', 'sensor_msgs.msg.PointCloud2'}, set()),
    ({'course.shapes.square', 'course.shapes.circle'}, set()),
    ({'course.shapes.square', 'course.nodes.main'}, {'course.shapes.square', 'course.nodes.main'}),
    ({'turtlesim.node'}, {'turtlesim.node'}),
    ({'tfx'}, {'tfx'}),
])
def test_what_a_lesson_may_not_import_is_found(names, wrong):
    assert not_for_a_lesson(names, 'course') == wrong


@each(LESSONS)
def test_a_lesson_runs_wherever_a_student_copies_it(path):
    package = 'turtle_robotont' if path.parents[1] == REPOSITORY else next(
        folder.name for folder in path.parents if (folder / 'package.xml').exists())
    own_modules = 10 if path.name in CONTROLLED else OWN_MODULES
    assert not_for_a_lesson(imports_of(path), package, own_modules) == set()


def private_parts(source):
    """Return what Python source uses of rospy that is not its documented interface."""
    tree = ast.parse(source)
    named = {dotted(node) for node in ast.walk(tree)} | imported(source)
    found = {name for name in named for module in PRIVATE_MODULES if name == module or name.startswith(f'{module}.')}
    return found | {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)
                    and node.attr in PRIVATE_ATTRIBUTES}


@pytest.mark.parametrize('source, found', [
    ('import rospy\nrospy.init_node("a")\nrospy.exceptions.ROSException', set()),
    ('from rospy.impl.registration import get_topic_manager', {'rospy.impl.registration.get_topic_manager'}),
    ('import rospy.rostime', {'rospy.rostime'}),
    ('rospy.core.is_shutdown()', {'rospy.core.is_shutdown', 'rospy.core'}),
    ('publisher.impl.connections', {'impl'}),
    ('message._connection_header["callerid"]', {'_connection_header'}),
])
def test_private_parts_are_found(source, found):
    assert private_parts(source) == found


@each([path for path in MODULES if name_of(path) not in (INTERNALS, REPAIR)
       and 'test' not in path.relative_to(REPOSITORY).parts])
def test_one_module_uses_private_parts_of_rospy(path):
    taught = {'_connection_header'} if path in LESSONS else set()  # of rospy_tutorials/007_connection_header
    assert private_parts(path.read_text(encoding='utf-8')) - taught == set(), f'use or extend {INTERNALS}'


@each([path for path in MODULES if not {'test', 'bench', 'rostest_support'} & set(path.relative_to(REPOSITORY).parts)
       and path not in LESSONS])
def test_who_calls_init_node_has_servers_that_idle_connections_do_not_block(path):
    source = path.read_text(encoding='utf-8')
    if 'rospy.init_node' in {dotted(node) for node in ast.walk(ast.parse(source))}:
        assert 'servers.protect()' in source, 'call nodes.init_node, or servers.protect() before it'


def test_root_holds_no_pictures():
    assert not list(REPOSITORY.glob('*.png')), 'pictures of the docs are in docs/images'


def test_the_repository_was_found():
    assert (REPOSITORY / INTERNALS).is_file() and (REPOSITORY / REPAIR).is_file()
    assert len(PACKAGES) >= 10 and len(WITHOUT_ROS) >= 60 and len(SCRIPTS) >= 11
    assert len(LAUNCH_FILES) >= 8 and len(MODULES) >= 150 and len(LESSONS) >= 40
