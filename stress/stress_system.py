"""Systems without descriptors, disk space, stdout or HOME; signals; and how nodes end."""

import contextlib
import os
import resource
import signal
import subprocess
import time

from roscpp.srv import GetLoggers

import inputs
import tcpros
from figures import Figure, Target, median
from rostest_support import node_kinds
from trial import NOTHING, Attack, Trial, deaf, losses
from under_test import MOTION, TROUBLE, running, started, tell, until

KINDS = ('turtlesim', 'robotont', 'usb_cam', 'mimic')
SMALL_KINDS = ('turtlesim', 'mimic')
SPARE_FILES = 3
FLOOD = 60  # connections to a node without descriptors
DISK = 400  # [kB]
AT_THE_WALL = 3.0  # [s] of a turtle that logs
LINES = Target('at_most', 500)  # warnings of the wall in AT_THE_WALL are 190; 3,710 were seen on a full disk
STOPPED = 3.0  # [s]
STARTING = 0.1  # [s] from a node's first registration to its last, and a little more
END = 20.0  # [s] until a node that was asked has ended
DRIVING = ('velocity_publisher', 'stop_at_x', 'drive_shape', 'teleport_tour', 'drive_shape_robot', 'draw_square',
           'ar_control')
SMALL_DRIVING = ('velocity_publisher', 'stop_at_x', 'drive_shape')
WAYS = ('SIGINT', 'SIGTERM', 'rosnode kill', 'master gone')


def keys_of(subject, small):
    """Return the kinds that are tried one after the other."""
    if subject.side != 'ours':
        return ('turtlesim',)
    return SMALL_KINDS if small else KINDS


def merged(parts):
    """Return one {key: samples} made of many."""
    found = {}
    for part in parts:
        for key, values in part.items():
            found.setdefault(key, []).extend(values)
    return found


def descriptors(subject, scale, _rng):
    """No descriptor is left: does the node answer again when the clients are gone, and how soon?"""
    return merged(_without_descriptors(subject, key) for key in keys_of(subject, scale.small))


def _without_descriptors(subject, key):
    with running(subject, key) as nodes:
        node = nodes[key]
        trial = Trial(node)
        place = node.tcpros_place()
        limits = resource.prlimit(node.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(node.pid, resource.RLIMIT_NOFILE, (node.descriptors() + SPARE_FILES, limits[1]))
        open_ones = []
        hello = tcpros.header(callerid=tcpros.CALLER, service=f'{node.kind.node}/get_loggers', persistent='1',
                              md5sum=GetLoggers._md5sum)  # without it a node may only ever take one connection
        open_ones += _flood(trial, place, hello)
        open_ones += _flood(trial, tcpros.address(node.uri), b'')
        time.sleep(1.0)
        for one in open_ones:
            one.close()
        begun = time.monotonic()
        while deaf(node) and time.monotonic() - begun < END:
            time.sleep(0.1)
        back = time.monotonic() - begun
        resource.prlimit(node.pid, resource.RLIMIT_NOFILE, limits)
        return {**trial.samples('nofile'), 'nofile_back': [back]}


def _flood(trial, place, hello):
    """Open up to FLOOD connections that send ``hello``, as long as the node accepts them."""
    open_ones = []
    with contextlib.suppress(*TROUBLE):
        for _ in range(FLOOD):
            trial.inputs += 1
            open_ones.append(tcpros.connect(place, 1.0))
            tcpros.send(open_ones[-1], hello)
    return open_ones


def disk(subject, scale, _rng):
    """A full disk for logs, recording and snapshots."""
    folder = os.path.join(subject.folder, 'small_disk')
    os.makedirs(folder, exist_ok=True)
    inside = _small_disk(folder)
    kind = node_kinds.BY_KEY['turtlesim']
    if subject.side == 'ours':
        kind = kind._replace(arguments=(*kind.arguments, f'_record:={folder}/recording.csv'))
    with started(subject, kind, inside, ROS_LOG_DIR=folder) as node:
        node.await_registered()
        trial = Trial(node)
        seen = f'/proc/{node.pid}/root{folder}'
        _fill(os.path.join(seen, 'filler'))
        found = {'disk_lines': [_lines_at_the_wall(node)]}
        if subject.side == 'ours':
            node.master.setParam(tcpros.CALLER, '/turtlesim/snapshot_dir', folder)
            answer = trial.answered(lambda: node.call('/turtlesim/snapshot'))
            found['disk_told'] = [int(answer is not None and answer[1][:1] == b'\1')]
            found['disk_partial'] = [sum(name.endswith('.png') for name in os.listdir(seen))]
        with contextlib.suppress(OSError):
            os.unlink(os.path.join(seen, 'filler'))
        found.update({key: value for key, value in trial.samples('disk').items() if key != 'disk_changed'})
        return found


def _small_disk(folder):
    """Return a command that runs another with a disk of DISK kB on the folder; if not permitted, with small files."""
    mounting = ('unshare', '--mount', '--map-root-user', 'sh', '-c',
                f'mount -t tmpfs -o size={DISK}k none "$0" && exec "$@"', folder)
    tried = subprocess.run([*mounting, 'true'], capture_output=True, timeout=10.0, check=False)
    return mounting if tried.returncode == 0 else ('prlimit', f'--fsize={DISK * 1024 // 8}')


def _fill(path):
    with contextlib.suppress(OSError), open(path, 'wb', buffering=0) as file:
        for size in (4096, 64, 1):
            with contextlib.suppress(OSError):
                while file.tell() < DISK * 1024:
                    file.write(b'x' * size)


def _lines_at_the_wall(node):
    """Return how many lines a node prints while a turtle drives against the wall."""
    topic, kind = MOTION['turtlesim']
    publisher = tcpros.Publisher(node.subject.uri, topic, kind)
    try:
        until(lambda: publisher.connections, 'a subscription of /turtle1/cmd_vel')
        before, end = node.child.lines(), time.monotonic() + AT_THE_WALL
        while time.monotonic() < end:
            publisher.publish(inputs.legal_twist(x=1000.0))
            time.sleep(0.1)
        return node.child.lines() - before
    finally:
        publisher.close()


def surroundings(subject, scale, _rng):
    """Closed stdout and stderr; a read-only HOME without ROS_HOME and ROS_LOG_DIR."""
    parts = []
    for key in keys_of(subject, scale.small):
        parts.append(_lives(subject, key, 'closed', before=('sh', '-c', 'exec "$@" >&- 2>&-', 'sh')))
        parts.append(_lives(subject, key, 'home', HOME='/proc/nothing', ROS_HOME=None, ROS_LOG_DIR=None))
    return merged(parts)


def _lives(subject, key, name, **options):
    with _needed(subject, key), started(subject, node_kinds.BY_KEY[key], **options) as node:
        try:
            node.await_registered()
        except Exception as error:  # noqa: BLE001 (whatever keeps it from coming up is a node lost)
            tell(f'    {name}, {key}: {error}')
            return {f'{name}_ended': [1]}
        trial = Trial(node)
        trial.inputs += 1
        if key == 'turtlesim':
            _lines_at_the_wall(node)
        return {word: value for word, value in trial.samples(name).items() if word != f'{name}_changed'}


def stop_and_go(subject, scale, _rng):
    """SIGSTOP, a pause, SIGCONT."""
    parts = []
    for key in keys_of(subject, scale.small):
        with running(subject, key) as nodes:
            trial = Trial(nodes[key])
            os.kill(nodes[key].pid, signal.SIGSTOP)
            time.sleep(scale.seconds(STOPPED, 1.0))
            os.kill(nodes[key].pid, signal.SIGCONT)
            trial.inputs += 1
            parts.append(trial.samples('sigstop'))
    return merged(parts)


def asked_to_end(subject, scale, _rng):
    """SIGINT and SIGTERM to a node: exit code, time, and whether it is unregistered."""
    found = {'end_code': [], 'end_registered': [], 'end_time': []}
    for key in keys_of(subject, scale.small):
        for number in (signal.SIGINT, signal.SIGTERM):
            with running(subject, key) as nodes:
                node = nodes[key]
                begun = time.monotonic()
                os.kill(node.pid, number)
                code = _exit_code(node.child)
                found['end_time'].append(time.monotonic() - begun)
                found['end_code'].append(int(code != 0))
                found['end_registered'].append(int(any(node.registered())))
                _forget(node)
    return found


def asked_while_starting(subject, scale, rng):
    """SIGINT or SIGTERM to a node that has begun to register: exit code, and whether it is unregistered."""
    found = {'start_code': [], 'start_registered': []}
    for key in keys_of(subject, scale.small):
        with _needed(subject, key):
            for _ in range(scale.count(25, 4)):
                with started(subject, node_kinds.BY_KEY[key]) as node:
                    until(lambda node=node: any(node.registered()), f'{key} registers', poll=0.002)
                    time.sleep(rng.uniform(0.0, STARTING))
                    os.kill(node.child.pid, rng.choice((signal.SIGINT, signal.SIGTERM)))
                    found['start_code'].append(int(_exit_code(node.child) != 0))
                    found['start_registered'].append(int(any(node.registered())))
                    _forget(node)
    return found


@contextlib.contextmanager
def _needed(subject, key):
    """Run what a kind of node needs, if anything."""
    needed = [kind.key for kind in node_kinds.in_order([key])[:-1]]
    with running(subject, *needed) if needed else contextlib.nullcontext():
        yield


def _forget(node):
    """Unregister a node that has not done it itself, so that the next one is not taken for it."""
    for names, forget in zip(node.registered(), ('unregisterPublisher', 'unregisterSubscriber', 'unregisterService')):
        for name in names:
            place = node.uri if forget != 'unregisterService' else node.master.lookupService(tcpros.CALLER, name)[2]
            getattr(node.master, forget)(node.kind.node, name, place)


def _exit_code(child):
    """Return its exit code, None when it does not end in time."""
    try:
        return child.process.wait(END)
    except subprocess.TimeoutExpired:
        return None


def ends(subject, scale, rng):
    """End driving nodes 200 times, each in one of WAYS at a random moment."""
    count, keys = scale.count(200, 6), SMALL_DRIVING if scale.small else DRIVING
    found = {'driving_ends': [], 'driving_traceback': [], 'driving_left': []}
    with running(subject, *{need for key in keys for need in node_kinds.BY_KEY[key].needs}):
        while len(found['driving_ends']) < count:
            way = WAYS[len(found['driving_ends']) // len(keys) % len(WAYS)]
            with contextlib.ExitStack() as stack:
                nodes = []
                for key in keys[:count - len(found['driving_ends'])]:
                    node = stack.enter_context(started(subject, node_kinds.BY_KEY[key]))
                    nodes.append(node)
                for node in nodes:
                    _await_up(node)
                time.sleep(rng.uniform(0.0, 1.0))
                _end(subject, nodes, way)
                for node in nodes:
                    left = _exit_code(node.child) is None
                    found['driving_ends'].append(1)
                    found['driving_left'].append(int(left))
                    found['driving_traceback'].append(int('Traceback' in node.child.output()))
            if way == 'master gone':
                subject.start_master()
                time.sleep(3.0)  # the simulators register again
    return found


def _await_up(node):
    """Wait until a node is registered or has ended by itself."""
    with contextlib.suppress(Exception):
        node.await_registered(END)


def _end(subject, nodes, way):
    if way == 'master gone':
        subject.master.kill()
        time.sleep(1.0)
    for node in nodes:
        if not node.runs():
            continue
        if way == 'rosnode kill' and node.uri:
            with contextlib.suppress(*TROUBLE):
                tcpros.api(node.uri).shutdown(tcpros.CALLER, 'rosnode kill')
        else:
            os.kill(node.child.pid, signal.SIGTERM if way == 'SIGTERM' else signal.SIGINT)


ATTACKS = {
    'nofile': Attack(descriptors, 'no descriptors'),
    'disk': Attack(disk, 'a full disk'),
    'surroundings': Attack(surroundings, 'closed stdout, unwritable HOME'),
    'sigstop': Attack(stop_and_go, 'SIGSTOP and SIGCONT'),
    'asked': Attack(asked_to_end, 'SIGINT and SIGTERM'),
    'starts': Attack(asked_while_starting, 'SIGINT and SIGTERM during the start'),
    'ends': Attack(ends, '200 ends of driving nodes', peer=False),
}
FIGURES = (
    *losses('nofile', 'no descriptors'),
    Figure('no descriptors: answers again after', 'nofile_back', 's', max, Target('below', 2.0)),
    *losses('disk', 'full disk', changed=False),
    Figure(f'full disk: lines printed in {AT_THE_WALL:g} s at the wall', 'disk_lines', '', max, LINES),
    Figure('full disk: a snapshot was reported but does not exist', 'disk_told', '', sum, NOTHING),
    Figure('full disk: PNG files cut off or empty', 'disk_partial', '', sum, NOTHING),
    *losses('closed', 'closed stdout', changed=False),
    *losses('home', 'unwritable HOME', changed=False),
    *losses('sigstop', 'SIGSTOP and SIGCONT'),
    Figure('SIGINT and SIGTERM: not exit code 0', 'end_code', '', sum, NOTHING),
    Figure('SIGINT and SIGTERM: still registered', 'end_registered', '', sum, NOTHING),
    Figure('SIGINT and SIGTERM during the start', 'start_code', '', len),
    Figure('SIGINT and SIGTERM during the start: not exit code 0', 'start_code', '', sum, NOTHING),
    Figure('SIGINT and SIGTERM during the start: still registered', 'start_registered', '', sum, NOTHING),
    Figure('SIGINT and SIGTERM: ended after', 'end_time', 's', median, Target('below', 2.0)),
    Figure('ends of driving nodes', 'driving_ends', '', sum),
    Figure('ends of driving nodes: with a traceback', 'driving_traceback', '', sum, NOTHING),
    Figure('ends of driving nodes: not ended', 'driving_left', '', sum, NOTHING),
)
