"""A node of ROS seen from outside, by raw sockets: what an honest peer does with it, and how long that takes.

No rospy: a test opens thousands of connections beside it, and sends what rospy would never send.
"""
import os
import socket
import struct
import time
import xmlrpc.client

CALLER = '/attacker'
LOG = {'topic': '/rosout', 'type': 'rosgraph_msgs/Log', 'md5sum': 'acffd30cd6b6de30f120938c17c593fb'}
TIMEOUT = 15.0  # [s] for an answer that takes milliseconds


class Timeout(xmlrpc.client.Transport):
    """HTTP with a time limit."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT
        return connection


def api(uri):
    """The XML-RPC interface at a URI."""
    return xmlrpc.client.ServerProxy(uri, transport=Timeout())


def block(data):
    """Bytes with their length in front."""
    return struct.pack('<I', len(data)) + data


def header(**fields):
    """The bytes of a TCPROS header."""
    return block(b''.join(block(f'{key}={value}'.encode()) for key, value in fields.items()))


def receive(connection, size):
    """Exactly so many bytes; EOFError when the connection ends before."""
    data = b''
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise EOFError(f'closed after {len(data)} of {size} bytes')
        data += more
    return data


def receive_header(connection):
    """{field: text} of the header that comes."""
    data = receive(connection, struct.unpack('<I', receive(connection, 4))[0])
    fields, start = {}, 0
    while start < len(data):
        size, = struct.unpack_from('<I', data, start)
        key, _, value = data[start + 4:start + 4 + size].decode().partition('=')
        fields[key] = value
        start += 4 + size
    return fields


def is_closed(connection):
    """Whether the other side has closed a connection; what it has sent before is dropped."""
    connection.setblocking(False)
    try:
        while connection.recv(1 << 16):
            pass
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True


class Peer:
    """A node, named by its URI; every node has the topic /rosout and the services ~get_loggers, ~set_logger_level."""

    def __init__(self, name, uri):
        self.name, self.uri = name, uri
        self.slave = api(uri)
        self.pid = self.slave.getPid(CALLER)[2]
        self.address = self.slave_address = None
        host, _, port = uri.rstrip('/').rpartition('/')[2].partition(':')
        self.slave_address = host, int(port)
        self.address = self.tcpros()

    def tcpros(self):
        """The address of its TCPROS server, by a request for a topic."""
        code, text, protocol = api(self.uri).requestTopic(CALLER, '/rosout', [['TCPROS']])
        assert code == 1, text
        return tuple(protocol[1:])

    def connect(self, data=b''):
        """A connection on which ``data`` has been sent."""
        connection = socket.create_connection(self.address, timeout=TIMEOUT)
        connection.sendall(data)
        return connection

    def subscribe(self, **changed):
        """Subscribe to /rosout; (header of the answer, connection)."""
        connection = self.connect(header(**{'callerid': CALLER, **LOG, **changed}))
        return receive_header(connection), connection

    def open_service(self, service='get_loggers', **changed):
        """(header of the answer, connection) to a service of the node."""
        connection = self.connect(header(**{'callerid': CALLER, 'service': f'{self.name}/{service}', 'md5sum': '*',
                                            **changed}))
        return receive_header(connection), connection

    def call(self, request=b'', service='get_loggers', **changed):
        """Call a service; (whether it went well, answer)."""
        answer, connection = self.open_service(service, **changed)
        with connection:
            assert 'error' not in answer, answer
            connection.sendall(block(request))
            return receive_answer(connection)

    def answers(self):
        """Subscribe as a new subscriber does and call a service; how long [s] each took."""
        begin = time.monotonic()
        self.tcpros()
        answer, connection = self.subscribe()
        connection.close()
        assert answer.get('md5sum') == LOG['md5sum'], answer
        middle = time.monotonic()
        done, _ = self.call()
        assert done
        return middle - begin, time.monotonic() - middle

    def threads(self):
        """How many threads its process has."""
        with open(f'/proc/{self.pid}/status', encoding='ascii') as status:
            return next(int(line.split()[1]) for line in status if line.startswith('Threads:'))

    def descriptors(self):
        """How many file descriptors its process has open."""
        return len(os.listdir(f'/proc/{self.pid}/fd'))

    def processor_time(self):
        """How long [s] its process has run."""
        with open(f'/proc/{self.pid}/stat', encoding='ascii') as stat:
            return sum(map(int, stat.read().rpartition(')')[2].split()[11:13])) / 100.0


def receive_answer(connection):
    """(whether a call went well, the answer's bytes)."""
    done = receive(connection, 1) == b'\1'
    return done, receive(connection, struct.unpack('<I', receive(connection, 4))[0])
