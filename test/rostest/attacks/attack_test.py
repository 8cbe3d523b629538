#!/usr/bin/env python3
"""Every kind of node but lessons is attacked through its two ports; it answers others all the while, and lives on.

The nodes of a group run together, with what they need. An attack is the name of a method of Attacks.
"""
import concurrent.futures
import contextlib
import os
import resource
import socket
import statistics
import threading
import time
import unittest
import xmlrpc.client
import xmlrpc.server

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from attacked_nodes import interrupt, running
from rostest_support import tcpros
from rostest_support.common import DEADLINE, run, until
from rostest_support.tcpros import CALLER, LOG, block, header, is_closed, receive_answer, receive_header

IDLE = 2000  # connections
SOON = 0.2  # [s] in which a new subscriber and a call get through beside them: the median of
TRIES = 7
AT_ONCE = 3  # nodes that are attacked at the same time
ENOUGH_TROUBLES = 4  # of one node
SILENT = 100  # publishers that do not answer
GROUPS = {  # the nodes that run together; those that an earlier group has had are not attacked again
    'simulators': ('turtlesim', 'draw_square', 'robotont', 'camera', 'tracker', 'usb_cam', 'bundles'),
    'others': ('turtlesim', 'teleop', 'twist_keyboard', 'mimic'),
}
ALIKE = 'draw_square', 'mimic', 'twist_keyboard'  # these begin as the others do: whether what protects those is seen by
ENOUGH = 'idle_connection', 'wrong_request', 'endless_message', 'many_idle_connections', 'no_descriptors'
DRAWN = 50  # examples by hypothesis
NESTED = 20000  # arrays in each other, in a call of 600 kB
METHODS = ('getPid', 'getBusStats', 'getBusInfo', 'getMasterUri', 'getSubscriptions', 'getPublications', 'paramUpdate',
           'publisherUpdate', 'requestTopic', '', 'nothing', 'system.multicall', '__init__', '_dispatch', 'getPid.x',
           '_shutdown', 'x' * 9999)
TEXT = st.text(st.characters(min_codepoint=32, max_codepoint=0x2fff), max_size=20)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-2 ** 31, 2 ** 31 - 1) | st.floats(allow_nan=False, allow_infinity=False)
    | TEXT | st.binary(max_size=20) | st.sampled_from([CALLER, '/rosout', '/turtle1/pose']),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=3), max_leaves=8)
FIELDS = st.dictionaries(st.sampled_from(['callerid', 'topic', 'service', 'md5sum', 'type', 'persistent']),
                         st.sampled_from(['', 'x', '*', '/rosout', '/none', CALLER, 'y' * 5000, '\0']) | TEXT)
HEADERS = st.binary(max_size=200) | FIELDS.map(lambda fields: header(**fields)) | st.builds(
    lambda fields, size: header(**fields)[:size], FIELDS, st.integers(0, 60))


def drawn(strategy, count):
    """Return ``count`` examples of a hypothesis strategy, the same ones in every run."""
    found = []

    @settings(max_examples=count, derandomize=True, database=None, deadline=None, phases=[Phase.generate],
              suppress_health_check=list(HealthCheck))
    @given(strategy)
    def draw(example):
        found.append(example)
    draw()
    return found


class Attacks:
    """The attacks of a peer on one node; ``hostile`` closes the connections that a method leaves open."""

    def __init__(self, peer, kind, output):
        self.peer, self.kind, self.output = peer, kind, output
        self.hostile = contextlib.ExitStack()

    def open(self, data=b'', address=None):
        connection = tcpros.connect(address or self.peer.address, data)
        self.hostile.callback(connection.close)
        return connection

    def assert_answers(self, what):
        """Assert that a new subscriber and a call get through."""
        try:
            self.peer.answers()
        except tcpros.TROUBLE as error:
            raise AssertionError(f'{self.kind.key}: {what}: {error!r}') from None

    def closed(self, connection, what):
        until(lambda: is_closed(connection), f'{self.kind.key} closes the connection of {what}')

    def idle_connection(self):
        self.open()
        self.assert_answers('one idle connection')

    def slow_header(self):
        connections = [self.open(header(callerid=CALLER, **LOG)[:size]) for size in (1, 3, 4, 9)]
        self.assert_answers('a header that comes slowly')
        for connection in connections:
            connection.sendall(b'\0')
        self.assert_answers('a header that goes on slowly')

    def endless_header(self):
        connection = self.open(b'\xff\xff\xff\xff' + b'x' * 100)
        self.assert_answers('a header of 4 GB')
        self.closed(connection, 'a header of 4 GB')

    def garbage_header(self):
        for name, data in GARBAGE.items():
            connection = self.open(data)
            self.closed(connection, name)
        for data in drawn(HEADERS, DRAWN):
            self.open(data).close()
        self.assert_answers('headers of garbage')

    def header_with_error(self):
        connection = self.open(header(error='I am an error', callerid=CALLER))
        assert 'error' in receive_header(connection)
        self.closed(connection, 'a header with an error')
        self.assert_answers('a header with an error')

    def wrong_md5(self):
        for opened in (self.peer.subscribe(md5sum='0' * 32), self.peer.open_service(md5sum='0' * 32),
                       self.peer.subscribe(topic='/none'), self.peer.open_service('none')):
            answer, connection = opened
            assert answer.get('error'), (self.kind.key, answer)
            self.closed(connection, answer['error'])
        self.assert_answers('wrong types')

    def wrong_request(self):
        """A service request of wrong length is answered, and the next one on that connection too."""
        level = block(b'rosout') + block(b'info')
        for service, request, size in (('get_loggers', b'.' * 3, b'3 bytes'), ('set_logger_level', b'', b'0 bytes'),
                                       ('set_logger_level', level[:-1], b'17 bytes'),
                                       ('set_logger_level', level + b'..', b'20 bytes'),
                                       ('set_logger_level', b'\xff\xff\xff\xff' + level, b'22 bytes')):
            done, text = self.peer.call(request, service)
            assert not done and size in text, (self.kind.key, service, request, text)
        _, connection = self.peer.open_service(persistent='1')
        with connection:
            connection.sendall(block(b'...'))
            assert not receive_answer(connection)[0]
            connection.sendall(block(b''))
            assert receive_answer(connection)[0]
        self.assert_answers('requests of wrong length')

    def endless_request(self):
        _, connection = self.peer.open_service()
        self.hostile.callback(connection.close)
        connection.sendall(b'\xff\xff\xff\xff....')
        self.closed(connection, 'a request of 4 GB')
        self.assert_answers('a request of 4 GB')

    def half_closed(self):
        for data in (b'', b'\0', header(callerid=CALLER, **LOG)[:20]):
            connection = self.open(data)
            connection.shutdown(socket.SHUT_WR)
            self.closed(connection, 'a peer that has closed its side')
        connection = self.open(header(callerid=CALLER, service=f'{self.peer.name}/get_loggers', md5sum='*'))
        connection.sendall(block(b''))
        connection.shutdown(socket.SHUT_WR)  # it still reads
        receive_header(connection)
        assert receive_answer(connection)[0]
        self.assert_answers('half-closed connections')

    def many_idle_connections(self):
        threads = self.peer.threads()
        alone = self._time_to_answer()
        for _ in range(IDLE):
            self.open()
        beside = self._time_to_answer()
        assert beside < max(SOON, 4.0 * alone), (self.kind.key, f'{beside:.3f} s beside {IDLE} idle connections', alone)
        assert self.peer.threads() < threads + 20, (self.kind.key, threads, self.peer.threads())

    def _time_to_answer(self):
        """The median time [s] of the slower one of a new subscriber and a call."""
        return statistics.median(max(self.peer.answers()) for _ in range(TRIES))

    def idle_callers(self):
        """Callers that send no request, and nodes that keep a connection to the XML-RPC server, cost no thread."""
        threads = self.peer.threads()
        for _ in range(100):
            self.hostile.callback(self.peer.open_service(persistent='1')[1].close)
            self.open(address=self.peer.slave_address)
            self.open(b'POST / HTTP/1.1\r\nContent-Length: 100\r\n', address=self.peer.slave_address)
        self.assert_answers('callers that do not call')
        until(lambda: self.peer.threads() < threads + 20, f'{self.kind.key}: few threads')

    def bodies(self):
        """Requests to the XML-RPC server that are too long, or none."""
        for text, status in (('Content-Length: 50000000', b'413'), ('Content-Length: -1', b'413'),
                             ('Content-Length: 1e3', b'413'), ('X: ' + 'y' * 70000, b'431'), ('X: y', b'500')):
            connection = self.open(f'POST /RPC2 HTTP/1.1\r\n{text}\r\n\r\n'.encode(), address=self.peer.slave_address)
            answer = connection.recv(100)
            assert status in answer, (self.kind.key, text[:50], answer)
        self.open(os.urandom(10000), address=self.peer.slave_address)
        nested = '<value><array><data>' * NESTED + '</data></array></value>' * NESTED
        body = f'<methodCall><methodName>getPid</methodName><params><param>{nested}</param></params></methodCall>'
        connection = self.open(f'POST /RPC2 HTTP/1.1\r\nContent-Length: {len(body)}\r\n\r\n{body}'.encode(),
                               address=self.peer.slave_address)
        assert connection.recv(100), (self.kind.key, 'nested arrays')
        self.assert_answers('bad HTTP')

    def bad_calls(self):
        """Calls of the slave API with nonsense; it is the answer that counts: there is one."""
        for method in ('publisherUpdate', 'requestTopic', 'paramUpdate', 'getBusInfo', 'getBusStats'):
            for arguments in ((), (1,), (CALLER, 1, 2), (CALLER, '', []), (CALLER, '/rosout', [[]]),
                              (CALLER, '/rosout', [[[]]]), (CALLER, '/rosout', 'x'), (CALLER, '/x', {}, [])):
                self.bad_call(method, arguments)
        for method, arguments in drawn(st.tuples(st.sampled_from(METHODS), st.lists(VALUES, max_size=5)), DRAWN):
            self.bad_call(method, arguments)
        self.assert_answers('nonsense for the slave API')

    def bad_call(self, method, arguments):
        with contextlib.suppress(xmlrpc.client.Error):
            tcpros.any_call(self.peer.uri, method, arguments)

    def wrong_message(self):
        """A publisher sends messages of a wrong length for their type."""
        for data in (b'', b'\xff' * 7, b'\xff' * 4099) if self.kind.subscribed else ():
            with HostilePublisher(self.peer, self.kind.subscribed[0]) as connection:
                connection.sendall(block(data))
                self.assert_answers(f'a message of {len(data)} bytes')

    def endless_message(self):
        """A publisher announces a message of 4 GB."""
        if self.kind.subscribed:
            with HostilePublisher(self.peer, self.kind.subscribed[0]) as connection:
                connection.sendall(b'\xff\xff\xff\xff' + b'x' * 100)
                self.closed(connection, 'a message of 4 GB')
        self.assert_answers('a message of 4 GB')

    def no_descriptors(self):
        """The node has no file descriptor left: it waits without using processor time, says why, and recovers."""
        soft, hard = resource.prlimit(self.peer.pid, resource.RLIMIT_NOFILE)
        until(lambda: self.peer.descriptors() < 200, f'{self.kind.key} has closed what the attack before has left')
        resource.prlimit(self.peer.pid, resource.RLIMIT_NOFILE, (self.peer.descriptors(), hard))
        try:
            for address in [self.peer.address] * 150 + [self.peer.slave_address] * 150:
                self.open(address=address)
            until(lambda: 'ulimit -n' in self.output(), f'{self.kind.key} names the reason')
            ran, begin = sum(self.peer.process.cpu_times()[:2]), time.monotonic()
            time.sleep(0.6)  # a span to measure over
            share = (sum(self.peer.process.cpu_times()[:2]) - ran) / (time.monotonic() - begin)
        finally:
            resource.prlimit(self.peer.pid, resource.RLIMIT_NOFILE, (soft, hard))
        self.assert_answers('file descriptors again')
        assert self.output().count('ulimit -n') == 1, self.output()
        assert share < 0.8, (self.kind.key, f'{share:.0%} of a core without descriptors')

    def many_publishers(self):
        """A peer announces again and again that a topic has publishers, none of which answers."""
        if self.kind.subscribed:
            threads = self.peer.threads()
            with socket.create_server(('localhost', 0), backlog=SILENT) as silent:
                uris = [f'http://localhost:{silent.getsockname()[1]}/{number}' for number in range(SILENT)]
                for _ in range(5):
                    self.peer.slave.publisherUpdate(CALLER, self.kind.subscribed[0], uris)
                    time.sleep(0.2)  # the node takes the newest of the updates that lie there
                self.assert_answers('publishers that do not answer')
                now = self.peer.threads()
                assert now < threads + SILENT + 20, (self.kind.key, threads, now)


GARBAGE = {
    'a field of no length': block(block(b'')), 'a field without =': block(block(b'topic')),
    'a field that is longer than the header': block(b'\xff\0\0\0a=b'), 'half a length': block(b'\1\0'),
    'no text': block(block(b'topic=\xff\xfe')), 'no field': block(b''), 'no name': block(block(b'=')),
    'many fields': block(block(b'a=b') * 10000), 'HTTP': b'GET / HTTP/1.1\r\nHost: localhost\r\n\r\n',
    'no caller': header(topic='/rosout', md5sum='*'), 'no md5sum': header(service='/x', callerid=CALLER),
}


class HostilePublisher:
    """A publisher of one topic as a node sees it; gives the connection of the node, the headers being exchanged."""

    def __init__(self, peer, topic):
        self._server = xmlrpc.server.SimpleXMLRPCServer(('localhost', 0), logRequests=False)
        self._listening = socket.create_server(('localhost', 0))
        self._listening.settimeout(DEADLINE)
        port = self._listening.getsockname()[1]
        self._server.register_function(lambda *_: (1, '', ['TCPROS', 'localhost', port]), 'requestTopic')
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._peer, self._topic = peer, topic

    def __enter__(self):
        self._thread.start()
        self._peer.slave.publisherUpdate(CALLER, self._topic, [f'http://localhost:{self._server.server_address[1]}/'])
        self.connection, _ = self._listening.accept()
        asked = receive_header(self.connection)
        self.connection.sendall(header(callerid=CALLER, topic=self._topic, type=asked['type'], md5sum=asked['md5sum']))
        return self.connection

    def __exit__(self, *_):
        self.connection.close()
        self._listening.close()
        self._server.shutdown()
        self._server.server_close()


ATTACKS = [name for name, method in vars(Attacks).items() if callable(method) and not name.startswith('_')
           and name not in ('open', 'assert_answers', 'bad_call', 'closed')]


class AttackTest(unittest.TestCase):

    def attack(self, group):
        """Start the nodes of a group; attack each in every way."""
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        with contextlib.ExitStack() as stack:
            nodes = list(running(stack, GROUPS[group]).values())
            attacked = [node for node in nodes if group == 'simulators' or node.kind.key != 'turtlesim']
            idle = [stack.enter_context(tcpros.connect(node.peer.address)) for node in attacked]
            with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
                troubles = sum(pool.map(attack_one, attacked), [])
            until(lambda: all(map(is_closed, idle)), 'idle connections are closed at their deadline')
            troubles += sum((node.troubles() for node in nodes), [])
            processes = [node.process for node in nodes]
            interrupt(processes)
            for process in processes:
                process.process.wait(DEADLINE)  # SIGINT alone is enough
        self.assertFalse(troubles, '\n'.join(troubles))

    def test_attack_simulators(self):
        """Simulators, camera, trackers, usb_cam and draw_square: attacked on their ports, they answer others all the
        while.
        """
        self.attack('simulators')

    def test_attack_others(self):
        """Teleop by keys and mimic: the same."""
        self.attack('others')


def attack_one(node):
    """Attack a node in every way; the list of what went wrong."""
    troubles, kind = [], node.kind
    for name in ENOUGH if kind.key in ALIKE else ATTACKS:
        attacks = Attacks(node.peer, kind, node.process.output)
        with attacks.hostile:
            try:
                getattr(attacks, name)()
            except Exception as error:
                troubles.append(f'{kind.key} {name}: {error!r}')
                if len(troubles) >= ENOUGH_TROUBLES:
                    return [*troubles, f'{kind.key}: no further attacks']
    return troubles


if __name__ == '__main__':
    run(AttackTest)
