"""Check the size of a serialised message.

genpy itself accepts a message whose last string is cut off, and one with bytes after its last field.
"""
import struct

import genmsg.msgs
import genpy.message

SIZES = {'bool': 1, 'byte': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2, 'int32': 4, 'uint32': 4,
         'float32': 4, 'int64': 8, 'uint64': 8, 'float64': 8, 'time': 8, 'duration': 8}  # [bytes]


def wrong_size(message_class, data):
    """Return why ``data`` (bytes) has the wrong size for a message of this class, as a text for people; else ''."""
    end = _end_of_fields(message_class, data, 0)
    if end == len(data):
        return ''
    fields = ', '.join(f'{kind} {name}' for kind, name in zip(message_class._slot_types, message_class.__slots__))
    if end > len(data):
        return f'{len(data)} bytes, too few: {fields} take {end} or more'
    return f'{len(data)} bytes, too many: ' + (f'{fields} take {end}' if fields else 'it has no fields')


def _end_of_fields(message_class, data, start):
    """Return the offset [bytes] in ``data`` where the fields end; if data is too short, the smallest possible one."""
    for kind in message_class._slot_types:
        start = _end_of_field(kind, data, start)
    return start


def _end_of_field(kind, data, start):
    base, is_array, length = genmsg.msgs.parse_type(kind)
    if is_array and length is None:
        length, start = _number(data, start)
    if not is_array:
        length = 1
    if base in SIZES:
        return start + length * SIZES[base]
    for _ in range(length):
        if is_array and start > len(data):  # a false length of an array must not cost time
            break
        if base == 'string':
            size, start = _number(data, start)
            start += size
        else:
            nested = genpy.message.get_message_class(base)
            if not nested._slot_types:
                break
            start = _end_of_fields(nested, data, start)
    return start


def _number(data, start):
    """Return the uint32 at ``start`` (0 if data is too short for it) and the offset of its end."""
    end = start + 4
    return (struct.unpack('<I', data[start:end])[0] if end <= len(data) else 0), end
