"""ROS messages from and to the dicts of JSON and CBOR.

A message class is anything with ``_type``, ``__slots__`` and ``_slot_types``; nothing here imports ROS.

JSON has neither NaN nor infinity: both become null. For a float, null, "NaN", "Infinity" and "-Infinity" are accepted;
null is NaN. CBOR has all of them.
"""
import base64
import binascii
import functools
import math
import re
import struct
from typing import Any, Callable, Dict, Hashable, List, NamedTuple, Optional, Tuple

import cbor2

from browser_servers.core.operations import Refused, name_of, shown

Converter = Callable[[Any], Any]
Plan = Tuple[Tuple[str, Optional[Converter]], ...]  # fields and their converters; None: unchanged

RANGES = {'bool': (0, 1), 'int8': (-2**7, 2**7 - 1), 'byte': (-2**7, 2**7 - 1), 'uint8': (0, 2**8 - 1),
          'char': (0, 2**8 - 1), 'int16': (-2**15, 2**15 - 1), 'uint16': (0, 2**16 - 1), 'int32': (-2**31, 2**31 - 1),
          'uint32': (0, 2**32 - 1), 'int64': (-2**63, 2**63 - 1), 'uint64': (0, 2**64 - 1)}
FLOATS = 'float32', 'float64'
TIMES = {'time': 'uint32', 'duration': 'int32'}  # and the type of its secs and nsecs
HEADERS = 'Header', 'std_msgs/Header', 'roslib/Header'
NOT_FINITE = {'NaN': math.nan, 'Infinity': math.inf, '-Infinity': -math.inf}
LARGEST_FLOAT32 = 3.4028235677973366e+38  # numbers that are not below round to infinity
TYPED_ARRAYS = {'uint16': (69, 'H'), 'uint32': (70, 'I'), 'uint64': (71, 'Q'), 'byte': (72, 'b'), 'int8': (72, 'b'),
                'int16': (77, 'h'), 'int32': (78, 'i'), 'int64': (79, 'q'), 'float32': (85, 'f'),
                'float64': (86, 'd')}  # element: tag of RFC 8746, little-endian, and format of struct
ARRAY = re.compile(r'(.*)\[(\d*)\]')


class Kind(NamedTuple):
    """The type of a field: that of its elements, whether it is an array, and its fixed length."""

    element: str
    array: bool = False
    length: Optional[int] = None

    @property
    def is_bytes(self) -> bool:
        """Whether Python holds the array as bytes."""
        return self.array and self.element in ('uint8', 'char')


@functools.lru_cache(maxsize=None)
def kind_of(text: str) -> Kind:
    """Return the Kind of a type in a message definition, such as ``float64[36]``."""
    match = ARRAY.fullmatch(text)
    if not match:
        return Kind(text)
    return Kind(match[1], True, int(match[2]) if match[2] else None)


def is_message(element: str) -> bool:
    return element not in RANGES and element not in FLOATS and element not in TIMES and element != 'string'


# ---------------------------------------------------------------------------------------------------- message to dict


def json_values(message: Any) -> Dict[str, Any]:
    """Return the fields of a message for JSON: bytes as base64, NaN and infinity as None."""
    return {name: getattr(message, name) if convert is None else convert(getattr(message, name))
            for name, convert in _json_plan(message.__class__)}


def cbor_values(message: Any) -> Dict[str, Any]:
    """Return the fields of a message for cbor2: bytes, and typed arrays with the tags of RFC 8746."""
    return {name: getattr(message, name) if convert is None else convert(getattr(message, name))
            for name, convert in _cbor_plan(message.__class__)}


@functools.lru_cache(maxsize=1000)
def _json_plan(cls: Hashable) -> Plan:
    return _plan(cls, _json_converter)


@functools.lru_cache(maxsize=1000)
def _cbor_plan(cls: Hashable) -> Plan:
    return _plan(cls, _cbor_converter)


def _plan(cls: Any, converter: Callable[[Kind], Optional[Converter]]) -> Plan:
    return tuple((name, converter(kind_of(text))) for name, text in zip(cls.__slots__, cls._slot_types))


def _json_converter(kind: Kind) -> Optional[Converter]:
    if kind.is_bytes:
        return _base64
    if kind.element in FLOATS:
        return _finite_list if kind.array else _finite
    if kind.element in RANGES or kind.element == 'string':
        return _plain_converter(kind)
    return _each(_time if kind.element in TIMES else json_values, kind.array)


def _cbor_converter(kind: Kind) -> Optional[Converter]:
    if kind.is_bytes:
        return bytes
    if kind.array and kind.element in TYPED_ARRAYS:
        return functools.partial(_typed_array, *TYPED_ARRAYS[kind.element])
    if kind.element in RANGES or kind.element in FLOATS or kind.element == 'string':
        return _plain_converter(kind)
    return _each(_time if kind.element in TIMES else cbor_values, kind.array)


def _plain_converter(kind: Kind) -> Optional[Converter]:
    if kind.element == 'bool':
        return _each(bool, kind.array)
    return list if kind.array else None


def _each(convert: Converter, array: bool) -> Converter:
    return (lambda values: [convert(value) for value in values]) if array else convert


def _base64(value: Any) -> str:
    return base64.b64encode(bytes(value)).decode('ascii')


def _finite(value: float) -> Optional[float]:
    return value if math.isfinite(value) else None


def _finite_list(values: Any) -> List[Optional[float]]:
    if math.isfinite(sum(values)):  # then all are
        return list(values)
    return [_finite(value) for value in values]


def _time(value: Any) -> Dict[str, int]:
    return {'secs': value.secs, 'nsecs': value.nsecs}


def _typed_array(tag: int, code: str, values: Any) -> Any:
    return cbor2.CBORTag(tag, struct.pack(f'<{len(values)}{code}', *values))


# ---------------------------------------------------------------------------------------------------- dict to message


class Builder:
    """Makes messages from dicts.

    ``find_class``: returns the class of a message type like ``geometry_msgs/Point``, or None; ``now``: returns the
    present ROS time as (secs, nsecs).
    """

    def __init__(self, find_class: Callable[[str], Any], now: Callable[[], Tuple[int, int]]) -> None:
        self._find_class, self._now = find_class, now

    def build(self, cls: Any, values: Any) -> Any:
        """Return a message of a class with these fields; others keep their defaults. Raise Refused with the field.

        A header without a stamp gets the present time. ``values`` may be a list of the first fields' values.
        """
        message = cls()
        if isinstance(values, list):
            if len(values) > len(cls.__slots__):
                raise Refused(f'{cls._type} has {len(cls.__slots__)} fields, but {len(values)} values were given')
            values = dict(zip(cls.__slots__, values))
        self._fill(message, values, cls._type, '')
        return message

    def _fill(self, message: Any, values: Any, root: str, path: str) -> None:
        if not isinstance(values, dict):
            raise Refused(f'{root}: {path or "the message"} is {shown(values)}; it must be an object with the fields '
                          f'of {message._type}')
        if message._type in HEADERS:
            message.stamp.secs, message.stamp.nsecs = self._now()
        kinds = dict(zip(message.__slots__, message._slot_types))
        for name, value in values.items():
            inner = f'{path}.{name}' if path else str(name)
            if name not in kinds:
                raise Refused(f'{root} has no field {inner}; {message._type} has '
                              f'{", ".join(message.__slots__) or "no fields"}')
            setattr(message, name, self._field(kind_of(kinds[name]), getattr(message, name), value, root, inner))

    def _field(self, kind: Kind, default: Any, value: Any, root: str, path: str) -> Any:
        if kind.is_bytes:
            result = _bytes(value, root, path)
        elif kind.array:
            result = self._list(kind, value, root, path)
        else:
            return self._element(kind.element, default, value, root, path)
        if kind.length is not None and len(result) != kind.length:
            raise Refused(f'{root}: {path} has {len(result)} elements; it must have {kind.length}')
        return result

    def _list(self, kind: Kind, value: Any, root: str, path: str) -> Any:
        if isinstance(value, cbor2.CBORTag):
            return _from_typed_array(value, kind.element, root, path)
        if not isinstance(value, (list, tuple)):
            raise Refused(f'{root}: {path} is {shown(value)}; it must be a list of {kind.element}')
        return [self._element(kind.element, None, element, root, f'{path}[{index}]')
                for index, element in enumerate(value)]

    def _element(self, element: str, default: Any, value: Any, root: str, path: str) -> Any:
        if element in RANGES:
            return _integer(element, value, root, path)
        if element in FLOATS:
            return _float(element, value, root, path)
        if element == 'string':
            return _text(value, root, path)
        message = default if default is not None else self._new(element, root, path)
        if element in TIMES:
            self._fill_time(element, message, value, root, path)
        else:
            self._fill(message, value, root, path)
        return message

    def _new(self, element: str, root: str, path: str) -> Any:
        cls = self._find_class(element)
        if cls is None:
            raise Refused(f'{root}: the type of {path}, {element}, is not installed here')
        return cls()

    def _fill_time(self, element: str, time: Any, value: Any, root: str, path: str) -> None:
        if value == 'now' and element == 'time':
            time.secs, time.nsecs = self._now()
            return
        if not isinstance(value, dict) or not set(value) <= {'secs', 'nsecs'}:
            raise Refused(f'{root}: {path} is {shown(value)}; it must be like {{"secs": 1, "nsecs": 0}}')
        for name, part in value.items():
            setattr(time, name, _integer(TIMES[element], part, root, f'{path}.{name}'))


def _integer(element: str, value: Any, root: str, path: str) -> Any:
    if element == 'bool':
        if not isinstance(value, bool):
            raise Refused(f'{root}: {path} is {shown(value)}; it must be true or false')
        return value
    low, high = RANGES[element]
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise Refused(f'{root}: {path} is {shown(value)}; it must be a whole number from {low} to {high} ({element})')
    return value


def _float(element: str, value: Any, root: str, path: str) -> float:
    if value is None:
        return math.nan
    if isinstance(value, str) and value in NOT_FINITE:
        return NOT_FINITE[value]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
            if element == 'float64' or not math.isfinite(number) or abs(number) < LARGEST_FLOAT32:
                return number
        except OverflowError:
            pass
    raise Refused(f'{root}: {path} is {shown(value)}; it must be a number ({element})')


def _text(value: Any, root: str, path: str) -> str:
    if not isinstance(value, str):
        raise Refused(f'{root}: {path} is {shown(value)}, {name_of(value)}; it must be a text')
    try:
        value.encode()
    except UnicodeEncodeError:
        raise Refused(f'{root}: {path} is {shown(value)}, which is not valid Unicode') from None
    return value


def _bytes(value: Any, root: str, path: str) -> bytes:
    if isinstance(value, (bytes, bytearray)):
        return bytes(value)
    try:
        if isinstance(value, str):
            return base64.b64decode(value, validate=True)
        if isinstance(value, list) and not any(isinstance(byte, bool) for byte in value):
            return bytes(value)
    except (binascii.Error, ValueError, TypeError):
        pass
    raise Refused(f'{root}: {path} is {shown(value)}; it must be base64, or a list of whole numbers from 0 to 255')


def _from_typed_array(value: Any, element: str, root: str, path: str) -> List[Any]:
    tag, code = TYPED_ARRAYS.get(element, (None, ''))
    data = value.value
    size = struct.calcsize(f'<{code}')
    if value.tag != tag or not isinstance(data, bytes) or len(data) % size:
        raise Refused(f'{root}: {path} is an array with the CBOR tag {value.tag}; it must be {tag} ({element})')
    return list(struct.unpack(f'<{len(data) // size}{code}', data))
