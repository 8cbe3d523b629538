"""The kinds of nodes in this repository: how each is started, and which names it must register. No ROS.

The rostests of properties that all kinds of nodes share use this table. A kind's simulators and sources must run before
it (`needs`, `in_order`). Several kinds that drive disturb each other on one turtle: `on_turtle` gives one of them
another turtle, which has to be spawned; draw_square also calls reset.
"""

import os
from typing import NamedTuple

import rospkg

WIDTH, HEIGHT = 160, 120  # [px] of the image that usb_cam publishes
TURTLE_SERVICES = tuple(f'/turtle1/{name}' for name in ('set_pen', 'teleport_absolute', 'teleport_relative'))


class NodeKind(NamedTuple):
    """One kind of node.

    ``key`` is its name in tables, ``node`` its name in ROS; ``package``, ``executable``: as for rosrun; ``arguments``:
    parameters and remaps, in which {folder} stands for a folder with an image, {bundle} for the file of a bundle,
    {map} for that of a map;
    ``needs``: keys of the kinds that must run before it; ``published``, ``subscribed``, ``services``: names that it has
    registered once it runs; ``drives``: it moves a turtle or a robot, forever or until it has arrived; ``lesson``: it
    is a program for students to read, plain rospy, so it has to end in time and without a traceback, but neither
    registers again with a new master nor survives a closed output. Keep its standard input open, because
    turtle_teleop_key reads it.
    """

    key: str
    node: str
    package: str
    executable: str
    arguments: tuple = ()
    needs: tuple = ()
    published: tuple = ()
    subscribed: tuple = ()
    services: tuple = ()
    drives: bool = False
    lesson: bool = False

    @property
    def parameters(self):
        """Return {absolute name: text} of the private parameters on its command line."""
        pairs = (argument[1:].split(':=', 1) for argument in self.arguments if argument.startswith('_') and
                 not argument.startswith('__'))
        return {f'{self.node}/{name}': value for name, value in pairs}


KINDS = (
    NodeKind('turtlesim', '/turtlesim', 'turtlesim', 'turtlesim_node', ('_background_r:=7', '_window:=false'),
             published=('/turtle1/pose', '/turtle1/color_sensor'), subscribed=('/turtle1/cmd_vel',),
             services=('/clear', '/kill', '/reset', '/spawn', *TURTLE_SERVICES, '/turtlesim/snapshot')),
    NodeKind('robotont', '/robotont_gazebo', 'robotont_gazebo', 'robotont_gazebo',
             ('_world:=minimaze_ar', '_x:=-2.0'), published=('/odom', '/tf', '/robotont_gazebo/world'),
             subscribed=('/cmd_vel',), services=('/robotont_gazebo/set_pose', '/robotont_gazebo/move_marker')),
    NodeKind('camera', '/robotont_camera', 'robotont_gazebo', 'robotont_camera',
             ('_width:=320', '_height:=240', '_rate:=5'), needs=('robotont',),
             published=('/camera/color/image_raw', '/camera/color/camera_info'),
             subscribed=('/robotont_gazebo/world',)),
    NodeKind('tracker', '/marker_detect', 'ar_track_alvar', 'individualMarkersNoKinect',
             ('camera_image:=/camera/color/image_raw', 'camera_info:=/camera/color/camera_info', '_marker_size:=28.0',
              '_output_frame:=camera_depth_optical_frame', '__name:=marker_detect'), needs=('camera',),
             published=('/ar_pose_marker', '/visualization_marker', '/diagnostics'),
             subscribed=('/camera/color/image_raw', '/camera/color/camera_info')),
    NodeKind('fake_driver', '/fake_driver_node', 'robotont_driver', 'fake_driver_node',
             ('cmd_vel:=/fake/cmd_vel', 'odom:=/fake/odom', '_odom_frame:=fake/odom', '_base_frame:=fake/base'),
             published=('/fake/odom', '/tf'), subscribed=('/fake/cmd_vel',)),
    NodeKind('driver', '/driver_node', 'robotont_driver', 'driver_node',
             tuple(f'{name}:=/real/{name}' for name in ('cmd_vel', 'odom', 'led_pixel', 'led_segment', 'power_supply')),
             published=('/real/odom', '/real/power_supply'), subscribed=('/real/cmd_vel', '/real/led_pixel')),
    NodeKind('depth_scan', '/depthimage_to_laserscan', 'depthimage_to_laserscan', 'depthimage_to_laserscan',
             ('_scan_height:=10', 'image:=/camera/depth/image_rect_raw', 'camera_info:=/camera/depth/camera_info'),
             needs=('camera',), published=('/scan',), subscribed=('/camera/depth/image_rect_raw',)),
    NodeKind('distances', '/distances', 'robotont_laserscan_to_distance', 'laserscan_to_distance.py',
             ('__name:=distances',), needs=('depth_scan',), published=('/scan_to_distance',), subscribed=('/scan',)),
    NodeKind('old_distances', '/old_distances', 'robotont_sensors', 'laserscan_to_distance.py',
             ('__name:=old_distances', '/scan_to_distance:=/old/scan_to_distance'), needs=('depth_scan',),
             published=('/old/scan_to_distance',), subscribed=('/scan',)),
    NodeKind('usb_cam', '/usb_cam', 'usb_cam', 'usb_cam_node',
             ('_video_device:={folder}', '_rate:=5', '_horizontal_fov:=60'),
             published=('/usb_cam/image_raw', '/usb_cam/camera_info'),
             services=('/usb_cam/start_capture', '/usb_cam/stop_capture', '/usb_cam/set_camera_info')),
    NodeKind('bundles', '/bundles', 'ar_track_alvar', 'findMarkerBundlesNoKinect',
             ('_bundle_files:={bundle}', 'camera_image:=/usb_cam/image_raw', 'camera_info:=/usb_cam/camera_info',
              'ar_pose_marker:=/bundles/ar_pose_marker', '_output_frame:=head_camera', '__name:=bundles'),
             needs=('usb_cam',), published=('/bundles/ar_pose_marker', '/visualization_marker', '/diagnostics'),
             subscribed=('/usb_cam/image_raw', '/usb_cam/camera_info')),
    NodeKind('training', '/training', 'ar_track_alvar', 'trainMarkerBundle',
             ('_nof_markers:=3', 'camera_image:=/usb_cam/image_raw', 'camera_info:=/usb_cam/camera_info',
              'ar_pose_marker:=/training/ar_pose_marker', '_output_frame:=head_camera', '__name:=training'),
             needs=('usb_cam',), published=('/training/ar_pose_marker', '/visualization_marker', '/diagnostics'),
             subscribed=('/usb_cam/image_raw', '/usb_cam/camera_info'),
             services=tuple(f'/training/{name}' for name in ('capture', 'optimize', 'save', 'load', 'reset'))),
    NodeKind('depth_tracker', '/depth_tracker', 'ar_track_alvar', 'individualMarkers',
             ('camera_image:=/camera/depth/points', 'camera_info:=/camera/color/camera_info', '_marker_size:=28.0',
              'ar_pose_marker:=/depth_tracker/ar_pose_marker', '_output_frame:=camera_depth_optical_frame',
              '__name:=depth_tracker'), needs=('camera',),
             published=('/depth_tracker/ar_pose_marker', '/visualization_marker', '/ARmarker_points', '/diagnostics'),
             subscribed=('/camera/depth/points', '/camera/color/camera_info')),
    NodeKind('depth_bundles', '/depth_bundles', 'ar_track_alvar', 'findMarkerBundles',
             ('_bundle_files:={bundle}', 'camera_image:=/camera/depth/points', 'camera_info:=/camera/color/camera_info',
              'ar_pose_marker:=/depth_bundles/ar_pose_marker', '_output_frame:=camera_depth_optical_frame',
              '__name:=depth_bundles'), needs=('camera',),
             published=('/depth_bundles/ar_pose_marker', '/visualization_marker', '/ARmarker_points', '/diagnostics'),
             subscribed=('/camera/depth/points', '/camera/color/camera_info')),
    NodeKind('teleop', '/teleop_turtle', 'turtlesim', 'turtle_teleop_key', ('_scale_linear:=1.5',),
             needs=('turtlesim',), published=('/turtle1/cmd_vel',)),
    NodeKind('goto_pose_server', '/goto_pose_server', 'turtle_robotont', 'goto_pose_server.py', ('_speed:=1.5',),
             needs=('turtlesim',), published=('/turtle1/cmd_vel',), subscribed=('/turtle1/pose',),
             services=('/turtle1/gotoPose',), lesson=True),
    NodeKind('drive_server', '/drive_server', 'turtle_robotont', 'drive_server.py', ('_speed:=1.5',),
             needs=('turtlesim',), published=('/turtle1/cmd_vel', '/turtle1/drive_status'),
             subscribed=('/turtle1/pose',), services=('/turtle1/drive_to', '/turtle1/draw_shape'), lesson=True),
    NodeKind('velocity_publisher', '/velocity_publisher', 'turtle_robotont', 'velocity_publisher.py',
             ('__name:=velocity_publisher', '_linear:=0.4'), needs=('turtlesim',), published=('/turtle1/cmd_vel',),
             drives=True, lesson=True),
    NodeKind('pose_subscriber', '/pose_subscriber', 'turtle_robotont', 'pose_subscriber.py',
             ('__name:=pose_subscriber', '_rate:=1'), needs=('turtlesim',), subscribed=('/turtle1/pose',), lesson=True),
    NodeKind('stop_at_x', '/stop_at_x', 'turtle_robotont', 'stop_at_x.py', ('_x:=11.0', '_speed:=0.05'),
             needs=('turtlesim',), published=('/turtle1/cmd_vel',),
             subscribed=('/turtle1/pose',), drives=True, lesson=True),
    NodeKind('drive_shape', '/drive_shape', 'turtle_robotont', 'drive_shape.py', ('_size:=4.0', '_speed:=0.05'),
             needs=('turtlesim',), published=('/turtle1/cmd_vel', '/turtle1/drive_status'),
             subscribed=('/turtle1/pose',), drives=True, lesson=True),
    NodeKind('drive_shape_robot', '/drive_robot', 'turtle_robotont', 'drive_shape.py',
             ('__name:=drive_robot', '_robot:=true', '_speed:=0.05'), needs=('robotont',),
             published=('/cmd_vel', '/drive_status'), subscribed=('/odom',), drives=True, lesson=True),
    NodeKind('teleport_tour', '/teleport_tour', 'turtle_robotont', 'teleport_tour.py', ('_pause:=60',),
             needs=('turtlesim',), drives=True, lesson=True),
    NodeKind('ar_control', '/ar_control', 'turtle_robotont', 'ar_control_node.py',
             ('_mode:=follow', '_log_rate:=1', '_speed:=0.05'),
             needs=('tracker',), published=('/cmd_vel',), subscribed=('/ar_pose_marker',), drives=True, lesson=True),
    NodeKind('ar_maze', '/ar_maze', 'turtle_robotont', 'ar_maze.py', ('_speed:=0.05', '_search_speed:=0.0'),
             needs=('tracker',), published=('/cmd_vel',), subscribed=('/ar_pose_marker',), drives=True, lesson=True),
    NodeKind('rosbridge', '/rosbridge_websocket', 'rosbridge_server', 'rosbridge_websocket', ('_port:=0',),
             published=('/client_count', '/connected_clients')),
    NodeKind('browser', '/browser', 'turtle_robotont', 'browser.py', ('--port=0',)),
    NodeKind('web_video', '/web_video_server', 'web_video_server', 'web_video_server', ('_port:=0',)),
    NodeKind('tf2_web', '/tf2_web_republisher', 'tf2_web_republisher', 'tf2_web_republisher',
             published=('/tf2_web_republisher/feedback',), subscribed=('/tf2_web_republisher/goal',),
             services=('/republish_tfs',)),
    NodeKind('maps', '/map_server', 'map_server', 'map_server', ('{map}', '__name:=map_server'),
             published=('/map', '/map_metadata'), services=('/static_map', '/change_map')),
    NodeKind('mapping', '/slam_gmapping', 'gmapping', 'slam_gmapping',
             ('_base_frame:=base_footprint', 'map:=/mapping/map', 'map_metadata:=/mapping/map_metadata',
              '_transform_publish_period:=0'), needs=('robotont',),
             published=('/mapping/map', '/mapping/map_metadata', '/slam_gmapping/entropy'), subscribed=('/scan',),
             services=('/dynamic_map',)),
    NodeKind('localisation', '/amcl', 'amcl', 'amcl', ('_base_frame_id:=base_footprint',), needs=('robotont',),
             published=('/amcl_pose', '/particlecloud'), subscribed=('/scan', '/initialpose'),
             services=('/global_localization', '/request_nomotion_update', '/set_map')),
    NodeKind('move_base', '/move_base', 'move_base', 'move_base',
             ('_global_costmap/robot_base_frame:=base_footprint', '_local_costmap/robot_base_frame:=base_footprint'),
             needs=('robotont',), published=('/cmd_vel', '/move_base/current_goal'),
             subscribed=('/odom', '/map', '/move_base_simple/goal'),
             services=('/move_base/make_plan', '/move_base/clear_costmaps')),
    NodeKind('rosapi', '/rosapi_node', 'rosapi', 'rosapi_node',
             services=('/rosapi/topics', '/rosapi/get_param', '/rosapi/topics_and_raw_types')),
    NodeKind('draw_square', '/draw_square', 'turtlesim', 'draw_square', ('_side:=1.0',), needs=('turtlesim',),
             published=('/turtle1/cmd_vel',), subscribed=('/turtle1/pose',), drives=True),
    NodeKind('mimic', '/mimic', 'turtlesim', 'mimic', ('__name:=mimic', 'input:=turtle1', 'output:=turtle2'),
             needs=('turtlesim',), published=('/turtle2/cmd_vel',), subscribed=('/turtle1/pose',)),
    NodeKind('broadcaster', '/broadcaster', 'turtle_tf2', 'turtle_tf2_broadcaster.py',
             ('__name:=broadcaster', '_turtle:=turtle1'), needs=('turtlesim',), published=('/tf',),
             subscribed=('/turtle1/pose',), lesson=True),
    NodeKind('follower_broadcaster', '/follower_broadcaster', 'turtle_tf', 'turtle_tf_broadcaster.py',
             ('__name:=follower_broadcaster', '_turtle:=turtle2'), needs=('turtlesim',), published=('/tf',),
             subscribed=('/turtle2/pose',), lesson=True),
    NodeKind('follower', '/follower', 'turtle_tf2', 'turtle_tf2_listener.py',
             ('__name:=follower', 'turtle2/cmd_vel:=/turtle8/cmd_vel'),  # mimic drives turtle2
             needs=('broadcaster', 'follower_broadcaster'), published=('/turtle8/cmd_vel',),
             subscribed=('/tf', '/tf_static'), drives=True, lesson=True),
    NodeKind('shape_server', '/turtle_shape', 'turtle_actionlib', 'shape_server', needs=('turtlesim',),
             published=('/turtle1/cmd_vel', '/turtle_shape/status'),
             subscribed=('/turtle1/pose', '/turtle_shape/goal', '/turtle_shape/cancel'), lesson=True),
    NodeKind('fibonacci_server', '/fibonacci', 'actionlib_tutorials', 'fibonacci_server.py',
             published=('/fibonacci/result', '/fibonacci/status'), subscribed=('/fibonacci/goal', '/fibonacci/cancel'),
             lesson=True),
    NodeKind('twist_keyboard', '/teleop_twist_keyboard', 'teleop_twist_keyboard', 'teleop_twist_keyboard.py',
             ('cmd_vel:=/keys/cmd_vel', '_repeat_rate:=5.0'), published=('/keys/cmd_vel',)),
)
BY_KEY = {kind.key: kind for kind in KINDS}
HARDENED = tuple(kind for kind in KINDS if not kind.lesson)  # these survive new masters, closed outputs and attacks
FIXED_TURTLE = ('velocity_publisher.py', 'pose_subscriber.py', 'draw_square')  # without a parameter ~turtle
SIMULATORS = ('turtlesim', 'robotont')


def in_order(keys):
    """Return the kinds with these keys and all kinds that they need, each after those that it needs."""
    found = []
    for key in keys:
        kind = BY_KEY[key]
        found += [one for one in (*in_order(kind.needs), kind) if one not in found]
    return found


def arguments(kind, folder):
    """Return the arguments of a kind's command; ``folder`` contains the image for usb_cam."""
    return [argument.format(folder=folder, bundle=_bundle() if '{bundle}' in argument else '',
                            map=_map() if '{map}' in argument else '') for argument in kind.arguments]


def _bundle():
    return os.path.join(rospkg.RosPack().get_path('ar_track_alvar'), 'bundles', 'board.xml')


def _map():
    return os.path.join(rospkg.RosPack().get_path('map_server'), 'test', 'rostest', 'data', 'turned.yaml')


def on_turtle(kind, turtle):
    """Return the kind with ``turtle`` instead of turtle1."""
    def moved(names):
        return tuple(name.replace('/turtle1/', f'/{turtle}/') for name in names)
    remaps = tuple(f'turtle1/{name}:={turtle}/{name}' for name in ('cmd_vel', 'pose', 'set_pen', 'teleport_absolute'))
    given = remaps if kind.executable in FIXED_TURTLE else (f'_turtle:={turtle}',)
    return kind._replace(arguments=kind.arguments + given, published=moved(kind.published),
                         subscribed=moved(kind.subscribed), services=moved(kind.services))


def make_picture(folder):
    """Write an image for usb_cam into a folder; return the folder."""
    os.makedirs(folder, exist_ok=True)
    pixels = bytes((x + y) % 256 for y in range(HEIGHT) for x in range(WIDTH) for _ in range(3))
    with open(os.path.join(folder, 'picture.ppm'), 'wb') as file:
        file.write(b'P6 %d %d 255\n' % (WIDTH, HEIGHT) + pixels)
    return folder


def missing(kind, registered):
    """Return the names of a kind that are not in ``registered``, which is (published, subscribed, services)."""
    needed = kind.published, kind.subscribed, kind.services
    return [name for names, there in zip(needed, registered) for name in names if name not in there]
