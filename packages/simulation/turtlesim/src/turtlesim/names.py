"""Check the names of turtles, which become part of the names of topics and services."""
import re
from typing import Iterable

import rospy

from plain_support import InvalidInput

NODE_SERVICES = ('clear', 'kill', 'reset', 'spawn')
MAX_LENGTH = 200  # [characters]
LEGAL = re.compile(r'/?[A-Za-z]\w*(/\w+)*', re.ASCII)  # a ROS graph name without '~'


class TurtleNames:
    """The names of the existing turtles, by their resolved names in ROS."""

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._names = {rospy.resolve_name(name): name for name in names}  # resolved name: name

    def __contains__(self, name: object) -> bool:
        return rospy.resolve_name(name) in self._names

    def add(self, name: str) -> None:
        self._names[rospy.resolve_name(name)] = name

    def remove(self, name: str) -> None:
        del self._names[rospy.resolve_name(name)]

    def check(self, name: str) -> None:
        """Raise InvalidInput unless a new turtle's name is legal in ROS and does not clash with other names.

        A turtle with exactly the same name is not an error here: the world refuses it with a text of its own.
        """
        if not LEGAL.fullmatch(name):
            raise InvalidInput(f'spawn: the name {name[:MAX_LENGTH]!r} is not allowed; a name starts with a letter and '
                               'contains only letters (a-z, A-Z), digits and _, with single / between its parts')
        if len(name) > MAX_LENGTH:
            raise InvalidInput(f'spawn: the name has {len(name)} characters; at most {MAX_LENGTH} are allowed')
        resolved = rospy.resolve_name(name)
        if resolved == rospy.get_name() or resolved in map(rospy.resolve_name, NODE_SERVICES):
            raise InvalidInput(f'spawn: the name {name!r} belongs to the simulator itself ({resolved}); choose another')
        other = self._names.get(resolved, name)
        if other != name:
            raise InvalidInput(f'spawn: the name {name!r} means {resolved}, as does the turtle {other!r}; '
                               'choose another')
