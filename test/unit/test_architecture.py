"""What holds the repository together: which way imports go, launch arguments' texts, scripts and module sizes."""
import ast
import importlib.util
import os
import pathlib
import sysconfig
import xml.etree.ElementTree as ElementTree

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
STAND_INS = REPOSITORY / 'stand_ins'
COURSE = REPOSITORY / 'src' / 'turtle_robotont'
NODE_LAYER = ['ar_control', 'course', 'course_markers', 'course_nodes', 'demo', 'drive_services', 'driver',
              'node_params', 'robot_driver', 'stage', 'turtle_driver', 'turtle_tasks']  # only these may import ROS
GRADING_NODES = ['cli', 'session', 'sources', 'stimuli']  # of turtle_robotont.grading, likewise
STAND_IN_LOGIC = {'ar_track_alvar': ['command_line', 'debug_picture', 'gates'],
                  'robotont_gazebo': ['backdrop', 'camera', 'colours', 'faces', 'frames', 'layers', 'meshes',
                                      'overhead', 'renderer', 'sdf', 'sight', 'textures', 'worlds'],
                  'turtlesim': ['canvas', 'drawn_world', 'recording', 'replay', 'sprites'],
                  'usb_cam': ['calibration', 'capture', 'devices', 'pace', 'sources']}  # must do without ROS
CORES = {'alvar_core', 'kinematic_core'}  # packages without ROS
PICTURES = {'cv2', 'numpy'}  # what ROS-free modules may use beside the standard library
CONVERSIONS = {'images': {'cv2', 'numpy', 'sensor_msgs'}, 'velocities': {'geometry_msgs'}}  # of kinematic_ros
PAPER = {'cairo'}  # and alvar_core's sheets to print
ROS_ITSELF = {'genmsg', 'genpy', 'rosgraph', 'rosgraph_msgs', 'rospkg', 'rospy', 'std_srvs'}
LONGEST_MODULE = 400  # [lines], but for INTERNALS, which is one module by intent
INTERNALS = 'stand_ins/kinematic_ros/src/kinematic_ros/rospy_internals.py'  # may use private parts of rospy
PRIVATE_MODULES = [f'rospy.{name}' for name in ('core', 'impl', 'msg', 'names', 'rostime', 'service', 'topics')]
PRIVATE_ATTRIBUTES = {'impl', '_connection_header', '_set_rostime'}
OLDEST_PYTHON = (3, 8)  # that of Ubuntu 20.04, where ROS Noetic comes from

MORE = {'rays': 'numpy', 'documents': 'yaml'}  # of kinematic_core: everything else there is plain Python

CORE_MODULES = sorted((STAND_INS / 'kinematic_core' / 'src' / 'kinematic_core').glob('*.py'))
ALVAR_MODULES = sorted((STAND_INS / 'alvar_core' / 'src' / 'alvar_core').rglob('*.py'))
ROS_MODULES = sorted((STAND_INS / 'kinematic_ros' / 'src' / 'kinematic_ros').glob('*.py'))
COURSE_LOGIC = sorted(path for path in COURSE.glob('*.py') if path.stem not in NODE_LAYER)
SCRIPTS = sorted(path for folder in (REPOSITORY / 'scripts', *STAND_INS.glob('*/scripts')) for path in folder.iterdir()
                 if path.is_file())
STAND_IN_MODULES = sorted(STAND_INS.rglob('*.py')) + [path for path in SCRIPTS if STAND_INS in path.parents
                                                      and path.suffix != '.py']
MODULES = sorted({path for folder in ('src', 'scripts', 'stand_ins', 'bench', 'stress', 'test')
                  for path in (REPOSITORY / folder).rglob('*.py')} | set(SCRIPTS))
LAUNCH_FILES = sorted([*REPOSITORY.glob('launch/*.launch'), *STAND_INS.glob('*/launch/*.launch')])


def name_of(path):
    return str(path.relative_to(REPOSITORY))


def each(paths):
    return pytest.mark.parametrize('path', paths, ids=name_of)


def imported(source, package=''):
    """Return the dotted names of everything that Python source imports, wherever in it; of ``package`` itself."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = '.'.join(filter(None, (package if node.level else '', node.module)))
            names.update(f'{base}.{alias.name}' for alias in node.names)
    return names


def imports_of(path):
    return imported(path.read_text(encoding='utf-8'), path.parent.name)


def top(name):
    return name.partition('.')[0]


def in_standard_library(name):
    spec = importlib.util.find_spec(top(name))
    if spec is None or spec.origin is None:
        return False
    if spec.origin in ('built-in', 'frozen'):
        return True
    folder = pathlib.Path(sysconfig.get_paths()['stdlib']).resolve()
    parents = pathlib.Path(spec.origin).resolve().parents
    return folder in parents and not any(parent.name in ('site-packages', 'dist-packages') for parent in parents)


def foreign(path, allowed):
    """Return what a module imports that is neither in the standard library nor in a package of ``allowed``."""
    return {name for name in imports_of(path) if top(name) not in allowed and not in_standard_library(name)}


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


@each(CORE_MODULES)
def test_core_imports_only_the_standard_library_and_itself(path):
    assert foreign(path, {'kinematic_core', MORE.get(path.stem)}) == set()


@each(ALVAR_MODULES)
def test_alvar_core_never_imports_ros(path):
    assert foreign(path, {'alvar_core', 'kinematic_core', *PICTURES, *PAPER}) == set()


@each(ROS_MODULES)
def test_kinematic_ros_imports_only_ros_and_the_core(path):
    assert foreign(path, {'kinematic_core', 'kinematic_ros', *ROS_ITSELF, *CONVERSIONS.get(path.stem, [])}) == set()


@each(COURSE_LOGIC)
def test_course_logic_never_imports_ros_nor_the_node_layer(path):
    assert foreign(path, {*CORES, 'turtle_robotont', *PICTURES}) == set()
    layers = {f'turtle_robotont.{module}' for module in (*NODE_LAYER, 'msg', 'srv')}
    assert {name for name in imports_of(path) if '.'.join(name.split('.')[:2]) in layers} == set()


@each(sorted(path for path in (COURSE / 'grading').glob('*.py') if path.stem not in GRADING_NODES))
def test_grading_never_imports_ros_but_in_its_nodes(path):
    assert foreign(path, {*CORES, 'turtle_robotont', 'tqdm', 'yaml', *PICTURES}) == set()
    nodes = {f'turtle_robotont.grading.{module}' for module in GRADING_NODES}
    assert {name for name in imports_of(path) if '.'.join(name.split('.')[:3]) in nodes} == set()


def test_list_of_the_node_layer_is_up_to_date():
    ros = {path.stem for path in COURSE.glob('*.py')
           if foreign(path, {*CORES, 'turtle_robotont', *PICTURES})}
    assert ros <= set(NODE_LAYER)
    assert {f'{module}.py' for module in NODE_LAYER} <= set(os.listdir(COURSE))
    assert len(COURSE_LOGIC) >= 4


@pytest.mark.parametrize('package, module', [(package, module) for package, modules in STAND_IN_LOGIC.items()
                                             for module in modules])
def test_logic_of_stand_ins_never_imports_ros(package, module):
    path = STAND_INS / package / 'src' / package / f'{module}.py'
    assert foreign(path, {*CORES, package, 'yaml', *PICTURES}) == set()
    used = {name.split('.')[1] for name in imports_of(path) if top(name) == package}
    assert used <= set(STAND_IN_LOGIC[package])


@each(STAND_IN_MODULES)
def test_no_stand_in_imports_the_course(path):
    assert 'turtle_robotont' not in map(top, imports_of(path))


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
def test_module_is_short_and_in_the_oldest_python(path):
    source = path.read_text(encoding='utf-8')
    assert source.count('\n') <= LONGEST_MODULE or name_of(path) == INTERNALS
    ast.parse(source, feature_version=OLDEST_PYTHON)


def dotted(node):
    """Return a.b.c of the expression a.b.c, '' of anything else."""
    if isinstance(node, ast.Attribute):
        before = dotted(node.value)
        return before and f'{before}.{node.attr}'
    return node.id if isinstance(node, ast.Name) else ''


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


@each([path for path in MODULES if name_of(path) != INTERNALS and 'test' not in path.relative_to(REPOSITORY).parts])
def test_one_module_uses_private_parts_of_rospy(path):
    assert private_parts(path.read_text(encoding='utf-8')) == set(), f'use or extend {INTERNALS}'


@each([path for path in MODULES if 'test' not in path.relative_to(REPOSITORY).parts and 'bench' not in path.parts])
def test_who_calls_init_node_has_servers_that_idle_connections_do_not_block(path):
    source = path.read_text(encoding='utf-8')
    if 'rospy.init_node' in {dotted(node) for node in ast.walk(ast.parse(source))}:
        assert 'servers.protect()' in source, 'call nodes.init_node, or servers.protect() before it'


def test_the_repository_was_found():
    assert (REPOSITORY / INTERNALS).is_file()
    assert len(CORE_MODULES) >= 4 and len(ROS_MODULES) >= 4 and len(SCRIPTS) >= 11
    assert len(STAND_IN_MODULES) >= 20 and len(LAUNCH_FILES) >= 8 and len(MODULES) >= 50
