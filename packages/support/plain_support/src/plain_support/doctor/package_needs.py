"""What the ROS packages in a folder need, by their package.xml, CMakeLists.txt, launch files, C++ and Python files."""
import ast
import builtins
import os
import re
import warnings
from typing import Dict, Iterator, List, NamedTuple, Optional, Set, Tuple

LARGEST_FILE = 1 << 20  # [bytes]; a launch file or program is smaller
MAX_FILES = 20000
SKIPPED = {'build', 'devel', 'install', 'logs', '__pycache__', 'node_modules'}
BUILD, INCLUDE, RUN, IMPORT, LISTED = 'build', 'include', 'launch', 'import', 'package.xml'  # kinds of needs
LAUNCHES, CPP = ('.launch', '.test', '.xacro', '.urdf'), ('.cpp', '.cc', '.cxx', '.h', '.hpp', '.c')
DEPENDS = re.compile(r'<(?:build_|exec_|run_|build_export_)?depend\b[^>]*>\s*([\w.-]+)\s*<')
NAME = re.compile(r'<name>\s*([\w-]+)\s*</name>')
COMMENT = re.compile(r'<!--.*?-->', re.DOTALL)
CATKIN = re.compile(r'find_package\s*\(\s*catkin\b([^)]*)\)', re.IGNORECASE)
FOUND = re.compile(r'find_package\s*\(\s*(\w+)', re.IGNORECASE)
LAUNCHED = re.compile(r'\bpkg\s*=\s*["\']([\w-]+)["\']|\$\(find\s+([\w-]+)\s*\)')
INCLUDED = re.compile(r'^\s*#\s*include\s*[<"](\w+)/(?:[A-Z]\w*|cv_bridge)\.h[>"]', re.MULTILINE)  # mostly a message
OLD_MODULES = {  # of Python 2: their names today
    'Tkinter': 'tkinter', 'tkMessageBox': 'tkinter.messagebox', 'Queue': 'queue', 'ConfigParser': 'configparser',
    'StringIO': 'io', 'cStringIO': 'io', 'cPickle': 'pickle', 'thread': '_thread', 'commands': 'subprocess',
    'urllib2': 'urllib.request', 'urlparse': 'urllib.parse', 'httplib': 'http.client', 'SocketServer': 'socketserver',
    'BaseHTTPServer': 'http.server', 'SimpleHTTPServer': 'http.server', 'xmlrpclib': 'xmlrpc.client',
    'HTMLParser': 'html.parser', '__builtin__': 'builtins'}
OLD_NAMES = {'raw_input': 'input', 'xrange': 'range', 'unicode': 'str', 'basestring': 'str', 'long': 'int',
             'unichr': 'chr', 'execfile': 'exec', 'reduce': 'functools.reduce'}
OLD_METHODS = {'has_key': 'in', 'iteritems': 'items', 'itervalues': 'values', 'iterkeys': 'keys'}


class Needs(NamedTuple):
    """What was found: packages {name: folder}; needs {(name, kind): the first file}; launch files {file: names}.

    ``old`` {file: (line, what is of Python 2)}; ``programs``: all Python files.
    """

    packages: Dict[str, str]
    needs: Dict[Tuple[str, str], str]
    launch_files: Dict[str, Set[str]]
    old: Dict[str, Tuple[int, str]]
    programs: List[str]


def read(folder: str) -> Needs:
    """Return what the packages in a folder and below need, without what they have themselves."""
    found = Needs({}, {}, {}, {}, [])
    own: Set[str] = set()
    for path, text in _texts(folder):
        name, extension = os.path.basename(path), os.path.splitext(path)[1]
        if name == 'package.xml':
            text = COMMENT.sub('', text)
            match = NAME.search(text)
            found.packages[match[1] if match else os.path.basename(os.path.dirname(path))] = os.path.dirname(path)
            _add(found, path, LISTED, DEPENDS.findall(text))
        elif name == 'CMakeLists.txt':
            text = re.sub('#.*', '', text)
            _add(found, path, BUILD, [word for words in CATKIN.findall(text) for word in words.split()
                                      if re.fullmatch(r'[A-Za-z]\w*', word) and not word.isupper()])  # no keywords
            _add(found, path, BUILD, [package for package in FOUND.findall(text) if package.islower()])
        elif extension in LAUNCHES:
            names = {first or second for first, second in LAUNCHED.findall(COMMENT.sub('', text))}
            if extension == '.launch':
                found.launch_files[path] = names
            _add(found, path, RUN, sorted(names))
        elif extension in CPP:
            _add(found, path, INCLUDE, INCLUDED.findall(text))
        elif extension == '.py' or re.match(r'#!.*\bpython', text):
            own.update((os.path.splitext(name)[0], os.path.basename(os.path.dirname(path))))
            found.programs.append(path)
            _python(found, path, text)
    own.update(found.packages)
    for need in [need for need in found.needs if need[0] in own]:
        del found.needs[need]
    return found


def _texts(folder: str) -> Iterator[Tuple[str, str]]:
    count = 0
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if name not in SKIPPED and not name.startswith('.'))
        if 'CATKIN_IGNORE' in names:
            folders[:] = []
            continue
        for name in sorted(names):
            path = os.path.join(parent, name)
            count += 1
            if count > MAX_FILES:
                return
            if _may_need(name) and os.path.isfile(path) and os.path.getsize(path) <= LARGEST_FILE:
                with open(path, encoding='utf-8', errors='replace') as file:
                    yield path, file.read()


def _may_need(name: str) -> bool:
    extension = os.path.splitext(name)[1]
    return name in ('package.xml', 'CMakeLists.txt') or extension in (*LAUNCHES, *CPP, '.py', '')


def _add(found: Needs, path: str, kind: str, names: List[str]) -> None:
    for name in names:
        found.needs.setdefault((name, kind), path)


def _python(found: Needs, path: str, text: str) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')  # such as that of an invalid escape sequence
            tree: Optional[ast.AST] = ast.parse(text)
    except (SyntaxError, ValueError) as error:
        tree = None
        line = getattr(error, 'lineno', None) or 1
        found.old[path] = line, _no_python_3(text, line)
    if tree is None:  # a later line may import something all the same
        names = re.findall(r'^\s*(?:from|import)\s+(\w+)', text, re.MULTILINE)
    else:
        names = [alias.name.partition('.')[0] for node in ast.walk(tree) if isinstance(node, ast.Import)
                 for alias in node.names]
        names += [str(node.module).partition('.')[0] for node in ast.walk(tree)
                  if isinstance(node, ast.ImportFrom) and not node.level and node.module]
        old = min(_old(tree, text), default=None)
        if old and path not in found.old:
            found.old[path] = old
    _add(found, path, IMPORT, [name for name in names if name not in OLD_MODULES])


def _no_python_3(text: str, line: int) -> str:
    shown = (text.splitlines() or [''])[min(line, text.count('\n') + 1) - 1].strip()
    return f'{shown[:60]!r} is no Python 3'


def _old(tree: ast.AST, text: str) -> Iterator[Tuple[int, str]]:
    """Yield (line, what) of modules, functions and methods that only Python 2 has; not what ``try`` replaces.

    ``except OSError, error:`` is Python 3.14, too, where it means (OSError, error).
    """
    defined = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    defined |= {alias.asname or alias.name for node in ast.walk(tree)
                if isinstance(node, (ast.Import, ast.ImportFrom)) for alias in node.names}
    exceptions = defined | set(dir(builtins)) | {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    guarded = {id(inner) for node in ast.walk(tree) if isinstance(node, ast.Try) for inner in ast.walk(node)}
    for node in ast.walk(tree):
        if (isinstance(node, ast.ExceptHandler) and isinstance(node.type, ast.Tuple)
                and node.type.col_offset == node.type.elts[0].col_offset  # no parentheses
                and not {name.id for name in ast.walk(node.type) if isinstance(name, ast.Name)} <= exceptions):
            yield node.lineno, _no_python_3(text, node.lineno)
        if id(node) in guarded:
            continue
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or '']
            for module in set(modules) & set(OLD_MODULES):
                yield node.lineno, f'the module {module} is {OLD_MODULES[module]} today'
        elif isinstance(node, ast.Name) and node.id in OLD_NAMES and node.id not in defined:
            yield node.lineno, f'{node.id} is {OLD_NAMES[node.id]} today'
        elif isinstance(node, ast.Attribute) and node.attr in OLD_METHODS:
            yield node.lineno, f'.{node.attr}() is {OLD_METHODS[node.attr]} today'
