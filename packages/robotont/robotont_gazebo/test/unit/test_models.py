"""robotont_gazebo.core.models: names, frames, and which models can be put somewhere."""
import math

import pytest

from kinematic_core.worlds.floor_plan import EMPTY, Box, Cylinder, Panel
from kinematic_core.worlds.planar import Pose2D, Twist2D
from kinematic_core.worlds.robot_world import RobotWorld
from plain_support import InvalidInput
from robotont_gazebo.core.models import Models

PLAN = EMPTY._replace(boxes=(Box('box', 3.0, 1.0, 0.5, 1.0, 1.0, 0.6),),
                      cylinders=(Cylinder('post', 0.0, 5.0, 0.1, 2.0),),
                      panels=(Panel('marker', 1, 2.0, -3.0, 0.0),
                              Panel('walker', 2, 0.0, 9.0, 0.0, path=((0.0, 0.0, 9.0, 0.0), (10.0, 10.0, 9.0, 0.0)))))
TOLERANCE = 1e-9  # [m, rad]


@pytest.fixture
def world():
    return RobotWorld(PLAN, Pose2D(1.0, 1.0, math.pi / 2))


def test_all_models_have_a_name_and_a_state(world):
    assert Models(world).names() == ['box', 'post', 'marker', 'walker', 'robotont']
    heights = [state.z for state in Models(world).states()]
    assert heights == pytest.approx([0.3, 1.0, 0.25, 0.25, 0.0])  # middles; the robot's is on the floor


def test_a_panel_that_moves_is_where_it_is_now(world):
    for _ in range(120):  # 1 s
        world.step()
    assert Models(world).state('walker').pose.x == pytest.approx(1.0, abs=TOLERANCE)
    assert Models(world).states()[3].pose.x == pytest.approx(1.0, abs=TOLERANCE)


def test_a_state_in_the_frame_of_another_model(world):
    # the robot faces +y, so 2 m along +x is 2 m to its right
    assert Models(world).state('box', 'robotont').pose == pytest.approx((0.0, -2.0, 0.5 - math.pi / 2), abs=TOLERANCE)
    assert Models(world).state('robotont', 'robotont').pose == pytest.approx((0.0, 0.0, 0.0), abs=TOLERANCE)


@pytest.mark.parametrize('frame', ['', 'world', 'map'])
def test_velocities_are_along_the_axes_of_the_frame(world, frame):
    world.command(0.6, 0.0, 0.0)
    world.step()
    assert Models(world).state('robotont', frame).twist == pytest.approx((0.0, 0.6, 0.0), abs=TOLERANCE)
    assert Models(world).state('robotont', 'robotont').twist == pytest.approx(Twist2D(0.6, 0.0, 0.0), abs=TOLERANCE)


def test_a_pose_in_a_frame_becomes_one_in_the_world(world):
    pose = Pose2D(2.0, -1.0, 0.3)
    there = Models(world).in_world(pose, 'box')
    world.place(*there)
    assert Models(world).state('robotont', 'box').pose == pytest.approx(pose, abs=TOLERANCE)


def test_robot_and_panels_can_be_put_somewhere(world):
    Models(world).put('robotont', Pose2D(-1.0, 0.0, 0.0))
    Models(world).put('marker', Pose2D(4.0, -3.0, 1.0))
    assert world.pose == (-1.0, 0.0, 0.0)
    assert Models(world).state('marker').pose == (4.0, -3.0, 1.0)


@pytest.mark.parametrize('name, pose, said', [
    ('box', Pose2D(), "'box' cannot be moved; only robotont and panels can"),
    ('nobody', Pose2D(), "there is no model 'nobody'; the models are: box, post, marker, walker, robotont"),
    ('robotont', Pose2D(3.0, 1.0, 0.0), 'box is closer than'),
    ('robotont', Pose2D(math.nan, 0.0, 0.0), 'x'),
    ('marker', Pose2D(1.0, 1.0, 0.0), 'the robot is there'),
    ('walker', Pose2D(1.0, 4.0, 0.0), 'moves by itself'),
])
def test_what_cannot_be_put_somewhere_is_named(world, name, pose, said):
    before = Models(world).states()
    with pytest.raises(InvalidInput, match=said):
        Models(world).put(name, pose)
    assert Models(world).states() == before


@pytest.mark.parametrize('ask', [lambda world: Models(world).state('robotont', 'elsewhere'),
                                 lambda world: Models(world).in_world(Pose2D(), 'elsewhere')])
def test_unknown_frames_are_named(world, ask):
    with pytest.raises(InvalidInput, match="there is no frame 'elsewhere'"):
        ask(world)
