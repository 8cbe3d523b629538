"""The address of this machine, its master's port, the registrations of the master, and left-over processes.

Among the registrations: topics that nodes were meant to share, but do not, because of their name or type.
"""
import concurrent.futures
import os
import re
import socket
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Set
from urllib.parse import urlsplit

from plain_support.doctor import addresses, findings, master, names, packages, processes, registrations
from plain_support.doctor.addresses import MasterAddress
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Check, Machine
from plain_support.doctor.master import Graph

ANSWER_TIME = 2.0  # [s] for a master or a node
AT_A_TIME = 16  # nodes that are asked at the same time
OF_ROS_ITSELF = {'roslaunch', 'rosdistro', 'rosversion', 'run_id', 'rosout'}  # parameters that belong to no node
LEFT_ON_PURPOSE = {'turtlesim': {'background_r': 69, 'background_g': 86, 'background_b': 255}}  # its own defaults
COMMAND = 'geometry_msgs/Twist'
WAITED_FOR = {COMMAND, 'actionlib_msgs/GoalID'}  # types that a node may wait for in vain: a command, ...
GOAL = 'ActionGoal'  # ... and the end of the types of goals
SENSED = {'turtlesim/Pose', 'nav_msgs/Odometry', 'ar_track_alvar_msgs/AlvarMarkers', 'sensor_msgs/Image',
          'sensor_msgs/LaserScan'}  # types that a simulator or a sensor publishes all the time
TOOLS = re.compile(r'/(rostopic|record|rosbag)_\d+.*')  # they read any topic
PROGRAMS = 'roscore', 'rosmaster', 'roslaunch', 'rosout', 'rostest'


def address(machine: Machine) -> Iterator[Finding]:
    """The address that this machine announces."""
    if addresses.master_address(machine.environment) is None:
        yield findings.bad_master_uri(machine.environment.get(addresses.MASTER_URI, ''))
    wrong = addresses.wrong_address(machine.environment)
    if wrong:
        yield wrong


def master_and_graph(machine: Machine) -> Iterator[Finding]:
    """The master and its registrations."""
    target = addresses.master_address(machine.environment)
    if target is None:
        return
    here = addresses.is_here(target.host)
    holder = _listener(target.port) if here else None
    if here and holder is None:
        if machine.environment.get(addresses.MASTER_URI) or packages.found(machine.environment):
            yield findings.no_roscore(target.uri, processes.master_of_user(machine.workspace))
        return
    who = holder.holder if holder else target.uri
    try:
        graph = master.ask(target.uri, ANSWER_TIME)
    except master.NoAnswer as error:
        yield _silent(target, holder, str(error))
    except master.NoMaster:
        yield findings.port_taken(target.port, who) if here else findings.master_unreachable(
            target.uri, 'what answers is no master')
    else:
        if holder and holder.user != os.geteuid():
            yield findings.foreign_master(target.uri, processes.user_name(holder.user), graph.pid)
        yield from graph_findings(graph)


def _listener(port: int) -> Optional[processes.Listener]:
    return next((listener for listener in processes.listeners() if listener.port == port), None)


def _silent(target: MasterAddress, holder: Optional[processes.Listener], reason: str) -> Finding:
    if holder is None:
        return findings.master_unreachable(target.uri, reason)
    if holder.process is None or any(word in ' '.join(holder.process.command) for word in ('rosmaster', 'roscore')):
        return findings.master_hangs(target.uri, holder.holder)
    return findings.port_taken(target.port, holder.holder)


def graph_findings(graph: Graph) -> Iterator[Finding]:
    """Yield the problems in the registrations of a master."""
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        alive = dict(zip(graph.nodes, pool.map(lambda node: _alive(graph, node), graph.nodes)))
    for node, uri in graph.nodes.items():
        if not alive[node]:
            yield findings.stale_registration(node, uri)
    clocks = [node for node in graph.publishers.get('/clock', []) if alive.get(node)]
    if len(clocks) > 1:
        yield findings.two_clocks(sorted(clocks))
    if graph.parameters.get('use_sim_time') and not clocks:
        yield findings.no_clock()
    running = {node for node, lives in alive.items() if lives}
    living = graph.of(running)
    yield from misnamed(living)
    yield from two_types(living, lambda nodes: _types(graph, nodes))
    for node, values in _private(graph.parameters, running).items():
        yield findings.stale_parameters(node, values)


def misnamed(graph: Graph) -> Iterator[Finding]:
    """Yield commands without a reader, and topics with readers but no publisher.

    A robot may wait for commands, and a simulator may publish poses that nobody reads; both are normal. So a misspelled
    name shows at the other end: nobody reads the commands, or nobody publishes the poses that a node waits for.
    """
    read = {topic for topic, nodes in graph.subscribers.items() if any(not TOOLS.fullmatch(node) for node in nodes)}
    published = {topic for topic, nodes in graph.publishers.items() if nodes}
    for topic in sorted(published - read):
        meant = names.meant(topic, _of_type(graph, COMMAND, read)) if graph.types.get(topic) == COMMAND else None
        for node in graph.publishers[topic]:
            if meant and node not in graph.publishers.get(meant, ()):
                yield findings.misnamed(node, 'publishes', topic, meant)
    for topic in sorted(set(graph.subscribers) - published):
        if not _is_optional(topic, graph.types.get(topic, '')):
            for node in graph.subscribers[topic]:
                yield from _in_vain(graph, node, topic, published)


def _is_optional(topic: str, kind: str) -> bool:
    return bool(names.OF_EVERY_NODE.fullmatch(topic)) or kind in WAITED_FOR or kind.endswith(GOAL)


def _in_vain(graph: Graph, node: str, topic: str, published: Iterable[str]) -> Iterator[Finding]:
    """Yield why a node waits in vain; topics below its own name are optional inputs."""
    if topic.startswith(f'{node}/'):
        return
    kind = graph.types.get(topic, '')
    known = {name for name in published if node not in (*graph.subscribers.get(name, ()), *graph.publishers[name])}
    meant = names.meant(topic, _of_type(graph, kind, known)) or names.meant(topic, known)
    if meant:
        yield findings.misnamed(node, 'subscribes', topic, meant)
    elif kind in SENSED:
        yield findings.nobody_publishes(node, topic)


def _of_type(graph: Graph, kind: str, topics: Iterable[str]) -> Set[str]:
    return {topic for topic in topics if graph.types.get(topic) == kind}


def two_types(graph: Graph, types_of: Callable[[List[str]], Mapping[str, Mapping[str, str]]]) -> Iterator[Finding]:
    """Yield topics whose nodes use different types; ``types_of(nodes)`` asks them: {node: {topic: type}}."""
    users: Dict[str, Set[str]] = {}
    for each in (graph.publishers, graph.subscribers):
        for topic, nodes in each.items():
            users.setdefault(topic, set()).update(nodes)
    shared = {topic: sorted(nodes) for topic, nodes in users.items()
              if len(nodes) > 1 and not names.OF_EVERY_NODE.fullmatch(topic)}
    types = types_of(sorted({node for nodes in shared.values() for node in nodes}))
    for topic, nodes in sorted(shared.items()):
        known = [(node, types.get(node, {}).get(topic, '*')) for node in nodes]
        known = [(node, kind) for node, kind in known if kind != '*']
        if len({kind for _, kind in known}) > 1:
            yield findings.two_types(topic, known)


def _types(graph: Graph, nodes: List[str]) -> Dict[str, Dict[str, str]]:
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        return dict(zip(nodes, pool.map(lambda node: master.types_of_node(graph.nodes[node], ANSWER_TIME), nodes)))


def _alive(graph: Graph, node: str) -> bool:
    service = f'{node}/{registrations.SIGN}'
    if service in graph.services:
        return registrations.offers(service, graph.services[service], ANSWER_TIME)
    address = urlsplit(graph.nodes[node])  # a node of a library that has no such service
    try:
        with socket.create_connection((address.hostname or '', address.port or 0), ANSWER_TIME):
            return True
    except (OSError, ValueError):
        return False


def _private(parameters: Mapping[str, Any], running: Set[str]) -> Dict[str, Mapping[str, Any]]:
    """Return {node: its parameters} for nodes that do not run; a namespace of a running node is not one of them."""
    found: Dict[str, Mapping[str, Any]] = {}
    for name, values in parameters.items():
        node = f'/{name}'
        if name in OF_ROS_ITSELF or not isinstance(values, dict) or not values:
            continue
        if any(each == node or each.startswith(f'{node}/') for each in running):
            continue
        usual = LEFT_ON_PURPOSE.get(name, {})
        left = {key: value for key, value in values.items() if key not in usual or usual[key] != value}
        if left:
            found[node] = left
    return found


def exposed(_: Machine) -> Iterator[Finding]:
    """Processes of ROS that other machines can reach although ROS_IP and ROS_HOSTNAME do not ask for it."""
    reported = set()
    for listener in processes.listeners():
        environment = listener.process.environment if listener.process else {}
        name = environment.get(addresses.HOSTNAME) or environment.get(addresses.IP) or 'localhost'
        is_public = name != 'localhost' and not name.startswith(addresses.LOOPBACK)
        is_ours = addresses.MASTER_URI in environment and not listener.local
        if is_ours and not is_public and listener.holder not in reported:
            reported.add(listener.holder)
            yield findings.exposed(listener.holder, f'{listener.address}, port {listener.port}')


def left_over(machine: Machine) -> Iterator[Finding]:
    """Processes of ROS of this user whose terminal or launcher has ended."""
    found = {process.pid: process for process in processes.all_processes()}
    for process in found.values():
        reaper = process.parent == 1 or getattr(found.get(process.parent), 'name', '') == 'systemd'
        alone = process.session == process.pid or process.session not in {0, *found}  # 0: outside of a container
        if process.user == os.geteuid() and reaper and alone and _of_ros(process, machine):
            yield findings.left_over(str(process), ' '.join(process.command)[:100])


def _of_ros(process: processes.Process, machine: Machine) -> bool:
    if addresses.MASTER_URI not in process.environment:
        return False
    words = process.command[:3]
    folders = machine.workspace, machine.repository
    return (any(os.path.basename(word) in PROGRAMS or word.startswith(folders) for word in words)
            or any('__name:=' in word or '__log:=' in word for word in process.command))


CHECKS: List[Check] = [address, master_and_graph, exposed, left_over]
