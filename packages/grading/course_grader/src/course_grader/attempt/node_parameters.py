"""Checks the parameters that an exercise sets for the nodes beside the simulator, by the tables of these nodes."""
import importlib
import xmlrpc.client

from course_grader.rules.exercise import ExerciseError
from plain_support import shown

TABLES = {'map_server': 'map_server.server', 'amcl': 'amcl.node', 'slam_gmapping': 'gmapping.node',
          'move_base': 'move_base.settings'}  # node: module with PARAMETERS; the original packages do not have them


def check(exercise):
    """Raise ExerciseError, with a line for each parameter with which a node would not start."""
    problems = list(filter(None, (_problem(name, value) for name, value in exercise.parameters.items())))
    if problems:
        raise ExerciseError(f'{exercise.name}: ' + '\n  '.join(problems))


def _problem(name, value):
    """Return why a parameter, such as /amcl/max_particles, cannot have a value, or None."""
    try:
        xmlrpc.client.dumps((value,))
    except (TypeError, OverflowError):
        return (f'parameters: {name} is {shown(value)}; it must be true, false, a whole number of 32 bits, a number '
                'with a point, a text, a list or a mapping')
    node, _, rest = name.lstrip('/').partition('/')
    try:
        declared = {parameter.name: parameter for parameter in importlib.import_module(TABLES[node]).PARAMETERS}
    except ImportError:
        return None
    parameter = declared.get(f'~{rest}')
    try:
        if parameter:
            parameter.convert(value)
    except ValueError:
        return f'parameters: {name} is {shown(value)}; it must be {parameter.allowed} {parameter.unit}'.rstrip()
    return None
