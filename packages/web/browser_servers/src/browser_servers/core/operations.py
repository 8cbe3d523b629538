"""The operations that a client may send: their fields, and the errors of wrong ones.

The protocol is rosbridge's version 2. A frame holds one JSON object, or one CBOR map in a binary frame.
"""
import fnmatch
import json
import re
from typing import Any, Dict, List, NamedTuple, Tuple, Union

import cbor2

Operation = Dict[str, Any]
NAMES: Dict[Any, str] = {str: 'a text', bool: 'true or false', int: 'a whole number', dict: 'an object', list: 'a list',
                         float: 'a number', type(None): 'null'}
ID = str, int, float, type(None)
LEVELS = 'error', 'warning', 'info', 'none'  # each of the first three shows those before it
COMPRESSIONS = 'none', 'png', 'cbor', 'cbor-raw'
MAX_NAME_LENGTH = 1000  # characters of a topic, service or type
OF_ROS_2 = re.compile(r'(\w+)/(?:msg|srv|action)/(\w+)')  # how clients of ROS 2 name a type


class Refused(Exception):
    """An operation that cannot be done; the text has the fault, the value, and what is allowed."""


class Field(NamedTuple):
    """A field of an operation: its name, its types, and its allowed values."""

    name: str
    types: Tuple[Any, ...]
    required: bool = False
    choices: Tuple[str, ...] = ()
    minimum: float = 0


def _needed(*names: str) -> Tuple[Field, ...]:
    return tuple(Field(name, (str,), True) for name in names)


_PARTS = Field('fragment_size', (int, type(None)), minimum=1)
_COMPRESSION = Field('compression', (str,), choices=COMPRESSIONS)
OPERATIONS: Dict[str, Tuple[Field, ...]] = {
    'advertise': (*_needed('topic', 'type'), Field('latch', (bool,)), Field('queue_size', (int,))),
    'unadvertise': _needed('topic'),
    'publish': (*_needed('topic'), Field('msg', (dict,)), Field('latch', (bool,)), Field('queue_size', (int,))),
    'subscribe': (*_needed('topic'), Field('type', (str, type(None))), Field('throttle_rate', (int, float)),
                  Field('queue_length', (int,)), _PARTS, _COMPRESSION),
    'unsubscribe': _needed('topic'),
    'call_service': (*_needed('service'), Field('args', (dict, list, type(None))), Field('type', (str,)), _PARTS,
                     _COMPRESSION),
    'advertise_service': _needed('service', 'type'),
    'unadvertise_service': _needed('service'),
    'service_response': (*_needed('service'), Field('values', (dict, list, str, type(None))),
                         Field('result', (bool,), True)),
    'fragment': (Field('id', (str, int), True), Field('data', (str,), True), Field('num', (int,), True),
                 Field('total', (int,), True, minimum=1)),
    'png': _needed('data'),
    'set_level': (Field('level', (str,), True, LEVELS),),
    'status': (),
    'auth': (),
    'deadman': (Field('timeout', (int, float), True),),
}


def parse(frame: Union[str, bytes]) -> Operation:
    """Return the object in a frame; raise Refused."""
    try:
        return _object(json.loads(frame) if isinstance(frame, str) else cbor2.loads(frame))
    except Refused:
        raise
    except RecursionError:
        raise Refused('the message is nested too deeply') from None
    except Exception as error:  # cbor2's decoders of dates, numbers and expressions raise many types
        kind = 'JSON' if isinstance(frame, str) else 'CBOR'
        raise Refused(f'the message is not valid {kind}: {error}. It begins with {shown(frame)}') from None


def _object(value: Any) -> Operation:
    if not isinstance(value, dict):
        raise Refused(f'the message is {name_of(value)}, {shown(value)}; it must be an object with the field "op"')
    return value


def check(operation: Operation) -> str:
    """Return the name of an operation whose fields are right, and give it ROS 1's name of its type; raise Refused."""
    name = operation.get('op')
    if not isinstance(name, str) or name not in OPERATIONS:
        if 'op' not in operation:
            raise Refused(f'the message has no field "op"; it must be one of {", ".join(OPERATIONS)}')
        raise Refused(f'unknown operation {shown(name)}; it must be one of {", ".join(OPERATIONS)}')
    if 'id' in operation and not isinstance(operation['id'], ID):
        raise Refused(f'{name}: "id" is {name_of(operation["id"])}; it must be a text or a number')
    for field in OPERATIONS[name]:
        _check_field(name, field, operation)
    if operation.get('type'):
        operation['type'] = ros1_type(operation['type'])
    return name


def ros1_type(name: str) -> str:
    """Return ROS 1's name of a type: geometry_msgs/Twist for geometry_msgs/msg/Twist."""
    return OF_ROS_2.sub(r'\1/\2', name) if OF_ROS_2.fullmatch(name) else name


def _check_field(operation: str, field: Field, values: Operation) -> None:
    if field.name not in values:
        if field.required:
            raise Refused(f'{operation}: the field "{field.name}" is missing; it must be {_allowed(field)}')
        return
    value = values[field.name]
    fits = isinstance(value, field.types) and not (isinstance(value, bool) and bool not in field.types)
    if fits and isinstance(value, str):
        fits = (not field.choices or value in field.choices) and (
            field.name == 'data' or 0 < len(value) <= MAX_NAME_LENGTH or not field.required)
    if fits and isinstance(value, (int, float)) and not isinstance(value, bool) and field.name != 'id':
        fits = value >= field.minimum and abs(value) < float('inf')
    if not fits:
        raise Refused(f'{operation}: "{field.name}" is {shown(value)}; it must be {_allowed(field)}')


def _allowed(field: Field) -> str:
    if field.choices:
        return f'one of {", ".join(field.choices)}'
    kinds = ' or '.join(dict.fromkeys(NAMES[kind] for kind in field.types))
    if field.required and field.types == (str,) and field.name != 'data':
        return f'{kinds} of 1 to {MAX_NAME_LENGTH} characters'
    if int in field.types or float in field.types:
        return f'{kinds}, at least {field.minimum:g}'
    return kinds


def name_of(value: Any) -> str:
    """Return the name of a value's type for people."""
    return NAMES.get(type(value), f'a {type(value).__name__}')


def shown(value: Any) -> str:
    """Return the start of a value as text."""
    try:
        text = ascii(value[:100] if isinstance(value, (str, bytes)) else value)
    except RecursionError:
        text = '...'
    return text if len(text) <= 100 else f'{text[:97]}...'


def matches(name: str, globs: List[str]) -> bool:
    """Return whether a name matches one of the patterns; without patterns every name does."""
    return not globs or any(fnmatch.fnmatchcase(name, pattern) for pattern in globs)


def globs(text: str) -> List[str]:
    """Return the patterns in the text of a parameter such as ``[/turtle*, '/rosout']``."""
    return [part for part in (part.strip().strip('\'"') for part in text.strip()[1:-1].split(',')) if part]
