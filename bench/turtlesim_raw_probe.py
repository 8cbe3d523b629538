"""Client of a turtlesim_node with connections of its own, where rospy's threads would be slower than what is measured.

`turtlesim_raw_probe.py calls | many | listen_many | reset`; every answer is one line of JSON.
"""

import io
import itertools
import random
import select
import socket
import struct
import sys
import time
import xmlrpc.client

import rosgraph
import rospy
from std_srvs.srv import Empty
from turtlesim.msg import Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from figures import intervals, stratified_phases
from turtlesim_probe import COME_UP, POSE, TICK, Receiver, Silent, clock, main, say

CALLERS = 4  # that call at once
SAME_FRAME = 0.5 * TICK  # [s] between two answers of one frame, at most
CALLS = {'clear': (Empty, lambda name: ()), 'reset': (Empty, lambda name: ()),
              'spawn': (Spawn, lambda name: (2.0, 2.0, 0.0, name)), 'kill': (Kill, lambda name: (name,)),
              'set_pen': (SetPen, lambda name: (1, 2, 3, 2, 0)),
              'teleport_absolute': (TeleportAbsolute, lambda name: (5.0, 5.0, 0.0)),
              'teleport_relative': (TeleportRelative, lambda name: (0.0, 0.1))}
OF_TURTLE = {'set_pen', 'teleport_absolute', 'teleport_relative'}


class Caller:
    """A persistent connection to a service, without the waiting of rospy's ServiceProxy."""

    def __init__(self, service):
        kind, self._values = CALLS[service]
        self._request = kind._request_class
        name = f'turtle1/{service}' if service in OF_TURTLE else service
        rospy.wait_for_service(name, COME_UP)
        uri = rosgraph.Master(rospy.get_name()).lookupService(rospy.resolve_name(name))
        host, port = uri[len('rosrpc://'):].split(':')
        self.socket = connect(host, int(port), service=rospy.resolve_name(name), md5sum=kind._md5sum, persistent='1')

    def send(self, name):
        """Send a request; ``name`` is that of the turtle to spawn or kill."""
        buffer = io.BytesIO()
        self._request(*self._values(name)).serialize(buffer)
        data = buffer.getvalue()
        self.socket.sendall(struct.pack('<I', len(data)) + data)

    def receive(self):
        """Read the answer."""
        well, length = struct.unpack('<BI', receive(self.socket, 5))
        text = receive(self.socket, length)
        if not well:
            raise Silent(f'a call failed: {text.decode()}')

    def call(self, name):
        """Return the time [s] of a call."""
        begun = clock()
        self.send(name)
        self.receive()
        return clock() - begun


def connect(host, port, **fields):
    """Return a TCPROS connection whose headers have been exchanged."""
    connection = socket.create_connection((host, port), COME_UP)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    fields.update(callerid=rospy.get_name(), tcp_nodelay='1')
    pairs = [f'{key}={value}'.encode() for key, value in fields.items()]
    header = b''.join(struct.pack('<I', len(pair)) + pair for pair in pairs)
    connection.sendall(struct.pack('<I', len(header)) + header)
    receive(connection, struct.unpack('<I', receive(connection, 4))[0])
    return connection


def receive(connection, size):
    """Return this many bytes of a connection."""
    data = b''
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise Silent('the node closed a connection')
        data += more
    return data


def together(callers, names):
    """(time [s] until all callers, who call at once, are answered; in how many frames)."""
    begun = clock()
    for caller, name in zip(callers, names):
        caller.send(name)
    stamps, waiting = [], {caller.socket: caller for caller in callers}
    while waiting:
        for each in select.select(list(waiting), [], [], COME_UP)[0]:
            waiting.pop(each).receive()
            stamps.append(clock())
    return stamps[-1] - begun, 1 + sum(pause > SAME_FRAME for pause in intervals(stamps))


def calls(options):
    """Times [s] of a service's calls: back to back, single ones at phases spread evenly, and of several at once.

    Turtles that a kill needs are spawned, those of a spawn are killed, outside the times.
    """
    service, count = options.service, options.count
    callers = [Caller(service) for _ in range(CALLERS)]
    helper = Caller({'spawn': 'kill', 'kill': 'spawn'}[service]) if service in ('spawn', 'kill') else None
    fresh = (f'bench{number}' for number in itertools.count())

    def names(number):
        made = [next(fresh) for _ in range(number)]
        if service == 'kill':
            for name in made:
                helper.call(name)
        return made

    def tidy(made):
        if service == 'spawn':
            for name in made:
                helper.call(name)
    made = names(count + 1)
    back = [callers[0].call(name) for name in made][1:]
    tidy(made)
    single, at_once = [], []
    for phase in stratified_phases(count, random.Random(options.seed)):
        made = names(1)
        time.sleep(TICK * (1.0 + phase))
        single.append(callers[0].call(made[0]))
        tidy(made)
    for phase in stratified_phases(count // 2, random.Random(options.seed)):
        made = names(CALLERS)
        time.sleep(TICK * (1.0 + phase))
        at_once.append(together(callers, made))
        tidy(made)
    say(back=back, single=single, together=[seconds for seconds, _ in at_once], frames=[each for _, each in at_once])


def many(options):
    """Tell when ready, then spawn turtles up to options.turtles: times [s] and turtle1's longest pose gap [s]."""
    receiver = Receiver(['turtle1'])
    receiver.await_all()
    caller = Caller('spawn')
    say(ready=True)
    receiver.clear()
    times = [caller.call(f'turtle{number}') for number in range(2, options.turtles + 1)]
    say(times=times, gap=max(intervals(receiver.stamps['turtle1'])))


def reset(options):
    """Time [s] of a reset and turtle1's longest pose gap [s] meanwhile and a little later."""
    receiver = Receiver(['turtle1'])
    receiver.await_all()
    caller = Caller('reset')
    receiver.clear()
    seconds = caller.call('')
    time.sleep(options.settle)
    say(seconds=seconds, gap=max(intervals(receiver.stamps['turtle1'])))


def listen_many(options):
    """Like listen, but count the bytes without decoding them: a thousand poses would take the node's core."""
    node = xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode('/turtlesim'))
    sockets = []
    for number in range(1, options.turtles + 1):
        topic = f'/turtle{number}/pose'
        _, _, (_, host, port) = node.requestTopic(rospy.get_name(), topic, [['TCPROS']])
        sockets.append(connect(host, port, topic=topic, type=Pose._type, md5sum=Pose._md5sum))
    for each in sockets:
        receive(each, 4 + POSE.size)
        each.setblocking(False)
    time.sleep(options.settle)
    say(ready=True)
    drain(sockets)
    begun, counts = clock(), [0] * len(sockets)
    while clock() - begun < options.seconds:
        time.sleep(10 * TICK)
        counts = [count + more for count, more in zip(counts, drain(sockets))]
    elapsed = clock() - begun
    say(rates=[count / (4 + POSE.size) / elapsed for count in counts])
    time.sleep(options.settle)  # stay subscribed while the bench takes its last reading


def drain(sockets):
    """Read all bytes that wait in the sockets; return how many each had."""
    counts = []
    for each in sockets:
        try:
            counts.append(len(each.recv(65536)))
        except BlockingIOError:
            counts.append(0)
    return counts


TASKS = {task.__name__: task for task in (calls, many, listen_many, reset)}

if __name__ == '__main__':
    sys.exit(main(TASKS, CALLS))
