"""Find topics that two nodes were meant to share, but do not, because of their name or type. Without ROS.

A robot may wait for commands, and a simulator may publish poses that nobody reads; both are normal. So a misspelled
name shows at the other end: nobody reads the commands, or nobody publishes the poses that a node waits for.
"""
import re
from typing import Callable, Dict, Iterable, Iterator, List, Mapping, Set

from plain_support.doctor import findings, names
from plain_support.doctor.findings import Finding
from plain_support.doctor.master import Graph

COMMAND = 'geometry_msgs/Twist'
WAITED_FOR = {COMMAND, 'actionlib_msgs/GoalID'}  # types that a node may wait for in vain: a command, ...
GOAL = 'ActionGoal'  # ... and the end of the types of goals
SENSED = {'turtlesim/Pose', 'nav_msgs/Odometry', 'ar_track_alvar_msgs/AlvarMarkers', 'sensor_msgs/Image',
          'sensor_msgs/LaserScan'}  # types that a simulator or a sensor publishes all the time
TOOLS = re.compile(r'/(rostopic|record|rosbag)_\d+.*')  # they read any topic


def misnamed(graph: Graph) -> Iterator[Finding]:
    """Yield commands without a reader, and topics with readers but no publisher."""
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
