"""Checks the services that an exercise calls: their types must exist and take the numbers of the request."""
import roslib.message
import rospkg

from course_grader.rules.exercise import ExerciseError

WHOLE = {f'{sign}int{bits}': (-(2 ** (bits - 1)) * (not sign), 2 ** (bits - (not sign)) - 1)
         for sign in ('', 'u') for bits in (8, 16, 32, 64)}  # type of a field: the lowest and the highest number
WHOLE.update(bool=(0, 1), byte=WHOLE['int8'], char=WHOLE['uint8'])
NUMBERS = {'float32', 'float64', *WHOLE}


def check(exercise):
    """Raise ExerciseError, with a line for each stimulus that cannot call its service."""
    problems = [f'stimulus {number} (call): {problem}' for number, (what, values) in enumerate(exercise.stimuli, 1)
                if what == 'call' for problem in [_problem(values['type'], values['request'])] if problem]
    if problems:
        raise ExerciseError(f'{exercise.name}: ' + '\n  '.join(problems))


def request(service_class, numbers):
    """Return drawn numbers as a request of a service: whole ones where its fields are."""
    return tuple(round(number) if kind in WHOLE else number
                 for kind, number in zip(service_class._request_class._slot_types, numbers))


def _problem(name, spans):
    """Return why a service of this type cannot be called with numbers from these spans, or None."""
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
    if len(fields) != len(spans):
        return f'request has {len(spans)} numbers, but {name} takes {len(fields)}: {", ".join(fields) or "none"}'
    return next((f'request: {field} of {name} is a {kind}, from {WHOLE[kind][0]} to {WHOLE[kind][1]}'
                 for (field, kind), (low, high) in zip(fields.items(), spans)
                 if kind in WHOLE and not WHOLE[kind][0] <= low <= high <= WHOLE[kind][1]), None)
