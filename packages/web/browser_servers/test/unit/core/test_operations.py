"""Valid operations of a client, and the errors for all others."""
import json

import cbor2
import pytest

from browser_servers.core.operations import OPERATIONS, Refused, check, globs, matches, parse

DEEP = 'nested too deeply|not valid'  # Python 3.14 reads as much as its stack holds


@pytest.mark.parametrize('frame, value', [
    ('{"op": "status"}', {'op': 'status'}), (cbor2.dumps({'op': 'status'}), {'op': 'status'}),
])
def test_text_is_json_and_binary_is_cbor(frame, value):
    assert parse(frame) == value


@pytest.mark.parametrize('frame, error', [
    ('', 'not valid JSON'), ('nonsense', "not valid JSON: .*begins with 'nonsense'"), ('[1]', r'a list, \[1\]'),
    ('null', 'it must be an object'), ('[' * 100000, DEEP), ('{"a":' * 100000, DEEP),
    (b'\xff\xff', 'it must be an object'), (b'\xa1\xff', 'not valid CBOR'),
    (b'', 'not valid CBOR'), (cbor2.dumps(5), 'it must be an object'),
    (b'\x81' * 100000, DEEP), (b'\x9a\xff\xff\xff\xff', 'not valid CBOR'),
])
def test_garbage_is_refused(frame, error):
    with pytest.raises(Refused, match=error) as refused:
        parse(frame)
    assert len(str(refused.value)) < 500


def test_what_is_nested_too_deeply_for_python_is_refused(monkeypatch):
    monkeypatch.setattr(json, 'loads', lambda _: json.loads(_))
    with pytest.raises(Refused, match='nested too deeply'):
        parse('[]')


@pytest.mark.parametrize('operation', [
    {'op': 'advertise', 'topic': '/a', 'type': 'std_msgs/String', 'latch': True, 'queue_size': 10},
    {'op': 'publish', 'topic': '/a', 'msg': {}}, {'op': 'publish', 'topic': '/a'},
    {'op': 'subscribe', 'topic': '/a', 'id': 'subscribe:/a:1', 'type': None, 'throttle_rate': 0, 'queue_length': 1,
     'fragment_size': None, 'compression': 'cbor-raw'},
    {'op': 'call_service', 'service': '/a', 'args': [], 'id': 5}, {'op': 'call_service', 'service': '/a', 'args': {}},
    {'op': 'service_response', 'service': '/a', 'id': 'x', 'result': False, 'values': 'why'},
    {'op': 'set_level', 'level': 'none'}, {'op': 'auth', 'mac': 'x'}, {'op': 'deadman', 'timeout': 0.5},
])
def test_right_operation_passes(operation):
    assert check(operation) == operation['op']


@pytest.mark.parametrize('operation, error', [
    ({}, 'no field "op"; it must be one of advertise'), ({'op': 'fly'}, "unknown operation 'fly'; it must be one of"),
    ({'op': ['a']}, 'unknown operation'), ({'op': None}, 'unknown operation None'),
    ({'op': 'advertise', 'topic': '/a'}, 'advertise: the field "type" is missing; it must be a text'),
    ({'op': 'advertise', 'topic': 5, 'type': 'a'},
     'advertise: "topic" is 5; it must be a text of 1 to 1000 characters'),
    ({'op': 'publish', 'topic': ''}, 'publish: "topic" is \'\''),
    ({'op': 'publish', 'topic': 'a' * 1001}, '"topic" is'),
    ({'op': 'publish', 'topic': '/a', 'msg': [1]}, r'"msg" is \[1\]; it must be an object'),
    ({'op': 'publish', 'topic': '/a', 'id': {}}, '"id" is an object'),
    ({'op': 'subscribe', 'topic': '/a', 'throttle_rate': -1}, '"throttle_rate" is -1; .*at least 0'),
    ({'op': 'subscribe', 'topic': '/a', 'throttle_rate': float('nan')}, '"throttle_rate" is nan'),
    ({'op': 'subscribe', 'topic': '/a', 'queue_length': True}, '"queue_length" is True'),
    ({'op': 'subscribe', 'topic': '/a', 'fragment_size': 0}, '"fragment_size" is 0; .*at least 1'),
    ({'op': 'subscribe', 'topic': '/a', 'compression': 'zip'}, 'one of none, png, cbor, cbor-raw'),
    ({'op': 'fragment', 'id': 'a', 'data': 'x', 'num': '0', 'total': 1}, '"num" is \'0\''),
    ({'op': 'set_level', 'level': 'loud'}, 'one of error, warning, info, none'),
    ({'op': 'service_response', 'service': '/a'}, '"result" is missing; it must be true or false'),
])
def test_wrong_operation_is_refused_with_its_field(operation, error):
    with pytest.raises(Refused, match=error):
        check(operation)


def test_protocol_is_complete():
    of_rosbridge = ('advertise unadvertise publish subscribe unsubscribe call_service service_response fragment png '
                    'advertise_service unadvertise_service set_level status auth')
    assert set(of_rosbridge.split()) <= set(OPERATIONS)


@pytest.mark.parametrize('text, patterns', [
    ('[*]', ['*']), ('', []), ('[]', []), ("[/turtle*, '/rosout']", ['/turtle*', '/rosout']),
])
def test_patterns_are_read_as_the_original_does(text, patterns):
    assert globs(text) == patterns


@pytest.mark.parametrize('name, patterns, found', [
    ('/a', [], True), ('/a', ['*'], True), ('/turtle1/pose', ['/turtle*'], True), ('/odom', ['/turtle*'], False),
])
def test_names_match_patterns(name, patterns, found):
    assert matches(name, patterns) is found
