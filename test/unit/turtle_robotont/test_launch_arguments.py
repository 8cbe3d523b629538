"""The arguments of the course's launch files reach its nodes: as parameters, or as the turtle of remapped topics."""

import pytest
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from unit_support import REPOSITORY

LAUNCH = REPOSITORY / 'launch'
SPEEDS = {'speed': 4.0, 'turn_speed': 8.0}
DRAWING = {'shape': 'corners', 'corners': [[4.5, 3.0], [4.5, 5.0]], 'size': 0.7, **SPEEDS}


def load(name, arguments):
    """Return the nodes {name: Node} and parameters {name: value} of a launch file."""
    config = ROSLaunchConfig()
    words = [f'{argument}:={str(value).lower() if isinstance(value, bool) else value}'
             for argument, value in arguments.items()]
    XmlLoader().load(str(LAUNCH / name), config, argv=words, verbose=False)
    return {node.name: node for node in config.nodes}, {name: each.value for name, each in config.params.items()}


@pytest.mark.parametrize('name, arguments', [
    ('drive_shape.launch', DRAWING),
    ('drive_robot_shape.launch', {**DRAWING, 'strafe': True}),
    ('stop_at_x.launch', {'x': 6.0, **SPEEDS}),
    ('teleport_tour.launch', {'positions': [[4.0, 8.0], [7.0, 8.0]], 'color': [9, 8, 7], 'width': 5, 'pause': 0.0}),
    ('velocity_publisher.launch', {'linear': 0.75, 'angular': -0.5, 'rate': 4.0}),
    ('pose_subscriber.launch', {'rate': 2.0}),
    ('services.launch', {'mode': 'teleport', 'r': 9, 'g': 8, 'b': 7, 'width': 1, 'off': True, **SPEEDS}),
    ('ar_maze.launch', {'markers': [2, 7], 'distance': 0.9, 'search_speed': 2.0, **SPEEDS}),
])
def test_each_argument_is_a_parameter(name, arguments):
    _, parameters = load(name, {'sim': False, **arguments})
    for argument, value in arguments.items():
        given = [value for key, value in parameters.items() if key.endswith(f'/{argument}')]
        assert given and given == [value] * len(given), argument


def test_each_argument_of_ar_control_is_a_parameter():
    arguments = {'mode': 'follow', 'rate': 5.0, 'log_rate': 2.0, 'frame_axes': 'body', 'linear': 0.1, 'angular': 0.3,
                 'lateral': 0.4, 'marker_id': 5, 'distance': 0.3, 'strafe': True, 'lost_after': 0.7, **SPEEDS}
    _, parameters = load('ar_control.launch', {'track': False, **arguments})
    assert parameters == {f'/ar_control/{argument}': value for argument, value in arguments.items()}


@pytest.mark.parametrize('name, node, topic', [
    ('velocity_publisher.launch', 'velocity_publisher', 'cmd_vel'), ('services.launch', 'set_pen', 'set_pen'),
    ('pose_subscriber.launch', 'pose_subscriber', 'pose'), ('stop_at_x.launch', 'stop_at_x', None),
    ('drive_shape.launch', 'drive_shape', None), ('teleport_tour.launch', 'teleport_tour', None),
    ('services.launch', 'goto_pose_server', None), ('services.launch', 'drive_server', None)])
def test_the_turtle_is_a_parameter_or_that_of_a_topic(name, node, topic):
    nodes, parameters = load(name, {'sim': False, 'turtle': 'anna'})
    if topic:
        assert nodes[node].remap_args == [[f'turtle1/{topic}', f'anna/{topic}']]
    else:
        assert parameters[f'/{node}/turtle'] == 'anna'


@pytest.mark.parametrize('name', ['stop_at_x', 'drive_shape', 'teleport_tour', 'drive_robot_shape', 'ar_maze'])
@pytest.mark.parametrize('stay', [False, True])
def test_a_launch_file_ends_with_its_node_unless_the_simulator_shall_stay(name, stay):
    nodes, _ = load(f'{name}.launch', {'sim': False, 'stay': stay})
    assert nodes[name.replace('_robot_', '_')].required is not stay


@pytest.mark.parametrize('window', [False, True])
def test_the_window_of_turtlesim(window):
    nodes, _ = load('turtlesim.launch', {'window': window})
    assert f'_window:={str(window).lower()}' in nodes['turtlesim'].args


def test_the_simulator_as_a_source_brings_its_own_camera():
    """The tracker listens to the robot's camera; others start usb_cam."""
    nodes, parameters = load('ar_control.launch', {'source': 'simulator'})
    assert 'usb_cam' not in nodes and ['camera_image', 'camera/color/image_raw'] in nodes['ar_track_alvar'].remap_args
    assert parameters['/ar_track_alvar/marker_size'] == 28.0
    nodes, parameters = load('ar_control.launch', {'source': '/pictures'})
    assert 'usb_cam' in nodes and parameters['/usb_cam/video_device'] == '/pictures'
