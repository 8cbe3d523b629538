"""Checks the services that an exercise calls: their types must exist and take the numbers of the request."""
import roslib.message
import rospkg

from course_grader.rules.exercise import ExerciseError

NUMBERS = {'bool', 'byte', 'char', 'float32', 'float64',
           *(f'{sign}int{bits}' for sign in ('', 'u') for bits in (8, 16, 32, 64))}


def check(exercise):
    """Raise ExerciseError, with a line for each stimulus that cannot call its service."""
    problems = [f'stimulus {number} (call): {problem}' for number, (what, values) in enumerate(exercise.stimuli, 1)
                if what == 'call' for problem in [_problem(values['type'], len(values['request']))] if problem]
    if problems:
        raise ExerciseError(f'{exercise.name}: ' + '\n  '.join(problems))


def _problem(name, count):
    """Return why a service of this type cannot be called with so many numbers, or ''."""
    try:
        found = roslib.message.get_service_class(name)
    except (rospkg.ResourceNotFound, ImportError):
        found = None
    if found is None:
        return f'type: there is no service type {name} here; ./run shell -c "rossrv list" names all'
    fields = dict(zip(found._request_class.__slots__, found._request_class._slot_types))
    others = [f'{field} ({kind})' for field, kind in fields.items() if kind not in NUMBERS]
    if others:
        return f'type: {name} has {", ".join(others)}, but the grader sends numbers only'
    if len(fields) != count:
        return f'request has {count} numbers, but {name} takes {len(fields)}: {", ".join(fields) or "none"}'
    return ''
