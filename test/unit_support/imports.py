"""What Python source imports and names. Each file is read and parsed once."""
import ast
import functools
import importlib.util
import pathlib
import sysconfig

OLDEST_PYTHON = (3, 8)  # that of Ubuntu 20.04, where ROS Noetic comes from
WITH_DOCSTRING = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef


def imported(source, package=''):
    """Return the dotted names of everything that Python source imports, wherever in it; of ``package`` itself."""
    return imports_in(ast.walk(ast.parse(source)), package)


def imports_in(nodes, package=''):
    """Return what ``imported`` does, of the nodes of parsed source."""
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = '.'.join(filter(None, (package if node.level else '', node.module)))
            names.update(f'{base}.{alias.name}' for alias in node.names)
    return names


def strings_in(nodes):
    """Return the strings among the nodes of parsed source that are not docstrings."""
    docstrings = {id(node.body[0].value) for node in nodes if isinstance(node, WITH_DOCSTRING)
                  and node.body and isinstance(node.body[0], ast.Expr)}
    return {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)
            and id(node) not in docstrings}


@functools.lru_cache(maxsize=None)
def tree_of(path):
    """Return the source of a Python file, parsed as the oldest Python does; raise SyntaxError if it would."""
    return ast.parse(path.read_text(encoding='utf-8'), str(path), feature_version=OLDEST_PYTHON)


@functools.lru_cache(maxsize=None)
def nodes_of(path):
    """Return all nodes of the parsed source of a Python file."""
    return tuple(ast.walk(tree_of(path)))


@functools.lru_cache(maxsize=None)
def imports_of(path):
    """Return the dotted names that a Python file imports."""
    return frozenset(imports_in(nodes_of(path), path.parent.name))


def top(name):
    return name.partition('.')[0]


def in_standard_library(name):
    return _in_standard_library(top(name))


@functools.lru_cache(maxsize=None)
def _in_standard_library(name):
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        return False
    if spec.origin in ('built-in', 'frozen'):
        return True
    folder = pathlib.Path(sysconfig.get_paths()['stdlib']).resolve()
    parents = pathlib.Path(spec.origin).resolve().parents
    return folder in parents and not any(parent.name in ('site-packages', 'dist-packages') for parent in parents)
