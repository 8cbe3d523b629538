"""rospy_support.master: many calls in one request, and a master that refuses, hangs or does not run."""
import os
import socket
import threading
import types
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import String
from std_srvs.srv import Empty

from rospy_support import master as module
from rospy_support import rospy_internals
from rospy_support.master import Master, NoMaster
from rospy_support.rospy_internals import QueuedService
from rospy_support.rospy_internals import registration as collecting

URI = 'http://localhost:1234/'  # of the node
STATISTICS = ('getParam', '/test', '/enable_statistics')
HANG = 0.2  # [s] limit of a request to a master that hangs


class FakeMaster(SimpleXMLRPCServer):
    """Notes its calls, (method, caller, arguments ...), and in how many requests they came."""

    def __init__(self):
        super().__init__(('127.0.0.1', 0), logRequests=False)
        self.calls, self.requests, self.parameters = [], 0, {}
        self.uri = f'http://127.0.0.1:{self.server_address[1]}'

    def _dispatch(self, method, arguments):
        if method == 'system.multicall':
            return self.system_multicall(*arguments)
        self.calls.append((method, *arguments))
        if method == 'getParam':
            value = self.parameters.get(arguments[1])
            return [1, '', value] if value is not None else [-1, 'not set', 0]
        return [1, '', ['http://localhost:4321/'] if '/heard' in arguments else []]

    def process_request(self, request, address):
        self.requests += 1
        super().process_request(request, address)


@pytest.fixture
def fake(monkeypatch):
    server = FakeMaster()
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setattr(module.rosgraph, 'get_master_uri', lambda: server.uri)
    monkeypatch.setattr(module.rospy, 'get_name', lambda: '/test')
    monkeypatch.setattr(module.rospy, 'get_node_uri', lambda: URI)
    yield server
    server.shutdown()
    server.server_close()


@pytest.fixture
def master(fake):
    made = Master()
    yield made
    if made._proxy is not None:
        made._proxy('close')()


def things(name):
    """Return a subscriber, a publisher and a service."""
    return (rospy.Subscriber(f'{name}/in', Twist, print), rospy.Publisher(f'{name}/out', String, queue_size=1),
            QueuedService(f'{name}/do', Empty, print))


def collected(make):
    with rospy_internals.collected_registrations() as calls:
        made = make()
    return made, calls


def remove(made):
    with rospy_internals.collected_unregistrations() as calls:
        for each in made:
            each.shutdown() if isinstance(each, rospy.Service) else each.unregister()
    return calls


def files():
    return len(os.listdir('/proc/self/fd'))


def test_what_is_made_and_removed_together_takes_one_request_each_in_its_order(fake, master):
    made, calls = collected(lambda: things('a'))
    assert fake.requests == 0
    uri = made[2].uri
    master.register(calls)
    assert fake.calls == [('registerSubscriber', '/test', '/a/in', 'geometry_msgs/Twist', URI),
                          ('registerPublisher', '/test', '/a/out', 'std_msgs/String', URI),
                          ('registerService', '/test', '/a/do', uri, URI), STATISTICS]
    assert fake.requests == 1
    del fake.calls[:]
    master.unregister(remove(reversed(made)))
    assert fake.calls == [('unregisterService', '/test', '/a/do', uri), ('unregisterPublisher', '/test', '/a/out', URI),
                          ('unregisterSubscriber', '/test', '/a/in', URI)]
    assert not [name for name, *_ in (*rospy_internals.publications(), *rospy_internals.subscriptions(),
                                      *rospy_internals.offered_services()) if name.startswith('/a/')]


def test_many_leave_no_file_descriptor_and_take_none(fake, master):
    collected(lambda: things('first'))  # the server for connections stays
    before = files()
    made, calls = collected(lambda: [each for number in range(50) for each in things(f'b{number}')])
    assert files() <= before + 1
    master.register(calls)
    remove(made)
    assert files() <= before + 2  # the connection to the master, both ends


def test_the_poller_of_a_topic_is_replaced_while_rospy_cannot_use_it():
    manager, taken = collecting.get_topic_manager(), []

    def close():
        thread = threading.Thread(target=lambda: taken.append(manager.lock.acquire(blocking=False)))
        thread.start()
        thread.join()

    def make():
        publisher = rospy.Publisher('d/out', String, queue_size=1)
        publisher.impl.connection_poll = types.SimpleNamespace(poller=types.SimpleNamespace(close=close))
        return [publisher]
    remove(collected(make)[0])
    assert taken == [False]


def test_topics_that_are_removed_together_are_gone_through_once(monkeypatch):
    manager, calls = type(collecting.get_topic_manager()), []
    monkeypatch.setattr(manager, '_recalculate_topics', lambda _: calls.append(None))
    made, _ = collected(lambda: [each for number in range(5) for each in things(f'e{number}')])
    del calls[:]
    remove(made)
    assert len(calls) == 1


def test_publishers_are_passed_on_and_statistics_begin_where_they_are_wanted(fake, master, monkeypatch):
    told = []
    monkeypatch.setattr(collecting, 'new_publishers', lambda topic, uris: told.append((topic, list(uris))))
    monkeypatch.setattr(collecting.SubscriberStatisticsLogger, 'read_parameters', lambda self: None)
    for wanted in (False, True):
        fake.parameters['/enable_statistics'] = wanted
        (heard,), calls = collected(lambda: [rospy.Subscriber('heard', String, print)])
        master.register(calls)
        assert told.pop() == ('/heard', ['http://localhost:4321/'])
        assert (heard.impl.statistics_logger is not None) == wanted
        remove([heard])


def test_what_another_thread_registers_meanwhile_is_not_collected(monkeypatch):
    told = []
    listeners = collecting.get_registration_listeners()
    with rospy_internals.collected_registrations() as calls:
        monkeypatch.setattr(type(listeners), 'notify_added', lambda *arguments: told.append(arguments[1]))
        for name in ('notify_added', 'notify_removed'):
            vars(listeners).pop(name)
        collecting._divert(listeners)
        thread = threading.Thread(target=lambda: rospy.Publisher('theirs', String, queue_size=1))
        thread.start()
        thread.join()
        rospy.Publisher('ours', String, queue_size=1)
    for name in ('notify_added', 'notify_removed'):
        vars(listeners).pop(name)
    assert told == ['/theirs']
    assert [name for _, name, *_ in calls[:-1]] == ['/ours']


def test_parameters_are_those_that_are_set(fake, master):
    fake.parameters['/test/a'] = 5
    assert master.parameters(['/test/a', '/test/b']) == {'/test/a': 5}


def test_thousands_of_calls_are_made_in_their_order_in_several_requests(fake, master):
    calls = [('unregisterPublisher', f'/{number}', URI) for number in range(2 * module.MAX_CALLS + 1)]
    master.unregister(calls)
    assert [call[2] for call in fake.calls] == [name for _, name, _ in calls]
    assert master.request([('getPid',)]) == [[1, '', []]]  # the connection is where it should be


def test_a_master_that_is_gone_and_comes_back(fake, master, monkeypatch):
    master.request([('getPid',)])
    with socket.create_server(('127.0.0.1', 0)) as free:
        gone = f'http://127.0.0.1:{free.getsockname()[1]}'
    monkeypatch.setattr(module.rosgraph, 'get_master_uri', lambda: gone)
    master._proxy('close')()
    master._proxy = None
    with pytest.raises(NoMaster, match=f'no ROS master answers at {gone}'):
        master.request([('getPid',)])
    monkeypatch.setattr(module.rosgraph, 'get_master_uri', lambda: fake.uri)
    assert master.request([('getPid',)])


def test_a_master_that_hangs_is_given_up(monkeypatch):
    monkeypatch.setattr(module.rospy, 'get_name', lambda: '/test')
    with socket.create_server(('127.0.0.1', 0)) as hanging:
        monkeypatch.setattr(module.rosgraph, 'get_master_uri', lambda: f'http://127.0.0.1:{hanging.getsockname()[1]}')
        with pytest.raises(NoMaster, match='timed out'):
            Master(HANG).request([('getPid',)])
