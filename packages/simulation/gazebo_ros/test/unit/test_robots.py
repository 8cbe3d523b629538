"""gazebo_ros.core.urdf and robots: drives, sensors and bodies as the plugins of URDF and SDF describe them."""
import math

import pytest

from gazebo_ros.core import robots
from gazebo_ros.core.model_files import parse
from plain_support import InvalidInput
from rostest_support.gazebo_robots import BURGER, CAMERA, OMNI, with_extension

MILLIMETRE = 1e-3


def robot_of(text, namespace=''):
    return robots.read(parse(text), 'robot', namespace)


def test_the_drive_is_that_of_the_plugin():
    drive = robot_of(BURGER, '/robot1').drive
    assert drive == robots.Drive('/robot1', 'cmd_vel', 'odom', 'odom', 'base_footprint', 50.0, ('left_joint',),
                                 ('right_joint',), 0.16, 0.033, publishes_wheels=True)
    assert drive.timeout == math.inf  # Gazebo's robots drive on


def test_a_plugin_that_names_its_namespace_keeps_it():
    text = BURGER.replace('<leftJoint>', '<robotNamespace>/other</robotNamespace><leftJoint>')
    robot = robot_of(text, '/robot1')
    assert (robot.drive.namespace, robot.lasers[0].namespace) == ('/other', '/robot1')


def test_the_laser_stands_where_its_link_is():
    laser, = robot_of(BURGER).lasers
    assert laser.mount == pytest.approx((-0.03, 0.0, 0.18, math.pi), abs=MILLIMETRE)
    assert (laser.topic, laser.frame, laser.rate, laser.rays, laser.nearest, laser.farthest) == (
        'scan', 'base_scan', 10.0, 4, 0.1, 3.5)


def test_the_body_is_a_disc_about_the_axle():
    """Outline: -0.10 to 0.04 m along x (box), +-0.089 m along y (wheels): the mean distance is 0.0795 m."""
    robot = robot_of(BURGER)
    assert robot.radius == pytest.approx((0.10 + 0.04 + 2 * 0.089) / 4.0, abs=MILLIMETRE)
    assert robot.height == pytest.approx(0.18 + 0.03, abs=MILLIMETRE)  # the laser stands on the box
    assert robot.colour == (255, 0, 0)


def test_the_robot_turns_about_its_axle_wherever_the_model_begins():
    """Wheels 0.1 m behind the origin: the laser, 0.03 m behind it, is 0.07 m ahead of the axle."""
    text = BURGER.replace('xyz="0 0.08 0.023"', 'xyz="-0.1 0.08 0.023"').replace('xyz="0 -0.08 0.023"',
                                                                                'xyz="-0.1 -0.08 0.023"')
    robot = robot_of(text)
    assert robot.ahead == pytest.approx(-0.1, abs=MILLIMETRE)
    assert robot.lasers[0].mount.x == pytest.approx(0.07, abs=MILLIMETRE)


def test_a_camera_is_read_with_its_name_as_namespace():
    camera, = robot_of(with_extension(BURGER, CAMERA), '/robot1').cameras
    assert (camera.namespace, camera.image, camera.info, camera.frame) == (
        '/robot1/front', 'image_raw', 'camera_info', 'eye_link')
    assert (camera.width, camera.height, camera.rate, camera.depth) == (64, 48, 20.0, None)


def test_a_depth_camera_has_a_range():
    text = CAMERA.replace('libgazebo_ros_camera.so', 'libgazebo_ros_openni_kinect.so').replace(
        '<frameName>', '<pointCloudCutoff>0.5</pointCloudCutoff><frameName>')
    camera, = robot_of(with_extension(BURGER, text)).cameras
    assert (camera.depth, camera.depth_image, camera.points) == ((0.5, 5.0), 'depth/image_raw', 'points')


def test_an_sdf_model_that_drives_in_any_direction():
    robot = robot_of(OMNI)
    assert (robot.drive.separation, robot.drive.rate, robot.radius) == (0.0, 20.0, pytest.approx(0.2))


def test_plugins_that_are_not_simulated_are_named():
    text = with_extension(BURGER, '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>')
    assert robot_of(text).warnings == ('the plugin libgazebo_ros_control.so is not simulated',)


def test_a_rate_that_is_no_number_is_replaced_with_a_warning():
    robot = robot_of(BURGER.replace('<updateRate>50', '<updateRate>${update_rate}'))
    assert robot.drive.rate == 100.0 and any("'${update_rate}'; it must be a number" in line and '100 is used' in line
                                             for line in robot.warnings)


def test_a_tilted_laser_is_said_to_be_level():
    assert 'tilted' in robot_of(BURGER.replace('rpy="0 0 3.14159265"', 'rpy="0 0.5 0"')).warnings[0]


@pytest.mark.parametrize('old, new, part', [
    ('<wheelSeparation>0.16', '<wheelSeparation>a', "<wheelSeparation> is 'a'; it must be a number from 0.01 to 10"),
    ('<wheelDiameter>0.066', '<wheelDiameter>0', "<wheelDiameter> is '0'; it must be a number from 0.01 to 10"),
    ('<leftJoint>left_joint', '<leftJoint>wheel', "names the joint 'wheel', which the model does not have"),
    ('<child link="left_wheel"/>', '<child link="wheel"/>', "names the link 'wheel', which is missing"),
    ('<parent link="base_footprint"/>', '<parent link="base_link"/>', "the link 'base_link' is its own parent"),
    ('xyz="0 0 0.01"', 'xyz="0 0"', "<origin> has '0 0'; it must be three finite numbers"),
    ('box size="0.14 0.14 0.14"', 'box size="0.14 0.14"', '<box> has impossible sizes'),
    ('<samples>4', '<samples>many', "<samples> is 'many'; it must be a number from 1 to 4096"),
])
def test_what_is_wrong_with_a_description_is_said(old, new, part):
    with pytest.raises(InvalidInput) as error:
        robot_of(BURGER.replace(old, new))
    assert part in str(error.value)


@pytest.mark.parametrize('text, part', [
    ('<robot', 'the model is not XML'), ('<map/>', 'neither URDF nor SDF: it begins with <map>'),
    ('<sdf><world><include><uri>model://no_such_model</uri></include></world></sdf>', 'there is no such model'),
])
def test_texts_that_are_no_models_are_refused(text, part):
    with pytest.raises(InvalidInput) as error:
        parse(text)
    assert part in str(error.value)


def test_a_model_of_the_database_is_known_by_its_name():
    model = parse('<sdf><world><include><uri>model://cafe_table</uri></include></world></sdf>')
    assert len(model.findall('link/collision')) == 3
