"""One world in a namespace: refuse to start a second one, before it disturbs the first.

roslaunch sets the parameters of a launch file before it starts a node. So launch files give a simulator its parameters
as arguments (``_world:=...``), which take effect after ``require_alone``; robot_description and /use_sim_time, which
others read, are put back by the simulator that does not start, from the copies that the first one keeps below
``~launched``. A node of the launch file that would end one of the first, robot_state_publisher, is started by
``python3 -m sim_ros.single_world gazebo COMMAND``, which does not start it beside another world.

Nothing here initialises rospy, because that shuts down a node with the same name.
"""
from __future__ import annotations

import contextlib
import http.client
import os
import sys
import xmlrpc.client
from typing import Any, Iterator

import rosgraph
import rosgraph.names

from plain_support.doctor import registrations
from rospy_support.limited_transport import LimitedTransport

TIMEOUT = 2.0  # [s] in which a running node must answer
WORLD = 'gazebo'  # the namespace of the services that each world offers
SIGN = 'get_world_properties'  # one of them
LAUNCHED = 'launched'  # below the name of a simulator: copies of the parameters that its launch file has set
USE_SIM_TIME, CLOCK = '/use_sim_time', '/clock'
TROUBLES = OSError, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException


def resolved(name: str) -> str:
    """Return the full name of a topic or node of this process, from the command line and the environment."""
    mappings = rosgraph.names.load_mappings(sys.argv)
    namespace = rosgraph.names.get_ros_namespace(argv=sys.argv)
    full = rosgraph.names.ns_join(namespace, name)
    for old, new in mappings.items():
        if rosgraph.names.ns_join(namespace, old) == full:
            return rosgraph.names.ns_join(namespace, new)
    return full


def require_alone(node: str, topic: str | None = None, world: str | None = None) -> None:
    """End this process with a text if another node has its name, its ``topic``, or the services below ``world``.

    Call it before init_node.
    """
    found = other_robot(node, topic, world)
    if found:
        other, text = found
        if any(argument.startswith('__log:=') for argument in sys.argv):  # by roslaunch, which has set parameters
            with contextlib.suppress(*TROUBLES):
                put_back(other)
        sys.exit(f'{node} does not start: {text}')


def other_robot(node: str, topic: str | None = None, world: str | None = None) -> tuple[str, str] | None:
    """Return (name, text) of a running node that is called ``node``, or that has what the arguments name; or None."""
    own = resolved(rosgraph.names.load_mappings(sys.argv).get('__name', node))
    published = topic and resolved(topic)
    master = rosgraph.Master(own)
    try:
        publishers, _, services = map(dict, master.getSystemState())
        others = [(own, 'has this name')]
        others += [(name, f'publishes {published}') for name in sorted(publishers.get(published, ()))]
        others += [(name, f'has the services of {resolved(world)}') for name in sorted(services.get(_sign(world), ()))
                   ] if world else []
        for name, what in others:
            if _lives(master, name):
                return name, (f'{name} {what} already: two robots would use the same topics. Stop that node (Ctrl-C in '
                              f'its terminal, or rosnode kill {name}), or start this one in its own namespace, e.g. '
                              '__ns:=robot2')
    except TROUBLES:
        pass  # rospy itself reports that there is no master
    return None


def put_back(other: str) -> None:
    """Undo what the launch file of this process has set: ``other`` keeps copies of the parameters of its own world."""
    master = rosgraph.Master(other)
    copies = {}
    with contextlib.suppress(rosgraph.MasterException):  # it keeps none
        copies = dict(_flat(master.getParam(rosgraph.names.ns_join(other, LAUNCHED))))
    for name, value in copies.items():
        master.setParam(name, value)
    for name in _launch_parameters():
        if name not in copies and master.hasParam(name):
            master.deleteParam(name)
    clocks = dict(master.getSystemState()[0]).get(CLOCK, ())
    if any(_lives(master, name) for name in clocks):
        master.setParam(USE_SIM_TIME, True)
    elif master.hasParam(USE_SIM_TIME):
        master.deleteParam(USE_SIM_TIME)


def world_of_another_launch(world: str) -> str | None:
    """Return the name of the node that has the services below ``world``, if another roslaunch has started it."""
    master = rosgraph.Master('/single_world')
    try:
        for name in dict(master.getSystemState()[2]).get(_sign(world), ()):
            if _lives(master, name) and _parent(master, name) != os.getppid():
                return name
    except TROUBLES:
        pass
    return None


def _launch_parameters() -> list[str]:
    """Return the full names in _launch_parameters:=NAMES on the command line."""
    given = [argument.partition(':=')[2] for argument in sys.argv if argument.startswith('_launch_parameters:=')]
    return [resolved(name) for name in ' '.join(given).split()]


def _sign(world: str) -> str:
    return resolved(rosgraph.names.ns_join(world, SIGN))


def _lives(master: rosgraph.Master, node: str) -> bool:
    """Return whether a node answers with its own name; one that has ended does not, even if its port is reused."""
    service = rosgraph.names.ns_join(node, registrations.SIGN)
    try:
        return registrations.offers(service, master.lookupService(service), TIMEOUT)
    except rosgraph.MasterException:
        return False


def _parent(master: rosgraph.Master, node: str) -> int:
    """Return the process that has started a node; that of this process if the node runs on another machine."""
    try:
        proxy: Any = xmlrpc.client.ServerProxy(master.lookupNode(node), LimitedTransport(TIMEOUT))
        _, _, number = proxy.getPid('/single_world')
        with open(f'/proc/{number}/stat', encoding='utf-8', errors='replace') as file:
            return int(file.read().rpartition(')')[2].split()[1])
    except TROUBLES:
        return os.getppid()


def _flat(tree: dict[str, Any], above: str = '') -> Iterator[tuple[str, Any]]:
    """Yield (name, value) of the parameters in a tree of namespaces."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{above}/{key}')
        else:
            yield f'{above}/{key}', value


def main() -> None:
    """Start the command after the first word, unless another launch has a world with services below that word."""
    world, *command = sys.argv[1:]
    name = world_of_another_launch(world)
    if name:
        sys.exit(f'{os.path.basename(command[0])} does not start: {name} is the world of another launch.')
    os.execvp(command[0], command)


if __name__ == '__main__':
    main()
