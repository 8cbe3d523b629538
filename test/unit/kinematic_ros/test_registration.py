"""kinematic_ros.registration: a master that comes back gets everything again. Master and node are fakes here."""
import http.client
import socket
import time
import xmlrpc.client

import pytest
import rosgraph
import rospy

from kinematic_ros import registration, rospy_internals

DEADLINE = 5.0  # [s] for a thread to do what it does every PERIOD, on a busy machine
PERIOD = 0.005  # [s]
NODE, URI = '/sim/node', 'http://localhost:4711/'


class FakeMaster:
    """A ROS master and the slave API of the node."""

    def __init__(self):
        self.known, self.failure, self.calls, self.looked = True, None, [], 0
        self.failures = {}  # kind of registration -> exceptions of the next attempts

    def __call__(self, caller):  # in the place of rosgraph.Master and of ServerProxy
        assert caller in (NODE, URI)
        return self

    def lookupNode(self, name):
        self.looked += 1
        if self.failure is not None:
            raise self.failure
        if not self.known:
            raise rosgraph.MasterError(f'unknown node [{name}]')
        return URI

    def _register(self, kind, *args):
        if self.failures.get(kind):
            raise self.failures[kind].pop(0)
        self.calls.append((kind, *args))
        self.known = True  # from the first registration on

    def registerPublisher(self, *args):
        self._register('publisher', *args)

    def registerService(self, *args):
        self._register('service', *args)

    def registerSubscriber(self, name, *args):
        self._register('subscriber', name, *args)
        return [f'http://publisher-of{name}/']

    def publisherUpdate(self, *args):
        self._register('update', *args)


class FakeManager:
    def __init__(self, **lists):
        for name, values in lists.items():
            setattr(self, f'get_{name}', lambda values=values: values)


REGISTERED = [
    ('publisher', '/t/pose', 'turtlesim/Pose', URI), ('publisher', '/rosout', 'rosgraph_msgs/Log', URI),
    ('service', '/t/set_pen', 'rosrpc://localhost:1', URI),
    ('subscriber', '/t/cmd_vel', 'geometry_msgs/Twist', URI),
    ('update', '/master', '/t/cmd_vel', ['http://publisher-of/t/cmd_vel/']),
    ('subscriber', '/any', '*', URI), ('update', '/master', '/any', ['http://publisher-of/any/']),
]


@pytest.fixture
def master(monkeypatch):
    fake = FakeMaster()
    topics = FakeManager(publications=[['/t/pose', 'turtlesim/Pose'], ['/rosout', 'rosgraph_msgs/Log']],
                         subscriptions=[['/t/cmd_vel', 'geometry_msgs/Twist'], ['/any', '*']])
    services = FakeManager(services=[('/t/set_pen', 'rosrpc://localhost:1')])
    monkeypatch.setattr(rosgraph, 'Master', fake)
    monkeypatch.setattr(registration.xmlrpc.client, 'ServerProxy', fake)
    monkeypatch.setattr(rospy_internals, 'get_topic_manager', lambda: topics)
    monkeypatch.setattr(rospy_internals, 'get_service_manager', lambda: services)
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: URI)
    return fake


@pytest.fixture
def logged(monkeypatch):
    lines = []
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: lines.append(text % values))
    monkeypatch.setattr(rospy, 'logwarn_throttle', lambda period, text, *values: lines.append(text % values))
    return lines


@pytest.fixture
def watch(master, logged, monkeypatch):
    """Return a function that starts keep_registered; the thread ends with the test."""
    hooks, threads = [], []
    monkeypatch.setattr(rospy, 'on_shutdown', hooks.append)

    def start(on_return=None):
        threads.append(registration.keep_registered(on_return, PERIOD))
        return threads[-1]
    start.shutdown = lambda: [hook() for hook in hooks]
    yield start
    start.shutdown()
    for thread in threads:
        thread.join(DEADLINE)
        assert not thread.is_alive()


def until(condition):
    deadline = time.monotonic() + DEADLINE
    while not condition() and time.monotonic() < deadline:
        time.sleep(PERIOD)
    return condition()


def looked_again(master, times=3):
    before = master.looked
    return until(lambda: master.looked >= before + times)


def test_master_that_knows_the_node_is_left_alone(master, logged, watch):
    watch()
    assert looked_again(master)
    assert (master.calls, logged) == ([], [])


def test_master_started_anew_gets_every_topic_and_service_and_the_subscribers_their_publishers(master, logged, watch):
    returned = []
    watch(lambda: returned.append(list(master.calls)))
    master.known = False
    assert until(lambda: returned)
    assert master.calls == REGISTERED
    assert returned == [REGISTERED]  # called after everything was registered
    assert len(logged) == 1 and 'registered again' in logged[0]
    assert looked_again(master)
    assert master.calls == REGISTERED  # once is enough


def test_every_return_of_the_master_is_noticed(master, watch):
    returned = []
    watch(lambda: returned.append(None))
    for times in (1, 2, 3):
        master.known = False
        assert until(lambda times=times: len(returned) == times)
    assert master.calls == REGISTERED * 3


@pytest.mark.parametrize('failure', [ConnectionRefusedError(), socket.timeout(), OSError(), rosgraph.MasterFailure('?'),
                                     rosgraph.MasterException('?')])
def test_absent_master_is_waited_for_and_told(master, logged, watch, failure):
    returned = []
    master.failure = failure
    watch(lambda: returned.append(None))
    assert looked_again(master)
    assert master.calls == returned == []
    assert 'does not answer' in logged[0] and 'roscore' in logged[0]
    master.known, master.failure = False, None
    assert until(lambda: returned)
    assert master.calls == REGISTERED


@pytest.mark.parametrize('kind', ['publisher', 'service', 'subscriber', 'update'])
@pytest.mark.parametrize('failure', [ConnectionResetError(), rosgraph.MasterFailure('?'),
                                     http.client.BadStatusLine('?'),
                                     xmlrpc.client.ProtocolError(URI, 500, '?', {}), xmlrpc.client.Fault(1, '?')],
                         ids=lambda failure: type(failure).__name__)
def test_registration_that_breaks_off_half_way_is_done_again_until_it_is_complete(master, watch, kind, failure):
    returned = []
    master.failures[kind] = [failure, failure]
    watch(lambda: returned.append(None))
    master.known = False
    assert until(lambda: returned)
    assert master.calls[-len(REGISTERED):] == REGISTERED
    assert looked_again(master)
    assert len(returned) == 1


def test_on_return_that_fails_is_called_again(master, watch):
    attempts = []

    def on_return():
        attempts.append(None)
        if len(attempts) == 1:
            raise ConnectionRefusedError
    watch(on_return)
    master.known = False
    assert until(lambda: len(attempts) == 2)
    assert looked_again(master)
    assert len(attempts) == 2


def test_without_on_return_it_goes_on_as_well(master, watch):
    watch()
    master.known = False
    assert until(lambda: master.known)
    assert looked_again(master)


def test_thread_ends_at_shutdown_and_holds_no_process_up(master, watch):
    thread = watch()
    assert thread.daemon
    watch.shutdown()
    thread.join(DEADLINE)
    assert not thread.is_alive()


def test_node_unknown_because_it_is_shutting_down_does_not_register_again(master, watch, monkeypatch):
    master.known = False
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: True)
    watch()
    assert looked_again(master)
    assert master.calls == []
