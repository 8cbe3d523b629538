"""The table of node kinds agrees with itself and with the scripts that there are."""
import re

from rostest_support import node_kinds
from unit_support import REPOSITORY

NOT_NODES = {'browser', 'demo', 'demo.py', 'grade', 'grade.py', 'index_bag', 'marker_sequence',
             'marker_sequence.py', 'createMarker', 'robotont_urdf', 'robotont_rviz', 'rqt',
             'rqt_console', 'rqt_graph', 'rqt_gui', 'rqt_image_view', 'rqt_plot', 'rqt_reconfigure', 'rqt_tf_tree',
             'rqt_topic', 'terminal', 'xacro',
             'xacro.py'}
MAIN = re.compile(r'^from ([a-z_.]+) import main$', re.MULTILINE)
OWN_ENTRIES = {  # of the tutorials: small programs, and the other servers of the same shape
    'averaging_client', 'fibonacci_callback_client', 'fibonacci_class_client', 'fibonacci_client',
    'fibonacci_client.py', 'patrol.py', 'shape_client', 'averaging_server', 'gen_numbers.py', 'fibonacci_server',
    'turtle_tf2_message_broadcaster.py', 'turtle_tf_message_broadcaster.py', 'turtle_tf2_message_filter',
    'turtle_tf_message_filter', 'dynamic_tf2_broadcaster.py', 'dynamic_tf_broadcaster.py', 'fixed_tf2_broadcaster.py',
    'fixed_tf_broadcaster.py', 'turtle_tf_broadcaster', 'turtle_tf2_broadcaster', 'turtle_tf_listener',
    'turtle_tf_listener.py', 'turtle_tf_listener_wait.py', 'turtle_tf_listener_debug', 'turtle_tf2_listener',
    'turtle_tf2_listener_wait.py'}
BY_THEMSELVES = {  # nodes that only their own rostests start, as they need a device, a scene, a robot or parameters
    'arbotix_driver', 'fake_localization', 'gazebo', 'gazebo_cameras', 'gzclient', 'gzserver', 'joy_node',
    'turtlebot_teleop_joy', 'turtlebot_teleop_key', 'uvc_camera_node', 'video_stream'}
SHORT_LIVED = {'set_pen.py', 'spawn_model',  # calls once and ends, without the service after 10 s
               'map_saver'}  # writes one map and ends


def test_every_node_is_in_the_table():
    """A script that calls the main() of a module that a kind has, too, is the same program by another name."""
    scripts = {path: MAIN.findall(path.read_text(encoding='utf-8'))
               for folder in (REPOSITORY / 'scripts', *REPOSITORY.glob('packages/**/scripts'))
               for path in folder.iterdir() if path.is_file()}
    told = {kind.executable for kind in node_kinds.KINDS}
    modules = {module for path, found in scripts.items() if path.name in told for module in found}
    names = {path.name for path, found in scripts.items() if path.name in told or not modules.intersection(found)}
    assert names - told == NOT_NODES | BY_THEMSELVES | SHORT_LIVED | OWN_ENTRIES
    assert told <= names


def test_nothing_that_has_to_survive_needs_a_lesson():
    needed = node_kinds.in_order([kind.key for kind in node_kinds.HARDENED])
    assert len(node_kinds.HARDENED) >= 16 and not [kind.key for kind in needed if kind.lesson]
