"""Messages to dicts and back: every kind of field, and a refusal that names the field for everything else."""
import json
import math

import cbor2
import pytest

from browser_servers.core.conversion import Builder, cbor_values, json_values
from browser_servers.core.operations import Refused
from unit_support.messages import CLASSES, Everything, Point

BUILDER = Builder(CLASSES.get, lambda: (7, 8))
SAMPLE = {'header': {'seq': 1, 'stamp': {'secs': 2, 'nsecs': 3}, 'frame_id': 'map'}, 'flag': True, 'small': -128,
          'large': 2**64 - 1, 'f': 0.5, 'd': 0.1, 'text': 'Tõnu', 'data': 'AAEC', 'four': 'AAECAw==', 'ints': [-1, 2],
          'floats': [0.25, 1e300], 'three': [1.0, 2.0, 3.0], 'flags': [True, False], 'texts': ['a', ''],
          'points': [{'x': 1.0, 'y': 2.0, 'z': 3.0}], 'point': {'x': 0.0, 'y': 0.0, 'z': 4.0},
          'wait': {'secs': -1, 'nsecs': 5}, 'times': [{'secs': 9, 'nsecs': 0}]}


def test_message_survives_both_ways():
    message = BUILDER.build(Everything, SAMPLE)
    assert message.data == b'\0\1\2' and message.point.z == 4.0 and message.wait.secs == -1
    assert json_values(message) == SAMPLE
    assert json_values(BUILDER.build(Everything, json.loads(json.dumps(json_values(message))))) == SAMPLE


def test_cbor_holds_bytes_and_typed_arrays():
    values = cbor2.loads(cbor2.dumps(cbor_values(BUILDER.build(Everything, SAMPLE))))
    assert values['data'] == b'\0\1\2' and values['texts'] == ['a', ''] and values['flags'] == [True, False]
    assert values['ints'] == cbor2.CBORTag(78, b'\xff\xff\xff\xff\2\0\0\0')  # -1 and 2, little-endian
    assert json_values(BUILDER.build(Everything, values)) == SAMPLE


def test_json_has_null_for_what_is_not_finite():
    message = Everything(f=math.nan, d=-math.inf, floats=[1.0, math.inf, 1e308, 1e308])
    values = json_values(message)
    assert (values['f'], values['d'], values['floats']) == (None, None, [1.0, None, 1e308, 1e308])
    json.dumps(values, allow_nan=False)
    assert math.isnan(cbor_values(message)['f'])


@pytest.mark.parametrize('given, expected', [
    (None, math.nan), ('NaN', math.nan), ('Infinity', math.inf), ('-Infinity', -math.inf), (3, 3.0),
    (math.inf, math.inf),
])
def test_float_takes_what_json_cannot_say(given, expected):
    for name in ('f', 'd'):
        value = getattr(BUILDER.build(Everything, {name: given}), name)
        assert value == expected or math.isnan(value) and math.isnan(expected)


@pytest.mark.parametrize('header, stamp', [
    ({}, (7, 8)), ({'frame_id': 'a'}, (7, 8)), ({'stamp': {'secs': 1, 'nsecs': 0}}, (1, 0)), ({'stamp': 'now'}, (7, 8)),
])
def test_header_without_stamp_gets_the_present_time(header, stamp):
    built = BUILDER.build(Everything, {'header': header}).header.stamp
    assert (built.secs, built.nsecs) == stamp


def test_fields_may_come_as_a_list():
    built = BUILDER.build(Point, [1, 2.5])
    assert (built.x, built.y, built.z) == (1.0, 2.5, 0.0)
    with pytest.raises(Refused, match='has 3 fields, but 4 values'):
        BUILDER.build(Point, [1, 2, 3, 4])


def test_whole_floats_are_integers():
    assert BUILDER.build(Everything, {'small': 5.0}).small == 5


@pytest.mark.parametrize('values, error', [
    ({'nope': 1}, 'test_msgs/Everything has no field nope'),
    ({'point': {'w': 1}}, 'has no field point.w; geometry_msgs/Point has x, y, z'),
    ({'points': [{}, {'x': 'a'}]}, r"points\[1\].x is 'a'; it must be a number"),
    ({'point': 3}, 'point is 3; it must be an object with the fields of geometry_msgs/Point'),
    ({'points': {}}, 'points is {}; it must be a list'),
    ({'small': 128}, 'small is 128; it must be a whole number from -128 to 127'),
    ({'small': 1.5}, 'small is 1.5'), ({'small': True}, 'small is True'), ({'large': -1}, 'large is -1'),
    ({'flag': 1}, 'flag is 1; it must be true or false'), ({'d': '1'}, "d is '1'; it must be a number"),
    ({'d': True}, 'd is True'), ({'f': 1e39}, 'f is 1e'), ({'d': 10**400}, 'd is 1000'),
    ({'text': 5}, 'text is 5, a whole number; it must be a text'), ({'text': '\ud800'}, 'not valid Unicode'),
    ({'data': '***'}, 'data is .*; it must be base64'), ({'data': [256]}, 'data is'), ({'data': [True]}, 'data is'),
    ({'four': 'AAEC'}, 'four has 3 elements; it must have 4'), ({'three': [1.0]}, 'three has 1 elements'),
    ({'wait': 3}, 'wait is 3'), ({'wait': {'secs': 2**31}}, 'wait.secs is 2147483648'),
    ({'header': {'stamp': {'secs': -1}}}, 'header.stamp.secs is -1'), ({'wait': 'now'}, "wait is 'now'"),
    ({'ints': cbor2.CBORTag(77, b'\0\0')}, 'ints is an array with the CBOR tag 77; it must be 78'),
    ({'ints': cbor2.CBORTag(78, b'\0\0')}, 'CBOR tag'), (5, 'the message is 5'), ({1: 2}, 'has no field 1'),
])
def test_refusal_names_the_field(values, error):
    with pytest.raises(Refused, match=error):
        BUILDER.build(Everything, values)


def test_unknown_type_of_a_list_is_refused():
    with pytest.raises(Refused, match=r'the type of points\[0\], geometry_msgs/Point, is not installed'):
        Builder(lambda name: None, lambda: (0, 0)).build(Everything, {'points': [{}]})
