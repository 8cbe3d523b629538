"""rospy_support.rospy_internals: the installed rospy has the parts that this package uses; guards of topics."""
import io
import socket
import struct
import threading
import time
import types
import xmlrpc.client

import pytest
import rosgraph
import rospy
import rospy.core
import rospy.impl.init
import rospy.impl.masterslave
import rospy.impl.paramserver
import rospy.impl.tcpros_base
import rospy.impl.tcpros_pubsub
import rospy.rostime
from rospy.topics import _PublisherImpl, _TopicImpl
from std_msgs.msg import String
from std_srvs.srv import EmptyRequest, SetBoolRequest, SetBoolResponse
from turtlesim.srv import SpawnRequest

from rospy_support import rospy_internals
from rospy_support.rospy_internals import compatibility, process, topics
from rospy_support.rospy_internals import services as service_module

DEADLINE = 10.0  # [s] for what takes milliseconds


def test_this_rospy_fits():
    said = '\n'.join(rospy_internals.misfits())
    assert not said, (f'rospy {rospy_internals.version()} differs from {", ".join(rospy_internals.CHECKED)}, for which '
                      f'rospy_support.rospy_internals was written; change it, or the table there:\n{said}')


def test_what_does_not_fit_is_named(monkeypatch):
    monkeypatch.delattr(rospy.rostime, '_set_rostime')
    monkeypatch.setattr(rospy.impl.tcpros_base.TCPROSTransport, 'close', lambda self, reason: None)
    monkeypatch.setattr(rospy.topics.Topic, '__init__', lambda self: None)
    assert rospy_internals.misfits() == [
        'rospy.rostime._set_rostime is missing',
        'rospy.impl.tcpros_base.TCPROSTransport.close takes (self, reason), not (self)',
        'rospy.topics.Topic has no attribute impl']


def test_a_missing_module_is_named(monkeypatch):
    monkeypatch.setattr(compatibility, 'FUNCTIONS', {'rospy.impl.no_such_module.function': ()})
    monkeypatch.setattr(compatibility, 'ATTRIBUTES', {'no_such_package.Class': ('socket',)})
    assert rospy_internals.misfits() == ['rospy.impl.no_such_module.function is missing',
                                         'no_such_package.Class is missing']


def test_a_publisher_without_and_after_its_topic(monkeypatch):
    publisher = rospy.Publisher('chatter', String, queue_size=1)
    assert list(rospy_internals.connections(publisher)) == []
    rospy_internals.publish_without_threads(publisher)
    assert ['/chatter', 'std_msgs/String'] in rospy_internals.publications()
    assert '/chatter' in rospy_internals.unconnected_publications()
    assert rospy_internals.published_messages() == {}
    with monkeypatch.context() as connected:
        connected.setattr(publisher.impl, 'has_connections', lambda: True)
        before = rospy_internals.published_messages()['/chatter']
        rospy_internals.count_publication(publisher)
        assert rospy_internals.published_messages() == {'/chatter': before + 1}
    publisher.unregister()
    assert list(rospy_internals.connections(publisher)) == []
    assert '/chatter' not in rospy_internals.unconnected_publications()
    rospy_internals.count_publication(publisher)


def test_the_caller_of_a_message():
    message = String()
    assert rospy_internals.caller(message) == ''
    message._connection_header = {'callerid': '/talker'}
    assert rospy_internals.caller(message) == '/talker'


class Connections:
    """A topic of rospy whose connections are told apart, and transports on sockets for it."""

    def __init__(self, monkeypatch):
        for method in ('_remove_connection', 'check'):
            monkeypatch.setattr(_TopicImpl, method, getattr(_TopicImpl, method))  # restored after the test
        rospy_internals.tell_connections_apart()
        self.topic = _PublisherImpl('/chatter', String)
        self.peers, self.transports = [], []

    def transport(self):
        """Return a transport of a subscriber that is always called the same."""
        own, peer = socket.socketpair()
        self.peers.append(peer)
        protocol = rospy.impl.tcpros_pubsub.TCPROSPub('/chatter', String)
        transport = rospy.impl.tcpros_base.TCPROSTransport(protocol, '/chatter')
        transport.set_socket(own, '/listener')
        self.transports.append(transport)
        return transport

    def successor(self, old):
        """Return a transport whose file descriptor has the number of an ended one."""
        self.peers.pop().close()  # of the old one; the two lowest numbers are free
        new = self.transport()
        while new.fileno() != old.fileno():
            new = self.transport()
        return new


@pytest.fixture
def connections(monkeypatch):
    """Connections, which are closed after the test."""
    made = Connections(monkeypatch)
    yield made
    for transport in made.transports:
        transport.close()


@pytest.mark.parametrize('queue_size', [None, 1])
def test_a_subscriber_that_returns_at_once_keeps_its_new_connection(connections, queue_size):
    """The old one is still being removed when the new one has got the number of its file descriptor."""
    topic = connections.topic
    topic.set_queue_size(queue_size)
    old = connections.transport()
    topic.add_connection(old)
    ended, old.cleanup_cb = old.cleanup_cb, None  # the thread that closes it has not come that far
    old.close()
    new = connections.successor(old)
    topic.add_connection(new)
    ended(old)
    assert topic.get_num_connections() == 1 and topic.connections[0].socket is new.socket
    topic.check()
    assert topic.has_connections()
    connections.peers[-1].close()
    topic.check()  # still watches the new one
    assert not topic.has_connections() and new.socket is None


def test_no_connection_comes_while_broken_ones_are_sought(connections, monkeypatch):
    """A new one could have the number of one that was found."""
    topic, taken = connections.topic, []

    def seek():
        thread = threading.Thread(target=lambda: taken.append(topic.c_lock.acquire(blocking=False)))
        thread.start()
        thread.join(DEADLINE)
        return ()
    monkeypatch.setattr(topic, 'connection_poll', types.SimpleNamespace(error_iter=seek))
    topic.check()
    assert taken == [False]


class Connecting:
    """rospy's RegManager with a publisher that does not answer, as ``_Publishers`` sees them."""

    def __init__(self, monkeypatch, subscribed=('/pose',)):
        self.publishers = topics._Publishers()
        self.updates, self.tries, self.go_on = [], [], threading.Event()
        monkeypatch.setattr(topics, 'get_topic_manager', lambda: self)
        self.has_subscription = subscribed.__contains__

    def update(self, topic, *uris):
        self.publishers._update(lambda manager, *update: self.updates.append(update), self, topic, uris)

    def connect(self, topic, uri):
        self.publishers._connect(self._try, self, topic, uri)

    def _try(self, manager, topic, uri):
        self.tries.append(uri)
        self.go_on.wait(DEADLINE)
        self.publishers._proxy(lambda uri, cache: None, uri, False)


def test_a_publisher_that_is_named_often_gets_one_thread_and_a_last_try(monkeypatch):
    connecting = Connecting(monkeypatch)
    connecting.update('/pose', 'http://silent/')
    thread = threading.Thread(target=connecting.connect, args=('/pose', 'http://silent/'))
    thread.start()
    while not connecting.tries:
        time.sleep(0.001)
    for _ in range(5):
        connecting.connect('/pose', 'http://silent/')  # returns at once
    connecting.go_on.set()
    thread.join(DEADLINE)
    assert connecting.tries == 2 * ['http://silent/']
    connecting.connect('/pose', 'http://silent/')
    assert len(connecting.tries) == 3


def test_a_publisher_that_is_named_no_more_is_left(monkeypatch):
    connecting = Connecting(monkeypatch)
    connecting.go_on.set()
    connecting.update('/pose', 'http://gone/')
    connecting.connect('/pose', 'http://gone/')
    connecting.update('/pose', 'http://new/')
    with pytest.raises(ConnectionRefusedError):  # which rospy takes for the end
        connecting.connect('/pose', 'http://gone/')


def test_publishers_of_topics_that_nobody_subscribes_to_are_not_kept(monkeypatch):
    connecting = Connecting(monkeypatch)
    connecting.update('/other', 'http://a/')
    assert connecting.updates == [] and connecting.publishers._named == {}


@pytest.fixture
def peers():
    ours, theirs = socket.socketpair()
    theirs.settimeout(DEADLINE)
    with ours, theirs:
        yield types.SimpleNamespace(socket=ours, header={'callerid': '/caller'}), theirs


@pytest.mark.parametrize('request_class, data, size', [
    (SetBoolRequest, b'\1', None), (SetBoolRequest, b'', '0 bytes'), (SetBoolRequest, b'\1\0', '2 bytes'),
    (SpawnRequest, b'\0' * 12 + b'\3\0\0\0bob', None), (SpawnRequest, b'...', '3 bytes'),
    (SpawnRequest, b'\0' * 12 + b'\3\0\0\0bo', '18 bytes'), (SpawnRequest, b'\0' * 12 + b'\2\0\0\0bob', '19 bytes'),
    (SpawnRequest, b'\0' * 12 + b'\xff\xff\xff\xffbob', '19 bytes'), (EmptyRequest, b'...', '3 bytes'),
])
def test_a_request_of_wrong_length_gets_an_answer(peers, request_class, data, size):
    handled = []
    service = types.SimpleNamespace(request_class=request_class, _handle_request=lambda *each: handled.append(each))
    wrong = rospy_internals.respond(service, peers[0], data)
    if size is None:
        assert wrong is None and len(handled) == 1 and rospy_internals.caller(handled[0][1]) == '/caller'
    else:
        answer = peers[1].recv(1000)
        assert answer[:1] == b'\0' and size.encode() in answer and size in wrong and not handled


def test_a_caller_that_has_gone_is_no_error_of_the_service(peers):
    service = types.SimpleNamespace(handler=lambda _: SetBoolResponse(), response_class=SetBoolResponse, seq=0,
                                    error_handler=lambda *_: pytest.fail('an error of the handler'))
    peers[1].close()
    with pytest.raises(OSError):
        service_module.handle_request(service, peers[0], SetBoolRequest())


@pytest.mark.parametrize('size, closed', [(1000, False), (1001, True), (0xffffffff, True)])
def test_a_publisher_of_endless_messages_is_left(monkeypatch, size, closed):
    protocol, reports = rospy.impl.tcpros_base.TCPROSTransportProtocol, []
    monkeypatch.setattr(protocol, 'read_messages', lambda *_: 'read')
    rospy_internals.limit_messages(1000, reports.append)
    buffer = io.BytesIO()
    buffer.write(struct.pack('<I', size))
    if closed:
        with pytest.raises(rospy.exceptions.TransportTerminated):
            protocol('/chatter', String).read_messages(buffer, [], None)
    else:
        assert protocol('/chatter', String).read_messages(buffer, [], None) == 'read'
    assert len(reports) == closed and all('/chatter' in said and str(size) in said for said in reports)


ENDLESS = String('x' * 10_000_000)  # more than the buffers of a connection hold


def test_an_answer_does_not_wait_for_a_client_that_does_not_read(peers):
    transport, client = peers
    transport.socket.settimeout(DEADLINE)
    call = rospy_internals.ServiceCall(None, transport, None)
    begin = time.monotonic()
    call.answer(ENDLESS)
    assert time.monotonic() - begin < DEADLINE / 2.0
    thread = threading.Thread(target=call.finish)
    thread.start()
    expected, received = b'\1' + rospy_internals.frame(ENDLESS), 0
    while received < len(expected):
        received += len(client.recv(1 << 20))
    thread.join(DEADLINE)
    assert received == len(expected) and not thread.is_alive()


@pytest.mark.parametrize('closed', [True, False])
def test_an_answer_to_a_client_that_has_gone_is_dropped(peers, closed):
    transport, client = peers
    client.close()
    if closed:  # as rospy leaves it
        transport.socket = None
    call = rospy_internals.ServiceCall(None, transport, None)
    call.fail('too late')
    call.finish()


def test_a_call_that_is_not_answered_ends_with_the_node(monkeypatch):
    monkeypatch.setattr(service_module, 'SHUTDOWN_POLL', 0.01)
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: True)
    thread = threading.Thread(target=rospy_internals.ServiceCall(None, None, None).finish, daemon=True)
    thread.start()
    thread.join(DEADLINE)
    assert not thread.is_alive()


def test_a_node_polls_often_for_the_answer_of_the_master(monkeypatch):
    slept = []
    monkeypatch.setattr(rospy.impl.init, 'time', rospy.impl.init.time)  # restored after the test
    monkeypatch.setattr(time, 'sleep', slept.append)
    rospy_internals.poll_for_registration()
    for seconds in (0.1, 0.00001):
        rospy.impl.init.time.sleep(seconds)
    assert slept == [0.005, 0.00001]


@pytest.mark.parametrize('answer', [True, False, ConnectionRefusedError()])
def test_log_lines_do_not_ask_the_master(monkeypatch, answer):
    def get_param(name, default):
        if isinstance(answer, Exception):
            raise answer
        return answer
    cache = rospy.impl.paramserver.ParamServerCache()
    monkeypatch.setattr(rospy.impl.paramserver, 'get_param_server_cache', lambda: cache)
    monkeypatch.setattr(rospy, 'get_param', get_param)
    rospy_internals.log_without_asking()
    assert cache.get(rospy_internals.LOG_PARAMETER) is (answer is True)  # rospy asks if this raises KeyError


@pytest.mark.parametrize('message, obeyed', [
    ('user request', True), ('[/me] Reason: new node registered with same name', True),
    ('[/other] Reason: new node registered with same name', False)])
def test_a_request_to_shut_down_is_for_the_node_that_it_names(monkeypatch, message, obeyed):
    handler, reasons = rospy.impl.masterslave.ROSHandler, []
    monkeypatch.setattr(handler, 'shutdown', handler.shutdown)  # restored after the test
    rospy_internals.shut_down_by(reasons.append)
    code, _, _ = handler.shutdown(types.SimpleNamespace(name='/me'), '/master', message)
    assert code == obeyed and len(reasons) == obeyed and all(message in reason for reason in reasons)


def test_a_shutdown_does_not_wait_for_a_master_that_hangs(monkeypatch):
    """rospy's shutdown handles xmlrpc.client.Error, and prints other errors."""
    monkeypatch.setattr(rospy.core, '_xmlrpc_cache', {})
    with socket.create_server(('127.0.0.1', 0)) as hanging:
        monkeypatch.setenv('ROS_MASTER_URI', f'http://127.0.0.1:{hanging.getsockname()[1]}')
        rospy_internals.limit_calls_of_master(0.1)
        call = threading.Thread(target=lambda: ended.append(raised_by(rospy.core.xmlrpcapi(rosgraph.get_master_uri()))),
                                daemon=True)
        ended = []
        call.start()
        call.join(DEADLINE)
    assert ended == [xmlrpc.client.ProtocolError]


def raised_by(master):
    try:
        return master.getPid('/me')
    except Exception as error:
        return type(error)


@pytest.mark.parametrize('held', [True, False])
def test_a_shutdown_ends_a_registration_that_holds_its_lock(monkeypatch, held):
    monkeypatch.setattr(rospy.core, '_shutdown_flag', False)
    lock = threading.Lock()
    monkeypatch.setattr(process, 'get_topic_manager', lambda: types.SimpleNamespace(lock=lock))
    if held:
        lock.acquire()
    rospy_internals.end_registering(0.01)
    assert rospy.core._shutdown_flag == held
