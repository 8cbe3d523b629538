"""The parameters that several of the course's nodes have in common; each raises params.ParameterError."""
import rosgraph.names
import rospy

from kinematic_core.validation import InvalidInput
from rospy_support import parameters
from turtle_robotont.driving import shapes
from turtle_robotont.driving.following import Settings
from turtle_robotont.driving.vehicle import LIMITS, ROBOT, Limits

SLOWEST, FASTEST = 0.05, 10.0  # [m/s] speeds that can be asked for


def turtle():
    """Return ~turtle: the name under which the turtle's topics and services lie."""
    name = parameters.text('~turtle', 'turtle1')
    if not name or name.startswith('~') or not rosgraph.names.is_legal_name(name):
        raise parameters.ParameterError(f'parameter {rospy.resolve_name("~turtle")} is {name!r}; it must be a ROS name '
                                    'such as turtle1 or sim2/turtle1. Set it with _turtle:=turtle1')
    return name


def limits(speed, turn_speed=None):
    """Return the Limits in ~speed [m/s] and ~turn_speed [rad/s], by default these, or a turtle's."""
    return Limits(parameters.number('~speed', speed, minimum=SLOWEST, maximum=FASTEST, unit='m/s'),
                  parameters.number('~turn_speed', turn_speed or LIMITS.turn_speed, minimum=0.1, maximum=10.0,
                                unit='rad/s'))


def points(name, default, bounded=True):
    """Return the Points [m] in the parameter ``name``: a list of pairs [x, y], if ``bounded`` inside the arena."""
    try:
        result = shapes.points_from(parameters.numbers(name, default, unit='m'))
        if bounded:
            shapes.require_fit(result)
        return result
    except InvalidInput as error:
        raise parameters.ParameterError(f'parameter {rospy.resolve_name(name)}: {error}') from None


def colour(name, default):
    """Return the parameter ``name`` as (r, g, b), whole numbers from 0 to 255."""
    values = parameters.numbers(name, default, length=3)
    if not all(isinstance(value, float) and value in range(256) for value in values):
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name(name)} is {values}; it must be three whole numbers '
                                    f'from 0 to 255. Set it with _{name.lstrip("~")}:="{default}"')
    return tuple(int(value) for value in values)


def follow_settings(distance):
    """Return the Settings in ~distance [m], by default ``distance``, ~strafe, ~lost_after [s] and the limits."""
    return Settings(parameters.number('~distance', distance, minimum=0.1, maximum=20.0, unit='m'),
                    parameters.boolean('~strafe', False),
                    parameters.number('~lost_after', 0.5, minimum=0.1, maximum=5.0, unit='s'),
                    limits(ROBOT.limits.speed, ROBOT.limits.turn_speed))


def marker_ids(name, default):
    """Return the parameter ``name`` as a list of at least one marker id, whole numbers from 0."""
    values = parameters.numbers(name, default)
    if not values or not all(isinstance(value, float) and value.is_integer() and value >= 0.0 for value in values):
        raise parameters.ParameterError(f'parameter {rospy.resolve_name(name)} is {values}; it must be a list of ids, '
                                    f'whole numbers from 0. Set it with _{name.lstrip("~")}:="{default}"')
    return [int(value) for value in values]
