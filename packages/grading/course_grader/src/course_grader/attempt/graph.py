"""Reads from the master what the nodes of a program publish, subscribe and serve."""
import os
import xmlrpc.client

import rosgraph

from course_grader.attempt import beside, forked
from course_grader.attempt.faults import ProgramFault
from course_grader.rules.observation import Event, Problem

OF_EVERY_NODE = '/clock', '/rosout'  # topics
ROLES = {'PUB': 'publishes', 'SUB': 'subscribes', 'SERVICE': 'serves'}  # of a node for a name, as in the master's log
FAKES = {'/turtle1/pose': 'fake_pose', '/turtle1/color_sensor': 'fake_pose', '/odom': 'fake_pose',
         '/clock': 'fake_clock'}  # topic: kind of the event when the program publishes on it
OF_A_ROBOT = 'odom', 'scan', 'joint_states'  # topics in the namespace of each of several robots, of the simulator alone


class Graph:
    """The nodes of a program, as the master knows them; all calls in the main thread."""

    def __init__(self, exercise, master, log, own, observed):
        """``master``: a rosgraph.Master; ``log``: the master's; ``own``: the names of the grading's own nodes."""
        self._master, self._log, self._own, self._observed = master, log, own, observed
        self._fakes = {**FAKES, **dict.fromkeys(beside.topics(exercise.beside), 'fake_result'),
                       **{f'/{robot}/{topic}': 'fake_pose' for robot in exercise.robots for topic in OF_A_ROBOT}}
        self._seen = set()  # names of the program's nodes
        self._log_size = -1  # [bytes] when it was last read
        self.following = False  # whether one of the program's nodes follows /clock

    def has_nodes(self):
        """Return whether a node of the program is running. Raise ProgramFault."""
        self._seen = {node for kind in self._names() for _, users in kind for node in users} - self._own
        self.following = bool(self._seen)
        return self.following

    def had_nodes(self):
        """Return whether a node of the program has ever run: the master logs even one that ends immediately."""
        return self._seen or any(node not in self._own for _, _, node in forked.registrations(self._log))

    def update(self):
        """Read if the master has logged anything since the last call. Raise ProgramFault."""
        size = os.path.getsize(self._log)
        if size != self._log_size:
            self.read()
        self._log_size = size

    def read(self):
        """Record what the program's nodes publish, subscribe and serve, and which pretend to be the simulator.

        Raise ProgramFault.
        """
        try:
            names = self._names()
            self._observed.types.update(self._master.getTopicTypes())
        except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
            return
        self.following = any(name == '/clock' and set(nodes) - self._own for name, nodes in names[1])
        for kind, name, node in forked.registrations(self._log):  # also of names that were there between two calls
            if node not in self._own:
                self._record(kind, name, node)
        for listed, role in zip(names, ROLES.values()):
            for name, nodes in listed:
                if set(nodes) & self._own:
                    self._observed.others.add((name, role))
                self._seen |= set(nodes) - self._own

    def _record(self, kind, name, node):
        if name not in OF_EVERY_NODE:
            self._observed.connections.add((name, ROLES[kind]))
        if kind == 'PUB' and name in self._fakes:
            self._observed.events.append(Event(self._observed.seconds, self._fakes[name], (name,), node))

    def _names(self):
        """Return what all nodes publish, subscribe and serve."""
        try:
            return self._master.getSystemState()
        except ValueError:  # xmlrpc.client reads answers of at most 20 MB
            raise ProgramFault(Problem('the program registered so many or so long names that the state of the master '
                                       'cannot be read: it has more than 20 MB')) from None


def subscribers(master, topic):
    """Return the names of the nodes that subscribe to a topic."""
    return {node for name, users in master.getSystemState()[1] if name == topic for node in users}
