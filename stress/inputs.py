"""Bad inputs from seeded random numbers: the same seed gives the same inputs. No node, no socket.

A node must refuse all of them or ignore them. Legal but odd inputs (a spawn far away) are left out, so that any change
in a simulator is a fault.
"""

import json
import struct

from hypothesis import HealthCheck, Phase, given, settings, strategies
from hypothesis import seed as seeded
from turtlesim.srv import Kill, Spawn, TeleportAbsolute, TeleportRelative

import tcpros

NOT_A_NUMBER, INFINITE = float('nan'), float('inf')
ABSURD = NOT_A_NUMBER, INFINITE, -INFINITE, 3.4e38, -3.4e38, 1.7e7, -1.7e7  # of float32: beyond +-1,000,000
BAD_NAMES = ('a b', '1', '-', 'a//b', '/', 'a/', '~', '~x', 'x' * 5000, 'a\nb', 'a\0b', '\u00fc', '\U0001f422', '{}',
             '$(x)', '../..', 'a.b', '%s%n', ' ', '"', "';--", 'a:=b')
MISSING = 'nobody', 'turtle0', 'turtle99999', 'Turtle1', 'turtle1 ', '/turtle', *BAD_NAMES
METHODS = ('getPid', 'getBusStats', 'getBusInfo', 'getMasterUri', 'getSubscriptions', 'getPublications', 'paramUpdate',
           'publisherUpdate', 'requestTopic')
WRONG_METHODS = ('', 'nothing', 'system.listMethods', 'system.multicall', '__init__', '_dispatch', 'getPid.x',
                 'x' * 9999)
TWIST = struct.Struct('<6d')


def coordinates(rng, count):
    """Return numbers of which at least one is absurd."""
    values = [rng.uniform(0.0, 11.0) for _ in range(count)]
    for place in rng.sample(range(count), rng.randint(1, count)):
        values[place] = rng.choice(ABSURD)
    return values


def bad_spawn(rng):
    """Return a Spawn request that cannot be fulfilled."""
    if rng.random() < 0.5:
        return Spawn._request_class(*coordinates(rng, 3), f'n{rng.randrange(10 ** 6)}')
    return Spawn._request_class(5.0, 5.0, 0.0, rng.choice([*BAD_NAMES, 'turtle1']))


BAD_REQUESTS = {
    '/spawn': (Spawn, bad_spawn),
    '/kill': (Kill, lambda rng: Kill._request_class(rng.choice(MISSING))),
    '/turtle1/teleport_absolute': (
        TeleportAbsolute, lambda rng: TeleportAbsolute._request_class(*coordinates(rng, 3))),
    '/turtle1/teleport_relative': (
        TeleportRelative, lambda rng: TeleportRelative._request_class(*coordinates(rng, 2))),
}


def wrong_length(rng, right):
    """Return bytes of another length than the request ``right``; read as numbers, they are absurd."""
    wrong = rng.choice([b'', right[:rng.randrange(len(right))], right + b'\xff' * rng.randint(1, 100),
                        b'\xff' * rng.randint(1, 8),
                        right[:12] + struct.pack('<I', rng.choice([5000, 2 ** 31 - 1, 2 ** 32 - 1]))])
    return wrong if len(wrong) != len(right) else b''


def bad_twist(rng):
    """Return the bytes of a Twist with an absurd linear x, linear y or angular z."""
    values = [rng.uniform(-1.0, 1.0) for _ in range(6)]
    for place in rng.sample((0, 1, 5), rng.randint(1, 3)):
        values[place] = rng.choice((NOT_A_NUMBER, INFINITE, -INFINITE, 1e300, -1e300, 1e9, -1e9))
    return TWIST.pack(*values)


def bad_frame(rng):
    """Return bytes for a topic's connection that are not a Twist: of another length, or announced with a wrong one."""
    size = rng.choice((0, 1, 47, 49, 4096))
    lengths = size, 0, 2 ** 31 - 1, 2 ** 32 - 1
    return struct.pack('<I', rng.choice(lengths)) + b'\xff' * min(size, 64)  # NaN, where it is taken for a Twist


TOPIC_FIELDS = {'callerid': tcpros.CALLER, 'topic': '/turtle1/pose', 'md5sum': '*', 'type': 'turtlesim/Pose'}
SERVICE_FIELDS = {'callerid': tcpros.CALLER, 'service': '/spawn', 'md5sum': Spawn._md5sum, 'persistent': '1'}


def _bytes(rng, count):
    return bytes(rng.randrange(256) for _ in range(count))


def _untrue_length(rng):
    return struct.pack('<I', rng.choice((0, 1, 3, 2 ** 31, 2 ** 32 - 1, 10 ** 8))) + b'x' * rng.randint(0, 50)


def _untrue_field_length(rng):
    body = b'nothing'
    return struct.pack('<II', 4 + len(body), rng.choice((len(body), 10 ** 6, 2 ** 32 - 1))) + body


def _wrong_fields(rng):
    fields = dict(TOPIC_FIELDS)
    for name in rng.sample(sorted(fields), rng.randint(1, len(fields))):
        fields[name] = rng.choice(('', 'x', '\0', '/' * 50, 'y' * 5000, '*', '/nothing', '\u00fc'))
    return tcpros.header(**fields)


def _missing_fields(rng):
    fields = dict(SERVICE_FIELDS)
    for name in rng.sample(sorted(fields), rng.randint(1, len(fields))):
        del fields[name]
    return tcpros.header(**fields)


def _cut_off(rng):
    right = tcpros.header(**TOPIC_FIELDS)
    return right[:rng.randrange(len(right))]


HEADERS = (
    lambda rng: _bytes(rng, rng.randint(0, 200)), _untrue_length, _untrue_field_length, _wrong_fields, _missing_fields,
    _cut_off, lambda rng: b'GET / HTTP/1.1\r\nHost: localhost\r\n\r\n',
    lambda rng: tcpros.header(**dict(SERVICE_FIELDS, md5sum=rng.choice(('x', '', '0' * 32)))),
    lambda rng: tcpros.header(**SERVICE_FIELDS) + _bytes(rng, rng.randint(1, 8)))


def bad_header(rng):
    """Return the first bytes of a TCPROS connection: not a header, or one that must be refused."""
    return rng.choice(HEADERS)(rng)


def bad_http(rng):
    """Return bytes for an XML-RPC port that are not a call, or a malformed one."""
    length = rng.choice(('-1', 'x', '0', '5', '99999999', str(2 ** 63)))
    body = rng.choice((b'<methodCall>', b'<methodCall><methodName>getPid</methodName></methodCall>',
                       b'<a>' * 200, b'\xff\xfe\0', b'<!DOCTYPE x [<!ENTITY a "b">]><methodCall>&a;</methodCall>',
                       b'<methodCall><methodName>getPid</methodName><params><param><value><int>x</int></value></param>'
                       b'</params></methodCall>', json.dumps({'method': 'getPid'}).encode()))
    method = rng.choice((b'POST', b'GET', b'PUT', b'DELETE', b'\0\0', b'POST' * 500))
    if rng.random() < 0.5:
        length = str(len(body))
    return method + b' /RPC2 HTTP/1.1\r\nHost: x\r\nContent-Length: ' + length.encode() + b'\r\n\r\n' + body


VALUES = strategies.recursive(
    strategies.none() | strategies.booleans() | strategies.integers(-2 ** 31, 2 ** 31 - 1) |
    strategies.floats(allow_nan=False, allow_infinity=False) |
    strategies.text(strategies.characters(min_codepoint=32, max_codepoint=0x2fff), max_size=20) |
    strategies.binary(max_size=20),
    lambda inner: strategies.lists(inner, max_size=4) | strategies.dictionaries(
        strategies.text(strategies.characters(min_codepoint=97, max_codepoint=122), max_size=5), inner, max_size=3),
    max_leaves=8)
CALLS = strategies.tuples(strategies.sampled_from(METHODS + WRONG_METHODS), strategies.lists(VALUES, max_size=5))


def each_call(count, number, use):
    """Hand ``count`` calls (method, arguments) of an XML-RPC API, drawn by hypothesis, to ``use``.

    They have any type and length; a publisher (publisherUpdate) never has the address of a machine.
    """
    @seeded(number)
    @settings(max_examples=count, database=None, deadline=None, phases=[Phase.generate],
              suppress_health_check=list(HealthCheck))
    @given(CALLS)
    def draw(call):
        use(*call)
    draw()


def legal_twist(x=0.0, y=0.0, turn=0.0):
    """Return the bytes of a legal Twist."""
    return TWIST.pack(x, y, 0.0, 0.0, 0.0, turn)
