"""rospy_support.registration: a master that comes back gets everything again. The master is a server made here."""
import threading
import time
import xmlrpc.client
import xmlrpc.server

import pytest
import rosgraph
import rospy

from rospy_support import registration, rospy_internals
from rostest_support.waiting import until

DEADLINE = 20.0  # [s] for the work that a thread does every PERIOD, on a busy machine
PERIOD = 0.005  # [s]
NODE, URI = '/sim/node', 'http://localhost:4711/'
SIGN, SIGN_URI = '/sim/node/get_loggers', 'rosrpc://localhost:1'
PARAMETERS = {'/sim/node/rate': 5.0, '/sim/node/name': 'anna'}


class Server(xmlrpc.server.SimpleXMLRPCServer):
    allow_reuse_address = True


class Master:
    """The part of a ROS master that a node needs, as an XML-RPC server that can be absent, fail, hang, or restart."""

    def __init__(self):
        self.parameters, self.services, self.calls, self.looked = {}, {SIGN: SIGN_URI}, [], 0
        self.listed, self.uri = ([], [], []), URI  # names (published, subscribed, services) of the node, where it is
        self.failures = {}  # method -> how many of its next calls fail
        self.port, self._server = 0, None
        self.start()

    def start(self):
        self._server = Server(('localhost', self.port), logRequests=False, allow_none=True)
        self._server.register_multicall_functions()
        self._server.register_instance(self)
        self.port = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, args=(0.001,), daemon=True).start()

    def stop(self):
        self._server.shutdown()
        self._server.server_close()

    def forget(self):
        """Be a new one."""
        self.services.clear()
        self.parameters.clear()

    def _dispatch(self, method, arguments):
        caller, *arguments = arguments
        assert caller == NODE
        if self.failures.get(method):
            self.failures[method] -= 1
            raise OSError('made for the test')
        if method == 'lookupService':
            self.looked += 1
            return (1, '', self.services[arguments[0]]) if arguments[0] in self.services else (-1, 'unknown', '')
        if method == 'hasParam':
            return 1, '', arguments[0] in self.parameters
        if method == 'lookupNode':
            return (1, '', self.uri) if any(self.listed) else (-1, 'unknown node', '')
        if method == 'getSystemState':
            return 1, '', [[[name, [NODE, '/other']] for name in kind] + [['/foreign', ['/other']]]
                           for kind in self.listed]
        if method == 'getParam':
            return (1, '', self.parameters[arguments[0]]) if arguments[0] in self.parameters else (-1, 'not set', 0)
        self.calls.append((method, *arguments))
        if method == 'deleteParam':
            del self.parameters[arguments[0]]
        if method == 'setParam':
            self.parameters[arguments[0]] = arguments[1]
        if method == 'registerService':
            self.services[arguments[0]] = arguments[1]
        return 1, '', [f'http://publisher-of{arguments[0]}/'] if method == 'registerSubscriber' else 0


REGISTERED = [
    ('setParam', '/sim/node/rate', 5.0), ('setParam', '/sim/node/name', 'anna'),
    ('registerSubscriber', '/t/cmd_vel', 'geometry_msgs/Twist', URI), ('registerSubscriber', '/any', '*', URI),
    ('registerPublisher', '/t/pose', 'turtlesim/Pose', URI), ('registerPublisher', '/rosout', 'rosgraph_msgs/Log', URI),
    ('registerService', '/t/set_pen', SIGN_URI, URI), ('registerService', SIGN, SIGN_URI, URI),
]


@pytest.fixture
def master(monkeypatch):
    server = Master()
    monkeypatch.setenv('ROS_MASTER_URI', f'http://localhost:{server.port}')
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', f'{NODE}/'))
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: URI)
    monkeypatch.setattr(registration, '_hooks', [])
    monkeypatch.setattr(registration, '_deleted_at_end', {})
    yield server
    server.stop()


@pytest.fixture
def connected(monkeypatch, master):
    """The registrations of this process, and the list of publisher updates that it received."""
    told = []
    for name, value in {'publications': [['/t/pose', 'turtlesim/Pose'], ['/rosout', 'rosgraph_msgs/Log']],
                        'subscriptions': [['/t/cmd_vel', 'geometry_msgs/Twist'], ['/any', '*']],
                        'offered_services': [(SIGN, SIGN_URI), ('/t/set_pen', SIGN_URI)],
                        'shutting_down': False}.items():
        monkeypatch.setattr(rospy_internals, name, lambda value=value: value)
    monkeypatch.setattr(rospy_internals, 'new_publishers', lambda topic, uris: told.append((topic, uris)))
    return told


@pytest.fixture
def watch(master, connected, logged, monkeypatch):
    """Return a function that starts keep_registered; the thread ends with the test."""
    hooks, threads = [], []
    monkeypatch.setattr(rospy, 'on_shutdown', hooks.append)

    def start():
        threads.append(registration.keep_registered(PARAMETERS, PERIOD))
        return threads[-1]

    def shutdown():
        for hook in hooks:  # hooks may add hooks
            hook()
    start.shutdown = shutdown
    yield start
    shutdown()
    for thread in threads:
        thread.join(DEADLINE)
        assert not thread.is_alive()


def looked_again(master, times=3):
    before = master.looked
    return until(lambda: master.looked >= before + times)


def test_master_that_knows_the_node_is_left_alone(master, logged, watch):
    watch()
    assert looked_again(master)
    assert (master.calls, logged) == ([], [])


def test_master_started_anew_gets_everything_and_the_subscribers_their_publishers(master, connected, logged, watch):
    returned = []
    registration.on_return(lambda: returned.append(list(master.calls)))
    watch()
    master.forget()
    assert until(lambda: returned)
    assert master.calls == REGISTERED
    assert returned == [REGISTERED]  # called after everything was registered
    assert connected == [('/t/cmd_vel', ['http://publisher-of/t/cmd_vel/']), ('/any', ['http://publisher-of/any/'])]
    assert looked_again(master)
    assert len(logged) == 1 and 'registered again' in logged[0]
    assert master.calls == REGISTERED  # once is enough


def test_a_parameter_that_the_new_master_has_stays(master, watch):
    watch()
    master.parameters['/sim/node/rate'] = 7.0
    master.services.clear()
    assert until(lambda: SIGN in master.services)
    assert master.parameters == {'/sim/node/rate': 7.0, '/sim/node/name': 'anna'}


def test_a_master_that_has_learnt_the_name_but_no_service_is_a_new_one(master, watch):
    """Fault: a node that logs asks for a parameter, and a new master then knows its name."""
    watch()
    del master.services[SIGN]
    assert until(lambda: SIGN in master.services)
    assert master.calls == REGISTERED


def test_absent_master_is_waited_for_and_told_once(master, logged, watch):
    watch()
    assert looked_again(master)
    master.stop()
    assert until(lambda: logged)
    assert 'does not answer' in logged[0] and 'roscore' in logged[0]
    time.sleep(20 * PERIOD)  # it looks again and again
    master.forget()
    master.start()
    assert until(lambda: len(logged) > 1)
    assert len(logged) == 2 and 'registered again' in logged[1]
    assert master.calls == REGISTERED


def test_master_that_only_stood_still_is_told_to_be_back(master, logged, watch, monkeypatch):
    monkeypatch.setattr(registration, 'TIMEOUT', 0.02)
    hold = threading.Event()
    original = master._dispatch
    monkeypatch.setattr(master, '_dispatch', lambda *call: (hold.wait(DEADLINE), original(*call))[1])
    watch()
    assert until(lambda: logged)
    assert 'does not answer' in logged[0]
    hold.set()
    assert until(lambda: len(logged) > 1)
    assert logged[1:] == ['The ROS master answers again.']
    assert master.calls == []


@pytest.mark.parametrize('method', ['lookupService', 'hasParam', 'setParam', 'registerPublisher', 'registerService',
                                    'registerSubscriber'])
def test_registration_that_breaks_off_half_way_is_done_again_until_it_is_complete(master, connected, watch, method):
    returned = []
    registration.on_return(lambda: returned.append(None))
    master.failures[method] = 2
    master.forget()
    watch()
    assert until(lambda: returned)
    assert master.calls[-len(REGISTERED) + 2:] == REGISTERED[2:]
    assert master.parameters == PARAMETERS
    assert [topic for topic, _ in connected[-2:]] == ['/t/cmd_vel', '/any']
    assert looked_again(master)
    assert len(returned) == 1


@pytest.mark.parametrize('error', [ConnectionRefusedError(), rosgraph.MasterFailure('?'), xmlrpc.client.Fault(1, '?')])
def test_a_hook_that_fails_is_called_again(master, watch, error):
    attempts = []

    def hook():
        attempts.append(None)
        if len(attempts) == 1:
            raise error
    registration.on_return(hook)
    watch()
    master.forget()
    assert until(lambda: len(attempts) == 2)
    assert looked_again(master)
    assert len(attempts) == 2


def test_a_newer_node_of_the_same_name_ends_this_one(master, logged, watch, monkeypatch):
    reasons = []
    monkeypatch.setattr(rospy, 'signal_shutdown', reasons.append)
    master.services[SIGN] = 'rosrpc://localhost:2'
    watch()
    assert until(lambda: reasons)
    assert 'Another node with the name /sim/node' in logged[0]
    assert master.calls == []


def test_node_unknown_because_it_is_shutting_down_does_not_register_again(master, watch, monkeypatch):
    monkeypatch.setattr(rospy_internals, 'shutting_down', lambda: True)
    master.forget()
    watch()
    assert until(lambda: master.looked)
    time.sleep(20 * PERIOD)
    assert master.calls == []


def test_many_registrations_take_few_requests_and_all_values_come_back(master):
    requests = []
    server = master._server
    original = server._marshaled_dispatch
    server._marshaled_dispatch = lambda *data: (requests.append(None), original(*data))[1]
    values = registration.values_of(('registerSubscriber', f'/t{number}', '*', URI) for number in range(1201))
    assert len(requests) == 3
    assert values == [[f'http://publisher-of/t{number}/'] for number in range(1201)]


def test_a_refused_call_of_many_is_named(master):
    with pytest.raises(rosgraph.MasterError, match='lookupService: unknown'):
        registration.values_of([('lookupService', SIGN), ('lookupService', '/none')])


OTHER = {'/sim/node/other': 1}


@pytest.mark.parametrize('change, left', [
    ({}, OTHER),
    ({'parameters': {**PARAMETERS, **OTHER, '/sim/node/rate': 7.0}}, {**OTHER, '/sim/node/rate': 7.0}),
    ({'parameters': {**OTHER, '/sim/node/rate': 5.0}}, OTHER),  # the name is deleted
    ({'services': {SIGN: 'rosrpc://localhost:2'}}, {**PARAMETERS, **OTHER}),  # a newer node has the name
    ({'uri': 'http://localhost:4712/'}, {**PARAMETERS, **OTHER}),  # a newer node is starting
    ({'services': {}}, {**PARAMETERS, **OTHER}),  # a master that does not know it
])
def test_the_end_deletes_what_the_command_line_has_set(master, watch, change, left):
    master.parameters.update(PARAMETERS, **OTHER)
    master.listed = [], [], [SIGN]
    registration.keep_registered(PARAMETERS, 1000.0)
    vars(master).update(change)
    watch.shutdown()
    assert master.parameters == left


def test_the_end_deletes_what_its_launch_file_has_set(master, watch):
    master.parameters.update(PARAMETERS, **{'/robot_description': 'urdf', '/other': 1})
    master.listed = [], [], [SIGN]
    registration.keep_registered({}, 1000.0)
    registration.delete_at_end({'/robot_description': 'urdf', '/other': 2})
    watch.shutdown()
    assert master.parameters == {**PARAMETERS, '/other': 1}


def test_the_end_of_a_node_without_parameters_does_not_ask_the_master(master, watch):
    registration.keep_registered({}, 1000.0)
    watch.shutdown()
    assert (master.calls, master.looked) == ([], 0)


def test_what_was_registered_during_the_shutdown_is_unregistered(master):
    registration.unregister_rest()
    assert master.calls == []
    master.listed = ['/t/pose'], ['/t/cmd_vel'], [SIGN]
    registration.unregister_rest()
    assert master.calls == [('unregisterPublisher', '/t/pose', URI), ('unregisterSubscriber', '/t/cmd_vel', URI),
                            ('unregisterService', SIGN, SIGN_URI)]


def test_a_newer_node_of_the_same_name_is_not_unregistered(master):
    master.listed, master.uri = (['/t/pose'], [], []), 'http://localhost:4712/'
    registration.unregister_rest()
    assert master.calls == []


def test_a_node_that_ends_without_a_master_does_not_look_for_it(master):
    master.stop()
    registration.unregister_rest()
    master.start()


def test_threads_may_call_the_master_at_once_during_the_shutdown(master, monkeypatch):
    monkeypatch.setattr(rospy.core, '_xmlrpc_cache', {})
    rospy_internals.limit_calls_of_master(DEADLINE)
    proxy = rospy.core.xmlrpcapi(rosgraph.get_master_uri())
    answered = []

    def call():
        for _ in range(50):
            answered.append(proxy.lookupService(NODE, SIGN))
    threads = [threading.Thread(target=call) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(DEADLINE)
    assert answered == 200 * [[1, '', SIGN_URI]]
