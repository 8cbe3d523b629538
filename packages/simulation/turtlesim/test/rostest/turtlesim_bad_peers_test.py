#!/usr/bin/env python3
"""Other programs that misbehave on their connections: the simulator keeps its rate for the others."""
import io
import socket
import struct
import time

import rosgraph.network
import rosservice
from sensor_msgs.msg import Image

from rostest_support.common import (
    DEADLINE,
    MIDDLE,
    Collected,
    Process,
    SimulatorCase,
    node_api,
    registered_names,
    run,
    until,
)

POSE = {'topic': '/turtle1/pose', 'type': 'turtlesim/Pose', 'md5sum': '863b248d5016ca62ea2e895ae5265cf9'}
IMAGE = {'topic': '/turtlesim/image_raw', 'type': 'sensor_msgs/Image', 'md5sum': '060021388200f6f0f447d0fcd9c64743'}
SMALL_SEGMENT = 88  # [bytes] the kernel's smallest: with it the simulator's side buffers 16 kB instead of megabytes
FULL_FOR = 1.0  # [s] without growth after which a connection's buffer is full
FULL_DEADLINE = 60.0  # [s] 16 kB of poses are written in 11 s
SECONDS = 3.0  # [s] of poses that are measured
RATE, LOWEST_RATE = 62.5, 45.0  # [Hz] on a machine that is idle, or busy


class BadPeersTest(SimulatorCase):

    def connect(self, host, port, small=False):
        peer = socket.socket()
        self.addCleanup(peer.close)
        if small:
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, SMALL_SEGMENT)
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        peer.settimeout(DEADLINE)
        peer.connect((host, port))
        return peer

    def deaf_subscriber(self, header):
        """Subscribe and never read; return when the simulator can write nothing more to the connection."""
        _, _, (_, host, port) = node_api('/turtlesim').requestTopic('/peer', header['topic'], [['TCPROS']])
        peer = self.connect(host, port, small=header is POSE)
        rosgraph.network.write_ros_handshake_header(peer, dict(header, callerid='/deaf', tcp_nodelay='1'))
        state = {'size': 0, 'since': time.monotonic()}

        def full():
            size = unread(peer)
            if size != state['size']:
                state.update(size=size, since=time.monotonic())
            return size and time.monotonic() - state['since'] > FULL_FOR
        until(full, lambda: f'a full buffer; it holds {unread(peer)} bytes', FULL_DEADLINE)

    def assert_rate(self, poses):
        """Assert that poses come, and often enough."""
        self.assertGreater(poses.rate(round(SECONDS * RATE), span=round(RATE / 2.0)), LOWEST_RATE)

    def test_turtlesim_deaf_pose_subscriber(self):
        """A subscriber of poses that stops reading."""
        poses = self.poses()
        self.deaf_subscriber(POSE)
        self.assert_rate(poses)
        self.driver()(x=1.0)
        poses.next(lambda pose: pose.x > MIDDLE, 'a turtle that moves')

    def test_turtlesim_deaf_image_subscriber(self):
        """A subscriber to pictures stops reading; another one still gets them."""
        poses, images = self.poses(), Collected('/turtlesim/image_raw', Image)
        self.deaf_subscriber(IMAGE)
        self.assert_rate(poses)
        images.more(10)
        self.snapshot()

    def test_turtlesim_wrong_type(self):
        """A publisher of another type on the turtle's topic: refused, the right one is served."""
        command = 'rostopic pub -r 50 /turtle1/cmd_vel std_msgs/String forward __name:=wrong'
        with Process(*command.split()) as publisher:
            until(lambda: '/turtle1/cmd_vel' in registered_names('/wrong')[0], 'a publisher of another type')
            poses = self.poses()
            self.driver()(x=1.0)
            poses.next(lambda pose: pose.x > MIDDLE, 'a turtle that moves')
            self.assertTrue(publisher.runs())

    def test_turtlesim_garbage(self):
        """Requests of a service that are nonsense, or break off in the middle."""
        before = self.state()
        _, address = rosservice.get_service_uri('/spawn').split('//')
        host, port = address.split(':')
        spawn = {'service': '/spawn', 'md5sum': '0b2d2e872a8e2887d5ed626f2bf2c561', 'callerid': '/peer'}
        for request in (b'', struct.pack('<I', 0), struct.pack('<I', 3) + b'abc', struct.pack('<I', 100) + b'short',
                        struct.pack('<I', 0xffffffff), struct.pack('<IfffI', 18, 1.0, 1.0, 0.0, 2) + b'\xff\xfe'):
            peer = self.connect(host, int(port))
            rosgraph.network.write_ros_handshake_header(peer, spawn)
            rosgraph.network.read_ros_handshake_header(peer, io.BytesIO(), 4096)
            peer.sendall(request)
            peer.shutdown(socket.SHUT_WR)
        self.assertEqual(b'\0', peer.recv(1), 'the last request has a name that is not UTF-8')
        self.assert_unchanged(before)
        self.assertEqual('turtle2', self.call('spawn', 1.0, 1.0, 0.0, '').name)


def unread(peer):
    """Return how many bytes wait in the buffer of the other side of a connection on this machine."""
    other = peer.getpeername()[1], peer.getsockname()[1]
    with open('/proc/net/tcp') as table:
        for line in table.readlines()[1:]:
            _, local, remote, _, queues, *_ = line.split()
            if other == (int(local.rsplit(':', 1)[1], 16), int(remote.rsplit(':', 1)[1], 16)):
                return int(queues.split(':')[0], 16)
    return 0


if __name__ == '__main__':
    run(BadPeersTest)
