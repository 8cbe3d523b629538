"""What can be read off a program before it runs: whether it looks at the wall clock.

Simulated time may pass faster only where a program follows it. rospy.sleep, Rate, Timer and Time do; what is searched
for here does not.
"""
import os
import re
import xml.etree.ElementTree as ElementTree

import roslib.packages
import rospkg

WALL_CLOCK = re.compile(rb'^[^#\n]*\btime\.(sleep|time|monotonic|perf_counter)\b|^\s*from time import|'
                        rb'^\s*import ([\w.]+(?: as \w+)?\s*,\s*)*time as\b|'
                        rb'^[^#\n]*\b(wait_for_message|datetime\.now|threading\.Timer)\b', re.MULTILINE)


def looks_at_the_wall_clock(command):
    """Return whether a Python program that ``command`` starts, itself or by rosrun or roslaunch, does so."""
    for path in _programs(command):
        try:
            with open(path, 'rb') as file:
                if WALL_CLOCK.search(file.read()):
                    return True
        except OSError:
            continue
    return False


def _programs(command):
    """Return the paths of the Python programs that a command starts, as far as they can be found."""
    tool, values = os.path.basename(command[0]), [part for part in command[1:] if not part.startswith('-')]
    nodes = []
    if tool == 'rosrun':
        nodes = [tuple(values[:2])]
    elif tool == 'roslaunch':
        nodes = [(node.get('pkg'), node.get('type')) for path in _launch_files(values) for node in _nodes(path)]
    found = [path for node in nodes for path in _find(*node)]
    return [part for part in command if part.endswith('.py')] + [path for path in found if _is_python(path)]


def _launch_files(values):
    """Return the paths of the launch files that roslaunch takes: FILE ... or PACKAGE FILE."""
    paths = [value for value in values if os.path.isfile(value)]
    if not paths and len(values) > 1:
        try:
            paths = roslib.packages.find_resource(values[0], values[1])
        except rospkg.ResourceNotFound:
            pass
    return paths


def _nodes(path):
    try:
        return list(ElementTree.parse(path).iter('node'))
    except (OSError, ElementTree.ParseError):
        return []  # roslaunch will say what is wrong with it


def _find(package='', name=''):
    try:
        return roslib.packages.find_node(package, name) if package and name else []
    except rospkg.ResourceNotFound:
        return []


def _is_python(path):
    try:
        with open(path, 'rb') as file:
            return b'python' in file.readline()
    except OSError:
        return False
