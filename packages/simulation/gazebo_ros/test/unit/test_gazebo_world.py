"""gazebo_ros.core.gazebo_world and vehicle: several robots and models in one world."""
import math

import numpy as np
import pytest

from gazebo_ros.core.gazebo_world import GazeboWorld
from gazebo_ros.core.model_files import parse
from gazebo_ros.core.vehicle import DT, angles
from kinematic_core.worlds.floor_plan import EMPTY, Box, FloorPlan
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.rays import RayCaster
from plain_support import InvalidInput
from rostest_support.gazebo_robots import BOX, BURGER, OMNI

MILLIMETRE = 1e-3
WALL = FloorPlan(boxes=(Box('wall', 2.0, 0.0, 0.0, 0.1, 4.0, 1.0),))


def matrix(x, y, yaw=0.0, z=0.0):
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def world_of(*robots, plan=EMPTY):
    """Return a world with robots (text, x, y), named r1, r2, ..."""
    world = GazeboWorld(plan)
    for number, (text, x, y) in enumerate(robots, 1):
        assert world.add(parse(text), f'r{number}', matrix(x, y)) == []
    return world


def run(world, seconds):
    for _ in range(round(seconds / DT)):
        world.step()


def test_a_robot_drives_on_without_commands():
    world = world_of((BURGER, 0.0, 0.0))
    world.vehicles['r1'].command(0.2, 0.0, 0.0)
    run(world, 10.0)
    assert world.state('r1').pose == pytest.approx((2.0, 0.0, 0.0), abs=MILLIMETRE)


def test_two_wheels_do_not_move_sideways_and_an_omni_robot_does():
    world = world_of((BURGER, 0.0, 0.0), (OMNI, 0.0, 3.0))
    for vehicle in world.vehicles.values():
        vehicle.command(0.0, 0.5, 0.0)
    run(world, 1.0)
    assert world.state('r1').pose.y == 0.0
    assert world.state('r2').pose.y == pytest.approx(3.5, abs=MILLIMETRE)


def test_wheels_turn_as_far_as_the_robot_drives():
    """0.33 m are 10 rad of wheels with a radius of 0.033 m."""
    world = world_of((BURGER, 0.0, 0.0))
    world.vehicles['r1'].command(0.33, 0.0, 0.0)
    run(world, 1.0)
    assert world.vehicles['r1'].wheel_angles == pytest.approx((10.0, 10.0), abs=0.01)


def test_acceleration_is_that_of_the_wheels():
    """1 m/s^2: after 0.1 s 0.1 m/s, of 0.2 m/s commanded."""
    world = world_of((BURGER.replace('<updateRate>', '<wheelAcceleration>1</wheelAcceleration><updateRate>'), 0.0, 0.0))
    world.vehicles['r1'].command(0.2, 0.0, 0.0)
    run(world, 0.1)
    assert world.vehicles['r1'].twist.linear_x == pytest.approx(0.1, abs=1e-6)
    run(world, 0.2)
    assert world.vehicles['r1'].twist.linear_x == pytest.approx(0.2, abs=1e-6)


def test_odometry_of_encoders_starts_at_the_robot():
    encoder = BURGER.replace('<updateRate>', '<odometrySource>encoder</odometrySource><updateRate>')
    world = world_of((encoder, 1.0, 1.0), (BURGER, 3.0, 3.0))
    run(world, 0.1)
    assert world.vehicles['r1'].odometry == Pose2D(0.0, 0.0, 0.0)
    assert world.vehicles['r2'].odometry == Pose2D(3.0, 3.0, 0.0)


def test_robots_stop_at_each_other():
    """Two discs of radius 0.2 m: the first one stops when the middles are 0.4 m apart; the other one is not pushed."""
    world = world_of((OMNI, 0.0, 0.0), (OMNI, 2.0, 0.0))
    world.vehicles['r1'].command(1.0, 0.0, 0.0)
    run(world, 3.0)
    assert world.state('r1').pose.x == pytest.approx(1.6, abs=MILLIMETRE)
    assert world.state('r2').pose == Pose2D(2.0, 0.0, 0.0)
    assert world.vehicles['r1'].touching


def test_four_robots_that_meet_never_overlap():
    world = world_of(*((OMNI, 1.5 * math.cos(k * math.pi / 2.0), 1.5 * math.sin(k * math.pi / 2.0)) for k in range(4)))
    for _ in range(300):
        for vehicle in world.vehicles.values():
            vehicle.command(-vehicle.pose.x, -vehicle.pose.y, 0.0)
        world.step()
        places = [vehicle.pose for vehicle in world.vehicles.values()]
        assert min(math.dist(a[:2], b[:2]) for k, a in enumerate(places) for b in places[:k]) > 0.4 - MILLIMETRE


def test_each_laser_sees_walls_and_the_other_robots():
    """Rays of the first robot, whose laser looks back: to +y nothing, ahead the second robot, behind nothing."""
    world = world_of((BURGER, 0.0, 0.0), (OMNI, 1.0, 0.0), plan=WALL)
    first = world.vehicles['r1']
    laser, = first.robot.lasers
    caster = RayCaster(world.plan, laser.mount.z, angles(laser))
    ranges = first.scan(laser, caster, world.bodies(without=first))
    assert ranges == pytest.approx([math.inf, math.inf, 1.0 - 0.2 + 0.03, math.inf], abs=MILLIMETRE)
    world.remove('r2')
    assert first.scan(laser, caster, world.bodies(without=first))[2] == pytest.approx(1.95 + 0.03, abs=MILLIMETRE)


def test_a_robot_that_left_is_no_obstacle():
    world = world_of((OMNI, 0.0, 0.0), (OMNI, 1.0, 0.0))
    world.step()
    world.remove('r2')
    world.vehicles['r1'].command(1.0, 0.0, 0.0)
    run(world, 2.0)
    assert world.state('r1').pose.x == pytest.approx(2.0, abs=MILLIMETRE)


def test_a_robot_in_a_wall_is_put_beside_it():
    world = GazeboWorld(WALL)
    warning, = world.add(parse(OMNI), 'r', matrix(1.9, 0.0))
    assert warning == 'it is 0.15 m beside its place, where an obstacle is'  # the wall's face is at 1.95 m
    assert world.state('r').pose.x == pytest.approx(1.75, abs=MILLIMETRE)


def test_objects_are_spawned_moved_and_removed():
    world = GazeboWorld()
    world.add(parse(BOX), 'crate', matrix(1.0, 0.0, math.pi / 2.0, 0.3))
    box, = world.plan.boxes
    assert (box.name, box.x, box.length, box.bottom) == ('crate/link', 1.0, 0.4, pytest.approx(0.0))
    world.put('crate', Pose2D(0.0, 2.0, 0.0))
    box, = world.plan.boxes
    assert (box.x, box.y, box.yaw) == pytest.approx((0.0, 2.0, 0.0))
    world.reset()
    assert world.plan.boxes[0].x == pytest.approx(1.0)
    world.remove('crate')
    assert world.plan.boxes == () and world.names() == ['ground_plane']


def test_an_object_cannot_be_where_a_robot_is():
    world = world_of((OMNI, 0.0, 0.0))
    with pytest.raises(InvalidInput, match='crate/link cannot be there: a robot is at'):
        world.add(parse(BOX), 'crate', matrix(0.1, 0.0))
    assert world.names() == ['ground_plane', 'r1'] and world.plan.boxes == ()


def test_reset_puts_all_where_they_started():
    world = world_of((BURGER, 1.0, 2.0))
    world.vehicles['r1'].command(1.0, 0.0, 1.0)
    run(world, 1.0)
    world.reset()
    assert world.state('r1').pose == pytest.approx((1.0, 2.0, 0.0), abs=MILLIMETRE)
    run(world, 0.1)
    assert world.state('r1').pose == pytest.approx((1.0, 2.0, 0.0), abs=MILLIMETRE)


def test_links_and_frames_of_models():
    world = world_of((BURGER, 1.0, 0.0), (OMNI, 1.0, 2.0))
    assert world.state('r1::left_wheel').pose[:2] == pytest.approx((1.0, 0.08), abs=MILLIMETRE)
    assert world.state('r2', 'r1').pose[:2] == pytest.approx((0.0, 2.0), abs=MILLIMETRE)
    assert world.in_world(Pose2D(1.0, 0.0, 0.0), 'r1')[:2] == pytest.approx((2.0, 0.0), abs=MILLIMETRE)


@pytest.mark.parametrize('call, part', [
    (lambda world: world.add(parse(OMNI), 'r1', matrix(5.0, 5.0)), "there is a model 'r1' already"),
    (lambda world: world.add(parse(OMNI), '', matrix(5.0, 5.0)), 'the model has no name'),
    (lambda world: world.add(parse(OMNI), 'r2', matrix(math.nan, 5.0)), "the pose of 'r2'"),
    (lambda world: world.remove('r9'), "there is no model 'r9'; there are: ground_plane, r1"),
    (lambda world: world.put('r1', Pose2D(math.inf, 0.0, 0.0)), "the pose of 'r1'"),
    (lambda world: world.state('r1', 'r9'), "there is no frame 'r9'"),
])
def test_impossible_calls_change_nothing(call, part):
    world = world_of((OMNI, 0.0, 0.0))
    with pytest.raises(InvalidInput) as error:
        call(world)
    assert part in str(error.value)
    assert world.names() == ['ground_plane', 'r1'] and world.state('r1').pose == Pose2D(0.0, 0.0, 0.0)
