"""Names on a command line that roscpp refuses and rospy accepts.

The fault: with a blank or an umlaut in its name a rospy node registers by half, or in a way that C++ nodes cannot read,
and reports that the master does not answer.
"""
import re

import rosgraph.names

NODE = re.compile(r'[A-Za-z]\w*', re.ASCII)
GRAPH = re.compile(r'[~/A-Za-z][\w/]*', re.ASCII)
NAMESPACE = 'ROS_NAMESPACE'


def fault(arguments, environment):
    """Return what is wrong with a name of the command line ``arguments`` or with ROS_NAMESPACE; '' if nothing is."""
    given = rosgraph.names.load_mappings(list(arguments))
    name, namespace = given.pop('__name', None), given.pop('__ns', None)
    if name is not None and not NODE.fullmatch(name):
        return _text(f'__name:={name}', 'a node has', 'letters a to z, digits and _, and begins with a letter',
                     f'__name:={_legal(name.replace("/", "_"))}')
    if namespace is not None and not GRAPH.fullmatch(namespace):
        return _graph_text(f'__ns:={namespace}', '__ns:=', namespace)
    if environment.get(NAMESPACE) and not GRAPH.fullmatch(environment[NAMESPACE]):
        return _graph_text(f'{NAMESPACE}={environment[NAMESPACE]}', f'export {NAMESPACE}=', environment[NAMESPACE])
    for one, other in given.items():
        if not one.startswith('__') and not (GRAPH.fullmatch(one) and GRAPH.fullmatch(other)):
            return _graph_text(f'{one}:={other}', f'{_legal(one)}:=', other)
    return ''


def _graph_text(given, before, name):
    return _text(given, 'it has', 'letters a to z, digits, _ and /, and begins with a letter, / or ~',
                 f'{before}{_legal(name)}')


def _text(given, subject, allowed, better):
    return f'{given!r} is not a name that ROS allows: {subject} only {allowed}. Type for example {better}'


def _legal(name):
    """Return a similar name that is allowed."""
    cleaned = re.sub(r'[^\w/~]', '_', name, flags=re.ASCII)
    return cleaned if GRAPH.fullmatch(cleaned) else f'n{cleaned}'
