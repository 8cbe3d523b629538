"""./run doctor: each fault is set up for real, in namespaces of its own, and named; a healthy machine gives no finding.

Everything runs among processes, ports and (where a test needs them) mounts that only it sees. What only root may set up
is left out for others.
"""
import json
import os
import re
import shlex
import subprocess
import tempfile
import time
from typing import NamedTuple

import pytest

from kinematic_core.worlds.turtle_world import BACKGROUND
from plain_support.doctor import cli, findings, system_checks
from plain_support.doctor.cli import CHECKS
from plain_support.doctor.machine import Machine
from unit_support import REPOSITORY
from unit_support.cases import nightly

pytestmark = pytest.mark.slow
IS_ROOT = os.geteuid() == 0
NAMESPACES = ['unshare', '-pfnm' if IS_ROOT else '-rpfnm', '--mount-proc', '--kill-child']
PORT = 12399
STRANGER = 61001  # a user who exists nowhere
DEADLINE = 200.0  # [s] for what takes one or two
HARNESS = r'''
set -e
ip link set lo up
listens() { for try in $(seq 400); do (: <"/dev/tcp/127.0.0.1/$1") 2>/dev/null && return; sleep 0.02; done; exit 90; }
as_stranger() { setpriv --reuid STRANGER --regid STRANGER --clear-groups "$@"; }
be_stranger() {  # who cannot look into a home folder in which the repository may lie
  user=(as_stranger)
  mkdir "$folder/repository"; mount --bind "$repo" "$folder/repository"; repo=$folder/repository
}
master() {
  "$@" env HOME="$folder" ROS_HOME="$folder/ros" rosmaster --core -p PORT >/dev/null 2>&1 &
  listens PORT
}
package() {  # a workspace of a student with the program $1 in a package; its text comes from standard input
  local package=$folder/ros_ws/src/topic_demo
  program=$package/scripts/$1
  mkdir -p "$package/scripts"; echo "<name>topic_demo</name>" >"$package/package.xml"
  cat >"$program"; chmod +x "$program"
  changed+=(ROS_PACKAGE_PATH="$folder/ros_ws/src:$repo")
}
node() {  # a node with the name $1, the port $2, and the topics $3 = [[TOPIC, TYPE], ...]; $4 is publish or subscribe
  /usr/bin/python3 -c "import sys, xmlrpc.client, xmlrpc.server
name, port, topics, does = sys.argv[1], int(sys.argv[2]), eval(sys.argv[3]), sys.argv[4]
server = xmlrpc.server.SimpleXMLRPCServer(('localhost', port), logRequests=False)
server.register_function(lambda caller: (1, '', topics * (does == 'publish')), 'getPublications')
server.register_function(lambda caller: (1, '', topics * (does == 'subscribe')), 'getSubscriptions')
master = xmlrpc.client.ServerProxy('http://localhost:PORT')
register = master.registerPublisher if does == 'publish' else master.registerSubscriber
for topic, kind in topics: register(name, topic, kind, 'http://localhost:%d/' % port)
server.serve_forever()" "$@" &
  until tell "assert '$1' in str(master.getSystemState('/x'))" 2>/dev/null; do sleep 0.02; done
}
tell() { /usr/bin/python3 -c "import sys, xmlrpc.client; master = xmlrpc.client.ServerProxy('http://localhost:PORT')
$1"; }
doctor() {
  "${user[@]}" "${changed[@]}" /usr/bin/python3 -I -c 'import sys
sys.path.insert(0, sys.argv.pop(1))
from plain_support.doctor import cli
sys.exit(cli.main())' "$repo/packages/support/plain_support/src" --repository "$repo" \
    --workspace "$workspace" "$@"
}
user=() changed=(env) code=0
'''.replace('STRANGER', str(STRANGER)).replace('PORT', str(PORT))
SERVER = f'''"import socket
server = socket.socket()
server.bind(('%s', {PORT})); server.listen()
while True: server.accept()" &
listens {PORT}'''


START = 'import rospy\nrospy.init_node("a")\n'
PROGRAM = f'#!/usr/bin/env python3\n{START}'


def package(text=PROGRAM, name='publisher.py', after=''):
    """Return commands that make a student's package with one program; ``after`` changes $program."""
    return f"package {name} < <(printf %b {shlex.quote(text)})\n{after}"


def nodes(*rows):
    """Return commands that start a master and a node for each row: name, topic, type, publish or subscribe."""
    return '\n'.join(['master', *(f'node {name} {PORT + number} "[[\'{topic}\', \'{kind}\']]" {does}'
                                  for number, (name, topic, kind, does) in enumerate(rows, 1))])


TWIST, POSE = 'geometry_msgs/Twist', 'turtlesim/Pose'
TURTLE = ('/turtlesim', '/turtle1/cmd_vel', TWIST, 'subscribe')
SIMULATOR = ('/turtlesim', '/turtle1/pose', POSE, 'publish')


class Fault(NamedTuple):
    """A fault: the name of its finding, whether something fails by it, commands that set it up, words of its text."""

    name: str
    fails: bool
    setup: str
    words: tuple
    root: bool = False
    arguments: tuple = ()


FAULTS = [
    Fault('outside_shell', False, 'changed+=(ROS_PACKAGE_PATH=)', ("[rospack] Error: package 'turtlesim' not found",
                                                                  '/run shell')),
    Fault('shell_overridden', True, 'changed+=(ROS_PACKAGE_PATH=/usr/share VIRTUAL_ENV=$workspace/venv)',
          ('/ws/env.bash', 'catkin_make')),
    Fault('workspace_not_sourced', False,
          'mkdir -p ros_ws/{src/a,devel}; touch ros_ws/devel/setup.bash; cd ros_ws/src/a',
          ('/ros_ws;', 'source /', '/ros_ws/devel/setup.bash')),
    Fault('no_roscore', False, '', (f'http://localhost:{PORT}', 'type roscore')),
    Fault('no_roscore', False, f'master; changed+=(ROS_MASTER_URI=http://localhost:{PORT + 9}); : ROS_HOSTNAME',
          (f'http://localhost:{PORT + 9}', f'export ROS_MASTER_URI=http://localhost:{PORT} ', 'rosmaster (process ')),
    Fault('not_executable', False, package(after='chmod -x "$program"'),
          ('/scripts/publisher.py is not executable', 'chmod +x /')),
    Fault('windows_line_ends', True, package(PROGRAM.replace('\n', '\r\n')),
          ('/scripts/publisher.py end with CR LF', "sed -i 's/\\r$//' /")),
    Fault('byte_order_mark', True, package(f'\\xef\\xbb\\xbf{PROGRAM}'),
          ('byte order mark', r"sed -i '1s/^\xEF\xBB\xBF//'")),
    Fault('no_shebang', True, package(START), ('bash instead of Python', "sed -i '1i #!/usr/bin/env python3' /")),
    Fault('wrong_shebang', True, package(PROGRAM.replace('python3', 'python2.9')),
          ('there is no python2.9 here', "sed -i '1s|.*|#!/usr/bin/env python3|' /")),
    Fault('wrong_extension', False, package(name='publisher.py.txt'), ('publisher.py.txt', 'type mv /')),
    Fault('outside_package', False, package(after='cp "$program" $folder/ros_ws/src/loose.py'),
          ('/src/loose.py is not in a package', 'catkin_create_pkg')),
    Fault('misnamed', False, nodes(TURTLE, ('/publisher', '/turtle/cmd_vel', TWIST, 'publish')),
          ('/publisher publishes /turtle/cmd_vel, which nobody reads: did you mean /turtle1/cmd_vel? Correct',
           '/turtle/cmd_vel:=/turtle1/cmd_vel')),
    Fault('misnamed', False, nodes(SIMULATOR, ('/reader', '/turtle1/Pose', POSE, 'subscribe')),
          ('/reader subscribes to /turtle1/Pose, which nobody publishes: did you mean /turtle1/pose?',)),
    Fault('nobody_publishes', False, nodes(('/reader', '/turtle1/pose', POSE, 'subscribe')),
          ('/reader subscribes to /turtle1/pose, which nobody publishes; start the node',)),
    Fault('two_types', True, nodes(SIMULATOR, ('/student', '/turtle1/pose', TWIST, 'publish')),
          ('/turtle1/pose', f'/student has {TWIST}, /turtlesim has {POSE}', 'rospy.Subscriber')),
    Fault('packages_unavailable', True, '', ('no-such-package-of-debian', 'apt-get update'),
          arguments=('--missing', 'no-such-package-of-debian')),
    Fault('packages_forbidden', True, 'changed+=(PATH=/nowhere); be_stranger', ('no sudo', 'install', 'cmake'),
          True, ('--missing', 'cmake')),
    Fault('disk_full', True, 'mkdir $folder/small; mount -t tmpfs -o size=1m none $folder/small\n'
          'workspace=$folder/small/ws', ('1 MB left of the 1100 MB', 'df -h')),
    Fault('addresses_limited', True, 'ulimit -v 1500000',
          ('1536 MB of addresses', 'need 2000 MB', 'ulimit -v unlimited')),
    Fault('loopback_down', True, 'ip link set lo down',
          ('can reach 127.0.0.1 (', 'sudo ip link set lo up')),
    Fault('no_network', True, '',
          ('1 Debian packages are missing', 'no network', 'cable'), arguments=('--missing', 'cmake')),
    Fault('workspace_impossible', True, 'mkdir $folder/locked; chmod 755 $folder{,/locked}\n'
          'workspace=$folder/locked/cache/ws; be_stranger', ('/locked/cache/ws: ', 'cannot write to', 'type '
                                                             'TURTLE_ROBOTONT_WS='), True),
    Fault('folder_not_writable', True, 'mkdir -p $folder/home/.ros; chmod 755 $folder/home{,/.ros}\n'
          'changed+=(HOME=$folder/home); be_stranger', ('.ros, which belongs to root', 'sudo chown -R'), True),
    Fault('python_shadowed', False, 'mkdir -p $folder/miniconda3/bin; ln -s /bin/false $folder/miniconda3/bin/python3\n'
          'changed+=(PATH=$folder/miniconda3/bin:/usr/bin:/bin)', ('(conda)', 'conda deactivate', './run shell')),
    Fault('python_shadowed', True, 'mkdir -p $folder/.pyenv/shims; ln -s /bin/false $folder/.pyenv/shims/python3\n'
          'changed+=(PATH=$folder/.pyenv/shims:/usr/bin:/bin VIRTUAL_ENV=$workspace/venv)',
          ('(pyenv)', 'pyenv shell system', 'open ./run shell again')),
    Fault('foreign_variable', False, 'changed+=(PYTHONPATH=/usr/lib:/opt/ros/foxy/lib/python3.8/site-packages)',
          ('PYTHONPATH is /opt/ros/foxy/lib/python3.8/site-packages,', 'unset PYTHONPATH')),
    Fault('foreign_variable', True, 'changed+=(PYTHONHOME=/opt/python VIRTUAL_ENV=$workspace/venv)\n'
          'mkdir -p $workspace/venv/bin; ln -s /usr/bin/python3 $workspace/venv/bin\n'
          'changed+=(PATH=$workspace/venv/bin:/usr/bin)', ('PYTHONHOME is /opt/python', 'unset PYTHONHOME')),
    Fault('opencv_unusable', True, '/usr/bin/python3 -m venv --without-pip $workspace/venv; touch $workspace/.built',
          ("No module named 'cv2'", './run clean')),
    Fault('opencv_unusable', True, 'mkdir -p $workspace/venv/bin\n'
          'ln -s /usr/bin/python3.5 $workspace/venv/bin/python3; touch $workspace/.built',
          ('cannot be started', './run build')),
    Fault('time_set_back', False, 'mkdir -p $workspace; touch -d "+3 hours" $workspace/.checkout',
          ('.checkout was written 3.0 hours from now', 'timedatectl')),
    Fault('no_isolation', False, 'forbid="echo 0 >/proc/sys/user/max_net_namespaces"\n'
          'user=(unshare -Ur sh -c "$forbid; exec \\"\\$@\\"" sh)',
          ('cannot be isolated', 'bubblewrap')),
    Fault('name_without_address', True, 'changed+=(ROS_HOSTNAME=robot.invalid)',
          ("ROS_HOSTNAME is 'robot.invalid'", 'unset ROS_HOSTNAME; export ROS_IP=127.0.0.1')),
    Fault('address_not_here', True, 'changed+=(ROS_IP=10.88.0.9)', ('ROS_IP is 10.88.0.9', 'export ROS_IP=')),
    Fault('address_only_here', True, 'changed+=(ROS_HOSTNAME=localhost ROS_MASTER_URI=http://10.88.0.9:11311)',
          ('another machine (10.88.0.9)', 'unset ROS_HOSTNAME')),
    Fault('master_unreachable', True, 'changed+=(ROS_MASTER_URI=http://10.88.0.9:11311)',
          ('10.88.0.9', 'start roscore')),
    Fault('bad_master_uri', True, 'changed+=(ROS_MASTER_URI=localhost:11311)',
          ("'localhost:11311'", 'http://HOST:PORT')),
    Fault('port_taken', True, f'/usr/bin/python3 -c {SERVER % "127.0.0.1"}',
          (str(PORT), 'python3 (process ', str(PORT + 1))),
    Fault('port_taken', True,
          f'/usr/bin/python3 -m http.server {PORT} --bind 127.0.0.1 >/dev/null 2>&1 &\nlistens {PORT}',
          (str(PORT), 'python3 (process ')),
    Fault('master_hangs', True, 'master; kill -STOP $!', ('rosmaster (process ', 'type fg')),
    Fault('foreign_master', True, 'master as_stranger', (f'the user {STRANGER}', './run shell'), True),
    Fault('stale_registration', False, 'master; tell "master.registerPublisher(\'/gone\', \'/pose\', \'a/B\', '
          '\'http://localhost:1/\')"', ('/gone is registered at http://localhost:1/', 'rosnode cleanup')),
    Fault('stale_registration', False, f'master; tell "master.registerService(\'/gone\', \'/gone/get_loggers\', '
          f'\'rosrpc://localhost:{PORT}\', \'http://localhost:{PORT}/\')"', ('/gone is registered', 'rosnode cleanup')),
    Fault('stale_parameters', False, 'master; tell "master.setParam(\'/x\', \'/drive_shape/shape\', \'corners\')"',
          ('/drive_shape has parameters from an earlier run: shape=corners', 'rosparam delete /drive_shape')),
    Fault('no_clock', True, 'master; tell "master.setParam(\'/x\', \'/use_sim_time\', True)"',
          ('no node publishes /clock', 'rosparam delete /use_sim_time')),
    Fault('two_clocks', True, f'master; tell "for name in (\'/a\', \'/b\'): master.registerPublisher(name, \'/clock\', '
          f'\'rosgraph_msgs/Clock\', \'http://localhost:{PORT}/\')"', ('/a and /b publish /clock', '_clock:=false')),
    Fault('exposed', False, f'ROS_MASTER_URI=http://localhost:1 /usr/bin/python3 -c {SERVER % "0.0.0.0"}\n'
          'changed+=(ROS_MASTER_URI=http://localhost:1)', (f'0.0.0.0, port {PORT}', 'ROS_HOSTNAME=localhost')),
    Fault('left_over', False, 'export ROS_MASTER_URI=http://localhost:1\n'
          '(setsid sh -c "while :; do sleep 1; done" sh __name:=a &)\n'
          'until pgrep -f __name:=a >/dev/null; do sleep 0.02; done', ('__name:=a', 'kill ')),
    Fault('dead_display', False, 'changed+=(DISPLAY=:59876)', ('DISPLAY=:59876', '/turtlesim/snapshot')),
    Fault('package_to_install', True, 'mkdir other; echo \'<node pkg="rviz" type="rviz"/>\' >other/a.launch',
          ('rviz is missing, which a.launch needs', 'apt-get install', ' rviz'), arguments=('other',)),
    Fault('package_not_to_be_had', True, 'mkdir other; echo \'<node pkg="slam_toolbox" type="x"/>\' >other/a.launch',
          ('slam_toolbox is missing, which a.launch needs', 'gmapping'), arguments=('other',)),
    Fault('python2_program', True, 'mkdir other; echo "print 1" >other/a.py',
          ("/other/a.py is written for Python 2: line 1: 'print 1' is no Python 3", '2to3 -w /'), arguments=('other',)),
    Fault('camera_unusable', False, 'mount -t tmpfs none /dev; mknod -m 666 /dev/null c 1 3\n'
          'mknod -m 600 /dev/video0 c 81 0; be_stranger', ('/dev/video0', 'usermod -aG'), True),
]


def examine(folder, setup='', arguments=()):
    """Return (exit code, findings) of the doctor in namespaces where ``setup`` was done."""
    script = f'{HARNESS}{setup}\ndoctor --json "$@" || code=$?\nexit $code'
    environment = {'PATH': '/usr/bin:/bin:/usr/sbin:/sbin', 'HOME': folder, 'LANG': 'C.UTF-8',
                   'ROS_PACKAGE_PATH': str(REPOSITORY),
                   'repo': str(REPOSITORY), 'folder': folder, 'workspace': f'{folder}/ws', 'ROS_HOSTNAME': 'localhost',
                   'ROS_MASTER_URI': f'http://localhost:{PORT}'}
    for name in ('ROS_HOSTNAME', 'ROS_MASTER_URI'):
        if name in setup or 'ROS_IP' in setup:
            del environment[name]
    done = subprocess.run([*NAMESPACES, 'bash', '-c', script, 'bash', *arguments], capture_output=True, text=True,
                          env=environment, timeout=DEADLINE, check=False, cwd=folder)
    assert done.returncode in (0, 1) and done.stdout, done.stderr
    return done.returncode, [findings.Finding(**finding) for finding in json.loads(done.stdout)]


@pytest.fixture
def folder():
    """A folder that the stranger may enter, too; those of pytest are private."""
    with tempfile.TemporaryDirectory() as path:
        os.chmod(path, 0o755)
        yield path


def test_a_healthy_machine_gives_no_finding(folder):
    assert examine(folder, 'master') == (0, [])
    assert examine(folder, f'master\n{package()}') == (0, [])


def test_a_running_master_with_a_node_gives_no_finding(folder):
    colour = '; '.join(f"master.setParam('/x', '/turtlesim/background_{channel}', {value})"
                       for channel, value in zip('rgb', BACKGROUND))
    setup = f'''master
        tell "master.registerPublisher('/drive_shape', '/clock', 'rosgraph_msgs/Clock', 'http://localhost:{PORT}/')
master.setParam('/x', '/use_sim_time', True); master.setParam('/x', '/drive_shape/shape', 'circle')
{colour}; master.setParam('/x', '/rosdistro', 'noetic')"'''
    assert examine(folder, setup) == (0, [])


def test_a_python_with_ros_is_no_trap(folder):
    """A virtual environment that sees the system's packages, as docs/installation.md makes it."""
    setup = '/usr/bin/python3 -m venv --system-site-packages --without-pip $folder/ros_venv\n'
    assert examine(folder, f'master; {setup}changed+=(PATH=$folder/ros_venv/bin:/usr/bin:/bin)') == (0, [])


@pytest.mark.parametrize('fault', [
    *FAULTS[::4], *nightly(*(fault for number, fault in enumerate(FAULTS) if number % 4))],
                         ids=lambda fault: fault.name)
def test_a_fault_is_named_with_its_cure(folder, fault):
    if fault.root and not IS_ROOT:
        pytest.skip('only root can set this up')
    code, found = examine(folder, fault.setup, fault.arguments)
    mine = [finding for finding in found if finding.name == fault.name]
    assert len(mine) == 1, found
    assert mine[0].fails is fault.fails and code == int(any(finding.fails for finding in found))
    for word in fault.words:
        assert word in str(mine[0])
    assert '\n' not in str(mine[0]) and mine[0].cure


def test_every_kind_of_finding_is_set_up_but_those_of_nodes_and_of_a_moving_clock():
    kinds = {name for name, function in vars(findings).items()
             if getattr(function, '__annotations__', {}).get('return') is findings.Finding}
    assert kinds == {fault.name for fault in FAULTS} | {'clock_jumps', 'no_answer', 'no_window', 'does_not_end'}


def test_a_clock_that_is_moved_is_noticed(monkeypatch, tmp_path):
    real, start = time.time, time.monotonic()
    monkeypatch.setattr(system_checks.time, 'time', lambda: real() + 2.0 * (time.monotonic() - start))
    found = list(system_checks.clock(Machine({}, str(tmp_path), str(tmp_path))))
    assert [finding.name for finding in found] == ['clock_jumps'] and found[0].fails
    gained = float(re.search(r'gains ([+\d.]+) s per second', found[0].text).group(1))
    assert gained >= 1.9  # 2, and more where the machine let the sample last longer


def test_it_needs_nothing_installed_and_changes_nothing(tmp_path):
    """In a clone that has never been built, by the command itself."""
    home = tmp_path / 'home'
    home.mkdir()
    done = subprocess.run([REPOSITORY / 'run', 'doctor'], env={'PATH': '/usr/bin:/bin', 'HOME': str(home)}, text=True,
                          capture_output=True, check=False, timeout=DEADLINE)
    assert done.returncode in (0, 1) and done.stderr == ''
    assert re.fullmatch(r'(\d+ errors?, )?\d+ notes?(, no errors)?\.', done.stdout.splitlines()[-1])
    assert 'this terminal is not a ./run shell' in done.stdout
    assert list(home.iterdir()) == [] and len(CHECKS) >= 12


@pytest.mark.parametrize('fails, said', [
    ((False,) * 6, '6 notes, no errors.'), ((False,), '1 note, no errors.'), ((True,), '1 error.'),
    ((True, False, True), '2 errors, 1 note.')])
def test_the_last_line_counts(fails, said):
    assert cli.summary([findings.Finding('a', 'b', 'c', each) for each in fails]) == said


def test_help_says_what_it_does():
    done = subprocess.run([REPOSITORY / 'run', 'doctor', '--help'], text=True, capture_output=True, check=True)
    assert '--json' in done.stdout and 'changes nothing' in done.stdout
