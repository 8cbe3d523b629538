"""What holds the repository together: the direction of the rooms, folders without ROS, lessons, launch files, scripts.

A module's folder tells what it may import: see ``ORDER`` of unit_support.packages and ``ROS_FREE``. One case is one
rule for one package; what it prints names the files.
"""
import ast
import functools
import importlib.metadata
import os
import re
import sysconfig
import xml.etree.ElementTree as ElementTree

import pytest

from unit_support.imports import imported, imports_in, imports_of, in_standard_library, nodes_of, top, tree_of
from unit_support.packages import COURSE, OPENED, PACKAGES, REPOSITORY, later_than

OURS = set(PACKAGES)
EXCEPTIONS = {  # (package, name of a later room that it uses): why
    **OPENED,
    ('plain_support', COURSE): 'it asks whether rosrun finds this package',
    ('plain_support', 'turtlesim'): 'it asks whether rosrun finds this package, and knows its background',
    ('plain_support', 'ar_track_alvar_msgs'): 'the type of a topic that it explains',
    ('plain_support', 'cv_bridge'): 'it knows that this stand-in has no C++',
    ('course_page', COURSE): 'the page starts launch files of the course, as OPENED starts the page',
    ('course_page', 'course_grader'): 'the panel Grade starts it, as ./run grade does',
    ('gazebo_ros', 'robotont_gazebo'): 'robotonts.launch starts robots of the next room',
    ('gazebo_ros', 'robotont_description'): 'and describes them',
    ('alvar_core', COURSE): 'the name of a folder in ~/.ros',
    ('course_grader', COURSE): 'static_analysis.py knows that its modules may use the wall clock',
}
INTERFACES = {'msg', 'srv', 'cfg'}  # of a stand-in; the real package has them, too

PLAIN, IMAGES = set(), {'cv2', 'numpy'}
ROS_FREE = {'packages/simulation/kinematic_core/src': IMAGES,  # most do without: test_core_import.py
            'packages/simulation/sim_scene/src': IMAGES,
            'packages/navigation/navigation_core/src': IMAGES | {'scipy'},
            'packages/vision/alvar_core/src': IMAGES | {'cairo'},
            'packages/support/plain_support/src': {'numpy', 'psutil', 'rospkg', 'yaml'},  # see test_plain_import.py
            'packages/support/plain_support/src/plain_support/doctor': PLAIN,
            'packages/web/browser_servers/src/browser_servers/core': IMAGES | {'cbor2', 'tornado'},
            'packages/grading/course_grader/src/course_grader/isolation': {'psutil'},
            'packages/grading/course_grader/src/course_grader/rules': IMAGES | {'yaml'},
            'packages/grading/course_grader/src/course_grader/classes': {'psutil', 'tornado', 'tqdm'},
            'packages/grading/course_grader/src/course_grader/formats': IMAGES | {'jinja2'},
            'packages/grading/course_grader/src/course_grader/supervision': {'psutil'},
            'src/turtle_robotont/driving': PLAIN,
            'src/turtle_robotont/markers': PLAIN,
            'packages/grading/course_grader/src/course_grader/demo/core': IMAGES,
            **{str(folder.relative_to(REPOSITORY)): IMAGES | {'yaml'}
               for folder in sorted(REPOSITORY.glob('packages/*/*/src/*/core'))
               if folder.parent.name != 'browser_servers'
               and any(folder.glob('*.py'))}}  # folder: foreign packages that it uses
WITH_ROS = REPOSITORY / 'packages/navigation/navigation_core/src/navigation_core/ros'  # in a folder of ROS_FREE
INTERNALS = 'packages/support/rospy_support/src/rospy_support/rospy_internals'  # may use private parts of rospy
REPAIR = 'packages/support/rospy_support/python_path/rospy_repair.py'  # too: it is loaded where rospy_support is not
PRIVATE_MODULES = [f'rospy.{name}' for name in ('core', 'impl', 'msg', 'names', 'rostime', 'service', 'topics')]
PRIVATE_ATTRIBUTES = {'impl', '_connection_header', '_set_rostime'}
REQUIREMENTS = dict.fromkeys(('tools', 'scripts', 'src', 'packages'), ('requirements.txt',))  # of commands
EXTRAS = {'Jinja2'}  # Debian's python3-jinja2 is there where the tests' one is not

TESTING = {'test', 'bench', 'rostest_support'}  # folders without nodes that users start
MODULES = sorted({path for folder in ('src', 'packages', 'test', 'scripts', 'tools')
                  for path in (REPOSITORY / folder).rglob('*.py')}
                 | {path for package in PACKAGES.values() for path in package.python()})
LESSON_PACKAGES = ('actionlib_tutorials', 'robotont_navigation', 'rospy_tutorials', 'turtle_actionlib', 'turtle_tf',
                   'turtle_tf2')
FORWARDERS = 'browser.py', 'demo.py', 'grade.py', 'marker_sequence.py'  # of the root: they start another package's
CONTROLLED = 'ar_control_node.py', 'ar_maze.py', 'drive_server.py', 'drive_shape.py'  # with controllers of the package
OF_LESSONS = {'rospy', 'tf', 'tf2_ros', 'tf2_geometry_msgs', 'tf_conversions', 'actionlib', 'numpy',
              'sensor_msgs.point_cloud2'}  # and messages, the standard library, one module of the own package
OWN_MODULES = 1
FILES = {name: package.python() for name, package in PACKAGES.items()}
FILES['bench'] = sorted((REPOSITORY / 'tools' / 'bench').rglob('*.py'))
each_package = pytest.mark.parametrize('package', PACKAGES.values(), ids=list(PACKAGES))


def name_of(path):
    return str(path.relative_to(REPOSITORY))


def parts_of(path):
    return set(path.relative_to(REPOSITORY).parts)


def programs(package):
    """Return the programs of a package, as students start them."""
    return [path for path in package.python() if path.parent.name == 'scripts' or path.parent.name[:1].isdigit()]


LESSONS = {name: [path for path in programs(PACKAGES[name]) if path.name not in FORWARDERS]
           for name in (COURSE, *LESSON_PACKAGES)}  # students read and copy these


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


# ------------------------------------------------------------------------------------------------ rooms and packages

@functools.lru_cache(maxsize=None)
def uses(package):
    """Return {kind of place: packages of this repository that a package names there}."""
    return {'imports': {top(name) for name in package.imports()} & OURS, 'launch files': package.launched() & OURS,
            'strings': package.named() & OURS, 'messages': package.messages() & OURS,
            'package.xml': package.depends('depend', 'build_depend', 'build_export_depend', 'exec_depend') & OURS}


def not_allowed(package):
    """Return the packages that a package must not know: of later rooms, and the course, which lies beside them."""
    return later_than(package.room) | (set() if package.room == 'test' else {COURSE})


@pytest.mark.parametrize('package', [each for each in PACKAGES.values() if each.room], ids=lambda each: each.name)
def test_rooms_know_each_other_in_one_direction(package):
    excepted = {named for name, named in EXCEPTIONS if name == package.name}
    assert {kind: names for kind, named in uses(package).items()
            for names in [named & not_allowed(package) - excepted] if names} == {}


def test_no_exception_is_left_over():
    for name, named in EXCEPTIONS:
        assert named in set().union(*uses(PACKAGES[name]).values()) & not_allowed(PACKAGES[name]), (name, named)


def test_the_course_imports_messages_of_two_packages_and_nothing_else_of_the_repository():
    """Its launch files may name packages of the rooms: test_root_package.py and test_launch_files.py."""
    imports = {name for name in PACKAGES[COURSE].imports() if top(name) in OURS - {COURSE}}
    assert {'.'.join(name.split('.')[:2]) for name in imports} <= {
        'turtlesim.msg', 'turtlesim.srv', 'ar_track_alvar_msgs.msg'}


def circle(needs):
    """Return the names in {name: names that it needs} that are on a circle or need one; empty if there is none."""
    left = dict(needs)
    while True:
        free = {name for name, needed in left.items() if not needed & set(left)}
        if not free:
            return set(left)
        left = {name: needed for name, needed in left.items() if name not in free}


@pytest.mark.parametrize('needs, found', [
    ({}, set()), ({'a': {'b'}, 'b': {'c'}, 'c': set()}, set()), ({'a': {'b'}, 'b': {'a'}}, {'a', 'b'}),
    ({'a': {'b'}, 'b': {'c'}, 'c': {'b'}, 'd': {'missing'}}, {'a', 'b', 'c'}),
])
def test_circles_are_found(needs, found):
    assert circle(needs) == found


def test_no_circle_between_packages():
    """Strings do not count: they may name a plug-in, or a program that a text tells the user to start."""
    excepted = {name: {named for owner, named in EXCEPTIONS if owner == name} for name in PACKAGES}
    needs = {name: {needed for kind, names in uses(package).items() if kind != 'strings' for needed in names}
             for name, package in PACKAGES.items()}
    assert circle({name: needed - {name} - excepted[name] for name, needed in needs.items()}) == set()


@pytest.mark.parametrize('package', [each for each in PACKAGES.values() if each.room != 'test'],
                         ids=lambda each: each.name)
def test_no_stand_in_is_a_library(package):
    """Where the real package is installed, it has other modules; its messages are the same."""
    imports = {tuple(name.split('.')[:2]) for name in package.imports() if top(name) in OURS - {package.name}}
    assert {'.'.join(parts) for parts in imports
            if PACKAGES[parts[0]].is_stand_in and not INTERFACES & set(parts[1:])} == set()


def folder_of(name):
    """Return the folder of a module of this repository by its dotted name, or by the name of something in it."""
    parts = name.split('.')
    path = PACKAGES[parts[0]].folder / 'src' / parts[0]
    for part in parts[1:]:
        if (path / f'{part}.py').exists():
            return path
        if not (path / part).is_dir():
            break
        path = path / part
    return path


@pytest.mark.parametrize('name, folder', [
    ('plain_support.validation.InvalidInput', 'packages/support/plain_support/src/plain_support'),
    ('kinematic_core.timing.pacing', 'packages/simulation/kinematic_core/src/kinematic_core/timing'),
    ('kinematic_core.worlds.planar.Pose2D', 'packages/simulation/kinematic_core/src/kinematic_core/worlds'),
    ('turtle_robotont.driving.control.Goal', 'src/turtle_robotont/driving'),
    ('turtle_robotont.msg.DriveStatus', 'src/turtle_robotont'),
])
def test_folder_of_an_import_is_found(name, folder):
    assert folder_of(name) == REPOSITORY / folder


def is_compiled(name):
    """Return whether a dotted name is that of a compiled module, as robotont_gazebo._renderer; none uses ROS."""
    package, _, module = name.partition('.')
    native = PACKAGES[package].folder / 'native'
    return module.startswith('_') and any(f'PYBIND11_MODULE({module.partition(".")[0]},' in path.read_text()
                                          for path in native.glob('*.cpp'))


def modules_without_ros(folder):
    return [path for path in (REPOSITORY / folder).rglob('*.py') if WITH_ROS not in path.parents]


@functools.lru_cache(maxsize=None)
def folders_without_ros():
    return {path.parent for folder in ROS_FREE for path in modules_without_ros(folder)}


@pytest.mark.parametrize('folder', ROS_FREE)
def test_folder_without_ros_imports_none(folder):
    wrong = set()
    for path in sorted(modules_without_ros(folder)):
        for name in imports_of(path):
            free = folder_of(name) in folders_without_ros() or is_compiled(name) if top(name) in OURS else \
                top(name) in ROS_FREE[folder] or in_standard_library(name)
            if not free:
                wrong.add((name_of(path), name))
    assert wrong == set()


FROM_FILE = re.compile(r'__file__\)[\w.()]*\.parents\[(\d+)\]')
OF_PACKAGES = re.compile(r"""(?:/ |join\([^)]*)['"]packages['"/]""")
READS_PACKAGES = {'packages/support/plain_support/src/plain_support/doctor/package_checks.py'}  # those of a repository


def paths_out(text, depth):
    """Return what leads out of the package in the text of a module ``depth`` folders below it."""
    return [found.group() for found in FROM_FILE.finditer(text) if int(found.group(1)) > depth] + \
        OF_PACKAGES.findall(text)


@pytest.mark.parametrize('text, found', [
    ("FOLDER = pathlib.Path(__file__).resolve().parents[2] / 'templates'", []),
    ("Path(__file__).parents[4] / 'simulation'", ['__file__).parents[4]']),
    ("os.path.join(repository, 'packages', 'grading')", ["join(repository, 'packages'"]),
    ("'packages/grading is a folder'", []),
    ("root / 'packages/grading'", ["/ 'packages/"]),
])
def test_paths_out_of_a_package_are_found(text, found):
    assert paths_out(text, 2) == found


@pytest.mark.parametrize('package', [each for each in PACKAGES.values() if each.room != 'test'],
                         ids=lambda each: each.name)
def test_modules_find_other_packages_by_rospack_or_import(package):
    """A path that is computed knows where the rooms lie, which ROS may find elsewhere."""
    found = {name_of(path): paths_out(path.read_text(encoding='utf-8'), len(path.relative_to(package.folder).parts) - 1)
             for path in package.python()}
    assert {name: out for name, out in found.items() if out and name not in READS_PACKAGES} == {}


# ---------------------------------------------------------------------------------------------------- files of each

@each_package
def test_every_launch_argument_has_a_text(package):
    assert [(name_of(path), argument.get('name')) for path in package.files() if path.suffix == '.launch'
            for parent in ElementTree.parse(path).iter() if parent.tag != 'include'
            for argument in parent.findall('arg') if not (argument.get('doc') or '').strip()] == []


@each_package
def test_programs_are_executable_and_find_their_python(package):
    files = [path for path in package.files() if path.parent.name == 'scripts' or
             path.parent.name[:1].isdigit() and path.suffix == '.py']
    assert [name_of(path) for path in files if not os.access(path, os.X_OK)
            or not path.read_text(encoding='utf-8').startswith('#!/usr/bin/env python3\n')] == []


@pytest.mark.parametrize('folder', sorted({path.relative_to(REPOSITORY).parts[0] for path in MODULES}))
def test_modules_parse_with_the_oldest_python(folder):
    for path in MODULES:
        if path.relative_to(REPOSITORY).parts[0] == folder:
            tree_of(path)


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
    """The requirements of other commands, which are installed here, would hide missing packages."""
    distribution_of, requires = distributions()
    required = names_in(line for file in REQUIREMENTS[folder]
                        for line in (REPOSITORY / file).read_text().splitlines())
    if not required <= requires.keys():
        pytest.skip(f'not installed: {", ".join(sorted(required - requires.keys()))}')
    required |= set().union(*(requires[name] for name in required))
    names = {top(name) for path in MODULES if path.relative_to(REPOSITORY).parts[0] == folder
             and path.name != 'setup.py' and 'test' not in parts_of(path) for name in imports_of(path)}
    assert {name: distribution_of[name] for name in names if name in distribution_of
            and distribution_of[name] not in required | EXTRAS} == {}


# --------------------------------------------------------------------------------------------------------- lessons

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


@pytest.mark.parametrize('name', LESSONS)
def test_a_lesson_runs_wherever_a_student_copies_it(name):
    assert {name_of(path): wrong for path in LESSONS[name] for wrong in [
        not_for_a_lesson(imports_of(path), name, 10 if path.name in CONTROLLED else OWN_MODULES)] if wrong} == {}


# -------------------------------------------------------------------------------------------------- parts of rospy

def dotted(node):
    """Return a.b.c of the expression a.b.c, '' of anything else."""
    if isinstance(node, ast.Attribute):
        before = dotted(node.value)
        return before and f'{before}.{node.attr}'
    return node.id if isinstance(node, ast.Name) else ''


def private_parts(nodes):
    """Return what the nodes of parsed Python source use of rospy that is not its documented interface."""
    named = {dotted(node) for node in nodes if isinstance(node, (ast.Attribute, ast.Name))} | imports_in(nodes)
    found = {name for name in named for module in PRIVATE_MODULES if name == module or name.startswith(f'{module}.')}
    return found | {node.attr for node in nodes if isinstance(node, ast.Attribute)
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
    assert private_parts(list(ast.walk(ast.parse(source)))) == found


@pytest.mark.parametrize('name', FILES)
def test_one_place_uses_private_parts_of_rospy(name):
    taught = {'_connection_header'} if name == 'rospy_tutorials' else set()  # by its 007_connection_header
    found = {name_of(path): private_parts(nodes_of(path)) - taught for path in FILES[name]
             if 'test' not in parts_of(path)}
    assert {path: parts for path, parts in found.items() if parts and not path.startswith((INTERNALS, REPAIR))} == {}, \
        f'use or extend {INTERNALS}'


@pytest.mark.parametrize('name', FILES)
def test_who_calls_init_node_has_servers_that_idle_connections_do_not_block(name):
    """Lessons are plain rospy."""
    nodes = [path for path in FILES[name] if not TESTING & parts_of(path) and path not in LESSONS.get(name, ())
             and any(dotted(node) == 'rospy.init_node' for node in nodes_of(path))]
    assert [name_of(path) for path in nodes if 'servers.protect()' not in path.read_text(encoding='utf-8')] == [], \
        'call nodes.init_node, or servers.protect() before it'


# ------------------------------------------------------------------------------------------------------- classes

@functools.lru_cache(maxsize=None)
def set_in_init(definition):
    """Return the private attributes of self that ``__init__`` of a class sets itself."""
    return {target.attr for node in definition.body if getattr(node, 'name', '') == '__init__'
            for target in ast.walk(node) if isinstance(target, ast.Attribute) and isinstance(target.ctx, ast.Store)
            and dotted(target) == f'self.{target.attr}' and target.attr.startswith('_')}


def set_twice(modules):
    """Return (class, base, attributes) of each class whose ``__init__`` sets private attributes that a base sets, too.

    Each then overwrites the state of the other. ``modules`` are the nodes of each; a base is looked for in the same
    module, then by its name everywhere.
    """
    classes = {}
    for nodes in modules:
        for node in nodes:
            if isinstance(node, ast.ClassDef):
                classes.setdefault(node.name, []).append((nodes, node))

    def bases_of(nodes, node):
        for base in node.bases:
            named = classes.get(dotted(base).rpartition('.')[2], [])
            for found in [(place, one) for place, one in named if place is nodes] or named:
                if found[1] is not node:
                    yield found[1]
                    yield from bases_of(*found)
    return [(name, base.name, sorted(both)) for name, found in classes.items() for nodes, node in found
            for base in bases_of(nodes, node) if (both := set_in_init(node) & set_in_init(base))]


def test_attributes_set_twice_are_found():
    source = '\n'.join(f'class {name}:\n def __init__(self):\n  {body}' for name, body in (
        ('A', 'self._x = self._y = None'), ('B(A)', 'self.x = self._z = 1'), ('C(B)', 'self._x, self._z = 1, 2')))
    assert set_twice([list(ast.walk(ast.parse(source)))]) == [('C', 'B', ['_z']), ('C', 'A', ['_x'])]


def test_no_class_overwrites_the_state_of_its_base():
    assert set_twice([nodes_of(path) for path in MODULES]) == [], 'rename them in one of the classes'


def test_root_holds_no_pictures():
    assert not list(REPOSITORY.glob('*.png')), 'pictures of the docs are in docs/images'


def test_the_repository_was_found():
    """A glob that finds nothing would let all of the above pass."""
    assert len(PACKAGES) >= 30 and len(MODULES) >= 150 and sum(map(len, LESSONS.values())) >= 40
    assert all(list((REPOSITORY / folder).rglob('*.py')) for folder in ROS_FREE)
    assert sum(map(len, FILES.values())) >= 150
    assert sum(path.suffix == '.launch' for package in PACKAGES.values() for path in package.files()) >= 30
    assert all(LESSONS.values()) and (REPOSITORY / REPAIR).is_file()
