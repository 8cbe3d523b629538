"""Analyses a program before it runs: whether it uses the wall clock, and which simulators it starts.

Simulated time may run faster only if the program follows it. rospy.sleep, Rate, Timer and Time do; the calls below do
not. Python programs are searched with their own modules, launch files with the files that they include.
"""
import ast
import os
import pathlib
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import roslib.packages
import rospkg

from course_grader.isolation.student_files import read

WALL_CLOCK = re.compile(
    r'time\.(sleep|time|monotonic|perf_counter)(_ns)?|datetime(\.datetime)?\.(now|utcnow|today)|threading\.Timer|'
    r'rospy\.(client\.)?wait_for_message|rospy\.rostime\.wallsleep|asyncio\.\w+|sched\.scheduler|select\.select|'
    r'signal\.(alarm|setitimer)|subprocess\.\w+|os\.(system|popen)|cv2\.waitKey(Ex)?')
COMMANDS = ('rostopic', 'rosservice', 'sleep', 'timeout')  # they follow the wall clock, as do rostopic's rates
SHELLS = ('sh', 'bash', 'dash', 'zsh')
SHELL = re.compile(rb'#!\s*\S*/(env\s+)?(ba|da|z)?sh\b')
EXECUTABLE_PYTHON = re.compile(rb'#!\s*/usr/bin/(env\s+)?python3\n')
COMPILED = re.compile(rb'\x7fELF')
SIMULATORS = {('turtlesim', 'turtlesim_node'), ('robotont_gazebo', 'robotont_gazebo'), ('gazebo_ros', 'gzserver'),
              ('gazebo_ros', 'gazebo')}  # package, executable
COURSE = 'turtle_robotont'  # its modules use the wall clock for timeouts only
MAX_FILES = 1000  # nodes, launch files, or lines of scripts that are searched
MAX_NAME = 1000  # characters of a dotted module name
FIRST_LINE = 256  # [bytes] that Linux reads of it
SUBSTITUTION = re.compile(r'\$\((find|dirname)\s*([\w-]*)\)')


def wall_clock_call(command):
    """Return the wall-clock call in a program that ``command`` starts, also by rosrun or roslaunch; '' if none."""
    commands, seen = [command], set()
    for words in commands:
        tool = os.path.basename(words[0])
        if tool in COMMANDS:
            return tool
        for part in words[1:] if tool in SHELLS else _programs(words):
            place = os.path.realpath(part)
            if place in seen:
                continue
            if tool in SHELLS or _begins(place, SHELL):
                seen.add(place)
                lines = _lines(_text(place) if os.path.isfile(place) else part)
                if found := next((word for line in lines for word in line if word in COMMANDS), ''):
                    return found
                commands += lines[:MAX_FILES - len(commands)]
            elif found := _python(place, seen):
                return found
    return ''


def source(command):
    """Return the text of the Python programs that ``command`` starts, without their own modules."""
    return '\n'.join(_text(path) for path in _programs(command) if not _begins(path, SHELL))


def compiled(command):
    """Return the name of a compiled executable, which cannot be searched, that ``command`` starts; '' if none."""
    found = _installed(command)
    own = [command[0]] if os.path.isabs(command[0]) and command[0] != sys.executable else []
    return next((os.path.basename(path) for path in own + found if _begins(path, COMPILED)), '')


def resolved(command):
    """Return a rosrun line as the Python program that rosrun would execute; rosrun takes 0.4 s to find it.

    Unusual lines are left to rosrun: options, no executable of that name, or several, among which it lets one choose.
    """
    if os.path.basename(command[0]) != 'rosrun' or len(command) < 3 or command[1].startswith('-') or '/' in command[2]:
        return command
    package, name, *arguments = command[1:]
    found = _find(package, name)
    if len(found) != 1 or not _begins(found[0], EXECUTABLE_PYTHON):
        return command
    below = subprocess.run(['find', '-L', rospkg.RosPack().get_path(package), '-name', name, '-type', 'f', '-perm',
                            '/111'], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False).stdout
    return [found[0], *arguments] if below.count(b'\n') <= 1 else command


def simulators(command):
    """Return the simulators, as [package/executable], that a rosrun or roslaunch line starts."""
    return [f'{package}/{name}' for package, name in _started(command) if (package, name) in SIMULATORS]


def _programs(command):
    """Return the paths of the Python programs and shell scripts that a command starts, if they can be found."""
    found = _installed(command)
    scripts = [part for part in command if part.endswith('.py') or os.path.isfile(part) and _begins(part, SHELL)]
    return scripts + [path for path in found if _begins(path, re.compile(b'.*python')) or _begins(path, SHELL)]


def _installed(command):
    """Return the paths of the executables that rosrun or roslaunch starts."""
    return [path for node in _started(command)[:MAX_FILES] for path in _find(*node)]


def _started(command):
    """Return [(package, executable)] that rosrun or roslaunch starts."""
    tool, values = os.path.basename(command[0]), [part for part in command[1:] if not part.startswith('-')]
    if tool == 'rosrun' and len(values) > 1:
        return [tuple(values[:2])]
    return _nodes(_launch_files(values)) if tool == 'roslaunch' else []


def _launch_files(values):
    """Return the paths of the launch files that roslaunch takes: FILE ... or PACKAGE FILE."""
    paths = [value for value in values if os.path.isfile(value)]
    if not paths and len(values) > 1:
        try:
            paths = roslib.packages.find_resource(values[0], values[1])
        except rospkg.ResourceNotFound:
            pass
    return paths


def _nodes(paths):
    """Return [(package, executable)] of launch files and those that they include."""
    found, seen, paths = [], set(), list(paths)
    for path in paths:
        if path in seen or len(seen) >= MAX_FILES:
            continue
        seen.add(path)
        try:
            elements = list(ElementTree.fromstring(read(path)).iter())
        except (ElementTree.ParseError, ValueError, LookupError):
            continue  # roslaunch reports what is wrong
        found += [(element.get('pkg', ''), element.get('type', '')) for element in elements if element.tag == 'node']
        if len(paths) < MAX_FILES:
            paths += [SUBSTITUTION.sub(lambda match, there=path: _place(match, there), element.get('file', ''))
                      for element in elements if element.tag == 'include']
    return found


def _place(match, path):
    """Return the folder of $(find PACKAGE) or $(dirname) in a launch file; '' if there is none."""
    try:
        packages = rospkg.RosPack.get_instance()  # cached, because finding packages takes long
        return packages.get_path(match[2]) if match[1] == 'find' else os.path.dirname(os.path.abspath(path))
    except rospkg.ResourceNotFound:
        return ''


def _find(package='', name=''):
    try:
        return roslib.packages.find_node(package, name, rospkg.RosPack.get_instance()) if package and name else []
    except rospkg.ResourceNotFound:
        return []


def _text(path):
    return read(path).decode('utf-8', 'replace').replace('\0', ' ')  # not allowed in file names


def _begins(path, pattern):
    return bool(pattern.match(b''.join(read(path, FIRST_LINE).partition(b'\n')[:2])))


def _lines(text):
    """Return the lines of a shell script as lists of words."""
    found = []
    for line in text.splitlines():
        try:
            found.append(shlex.split(line, comments=True))
        except ValueError:  # a quotation continues on another line
            found.append(line.split())
    return [words for words in found if words]


def _python(path, seen):
    """Return the wall-clock call in a Python program or in its own modules, other than those in ``seen``."""
    paths = [path]
    for path in paths:
        if path in seen:
            continue
        seen.add(path)
        try:
            tree = ast.parse(read(path))
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            continue  # Python reports what is wrong
        names = _imported(tree)
        for node in ast.walk(tree):
            found = _dotted(node, names)
            if WALL_CLOCK.fullmatch(found) or _waits(node):
                return found or 'a wait with a time limit'
        paths += [os.path.realpath(there) for name in names.values() for there in _modules(name, path)]
        paths += [os.path.realpath(node.value.value) for node in ast.walk(tree)  # a relay script of catkin: its program
                  if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
                  and isinstance(node.value.value, str) and os.path.isfile(node.value.value)
                  and [getattr(target, 'id', '') for target in node.targets] == ['python_script']]
    return ''


def _imported(tree):
    """Return {name in the program: full name} of all imports."""
    names = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update((alias.asname or alias.name.partition('.')[0],
                          alias.name if alias.asname else alias.name.partition('.')[0]) for alias in node.names)
            names.update((alias.name, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names.update((name, f'{node.module or ""}.{alias.name}'.lstrip('.')) for alias in node.names
                         for name in [alias.asname or alias.name])
            if (node.module, node.names[0].name) == ('time', '*'):
                names.update((name, f'time.{name}') for name in ('sleep', 'time'))
    return names


def _dotted(node, names):
    """Return the full name that a node of the tree uses, such as time.sleep, or ''."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.insert(0, node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return ''
    return '.'.join([names.get(node.id, node.id), *parts])


def _waits(node):
    """Return whether a call waits for an event, a queue or a thread with a time limit."""
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
        return False
    limited = any(keyword.arg == 'timeout' for keyword in node.keywords)
    return limited and node.func.attr in ('get', 'join') or node.func.attr == 'wait' and bool(node.args or limited)


def _modules(name, path):
    """Return the files of a module, or of a name imported from it, beside a program or in its package's src."""
    folders, found = list(pathlib.Path(path).parents), []
    for root in folders[:1] + [folder / 'src' for folder in folders if (folder / 'package.xml').is_file()][:1]:
        place = str(root)
        for part in name.split('.') if len(name) < MAX_NAME else ():
            place = os.path.join(place, part)
            found += filter(os.path.isfile, (f'{place}.py', os.path.join(place, '__init__.py')))
            if not os.path.isdir(place):
                break
    return [file for file in found if not any(folder.name == COURSE and (folder / '__init__.py').exists()
                                              for folder in pathlib.Path(file).parents)]
