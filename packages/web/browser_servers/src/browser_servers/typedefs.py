"""The fields and constants of message types, as rosapi describes them."""
import dataclasses
from typing import Any, Callable, List, Tuple

from browser_servers import types
from browser_servers.core.conversion import TIMES, is_message, kind_of
from browser_servers.core.operations import Refused

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


def of_message(name: str) -> List[TypeDef]:
    """Return the TypeDefs of a message type and of all types in it; empty if it is not installed."""
    return _with_inner(_installed(types.message_class, name), [name])


def of_service(name: str, part: str) -> List[TypeDef]:
    """Return the TypeDefs of a part of a service type: ``part`` is '_request_class' or '_response_class'."""
    service = _installed(types.service_class, name)
    return _with_inner(service and getattr(service, part), [])


def full_text(name: str) -> str:
    """Return the definition of a message type with those of all types in it; '' if it is not installed."""
    cls = _installed(types.message_class, name)
    return cls._full_text if cls else ''


def _installed(find: Callable[[str], Any], name: str) -> Any:
    """Return a class, or None for a type that is not installed."""
    try:
        return find(name)
    except Refused:
        return None


def _with_inner(cls: Any, seen: List[str]) -> List[TypeDef]:
    if cls is None:
        return []
    typedef, inner = _typedef(cls)
    typedefs = [typedef]
    for name in inner:
        if name not in seen:
            seen.append(name)
            typedefs += [_time(name)] if name in TIMES else _with_inner(_installed(types.message_class, name), seen)
    return typedefs


def _typedef(cls: Any) -> Tuple[TypeDef, List[str]]:
    """Return the TypeDef of a class, and the types of its fields that have one themselves."""
    instance, typedef = cls(), TypeDef(type=_type_name(cls))
    inner: List[str] = []
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


def _is_constant(cls: Any, name: str, value: object) -> bool:
    return name not in cls.__slots__ and not name.startswith('_') and isinstance(value, (str, bytes, int, float))


def _type_name(cls: Any) -> str:
    return f'{cls.__module__.partition(".")[0]}/{cls.__name__}'


def _time(name: str) -> TypeDef:
    return TypeDef(type=name, fieldnames=['secs', 'nsecs'], fieldtypes=[TIME_PARTS] * 2, fieldarraylen=[SINGLE] * 2,
                   examples=['0', '0'])
