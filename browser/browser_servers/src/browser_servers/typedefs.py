"""The fields and constants of message types, as rosapi describes them."""
import dataclasses
from typing import List

import roslib.message

from rosbridge_core.conversion import TIMES, is_message, kind_of

SINGLE, ANY_LENGTH = -1, 0  # of fieldarraylen; else the length of the array
TIME_PARTS = 'int32'  # the type that rosapi gives for secs and nsecs


@dataclasses.dataclass
class TypeDef:
    """The fields of rosapi/TypeDef."""

    type: str
    fieldnames: List[str] = dataclasses.field(default_factory=list)
    fieldtypes: List[str] = dataclasses.field(default_factory=list)
    fieldarraylen: List[int] = dataclasses.field(default_factory=list)
    examples: List[str] = dataclasses.field(default_factory=list)
    constnames: List[str] = dataclasses.field(default_factory=list)
    constvalues: List[str] = dataclasses.field(default_factory=list)


def of_message(name):
    """Return the TypeDefs of a message type and of all types in it; empty if it is not installed."""
    return _with_inner(roslib.message.get_message_class(name) if '/' in name else None, [name])


def of_service(name, part):
    """Return the TypeDefs of a part of a service type: ``part`` is '_request_class' or '_response_class'."""
    service = service_class(name)
    return _with_inner(service and getattr(service, part), [])


def full_text(name):
    """Return the definition of a message type with those of all types in it; '' if it is not installed."""
    found = message_class(name)
    return found._full_text if found else ''


def message_class(name):
    """Return the class of a message type, or None."""
    return _found(roslib.message.get_message_class, name)


def service_class(name):
    """Return the class of a service type, or None."""
    return _found(roslib.message.get_service_class, name)


def _found(find, name):
    try:
        return find(name) if name.count('/') == 1 else None
    except (ImportError, ValueError, AttributeError, TypeError):  # a package that is not built
        return None


def _with_inner(cls, seen):
    if cls is None:
        return []
    typedef, inner = _typedef(cls)
    found = [typedef]
    for name in inner:
        if name not in seen:
            seen.append(name)
            found += [_time(name)] if name in TIMES else _with_inner(message_class(name), seen)
    return found


def _typedef(cls):
    """Return the TypeDef of a class, and the types of its fields that have one themselves."""
    instance, typedef, inner = cls(), TypeDef(type=_type_name(cls)), []
    for name, text in zip(cls.__slots__, cls._slot_types):
        kind = kind_of(text)
        value = getattr(instance, name)
        typedef.fieldnames.append(name)
        typedef.fieldtypes.append(kind.element)
        typedef.fieldarraylen.append((kind.length or ANY_LENGTH) if kind.array else SINGLE)
        compound = kind.element in TIMES or is_message(kind.element)
        typedef.examples.append('[]' if kind.array else '{}' if compound else str(value))
        if compound:
            inner.append(kind.element)
    typedef.constnames = sorted(name for name, value in vars(cls).items() if _is_constant(cls, name, value))
    typedef.constvalues = [str(getattr(cls, name)) for name in typedef.constnames]
    return typedef, inner


def _is_constant(cls, name, value):
    return name not in cls.__slots__ and not name.startswith('_') and isinstance(value, (str, bytes, int, float))


def _type_name(cls):
    return f'{cls.__module__.partition(".")[0]}/{cls.__name__}'


def _time(name):
    return TypeDef(type=name, fieldnames=['secs', 'nsecs'], fieldtypes=[TIME_PARTS] * 2, fieldarraylen=[SINGLE] * 2,
                   examples=['0', '0'])
