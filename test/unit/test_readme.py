"""The pages that describe nodes agree with the code: parameters, topics, services, launch files, commands.

The nodes of the course are described in docs/nodes.md, with its launch files; a stand-in describes itself.
"""
import ast
import importlib.machinery
import importlib.util
import os
import re
import subprocess

import pytest

from rospy_support.parameters import Boolean, Computed, Integer, Number, Numbers, Table, Text
from rostest_support.node_pages import (
    NAME_COLUMNS,
    PAGES,
    PARAMETER_COLUMNS,
    names,
    page_of,
    page_path,
    sections,
    table,
)
from turtle_robotont import params
from turtle_robotont.driving import shapes
from turtle_robotont.markers.sightings import AXES
from unit_support import REPOSITORY

README = (REPOSITORY / 'README.md').read_text(encoding='utf-8')
LAUNCH_PAGE = (REPOSITORY / 'docs' / 'nodes.md').read_text(encoding='utf-8')
PROGRAMS_PAGE = (REPOSITORY / 'docs' / 'programs.md').read_text(encoding='utf-8')  # README.md links it
BROWSER_PAGE = (REPOSITORY / 'docs' / 'browser.md').read_text(encoding='utf-8')  # README.md links it
NODE_PAGES = {folder: path.read_text(encoding='utf-8') for folder, path in PAGES.items()}
OF_RUN = 'demo', 'demo.py', 'grade', 'grade.py', 'index_bag', 'terminal'  # of ./run, and of the panel Start
TYPED_OTHERWISE = 'browser', 'marker_sequence'  # described under the names that are typed, as programs of the root
SCRIPTS = sorted(path for folder in (REPOSITORY / 'scripts', *REPOSITORY.glob('packages/**/scripts'))
                 for path in folder.iterdir() if path.is_file() and path.name not in (*OF_RUN, *TYPED_OTHERWISE))
LAUNCH_FILES = sorted([*REPOSITORY.glob('launch/*.launch'), *REPOSITORY.glob('packages/**/launch/*.launch'),
                       *REPOSITORY.glob('packages/tutorials/rospy_tutorials/[0-9]*/*.launch')])


def parameters_of(script):
    """Return the parameters that a script's node declares beside its main(); none for a script without a node."""
    loader = importlib.machinery.SourceFileLoader(f'script_{script.stem}', str(script))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module.main.__globals__.get('PARAMETERS', ()) if hasattr(module, 'main') else ()


def lesson_parameters(source):
    """Return {name: (default, Allowed)} of a lesson; a default that is not a literal is None."""
    tree, known = ast.parse(source), {**vars(params), 'shapes': shapes, 'AXES': AXES}
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and isinstance(node.value, ast.Tuple):
            known[node.targets[0].id] = ast.literal_eval(node.value)
    allowed = {keyword.arg: eval(ast.get_source_segment(source, keyword.value), known) for call in calls
               if getattr(call.func, 'id', '') == 'check_params' for keyword in call.keywords}
    defaults = {}
    for call in calls:
        if ast.get_source_segment(source, call.func) == 'rospy.get_param' and len(call.args) == 2:
            name, default = call.args[0].value.lstrip('~'), call.args[1]
            literal = not list(node for node in ast.walk(default) if isinstance(node, (ast.Name, ast.IfExp)))
            # A default that is computed, or that depends on the mode, takes words.
            defaults[name] = ast.literal_eval(default) if literal and name not in defaults else None
    return {name: (defaults.get(name, 'not read'), allowed.get(name)) for name in {*defaults, *allowed}}


def lesson_differences(parameters, text):
    """Return the errors in the parameter table of a lesson's section."""
    rows = {row['parameter'].strip('`~'): row for row in table(text, PARAMETER_COLUMNS)}
    wrong = [f'{name} is on one side only' for name in sorted(set(rows) ^ set(parameters))]
    for name in sorted(set(rows) & set(parameters)):
        row, (default, allowed) = rows[name], parameters[name]
        if default == 'not read' or allowed is None:
            wrong.append(f'{name}: the program has to check and to read it')
            continue
        if default is not None and not isinstance(default, list) and not same(row['default'], str(default).lower()):
            wrong.append(f'{name}: default is {row["default"]!r}, in the code {default!r}')
        kind, unit = re.fullmatch(r'(.*?)(?:, ([^\]]*))?', row['type']).groups('')
        if kind != allowed.kind or unit not in allowed.text:
            wrong.append(f'{name}: type is {row["type"]!r}, in the code {allowed.kind}: {allowed.text}')
        if row['range'] not in ('finite', 'inside the arena', 'a ROS name', 'true, false') and \
                row['range'].replace(' or more', '').replace(' each', '') not in allowed.text:
            wrong.append(f'{name}: range is {row["range"]!r}, in the code {allowed.text!r}')
    return wrong


def unchecked_parameters(source):
    """Return {name: default} of the private parameters that a lesson reads without check_params.

    A default that is computed is None.
    """
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)
             and isinstance(node.func, ast.Attribute) and node.func.attr == 'get_param']
    return {call.args[0].value: getattr(call.args[1], 'value', None) if len(call.args) > 1 else None
            for call in calls if call.args[0].value.startswith('~')}


def unchecked_differences(read, text):
    """Return the errors in the parameter tables of a lesson's section."""
    rows = {row['parameter'].strip('`'): row for row in table(text, PARAMETER_COLUMNS)}
    return ([f'{name} is missing' for name in sorted(set(read) - set(rows))]
            + [f'{name} is not in the code' for name in sorted(set(rows) - set(read))]
            + [f'{name}: default is {rows[name]["default"]!r}, in the code {read[name]!r}'
               for name in sorted(set(read) & set(rows))
               if read[name] is not None and not same(rows[name]['default'], str(read[name]))])


def expected_cells(parameter):
    """Return {column: expected text}; a column that needs words may have any text."""
    cells = {'range': parameter.range} if parameter.range else {}
    words = isinstance(parameter.default, list) and parameter.default and isinstance(parameter.default[0], list)
    if not words:
        default = str(parameter.default)
        cells['default'] = default.lower() if isinstance(parameter.default, bool) else default
    return cells


def parameter_differences(parameters, text):
    """Return the errors in the parameter tables of a section."""
    rows = {row['parameter'].strip('`'): row for row in table(text, PARAMETER_COLUMNS)}
    declared = {parameter.name: parameter for parameter in parameters}
    private = {name for name in declared if name.startswith('~')}
    wrong = [f'{name} is missing' for name in sorted(private - set(rows))]
    wrong += [f'{name} is not in the code' for name in sorted(set(rows) - private)]
    wrong += [f'{name} is not mentioned' for name in sorted(set(declared) - private) if f'`{name}`' not in text]
    for name in sorted(private & set(rows)):
        parameter, row = declared[name], rows[name]
        wrong += [f'{name}: {column} is {row[column]!r}, in the code {cell!r}'
                  for column, cell in expected_cells(parameter).items() if not same(row[column], cell)]
        kind = ('name', 'text') if parameter.kind == 'text' else (parameter.kind,)
        if not row['type'].startswith(kind) or not row['type'].endswith(parameter.unit) or not row['meaning']:
            wrong.append(f'{name}: type is {row["type"]!r}, in the code {parameter.kind} {parameter.unit}')
    return wrong


def same(cell, expected):
    """Return whether two cells say the same, numbers written in whatever way."""
    def parts(text):
        return [float(part) if re.fullmatch(r'-?\d+\.?\d*(e[+-]?\d+)?', part) else part for part in text.split()]
    return parts(cell) == parts(expected)


def package_of(path):
    """Return the folder of the package that a script or a launch file belongs to."""
    return path.parents[1]


each_package = pytest.mark.parametrize('package', list(NODE_PAGES), ids=lambda folder: folder.name)


@pytest.mark.parametrize('script', SCRIPTS, ids=lambda script: script.name)
def test_parameters_of_a_node_are_described_as_they_are(script):
    source, section = script.read_text(encoding='utf-8'), sections(page_of(script))[script.name]
    if 'import check_params' in source:
        assert lesson_differences(lesson_parameters(source), section) == []
    elif 'rospy.init_node' in source:
        assert unchecked_differences(unchecked_parameters(source), section) == []
    else:
        assert parameter_differences(parameters_of(script), section) == []


@pytest.mark.parametrize('script', SCRIPTS, ids=lambda script: script.name)
def test_services_that_a_node_calls_are_there(script):
    """Topics and services are compared with the running node: nodes_master_returns.test."""
    served = {(name, service) for page in NODE_PAGES.values() for name, kind, service in names(page)
              if kind == 'serves'}
    called = {(name, service) for name, kind, service in names(sections(page_of(script))[script.name])
              if kind == 'calls'}
    source = '\n'.join(path.read_text(encoding='utf-8') for folder in ('scripts', 'src')
                       for path in (package_of(script) / folder).rglob('*.py'))
    assert called <= served
    assert {name for name, _ in called if f"{name.split('/')[-1]}'" not in source} == set()


@each_package
def test_headings_are_those_of_nodes(package):
    described = {heading for heading, text in sections(NODE_PAGES[package]).items()
                 if table(text, PARAMETER_COLUMNS) or table(text, NAME_COLUMNS)}
    assert described <= {script.name for script in SCRIPTS if package_of(script) == package}


@pytest.mark.parametrize('launch_file', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_is_mentioned(launch_file):
    package = package_of(launch_file)
    assert launch_file.name in (LAUNCH_PAGE if package == REPOSITORY else NODE_PAGES.get(package, ''))


def test_every_stand_in_with_nodes_is_in_the_readme():
    pages = {page_path(script) for script in SCRIPTS} - {PAGES[REPOSITORY]}
    linked = set(re.findall(r'\(([^)]+)\)', README))
    for name, page in (('docs/programs.md', PROGRAMS_PAGE), ('docs/browser.md', BROWSER_PAGE)):
        if name in linked:
            linked |= {link.replace('../', '', 1) for link in re.findall(r'\(([^)]+)\)', page)}
    for room in [link for link in linked if re.fullmatch(r'packages/\w+/README\.md', link)]:
        page = (REPOSITORY / room).read_text(encoding='utf-8')
        linked |= {os.path.join(os.path.dirname(room), link) for link in re.findall(r'\(([^)]+)\)', page)}
    assert {str(page.relative_to(REPOSITORY)) for page in pages} <= linked


def test_commands_are_described():
    printed = subprocess.run(['bash', str(REPOSITORY / 'run'), 'help'], stdout=subprocess.PIPE, check=True, timeout=60)
    listed = re.findall(r'^  ([a-z]+) ', printed.stdout.decode(), re.MULTILINE)
    commands = set(listed)
    assert len(commands) > 5 and len(listed) == len(commands)
    assert set(re.findall(r'^\| `\./run ([a-z]+)', README, re.MULTILINE)) == commands - {'help'}
    assert set(re.findall(r'\./run ([a-z]+)', README)) <= commands


SAMPLE = Table(Number('~size', 2.0, minimum=0.5, unit='m'), Integer('~r', 1, 0, 255), Integer('~g', 2, 0, 255),
               Text('~shape', 'square', ('square', 'dot')), Table(Boolean('~off', False), Number('scale', 1.0)),
               Numbers('~corners', [[1, 2]], unit='m'), Text('~folder', Computed('the working directory')))
SAMPLE_README = '''
| parameter | type | default | range | meaning |
|---|---|---|---|---|
| `~size` | float, m | 2.0 | 0.5 or more | side; `scale` |
| `~r` | int | 1 | 0 to 255 | red |
| `~g` | int | 2 | 0 to 255 | green |
| `~shape` | text | square | square, dot | what |
| `~off` | bool | false | true, false | off |
| `~corners` | list of [x, y], m | a square | inside the arena | where |
| `~folder` | text | the working directory | a folder | where files go |
'''


@pytest.mark.parametrize('right, wrong, message', [
    ('', '', []),
    ('`~off`', '`~on`', ['~off is missing', '~on is not in the code']),
    ('`scale`', '', ['scale is not mentioned']),
    ('| 2.0 |', '| 2 |', []),
    ('| false |', '| true |', ["~off: default is 'true', in the code 'false'"]),
    ('0.5 or more', '0.1 to 1', ["~size: range is '0.1 to 1', in the code '0.5 or more'"]),
    ('float, m', 'float, km/h', ["~size: type is 'float, km/h', in the code float m"]),
    ('| `~r` | int', '| `~r` | text', ["~r: type is 'text', in the code int "]),
    ('[x, y], m', '[x, y]', ["~corners: type is 'list of [x, y]', in the code list of m"]),
])
def test_every_difference_is_found(right, wrong, message):
    assert right in SAMPLE_README
    assert parameter_differences(SAMPLE, SAMPLE_README.replace(right, wrong, 1)) == message


LESSON = """turtle = rospy.get_param('~turtle', '')
size = rospy.get_param('~size', 2.0)
rate = rospy.get_param('~rate', best)
other = rospy.get_param('turtle', 'turtle2')
"""
LESSON_README = """
| parameter | type | default | range | meaning |
|---|---|---|---|---|
| `~turtle` | text |  | a name | which |
| `~size` | float, m | 2.0 | 0.5 or more | side |
| `~rate` | float, Hz | the best | 1 or more | how often |
"""


@pytest.mark.parametrize('right, wrong, message', [
    ('', '', []),
    ('`~size`', '`~side`', ['~size is missing', '~side is not in the code']),
    ('| 2.0 |', '| 3.0 |', ["~size: default is '3.0', in the code 2.0"]),
])
def test_differences_of_a_lesson_without_checks_are_found(right, wrong, message):
    assert unchecked_differences(unchecked_parameters(LESSON), LESSON_README.replace(right, wrong, 1)) == message
