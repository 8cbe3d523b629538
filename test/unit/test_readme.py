"""The pages that describe nodes agree with the code: parameters, topics, services, launch files, commands.

The nodes of the course are described in docs/nodes.md, its launch files in docs/course.md; a stand-in describes itself.
"""
import math
import pathlib
import re
import subprocess

import pytest

from unit_support.node_source import UNKNOWN, Node

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
README = (REPOSITORY / 'README.md').read_text(encoding='utf-8')
LAUNCH_PAGE = (REPOSITORY / 'docs' / 'course.md').read_text(encoding='utf-8')
NODE_PAGES = {REPOSITORY: (REPOSITORY / 'docs' / 'nodes.md').read_text(encoding='utf-8'),
              **{path.parent: path.read_text(encoding='utf-8') for path in sorted(REPOSITORY.glob('*/*/README.md'))}}
OF_RUN = 'demo.py', 'grade.py'  # ./run demo and ./run grade
SCRIPTS = sorted(path for folder in (REPOSITORY / 'scripts', *REPOSITORY.glob('stand_ins/*/scripts'))
                 for path in folder.iterdir() if path.is_file() and path.name not in OF_RUN)
LAUNCH_FILES = sorted([*REPOSITORY.glob('launch/*.launch'), *REPOSITORY.glob('stand_ins/*/launch/*.launch')])
PARAMETER_COLUMNS = ['parameter', 'type', 'default', 'range', 'meaning']
NAME_COLUMNS = ['name', 'kind', 'type', 'meaning']


def sections(readme):
    """Return {heading: text below it} of the headings ### of README."""
    return dict(re.findall(r'^### (\S+)\n(.*?)(?=^#{1,3} |\Z)', readme, re.MULTILINE | re.DOTALL))


def table(text, columns):
    """Return the rows of the tables with these columns, each as {column: cell}."""
    rows, inside = [], False
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip('|').split('|')] if line.startswith('|') else []
        if inside and cells and not set(line) <= set('|-: '):
            rows.append(dict(zip(columns, cells)))
        inside = bool(cells) and (inside or cells == columns)
    return rows


def expected_cells(parameter):
    """Return {column: what it must say}; where the code has no literal, any text will do."""
    cells = {}
    if parameter.choices:
        cells['range'] = ', '.join(parameter.choices)
    elif parameter.type == 'bool':
        cells['range'] = 'true, false'
    elif parameter.minimum is not None:
        cells['range'] = ', '.join(filter(None, (interval(parameter.minimum, parameter.maximum), parameter.infinite)))
    if parameter.default is not UNKNOWN:
        cells['default'] = str(parameter.default).lower() if parameter.type == 'bool' else str(parameter.default)
    return cells


def interval(low, high):
    """Return how README writes a range."""
    if low == -math.inf:
        return 'finite' if high == math.inf else f'{high:g} or less'
    return f'{low:g} or more' if high == math.inf else f'{low:g} to {high:g}'


def parameter_differences(node, text):
    """Return what the parameter tables of a section say wrong."""
    rows = {row['parameter'].strip('`'): row for row in table(text, PARAMETER_COLUMNS)}
    private = {name for name in node.parameters if name.startswith('~')}
    wrong = [f'{name} is missing' for name in sorted(private - set(rows))]
    wrong += [f'{name} is not in the code' for name in sorted(set(rows) - private)]
    wrong += [f'{name} is not mentioned' for name in sorted(set(node.parameters) - private) if f'`{name}`' not in text]
    for name in sorted(private & set(rows)):
        parameter, row = node.parameters[name], rows[name]
        for column, cell in expected_cells(parameter).items():
            if not same(row[column], cell) and not (cell.startswith('[[') and not row[column].startswith('[')):
                wrong.append(f'{name}: {column} is {row[column]!r}, in the code {cell!r}')
        kind = ('name', 'text') if parameter.type == 'text' else (parameter.type,)
        if not row['type'].startswith(kind) or not row['type'].endswith(parameter.unit) or not row['meaning']:
            wrong.append(f'{name}: type is {row["type"]!r}, in the code {parameter.type} {parameter.unit}')
    return wrong


def same(cell, expected):
    """Return whether two cells say the same, numbers written in whatever way."""
    def parts(text):
        return [float(part) if re.fullmatch(r'-?[\d.]+(e[+-]?\d+)?', part) else part for part in re.split(r'\s+', text)]
    return parts(cell) == parts(expected)


def name_differences(node, text, readme):
    """Return what the tables of topics and services say wrong; a section without one leaves them to others."""
    rows = {(row['name'].strip('`'), row['kind'], row['type']) for row in table(text, NAME_COLUMNS)}
    if not rows:
        return [f'{name} is not mentioned' for name, _, _ in sorted(node.names) if f'`{name}`' not in readme]
    return ([f'{" ".join(name)} is missing' for name in sorted(node.names - rows)]
            + [f'{" ".join(name)} is not in the code' for name in sorted(rows - node.names)])


def differences(script, readme):
    """Return all that README says wrong about a script."""
    if script.name not in sections(readme):
        return [f'there is no heading "### {script.name}"']
    node, text = Node(script), sections(readme)[script.name]
    return parameter_differences(node, text) + name_differences(node, text, readme)


def package_of(path):
    """Return the folder of the package that a script or a launch file belongs to."""
    return path.parents[1]


each_package = pytest.mark.parametrize('package', list(NODE_PAGES), ids=lambda folder: folder.name)


@pytest.mark.parametrize('script', SCRIPTS, ids=lambda script: script.name)
def test_node_is_described_as_it_is(script):
    assert differences(script, NODE_PAGES.get(package_of(script), '')) == []


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
    packages = {package_of(script) for script in SCRIPTS} - {REPOSITORY}
    assert {f'{path.relative_to(REPOSITORY)}/README.md' for path in packages} <= set(re.findall(r'\(([^)]+)\)', README))


def test_commands_are_described():
    printed = subprocess.run(['bash', str(REPOSITORY / 'run'), 'help'], stdout=subprocess.PIPE, check=True, timeout=60)
    listed = re.findall(r'^  ([a-z]+) ', printed.stdout.decode(), re.MULTILINE)
    commands = set(listed)
    assert len(commands) > 5 and len(listed) == len(commands)
    assert set(re.findall(r'^\| `\./run ([a-z]+)', README, re.MULTILINE)) == commands - {'help'}
    assert set(re.findall(r'\./run ([a-z]+)', README)) <= commands


SAMPLE_NODE = '''import rospy
from std_msgs.msg import Empty
from rospy_support import parameters
SIZE = 2.0
def main():
    parameters.number('~size', SIZE, minimum=0.5, unit='m')
    for channel, default in (('r', 1), ('g', 2)):
        parameters.integer(f'~{channel}', default, 0, 255)
    parameters.text('~shape', 'square', choices=('square', 'dot'))
    Helper(parameters.boolean('~off', False))
class Helper:
    def __init__(self, off):
        rospy.Publisher('begin', Empty, queue_size=1)
        self.later = lambda turtle: rospy.Service(f'{turtle}/end', Empty, None)
'''
SAMPLE_README = '''
### sample.py
| parameter | type | default | range | meaning |
|---|---|---|---|---|
| `~size` | float, m | 2.0 | 0.5 or more | side |
| `~r` | int | 1 | 0 to 255 | red |
| `~g` | int | 2 | 0 to 255 | green |
| `~shape` | text | square | square, dot | what |
| `~off` | bool | false | true, false | off |

| name | kind | type | meaning |
|---|---|---|---|
| `begin` | publishes | std_msgs/Empty | it begins |
| `turtle1/end` | serves | std_msgs/Empty | it ends |
## Next
'''


@pytest.mark.parametrize('right, wrong, said', [
    ('', '', []),
    ('| `~g` | int | 2 | 0 to 255 | green |\n', '', ['~g is missing']),
    ('`~off`', '`~on`', ['~off is missing', '~on is not in the code']),
    ('| 2.0 |', '| 2.5 |', ["~size: default is '2.5', in the code '2.0'"]),
    ('| 2.0 |', '| 2 |', []),
    ('| square |', '| dot |', ["~shape: default is 'dot', in the code 'square'"]),
    ('| false |', '| true |', ["~off: default is 'true', in the code 'false'"]),
    ('0.5 or more', '0.1 to 1', ["~size: range is '0.1 to 1', in the code '0.5 or more'"]),
    ('square, dot', 'square', ["~shape: range is 'square', in the code 'square, dot'"]),
    ('float, m', 'float, km/h', ["~size: type is 'float, km/h', in the code float m"]),
    ('| `~r` | int', '| `~r` | text', ["~r: type is 'text', in the code int "]),
    ('| `begin` | publishes | std_msgs/Empty | it begins |\n', '', ['begin publishes std_msgs/Empty is missing']),
    ('serves', 'calls', ['turtle1/end serves std_msgs/Empty is missing',
                         'turtle1/end calls std_msgs/Empty is not in the code']),
    ('std_msgs/Empty | it b', 'Empty | it b', ['begin publishes std_msgs/Empty is missing',
                                               'begin publishes Empty is not in the code']),
    ('sample.py', 'other.py', ['there is no heading "### sample.py"']),
])
def test_every_difference_is_found(right, wrong, said, tmp_path):
    script = tmp_path / 'sample.py'
    script.write_text(SAMPLE_NODE, encoding='utf-8')
    assert right in SAMPLE_README
    assert differences(script, SAMPLE_README.replace(right, wrong, 1)) == said
