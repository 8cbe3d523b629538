"""What Python source imports."""
import ast
import importlib.util
import pathlib
import sysconfig


def imported(source, package=''):
    """Return the dotted names of everything that Python source imports, wherever in it; of ``package`` itself."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = '.'.join(filter(None, (package if node.level else '', node.module)))
            names.update(f'{base}.{alias.name}' for alias in node.names)
    return names


def top(name):
    return name.partition('.')[0]


def in_standard_library(name):
    spec = importlib.util.find_spec(top(name))
    if spec is None or spec.origin is None:
        return False
    if spec.origin in ('built-in', 'frozen'):
        return True
    folder = pathlib.Path(sysconfig.get_paths()['stdlib']).resolve()
    parents = pathlib.Path(spec.origin).resolve().parents
    return folder in parents and not any(parent.name in ('site-packages', 'dist-packages') for parent in parents)
