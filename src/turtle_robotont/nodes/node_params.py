"""The parameters that several nodes of the course share; each function raises ParameterError."""
import rosgraph.names
import rospy

from kinematic_core.validation import InvalidInput
from rospy_support import parameters
from rospy_support.parameters import Boolean, Number, Table, Text
from turtle_robotont.driving import shapes
from turtle_robotont.driving.following import Settings
from turtle_robotont.driving.vehicle import LIMITS, ROBOT, Limits
from turtle_robotont.markers.sightings import AXES

SLOWEST, FASTEST = 0.05, 10.0  # [m/s] range of the parameter ~speed
TURTLE = Text('~turtle', 'turtle1')
FRAME_AXES = Text('~frame_axes', 'auto', AXES)


def log_rate(default):
    """Return the parameter ~log_rate [Hz]."""
    return Number('~log_rate', default, 0.0, 1000.0, 'Hz')


def speeds(speed, turn_speed=LIMITS.turn_speed):
    """Return a Table of ~speed [m/s] and ~turn_speed [rad/s] with these defaults; that of the second is a turtle's."""
    return Table(Number('~speed', speed, SLOWEST, FASTEST, 'm/s'),
                 Number('~turn_speed', turn_speed, 0.1, 10.0, 'rad/s'))


def following(distance):
    """Return a Table of the parameters of follow_settings; ``distance`` [m] is the default of ~distance."""
    return Table(Number('~distance', distance, 0.1, 20.0, 'm'), Boolean('~strafe', False),
                 Number('~lost_after', 0.5, 0.1, 5.0, 's'), speeds(*ROBOT.limits))


def turtle():
    """Return ~turtle: the namespace of the turtle's topics and services."""
    name = TURTLE.read()
    if not name or name.startswith('~') or not rosgraph.names.is_legal_name(name):
        raise parameters.ParameterError(f'parameter {rospy.resolve_name("~turtle")} is {name!r}; it must be a ROS name '
                                    'such as turtle1 or sim2/turtle1. Set it with _turtle:=turtle1')
    return name


def points(parameter, default=None, bounded=True):
    """Return the Points [m] in a parameter: a list of pairs [x, y], if ``bounded`` inside the arena.

    ``default`` replaces the parameter's own.
    """
    try:
        result = shapes.points_from(parameter.read(default))
        if bounded:
            shapes.require_fit(result)
        return result
    except InvalidInput as error:
        raise parameters.ParameterError(f'parameter {rospy.resolve_name(parameter.name)}: {error}') from None


def colour(parameter):
    """Return a parameter, a list of 3 numbers, as (r, g, b), whole numbers from 0 to 255."""
    values = parameter.read()
    if not all(isinstance(value, float) and value in range(256) for value in values):
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name(parameter.name)} is {values}; it must be three whole numbers '
            f'from 0 to 255. Set it with _{parameter.name.lstrip("~")}:="{parameter.default}"')
    return tuple(int(value) for value in values)


def limits(table, defaults=(None, None)):
    """Return the Limits in the parameters of ``speeds``, which are part of a node's table.

    ``defaults`` are Limits that replace those of the table.
    """
    return Limits(*(table[name].read(default) for name, default in zip(('~speed', '~turn_speed'), defaults)))


def follow_settings(table):
    """Return the Settings in the parameters of ``following``, which are part of a node's table."""
    return Settings(*table.read('~distance', '~strafe', '~lost_after'), limits(table))


def marker_ids(parameter):
    """Return a parameter, a list of numbers, as a list of at least one marker id, whole numbers from 0."""
    values = parameter.read()
    if not values or not all(isinstance(value, float) and value.is_integer() and value >= 0.0 for value in values):
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name(parameter.name)} is {values}; it must be a list of ids, '
            f'whole numbers from 0. Set it with _{parameter.name.lstrip("~")}:="{parameter.default}"')
    return [int(value) for value in values]
