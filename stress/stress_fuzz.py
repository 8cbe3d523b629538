"""Bad inputs for a node's services, topics, TCPROS connections and XML-RPC: 100,000 in the full form."""

import socket
import struct
import time

from robotont_gazebo.srv import MoveMarker, SetPose

import inputs
import tcpros
from figures import OURS, Figure, Target, median
from rostest_support import node_kinds
from trial import Attack, Trial, losses
from under_test import MOTION, TROUBLE, running, serialized

CONNECTIONS = 64  # at once
MOST_OF_A_PEER = 3000  # the original takes every other one, and thousands of turtles take it hours
BATCH = 500  # messages in one go
MANY_HUNG = 3  # after that it is clear, and each costs a deadline
NESTED = 20000  # arrays in each other
BODY = 50 * 10 ** 6  # [bytes]
BODY_DEADLINE = 60.0  # [s]


def services(subject, scale, rng):
    """Requests that cannot be fulfilled, on many connections at once."""
    count = scale.count(40000, 400)
    if subject.side != OURS:
        count = min(count, MOST_OF_A_PEER)
    with running(subject, 'turtlesim') as nodes:
        trial = Trial(nodes['turtlesim'])
        names = sorted(inputs.BAD_REQUESTS)
        accepted = dict.fromkeys(names, 0)
        for name in names:
            kind, make = inputs.BAD_REQUESTS[name]
            accepted[name] = _call_many(trial, name, kind, [serialized(make(rng)) for _ in range(count // len(names))])
        found = trial.samples('services')
    found['bad_accepted'] = [sum(accepted.values())]
    return found


def _call_many(trial, name, kind, requests):
    """Return how many requests were accepted; CONNECTIONS wait for their answers at once."""
    accepted, callers = 0, [None] * CONNECTIONS
    while requests and trial.hung < MANY_HUNG and trial.node.runs():
        batch, requests = requests[:CONNECTIONS], requests[CONNECTIONS:]
        waiting = []
        for place, request in enumerate(batch):
            try:
                callers[place] = callers[place] or trial.node.caller(name, kind)
                callers[place].send(request)
                waiting.append(place)
            except TROUBLE:
                callers[place] = None
        for place in waiting:
            answer = trial.answered(callers[place].answer)
            accepted += bool(answer and answer[0])
            if answer is None:
                callers[place].close()
                callers[place] = None
    for caller in filter(None, callers):
        caller.close()
    return accepted


def lengths(subject, scale, rng):
    """Requests with a wrong length for their type."""
    count = scale.count(3000, 60)
    with running(subject, 'turtlesim') as nodes:
        trial = Trial(nodes['turtlesim'])
        for name in sorted(inputs.BAD_REQUESTS):
            kind, make = inputs.BAD_REQUESTS[name]
            wrong = [inputs.wrong_length(rng, serialized(make(rng))) for _ in range(count // len(inputs.BAD_REQUESTS))]
            _call_many(trial, name, kind, wrong)
        return trial.samples('lengths')


def topics(subject, scale, rng):
    """A publisher of absurd velocities, and of bytes that are not a message."""
    with running(subject, 'turtlesim') as nodes:
        return _publish_bad(nodes['turtlesim'], scale.count(30000, 1000), scale.count(300, 10), rng, 'topics')


def _publish_bad(node, messages, frames, rng, name):
    trial = Trial(node)
    topic, kind = MOTION[node.kind.key]
    publisher = tcpros.Publisher(node.subject.uri, topic, kind)
    try:
        for start in range(0, messages, BATCH):
            _await_subscriber(publisher)
            publisher.publish_raw(b''.join(tcpros.framed(inputs.bad_twist(rng))
                                           for _ in range(min(BATCH, messages - start))))
            trial.inputs += min(BATCH, messages - start)
        for _ in range(frames):
            _await_subscriber(publisher)
            publisher.publish_raw(inputs.bad_frame(rng))
            trial.inputs += 1
            for connection in publisher.connections:
                connection.close()
            publisher.connections.clear()
            _kick(node, topic, publisher)
    finally:
        publisher.close()
    return trial.samples(name)


def _kick(node, topic, publisher):
    """Make the node look for publishers now, instead of after a growing pause."""
    try:
        api = tcpros.api(node.uri)
        api.publisherUpdate(tcpros.CALLER, topic, [])
        api.publisherUpdate(tcpros.CALLER, topic, [publisher.uri])
    except TROUBLE:
        pass


def _await_subscriber(publisher, deadline=tcpros.DEADLINE):
    end = time.monotonic() + deadline
    while not publisher.connections and time.monotonic() < end:
        time.sleep(0.005)


def connections(subject, scale, rng):
    """Bytes on new connections to the TCPROS port."""
    with running(subject, 'turtlesim') as nodes:
        return _attack_port(nodes['turtlesim'], scale.count(12000, 200), rng, 'tcpros')


def _attack_port(node, count, rng, name):
    trial = Trial(node)
    _open_badly(trial, node.tcpros_place(), count, inputs.bad_header, rng)
    return trial.samples(name)


def _open_badly(trial, place, count, make, rng):
    """Send bytes on this many new connections; the last CONNECTIONS stay open meanwhile."""
    kept = []
    for _ in range(count):
        if trial.hung >= MANY_HUNG:
            break
        trial.answered(lambda: kept.append(_opened(place, make(rng))))
        if len(kept) > CONNECTIONS:
            _close(kept.pop(0), rng)
    for connection in kept:
        _close(connection, rng)


def _opened(place, data):
    connection = tcpros.connect(place)
    try:
        tcpros.send(connection, data)
    except tcpros.Closed:
        pass
    return connection


def _close(connection, rng):
    """Close a connection, sometimes by a reset."""
    if rng.random() < 0.2:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
    connection.close()


def calls(subject, scale, rng):
    """Calls of the slave API with any arguments, and malformed HTTP."""
    with running(subject, 'turtlesim') as nodes:
        return _attack_api(nodes['turtlesim'], scale.count(8000, 100), rng, 'xmlrpc')


def _attack_api(node, count, rng, name):
    trial = Trial(node)
    inputs.each_call(max(1, count // 2), rng.randrange(2 ** 31), _calling(trial))
    _open_badly(trial, tcpros.address(node.uri), count // 2, inputs.bad_http, rng)
    return trial.samples(name)


def large(subject, scale, _rng):
    """One body of 50 MB, and arrays nested 20,000 deep."""
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        trial = Trial(node)
        size = BODY // 10 if scale.small else BODY
        body = b'<?xml version="1.0"?><methodCall><methodName>getPid</methodName><params><param><value><string>' + (
            b'x' * size) + b'</string></value></param></params></methodCall>'
        seconds, peak = _posted(trial, body)
        found = {'body_time': [seconds], 'body_memory': [peak]}
        deep = b'<?xml version="1.0"?><methodCall><methodName>getPid</methodName><params><param>' + (
            b'<value><array><data>' * NESTED + b'</data></array></value>' * NESTED) + b'</param></params></methodCall>'
        found['nested_time'] = [_posted(trial, deep)[0]]
        found.update(trial.samples('large'))
        return found


def _posted(trial, body):
    """Return (time until the answer [s], peak memory [MB]) of a call with this body."""
    begun = time.monotonic()

    def post():
        connection = tcpros.connect(tcpros.address(trial.node.uri), BODY_DEADLINE)
        try:
            tcpros.send(connection, b'POST /RPC2 HTTP/1.1\r\nHost: x\r\nContent-Type: text/xml\r\nContent-Length: '
                        + str(len(body)).encode() + b'\r\n\r\n' + body)
            tcpros.receive(connection, 1)
        finally:
            connection.close()
    trial.answered(post)
    return time.monotonic() - begun, trial.node.peak_memory()


def robotont(subject, scale, rng):
    """The same for the robot's simulator."""
    with running(subject, 'robotont') as nodes:
        node = nodes['robotont']
        found = _publish_bad(node, scale.count(3000, 200), scale.count(30, 3), rng, 'robotont')
        trial = Trial(node)
        for name, kind, make in (
                ('/robotont_gazebo/set_pose', SetPose, lambda: SetPose._request_class(*inputs.coordinates(rng, 3))),
                ('/robotont_gazebo/move_marker', MoveMarker,
                 lambda: MoveMarker._request_class(rng.choice(inputs.MISSING), 0.0, 0.0, 0.0))):
            requests = [serialized(make()) for _ in range(scale.count(1000, 30))]
            _call_many(trial, name, kind, requests)
            _call_many(trial, name, kind, [inputs.wrong_length(rng, requests[0]) for _ in range(scale.count(200, 10))])
        _open_badly(trial, node.tcpros_place(), scale.count(500, 30), inputs.bad_header, rng)
        _open_badly(trial, tcpros.address(node.uri), scale.count(500, 30), inputs.bad_http, rng)
        return _merged(found, trial.samples('robotont'))


def _merged(*parts):
    found = {}
    for part in parts:
        for key, values in part.items():
            found.setdefault(key, []).extend(values)
    return found


def kinds(subject, scale, rng):
    """TCPROS and XML-RPC of every other kind of node."""
    keys = [kind.key for kind in node_kinds.HARDENED if kind.key not in (*node_kinds.SIMULATORS, 'draw_square',
                                                                         'teleport_tour')]
    if scale.small:
        keys = ['teleop', 'usb_cam']
    parts = []
    with running(subject, *keys) as nodes:
        for key in keys:
            trial = Trial(nodes[key])
            _open_badly(trial, nodes[key].tcpros_place(), scale.count(200, 20), inputs.bad_header, rng)
            inputs.each_call(scale.count(100, 10), rng.randrange(2 ** 31), _calling(trial))
            _open_badly(trial, tcpros.address(nodes[key].uri), scale.count(100, 10), inputs.bad_http, rng)
            parts.append(trial.samples('kinds'))
    return _merged(*parts)


def _calling(trial):
    call = tcpros.AnyCall(trial.node.uri)
    return lambda method, arguments: trial.hung < MANY_HUNG and trial.answered(lambda: call(method, arguments))


ATTACKS = {
    'services': Attack(services, 'requests that cannot be fulfilled'),
    'lengths': Attack(lengths, 'requests of a wrong length'),
    'topics': Attack(topics, 'absurd velocities and random bytes'),
    'tcpros': Attack(connections, 'bytes to the TCPROS port'),
    'xmlrpc': Attack(calls, 'calls of the slave API and invalid HTTP'),
    'large': Attack(large, 'a body of 50 MB, and arrays nested 20,000 deep'),
    'robotont': Attack(robotont, "the robot's simulator", peer=False),
    'kinds': Attack(kinds, 'every other kind of node', peer=False),
}

FIGURES = (
    *losses('services', 'bad requests'),
    Figure('bad requests accepted', 'bad_accepted', '', sum, Target('at_most', 0)),
    *losses('lengths', 'wrong lengths'),
    *losses('topics', 'bad messages'),
    *losses('tcpros', 'bad connections'),
    *losses('xmlrpc', 'bad calls'),
    *losses('large', 'large calls'),
    Figure('50 MB body, answered after', 'body_time', 's', median, Target('below', 10.0)),
    Figure('50 MB body, most memory', 'body_memory', 'MB', median, Target('below', 400.0)),
    Figure('20,000 nested arrays, answered after', 'nested_time', 's', median, Target('below', 5.0)),
    *losses('robotont', "the robot's simulator"),
    *losses('kinds', 'other kinds of nodes', changed=False),
)
