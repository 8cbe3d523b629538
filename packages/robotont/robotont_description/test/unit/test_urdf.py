"""robotont_description.urdf: links, joints, places and prefixes of each model."""
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import rospy

from kinematic_core.worlds import camera, frames
from kinematic_core.worlds.omni import WHEEL_ANGLES, WHEEL_DISTANCE, WHEEL_RADIUS, WHEELS
from kinematic_core.worlds.planar import Pose2D
from plain_support.rotations import matrix_from_quaternion, matrix_from_rpy
from robotont_description.urdf import MODELS, describe
from robotont_gazebo.node import MODELS as SIMULATED_MODELS
from sim_ros import robotont_messages as messages
from unit_support.packages import PACKAGES

URDF = PACKAGES['robotont_description'].folder / 'urdf'
LENGTH_TOLERANCE = 1e-5  # [m]
BASE = {'base_footprint', 'base_link', 'rim_back_link', 'rim_right_link', 'rim_left_link'}
CAMERA = {'computer_link', 'camera_assembly_link1', 'camera_assembly_link2', 'camera_link', 'camera_color_frame',
          'camera_color_optical_frame', 'camera_depth_frame', 'camera_depth_optical_frame'}
LINKS = {'robotont_gazebo_basic': BASE, 'robotont_gazebo_nuc': BASE | CAMERA,
         'robotont_gazebo_lidar': BASE | {'computer_link', 'hokuyo_link'}}


def robot(model, prefix=''):
    return ElementTree.fromstring(describe(model, prefix, URDF))


def matrix(joint):
    origin = joint.find('origin')
    origin = {} if origin is None else origin.attrib
    rpy, xyz = ([float(word) for word in origin.get(key, '0 0 0').split()] for key in ('rpy', 'xyz'))
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = matrix_from_rpy(*rpy), xyz
    return placed


def place(tree, link, base='base_footprint'):
    """Return the 4 x 4 matrix of a link's frame in ``base``."""
    placed = np.eye(4)
    while link != base:
        joint = next(joint for joint in tree.iter('joint') if joint.find('child').get('link') == link)
        placed, link = matrix(joint) @ placed, joint.find('parent').get('link')
    return placed


@pytest.mark.parametrize('model', sorted(MODELS))
@pytest.mark.parametrize('prefix', ['', 'robot1/'])
def test_model_is_one_tree_with_the_links_it_should_have(model, prefix):
    tree = robot(model, prefix)
    links = [link.get('name') for link in tree.findall('link')]
    assert sorted(links) == sorted(prefix + link for link in LINKS[model])
    joints = tree.findall('joint')
    assert len({joint.get('name') for joint in joints}) == len(joints)
    assert all(joint.get('name').startswith(prefix) for joint in joints)
    children = [joint.find('child').get('link') for joint in joints]
    assert sorted(children + [f'{prefix}base_footprint']) == sorted(links)
    assert {joint.find('parent').get('link') for joint in joints} <= set(links)
    materials = {material.get('name') for material in tree.findall('material')}
    assert {material.get('name') for material in tree.iter('material')} == materials


def test_simulator_and_description_know_the_same_models():
    assert set(SIMULATED_MODELS) == set(MODELS)


@pytest.mark.parametrize('wheel, angle', list(zip(WHEELS, WHEEL_ANGLES)))
def test_wheels_are_where_the_kinematics_have_them(wheel, angle):
    placed = place(robot('robotont_gazebo_basic'), f'rim_{wheel}_link', 'base_link')
    outwards = np.array([math.cos(angle), math.sin(angle), 0.0])
    assert placed[:3, 3] == pytest.approx(WHEEL_DISTANCE * outwards + [0.0, 0.0, 0.021], abs=LENGTH_TOLERANCE)
    assert placed[:3, 2] == pytest.approx(-outwards, abs=LENGTH_TOLERANCE)  # the axis points to the middle
    rim = robot('robotont_gazebo_basic').find(f"link[@name='rim_{wheel}_link']/visual/geometry/cylinder")
    assert float(rim.get('radius')) == WHEEL_RADIUS
    assert f'rim_{wheel}_joint' in frames.frames('').joints


@pytest.mark.parametrize('turn', [0.0, 0.7, -4.0])
def test_wheels_turn_as_the_urdf_says(turn):
    sent = messages.transforms(rospy.Time(), frames.frames(''), Pose2D(), (turn,) * 3).transforms[1:]
    about_axis = np.array([[math.cos(turn), -math.sin(turn), 0.0], [math.sin(turn), math.cos(turn), 0.0], [0, 0, 1.0]])
    for transform in sent:
        placed = place(robot('robotont_gazebo_basic'), transform.child_frame_id, 'base_link')
        at, q = transform.transform.translation, transform.transform.rotation
        assert placed[:3, 3] == pytest.approx([at.x, at.y, at.z], abs=LENGTH_TOLERANCE)
        assert placed[:3, :3] @ about_axis == pytest.approx(matrix_from_quaternion((q.x, q.y, q.z, q.w)), abs=1e-6)


def test_sensors_are_those_of_the_simulator():
    tree = robot('robotont_gazebo_nuc')
    assert place(tree, 'camera_link') == pytest.approx(matrix_at(frames.CAMERA_X, 0.0, frames.CAMERA_Z))
    image = tree.find('gazebo/sensor/camera/image')
    assert (int(image.findtext('width')), int(image.findtext('height'))) == (camera.WIDTH, camera.HEIGHT)
    lidar = place(robot('robotont_gazebo_lidar'), 'hokuyo_link')
    assert lidar == pytest.approx(matrix_at(frames.LIDAR_X, 0.0, frames.LIDAR_Z))


def matrix_at(x, y, z):
    placed = np.eye(4)
    placed[:3, 3] = x, y, z
    return placed


@pytest.mark.parametrize('kind', ['color', 'depth'])
def test_optical_frames_look_ahead(kind):
    optical = place(robot('robotont_gazebo_nuc'), f'camera_{kind}_optical_frame', 'camera_link')
    # its z axis is camera_link's x, its x axis is camera_link's -y, its y axis -z
    assert optical[:3, :3] == pytest.approx(np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]]), abs=1e-9)
    assert optical[:3, 3] == pytest.approx([0.0, 0.0, 0.0])
