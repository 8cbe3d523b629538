"""Frames: each compression, each way; fragments within their bounds."""
import base64
import json
import math
import time

import cbor2
import cv2
import numpy as np
import pytest

from browser_servers.core import encodings
from browser_servers.core.encodings import MAX_OPEN, Defragmenter, Message, fragments, from_png, to_json, to_png
from browser_servers.core.operations import Refused
from unit_support.messages import Point, message_class

VALUES = {'x': 1.0, 'y': None, 'z': 0.5}
WANTED = {'op': 'publish', 'topic': '/p', 'msg': VALUES}


def message(calls=None):
    def deserialise(data):
        if calls is not None:
            calls.append(data)
        return Point(x=1.0, y=math.nan, z=0.5)
    return Message('/p', b'raw', deserialise, (3, 4))


def test_json_is_valid():
    frame = message().frame('none')
    assert json.loads(frame, parse_constant=lambda name: pytest.fail(name)) == WANTED


@pytest.mark.parametrize('fields', [('data',), ('width', 'data'), ('data', 'more', 'width')])
def test_long_bytes_are_valid_json(fields):
    kinds = {'data': 'uint8[]', 'more': 'char[]', 'width': 'uint32'}
    image = message_class('test_msgs/Image', **{name: kinds[name] for name in fields})
    values = {'data': bytes(range(256)) * 40, 'more': b'', 'width': 7}
    one = image(**{name: values[name] for name in fields})
    found = json.loads(Message('/a"b', b'', lambda data: one, (0, 0)).frame('none'))
    assert found['topic'] == '/a"b' and base64.b64decode(found['msg']['data']) == values['data']
    assert set(found['msg']) == set(fields) and found['msg'].get('width', 7) == 7


def test_cbor_raw_is_not_deserialised():
    calls = []
    assert cbor2.loads(message(calls).frame('cbor-raw')) == {
        'op': 'publish', 'topic': '/p', 'msg': {'bytes': b'raw', 'secs': 3, 'nsecs': 4}}
    assert calls == []


def test_message_is_encoded_once_for_all_clients():
    calls = []
    one = message(calls)
    assert one.frame('none') is one.frame('none')
    one.frame('cbor'), one.frame('png')
    assert calls == [b'raw']


def test_png_holds_the_json():
    outer = json.loads(message().frame('png'))
    assert outer['op'] == 'png'
    assert json.loads(from_png(outer['data'], 10000)) == WANTED


@pytest.mark.parametrize('text', ['', 'a', 'ab' * 500, 'Tõnu' * 10, '{"a": 1}'])
def test_png_is_reversible(text):
    assert from_png(to_png(text), 10000) == text


def test_png_has_the_bytes_of_the_text_as_red_green_blue():
    image = cv2.imdecode(np.frombuffer(base64.b64decode(to_png('RGB')), np.uint8), cv2.IMREAD_COLOR)
    assert image[0, 0].tolist() == [ord('B'), ord('G'), ord('R')]  # OpenCV has blue first


@pytest.mark.parametrize('data, error', [
    ('***', 'not a PNG image in base64'), ('', 'not a PNG'), (base64.b64encode(b'x' * 100).decode(), 'not a PNG'),
    (to_png('a' * 3000), 'pixels; the message may have 1000 bytes'), (to_png('abc')[:60], 'not a PNG|damaged'),
    (base64.b64encode(cv2.imencode('.png', np.full((2, 2, 3), 255, np.uint8))[1].tobytes()).decode(), 'not hold a'),
])
def test_what_is_no_png_is_refused(data, error):
    with pytest.raises(Refused, match=error):
        from_png(data, 1000)


def test_json_refuses_nan():
    with pytest.raises(ValueError):
        to_json({'a': math.nan})


def test_fragments_come_together_again_in_any_order():
    text = to_json({'op': 'publish', 'data': 'x' * 25})
    parts = [json.loads(part) for part in fragments(text, 10, 'name')]
    assert [(part['num'], part['total'], part['id']) for part in parts] == \
        [(number, len(parts), 'name') for number in range(len(parts))]
    assert all(len(part['data']) <= 10 for part in parts)
    together = Defragmenter(1000, 600)
    answers = [together.add(part) for part in reversed(parts)]
    assert answers == [None] * (len(parts) - 1) + [text]


@pytest.mark.parametrize('frame, size', [('short', 10), ('short', None), (b'binary' * 10, 10)])
def test_other_frames_stay_whole(frame, size):
    assert list(fragments(frame, size, 'name')) == [frame]


def part(name='a', number=0, total=2, data='x'):
    return {'op': 'fragment', 'id': name, 'num': number, 'total': total, 'data': data}


@pytest.mark.parametrize('parts, error', [
    ([part(number=2)], '"num" is 2'), ([part(number=-1)], '"num" is -1'),
    ([part(total=10**9)], '"total" is 1000000000'),
    ([part(), part(total=3, number=1)], '"total" is 3, but was 2'),
    ([part(data='x' * 101)], 'more than 100 characters'),
    ([part(name, data='x' * 30) for name in 'abcd'], 'more than 100 characters'),
    ([part(str(name)) for name in range(MAX_OPEN + 1)], f'{MAX_OPEN} messages are incomplete'),
    ([part(number=number, total=100, data='') for number in range(6)], 'or 5 fragments'),
])
def test_fragments_are_bounded(parts, error, monkeypatch):
    if '5 fragments' in error:
        monkeypatch.setattr(encodings, 'MAX_PARTS', 5)
    together = Defragmenter(100, 600)
    with pytest.raises(Refused, match=error):
        for one in parts:
            together.add(one)


def test_incomplete_messages_are_forgotten():
    now = [0.0]
    together = Defragmenter(10, 5.0, lambda: now[0])
    assert together.add(part(data='1234')) is None
    now[0] = 6.0
    assert together.add(part('b', data='123456')) is None  # 4 + 6 + 1 characters would be too many
    assert together.add(part('b', 1, data='7')) == '1234567'


def test_a_message_never_becomes_a_million_fragments():
    text = 'x' * 10 * encodings.MAX_FRAGMENTS
    parts = [json.loads(one) for one in fragments(text, 1, 'name')]
    assert len(parts) == encodings.MAX_FRAGMENTS
    assert ''.join(one['data'] for one in parts) == text


def test_many_small_fragments_take_no_longer_each():
    """In order, so that looking for the missing one at each would take the square of the time."""
    together, count = Defragmenter(10**6, 600), encodings.MAX_PARTS
    start = time.process_time()
    for number in range(count):
        last = together.add(part(number=number, total=count))
    assert last == 'x' * count
    assert time.process_time() - start < 2.0  # 0.05 s; the square took 4 s


def test_repeated_fragment_counts_once():
    together = Defragmenter(10, 5.0)
    for _ in range(10):
        assert together.add(part(data='1234')) is None
    assert together.add(part(number=1, data='5')) == '12345'
