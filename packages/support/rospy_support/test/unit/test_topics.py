"""rospy_support.topics: a publisher that never waits and never breaks a stream.

The publisher and its connections are rospy's own, without a master; only the subscriber's end is ours.
"""
import socket
import struct
import time

import genpy
import pytest
from geometry_msgs.msg import PointStamped
from hypothesis import given
from hypothesis import strategies as st
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub
from std_msgs.msg import ColorRGBA, String

from rospy_support.rospy_internals import frame
from rospy_support.topics import LatestPublisher, SubscriptionListener

NEVER_WAITS = 5.0  # [s] in which what must not block has long been done, on a busy machine
FLOOD = 3000  # messages of 1 kB: more than the buffers of a connection hold
KB = 1000


@pytest.fixture
def publisher():
    made = LatestPublisher('chatter', String)
    yield made
    made.unregister()


@pytest.fixture
def subscribe(publisher):
    """Return a function that connects one subscriber and returns its socket."""
    sockets = []

    def connect(name='listener', own=None):
        if own is None:
            with socket.create_server(('127.0.0.1', 0)) as server:
                server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                ours = socket.create_connection(server.getsockname())
                theirs, _ = server.accept()
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        else:
            ours, theirs = own, None
        transport = TCPROSTransport(TCPROSPub('/chatter', String), '/chatter')
        transport.set_socket(ours, name)
        publisher.impl.add_connection(transport)
        sockets.extend(filter(None, (ours, theirs)))
        return theirs if own is None else transport
    yield connect
    for each in sockets:
        each.close()


def text(number, length=KB):
    return f'{number:08d}' + 'x' * (length - 8)


def parse(stream):
    """Return the numbers of the whole messages in a stream of ``text``s; fail when it is out of step."""
    numbers = []
    while len(stream) >= 4:
        (size,) = struct.unpack_from('<I', stream)
        if len(stream) < 4 + size:
            break
        (length,) = struct.unpack_from('<I', stream, 4)
        assert size == length + 4
        data = stream[8:8 + length].decode()
        numbers.append(int(data[:8]))
        assert data == text(numbers[-1], length)
        stream = stream[4 + size:]
    return numbers, stream


def received(theirs):
    """Return all bytes that are there within a moment."""
    theirs.settimeout(0.1)
    data = b''
    try:
        while True:
            chunk = theirs.recv(65536)
            if not chunk:
                return data
            data += chunk
    except socket.timeout:
        return data


def test_frame_is_the_length_and_the_fields_in_little_endian():
    # String: uint32 length, text; before it the uint32 length of all that: 4 + 2 = 6
    assert frame(String('hi')) == b'\x06\0\0\0' + b'\x02\0\0\0hi'
    assert frame(ColorRGBA(1.0, 0.0, 0.0, 0.0)) == b'\x10\0\0\0' + b'\0\0\x80\x3f' + b'\0' * 12
    # PointStamped: seq 0, stamp 0, frame_id '' (16 bytes) and three float64 of 0 (24 bytes)
    assert frame(PointStamped()) == b'\x28\0\0\0' + b'\0' * 40


def test_message_with_a_field_of_the_wrong_type_is_refused_and_nothing_is_written(publisher, subscribe):
    theirs = subscribe()
    with pytest.raises(genpy.SerializationError):
        publisher.publish(3.5)
    assert received(theirs) == b''


@pytest.mark.parametrize('args, kwds', [(('hi',), {}), ((String('hi'),), {}), ((), {'data': 'hi'})])
def test_message_is_written_whole_and_at_once_to_every_subscriber(publisher, subscribe, args, kwds):
    listeners = [subscribe('one'), subscribe('two')]
    publisher.publish(*args, **kwds)
    assert [received(theirs) for theirs in listeners] == [frame(String('hi'))] * 2


def test_publishing_without_subscribers_or_after_unregistering_does_nothing(publisher):
    publisher.publish('x')
    publisher.unregister()
    assert not publisher.wanted()
    publisher.publish('x')
    publisher.publish(data='x')
    publisher.publish_frame(frame(String('x')))


def test_subscriber_that_stops_reading_loses_messages_and_gets_whole_ones_again_when_it_resumes(publisher, subscribe):
    theirs = subscribe()
    begun = time.monotonic()
    for number in range(FLOOD):
        publisher.publish(text(number))
    assert time.monotonic() - begun < NEVER_WAITS
    early, rest = parse(received(theirs))
    assert early[0] == 0
    assert early == sorted(set(early)) and len(early) < FLOOD  # whole, in their order, and not all
    late, number = [], FLOOD
    while late[-2:] != [number - 2, number - 1] or number < FLOOD + 2:  # two in a row that were not lost
        assert time.monotonic() - begun < 2.0 * NEVER_WAITS
        publisher.publish(text(number))
        number += 1
        numbers, rest = parse(rest + received(theirs))
        late += numbers
    assert rest == b''
    assert early + late == sorted(set(early + late))


def test_subscriber_that_does_not_read_takes_nothing_from_another(publisher, subscribe):
    subscribe('deaf')
    theirs = subscribe('good')
    seen = []
    for number in range(500):
        publisher.publish(text(number))
        data = b''
        while len(data) < 4 + 4 + KB:
            data += theirs.recv(65536)
        seen += parse(data)[0]
    assert seen == list(range(500))


def test_closed_subscribers_are_removed_and_the_others_stay(publisher, subscribe):
    gone, stays = subscribe('gone'), subscribe('stays')
    gone.close()
    for _ in range(5):
        publisher.publish('x')
    assert [connection.endpoint_id for connection in publisher.impl.connections] == ['stays'] and publisher.wanted()
    assert received(stays) == frame(String('x')) * 5


def test_connection_that_rospy_has_closed_meanwhile_is_left_alone(publisher, subscribe):
    subscribe()
    (connection,) = publisher.impl.connections
    connection.cleanup_cb = None  # rospy closes it first and takes it off the list a moment later
    connection.close()
    assert connection.socket is None
    publisher.publish('x')
    publisher.publish('x')


class ScriptedSocket:
    """The publisher's end of a connection whose buffer takes as much as the script says, send by send."""

    def __init__(self, script):
        self.script, self.stream = list(script), b''

    def send(self, data, flags):
        assert flags == socket.MSG_DONTWAIT
        room = self.script.pop(0) if self.script else len(data)
        if isinstance(room, Exception):
            raise room
        if room == 0:
            raise BlockingIOError
        self.stream += data[:room]
        return min(room, len(data))

    def fileno(self):
        return None

    def getsockname(self):
        return '127.0.0.1', 0

    def shutdown(self, _):
        pass

    def close(self):
        pass


def test_rest_of_a_message_goes_first_and_the_present_one_is_dropped(publisher, subscribe):
    # rooms: 10 bytes of number 0 (26 long), 0 for number 1, 6 and then all of the rest of 0; 4 is whole again
    ours = ScriptedSocket([10, 0, 6])
    subscribe(own=ours)
    lengths = []
    for number in range(5):
        publisher.publish(text(number, 18))
        lengths.append(len(ours.stream))
    assert lengths == [10, 10, 16, 26, 52]
    assert parse(ours.stream) == ([0, 4], b'')


@given(script=st.lists(st.one_of(st.just(0), st.integers(0, 70)), max_size=40))
def test_whatever_a_buffer_takes_the_stream_holds_whole_messages_in_their_order(script):
    publisher = LatestPublisher('chatter', String)
    ours = ScriptedSocket(script)
    transport = TCPROSTransport(TCPROSPub('/chatter', String), '/chatter')
    transport.set_socket(ours, 'listener')
    publisher.impl.add_connection(transport)
    for number in range(len(script) + 2):  # the script ends by taking everything
        publisher.publish(text(number, 8 + number % 30))
    publisher.unregister()
    numbers, rest = parse(ours.stream)
    assert rest == b''
    assert numbers == sorted(set(numbers))
    assert numbers[-1] == len(script) + 1


@pytest.mark.parametrize('error', [ConnectionResetError(), BrokenPipeError(), OSError(9, 'bad file descriptor')])
@pytest.mark.parametrize('before', [[], [10]])
def test_broken_connection_is_closed_and_forgotten_with_what_it_had_not_taken(publisher, subscribe, error, before):
    connection = subscribe(own=ScriptedSocket([*before, error]))
    for _ in (*before, error):
        publisher.publish(text(0))
    assert connection.done
    assert publisher.impl.connections == []
    assert publisher._unsent == {}


class ClosesTopic(ScriptedSocket):
    """A socket that breaks because another thread closes the topic, which has just set its lists to None."""

    def __init__(self, topic):
        super().__init__([])
        self._topic = topic

    def send(self, data, flags):
        self._topic.subscriber_listeners = None
        raise BrokenPipeError


def test_a_topic_that_is_closed_while_it_is_published_ends_no_node(publisher, subscribe):
    connection = subscribe(own=ClosesTopic(publisher.impl))
    publisher.publish(text(1))
    assert connection.done and not publisher.wanted()


def test_connection_removed_by_rospy_is_forgotten_with_what_it_had_not_taken(publisher, subscribe):
    connection = subscribe(own=ScriptedSocket([10]))
    publisher.publish(text(0))
    assert publisher._unsent
    publisher.impl.remove_connection(connection)
    publisher.publish(text(1))
    assert publisher._unsent == {}


def test_topic_is_published_without_a_queue_and_without_delay(publisher):
    assert publisher.impl.queue_size is None
    from rospy.impl.tcpros import get_tcpros_handler
    assert get_tcpros_handler().tcp_nodelay_map[publisher.resolved_name] is True


def test_listener_is_called_for_each_new_subscriber_which_is_counted_already(subscribe, publisher):
    counts = []
    publisher.impl.add_subscriber_listener(SubscriptionListener(
        lambda: counts.append(publisher.get_num_connections())))
    subscribe('one')
    subscribe('two')
    assert counts == [1, 2]
