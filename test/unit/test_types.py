"""Type hints: the folders that mypy checks, the reasons for the others, and the stubs of compiled modules."""
import ast
import configparser
import importlib
import re
import sys

import pytest

from unit_support import REPOSITORY

IGNORED = re.compile(r'#\s*type:\s*ignore.*')
WITH_REASON = re.compile(r'# type: ignore\[[a-z-]+(, [a-z-]+)*\]  # \S.*')


def settings():
    parser = configparser.ConfigParser()
    parser.read(REPOSITORY / 'mypy.ini')
    return parser['mypy']


def checked():
    """Return the paths of the folders and modules that mypy checks."""
    names = [name.strip() for name in settings()['files'].split(',')]
    assert all(any(REPOSITORY.glob(name)) for name in names)
    return [path for name in names for path in sorted(REPOSITORY.glob(name))]


MODULES = [module for path in checked() for module in (sorted(path.rglob('*.py')) if path.is_dir() else [path])]


def ignores_without_reason(source):
    return [found for found in IGNORED.findall(source) if not WITH_REASON.fullmatch(found)]


@pytest.mark.parametrize('source, wrong', [
    ('x = 1', 0), ('x = f()  # type: ignore[no-any-return]  # the stub is wrong', 0),
    ('x = f()  # type: ignore', 1), ('x = f()  # type: ignore[arg-type]', 1), ('x = f()  #type:ignore # why', 1),
])
def test_reason_of_an_ignore_is_seen(source, wrong):
    assert len(ignores_without_reason(source)) == wrong


def test_everything_is_strict():
    assert settings()['strict'] == 'True'
    assert len(MODULES) >= 60


def test_each_ignore_has_its_reason():
    found = {str(path): ignores_without_reason(path.read_text(encoding='utf-8')) for path in MODULES}
    assert {path: ignores for path, ignores in found.items() if ignores} == {}


# ------------------------------------------------------------------------------------------------------------ stubs

STUBS = sorted(REPOSITORY.glob('packages/*/*/src/*/_*.pyi'))


def stubbed(tree):
    """Return {name: arguments} of the functions of a stub, {class.name: arguments} of the methods."""
    found = {}
    for one in tree.body:
        if isinstance(one, ast.FunctionDef):
            found[one.name] = arguments_of(one.args)
        elif isinstance(one, ast.ClassDef) and not any(getattr(base, 'id', '') == 'Protocol' for base in one.bases):
            found.update({f'{one.name}.{each.name}': arguments_of(each.args) for each in one.body
                          if isinstance(each, ast.FunctionDef)})
    return found


def arguments_of(arguments):
    """Return a text of the names of arguments, of where keywords begin, and of which may be left out."""
    plain = [each.arg for each in arguments.args]
    optional = plain[len(plain) - len(arguments.defaults):] + [
        each.arg for each, default in zip(arguments.kwonlyargs, arguments.kw_defaults) if default]
    names = plain + ['*'] * bool(arguments.kwonlyargs) + [each.arg for each in arguments.kwonlyargs]
    return [f'{name}?' if name in optional else name for name in names if name != 'self']


def compiled(module):
    """Return the same of a module made by pybind11, whose documentation begins with the signature."""
    found = {}
    for name, one in public(module):
        if isinstance(one, type):
            methods = public(one)
            if one.__init__.__doc__.startswith('__init__('):  # else Python code cannot make one
                methods.append(('__init__', one.__init__))
            found.update({f'{name}.{own}': signature(each) for own, each in methods})
        else:
            found[name] = signature(one)
    return found


def public(one):
    return [(name, getattr(one, name)) for name in vars(one) if not name.startswith('_')]


def signature(one):
    """Return the arguments in the documentation; those of a property, which has none, are []."""
    arguments = re.match(r'\w+\((.*)\) -> ', getattr(one, '__doc__', None) or '')
    names = []
    for each in split(arguments[1]) if arguments else []:
        name, default = each.strip().partition(':')[0].partition('=')[0].strip(), '=' in each
        names += [f'{name}?' if default else name] * (name != 'self')
    return names


def split(text):
    """Return the parts of a text between the commas that are in no brackets."""
    parts, depth = [''], 0
    for letter in text:
        depth += (letter in '([{') - (letter in ')]}')
        parts = [*parts, ''] if letter == ',' and not depth else [*parts[:-1], parts[-1] + letter]
    return parts


@pytest.mark.parametrize('path', STUBS, ids=lambda path: path.parent.name)
def test_a_stub_says_what_the_compiled_module_has(path):
    tree = ast.parse(path.read_text(encoding='utf-8'))
    importlib.import_module(f'{path.parent.name}.native')  # it loads the module for this processor
    module = next(one for name, one in sys.modules.items() if name.startswith(f'{path.parent.name}.{path.stem}'))
    assert stubbed(tree) == compiled(module)
    undocumented = [one.name for one in tree.body
                    if isinstance(one, (ast.FunctionDef, ast.ClassDef)) and not ast.get_docstring(one)]
    assert undocumented == []
