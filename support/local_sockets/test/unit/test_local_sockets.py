"""local_sockets.c, as ./run preloads it: who gets loopback for 'all addresses', and who what he asked for."""
import json
import os
import subprocess
import sys

import pytest

LIBRARY = next((path for path in os.environ.get('LD_PRELOAD', '').split(':')
                if path.endswith('/libturtle_robotont_local_sockets.so')), None)
PROGRAM = '''
import json, socket, sys
V6, DUAL = socket.IPV6_V6ONLY, (socket.IPPROTO_IPV6, socket.IPV6_V6ONLY)
found = {}
for name, family, kind, address, only_six in (
        ("tcp", socket.AF_INET, socket.SOCK_STREAM, "", 0), ("udp", socket.AF_INET, socket.SOCK_DGRAM, "", 0),
        ("dual", socket.AF_INET6, socket.SOCK_STREAM, "::", 0), ("six", socket.AF_INET6, socket.SOCK_STREAM, "::", 1),
        ("own", socket.AF_INET, socket.SOCK_STREAM, "127.0.0.2", 0),
        ("unbound", socket.AF_INET, socket.SOCK_STREAM, None, 0)):
    opened = socket.socket(family, kind)
    if family == socket.AF_INET6:
        opened.setsockopt(*DUAL, only_six)
    if address is not None:
        opened.bind((address, 0))
    if kind == socket.SOCK_STREAM:
        opened.listen()
    found[name], port = opened.getsockname()[:2]
    assert port > 0
    if name == "dual":
        for host in ("127.0.0.1", "localhost"):
            socket.create_connection((host, port), 10.0).close()
print(json.dumps(found))
'''
EVERYWHERE = {'tcp': '0.0.0.0', 'udp': '0.0.0.0', 'dual': '::', 'six': '::', 'own': '127.0.0.2', 'unbound': '0.0.0.0'}
HERE = {'tcp': '127.0.0.1', 'udp': '127.0.0.1', 'dual': '::ffff:127.0.0.1', 'six': '::1', 'own': '127.0.0.2',
        'unbound': '127.0.0.1'}


def run(program, **variables):
    """Return what a Python program prints and complains of, with the library and only these variables of ROS."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(('ROS_', 'TURTLE_'))}
    done = subprocess.run([sys.executable, '-c', program], env={**environment, 'LD_PRELOAD': LIBRARY, **variables},
                          capture_output=True, text=True, timeout=60, check=True)
    return done.stdout, done.stderr


def test_run_preloads_the_library():
    assert LIBRARY and os.path.isfile(LIBRARY), 'start the tests with ./run test'


@pytest.mark.parametrize('variables, expected', [
    ({'ROS_HOSTNAME': 'localhost', 'TURTLE_ROBOTONT_LOCAL': 'all'}, HERE),
    ({'ROS_HOSTNAME': '127.0.1.1', 'TURTLE_ROBOTONT_LOCAL': 'all'}, HERE),
    ({'ROS_IP': '127.0.0.1', 'TURTLE_ROBOTONT_LOCAL': 'all'}, HERE),
    ({'ROS_HOSTNAME': 'localhost', 'TURTLE_ROBOTONT_LOCAL': 'ros'}, EVERYWHERE),  # Python is none of ROS's libraries
    ({'ROS_HOSTNAME': 'localhost'}, EVERYWHERE),
    ({'ROS_HOSTNAME': 'robot', 'ROS_IP': '127.0.0.1', 'TURTLE_ROBOTONT_LOCAL': 'all'}, EVERYWHERE),
    ({'ROS_IP': '10.77.0.1', 'TURTLE_ROBOTONT_LOCAL': 'all'}, EVERYWHERE),
    ({'TURTLE_ROBOTONT_LOCAL': 'all'}, EVERYWHERE),
])
def test_addresses(variables, expected):
    if not os.path.exists('/proc/net/if_inet6'):
        pytest.skip('no IPv6 here: NOT tested')
    said, complaints = run(PROGRAM, **variables)
    assert (json.loads(said), complaints) == (expected, '')


@pytest.mark.parametrize('whose', ['all', 'ros'])
def test_a_c_node_of_ros(tmp_path, whose):
    """rosout, with or without a master: its XML-RPC server is there before it looks for one."""
    node = subprocess.run(['catkin_find', '--first-only', 'rosout', 'rosout'], capture_output=True, text=True,
                          check=False).stdout.strip() or '/usr/lib/rosout/rosout'
    if not os.path.exists(node):
        pytest.skip(f'{node} is missing: NOT tested')
    bound = _addresses_of(node, tmp_path, whose, 'localhost')
    assert bound and bound <= {'0100007F'}
    assert '00000000' in _addresses_of(node, tmp_path, whose, 'anywhere.invalid')


def _addresses_of(node, folder, whose, name):
    """Return the local addresses, as /proc/net/tcp has them, on which a node listens once it does."""
    environment = dict(os.environ, LD_PRELOAD=LIBRARY, TURTLE_ROBOTONT_LOCAL=whose, ROS_HOSTNAME=name,
                       ROS_MASTER_URI='http://localhost:9', ROS_LOG_DIR=str(folder))
    process = subprocess.Popen([node], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        for line in process.stdout:
            if 'master' in line.lower():  # it waits for one, and listens by now
                break
        inodes = {os.readlink(f'/proc/{process.pid}/fd/{fd}') for fd in os.listdir(f'/proc/{process.pid}/fd')}
        with open('/proc/net/tcp', encoding='ascii') as file:
            rows = [line.split() for line in file][1:]
        return {row[1].split(':')[0] for row in rows if row[3] == '0A' and f'socket:[{row[9]}]' in inodes}
    finally:
        process.kill()
        process.communicate()
