"""What the source of a program shows before it runs: whether it uses the wall clock, and which simulators it starts.

Simulated time may pass faster only if the program follows it. rospy.sleep, Rate, Timer and Time do; the calls searched
for here do not. Python programs are searched with their own modules, launch files with the files that they include.
"""
import ast
import contextlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import roslib.packages
import rospkg

WALL_CLOCK = re.compile(
    r'time\.(sleep|time|monotonic|perf_counter)(_ns)?|datetime(\.datetime)?\.(now|utcnow|today)|threading\.Timer|'
    r'rospy\.(client\.)?wait_for_message|rospy\.rostime\.wallsleep|asyncio\.\w+|sched\.scheduler|select\.select|'
    r'signal\.(alarm|setitimer)|subprocess\.\w+|os\.(system|popen)|cv2\.waitKey(Ex)?')
COMMANDS = ('rostopic', 'rosservice', 'sleep', 'timeout')  # that follow the wall clock, rostopic's rates too
SHELLS = ('sh', 'bash', 'dash', 'zsh')
SHELL = re.compile(rb'#!\s*\S*/(env\s+)?(ba|da|z)?sh\b')
EXECUTABLE_PYTHON = re.compile(rb'#!\s*/usr/bin/(env\s+)?python3\n')
COMPILED = re.compile(rb'\x7fELF')
SIMULATORS = {('turtlesim', 'turtlesim_node'), ('robotont_gazebo', 'robotont_gazebo')}  # package, executable
OWN = 'turtle_robotont'  # the package whose modules look at the wall clock for their timeouts alone
FOUND = re.compile(r'\$\((find|dirname)\s*([\w-]*)\)')


def looks_at_the_wall_clock(command):
    """Return the wall-clock call in a program that ``command`` starts, also by rosrun or roslaunch; '' if none."""
    tool = os.path.basename(command[0])
    if tool in COMMANDS:
        return tool
    if tool in SHELLS:
        return _first(_shell(part) if os.path.isfile(part) else _lines([part]) for part in command[1:])
    read = set()
    return _first(_shell(path) if _begins(path, SHELL) else _python(path, read) for path in _programs(command))


def source(command):
    """Return the text of the Python programs that ``command`` starts, without their own modules."""
    texts = []
    for path in _programs(command):
        if not _begins(path, SHELL):
            with contextlib.suppress(OSError), open(path, encoding='utf-8', errors='replace') as file:
                texts.append(file.read())
    return '\n'.join(texts)


def compiled(command):
    """Return the name of a compiled executable that ``command`` starts, which cannot be searched; '' if none."""
    found = [path for node in _started(command) for path in _find(*node)]
    own = [command[0]] if os.path.isabs(command[0]) and command[0] != sys.executable else []
    return next((os.path.basename(path) for path in own + found if _begins(path, COMPILED)), '')


def resolved(command):
    """Return a rosrun line as the Python program that rosrun would execute, which takes it 0.4 s to find.

    What is unusual is left to rosrun: options, no executable of that name, or several, among which it asks to choose.
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


def _first(texts):
    """Return the first of some texts that is not empty, or ''."""
    return next(filter(None, texts), '')


def simulators(command):
    """Return the simulators, as [package/executable], that a rosrun or roslaunch line starts."""
    return [f'{package}/{name}' for package, name in _started(command) if (package, name) in SIMULATORS]


def _programs(command):
    """Return the paths of the Python programs and shell scripts that a command starts, as far as they can be found."""
    found = [path for node in _started(command) for path in _find(*node)]
    scripts = [part for part in command if part.endswith('.py') or os.path.isfile(part) and _begins(part, SHELL)]
    return scripts + [path for path in found if _begins(path, re.compile(b'.*python')) or _begins(path, SHELL)]


def _started(command):
    """Return [(package, executable)] of what rosrun or roslaunch starts."""
    tool, values = os.path.basename(command[0]), [part for part in command[1:] if not part.startswith('-')]
    if tool == 'rosrun' and len(values) > 1:
        return [tuple(values[:2])]
    return [node for path in _launch_files(values) for node in _nodes(path, set())] if tool == 'roslaunch' else []


def _launch_files(values):
    """Return the paths of the launch files that roslaunch takes: FILE ... or PACKAGE FILE."""
    paths = [value for value in values if os.path.isfile(value)]
    if not paths and len(values) > 1:
        try:
            paths = roslib.packages.find_resource(values[0], values[1])
        except rospkg.ResourceNotFound:
            pass
    return paths


def _nodes(path, seen):
    """Return [(package, executable)] of a launch file and those that it includes."""
    try:
        elements = [] if path in seen else list(ElementTree.parse(path).iter())
    except (OSError, ElementTree.ParseError):
        return []  # roslaunch will say what is wrong with it
    seen.add(path)
    found = [(element.get('pkg', ''), element.get('type', '')) for element in elements if element.tag == 'node']
    for element in elements:
        if element.tag == 'include':
            found += _nodes(FOUND.sub(lambda match: _place(match, path), element.get('file', '')), seen)
    return found


def _place(match, path):
    """Return the folder that $(find PACKAGE) or $(dirname) in a launch file means; '' when there is none."""
    try:
        return rospkg.RosPack().get_path(match[2]) if match[1] == 'find' else os.path.dirname(os.path.abspath(path))
    except rospkg.ResourceNotFound:
        return ''


def _find(package='', name=''):
    try:
        return roslib.packages.find_node(package, name) if package and name else []
    except rospkg.ResourceNotFound:
        return []


def _begins(path, pattern):
    """Return whether the first line of a file matches."""
    try:
        with open(path, 'rb') as file:
            return bool(pattern.match(file.readline()))
    except OSError:
        return False


def _shell(path):
    """Return the wall-clock command in a shell script."""
    with open(path, encoding='utf-8', errors='replace') as file:
        return _lines(file.read().splitlines())


def _lines(lines):
    """Return the wall-clock command in the lines of a shell script."""
    for line in lines:
        try:
            words = shlex.split(line, comments=True)
        except ValueError:  # a quotation that ends on another line
            words = line.split()
        found = next((word for word in words if word in COMMANDS), '')
        if found or (words and (found := looks_at_the_wall_clock(words))):
            return found
    return ''


def _python(path, read):
    """Return the wall-clock call in a Python program or in its own modules."""
    path = os.path.realpath(path)
    try:
        with open(path, 'rb') as file:
            tree = ast.parse(b'' if path in read else file.read())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return ''  # Python will say what is wrong with it
    read.add(path)
    names = _imported(tree)
    for node in ast.walk(tree):
        found = _dotted(node, names)
        if WALL_CLOCK.fullmatch(found) or _waits(node):
            return found or 'a wait with a time limit'
    modules = [there for name in names.values() for there in _modules(name, path)]
    relayed = [node.value.value for node in ast.walk(tree)  # catkin's devel space: the program that is meant
               if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
               and [getattr(target, 'id', '') for target in node.targets] == ['python_script']]
    return _first(_python(there, read) for there in modules + relayed)


def _imported(tree):
    """Return {name in the program: what it stands for} of all imports."""
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
    """Return the files, beside a program or in its package's src, of a module (or of what is imported from it)."""
    folders = list(pathlib.Path(path).parents)
    roots = folders[:1] + [folder / 'src' for folder in folders if (folder / 'package.xml').is_file()][:1]
    places = [root.joinpath(*name.split('.')[:length]) for root in roots for length in range(1, name.count('.') + 2)]
    return [str(file) for place in places for file in (place.with_suffix('.py'), place / '__init__.py')
            if file.is_file() and not any(folder.name == OWN and (folder / '__init__.py').exists()
                                          for folder in file.parents)]
