"""Every number that decides what is found is in thresholds.py, and is used; the docs show those that matter."""
import ast
import pathlib
import re

import pytest

from alvar_core.detection import thresholds
from unit_support import REPOSITORY

TABLE = REPOSITORY / 'docs' / 'marker_thresholds.md'
FOLDER = pathlib.Path(thresholds.__file__).parent
NAMES = {name for name in vars(thresholds) if name.isupper()}
NO_THRESHOLDS = {
    'prepared_image.MIN_IMAGE_SIDE': 'smaller images are refused',
    'prepared_image.MOST': 'images kept for reuse',
    'alignment.DISTANCES': 'of the table of sample weights', 'alignment.WEIGHTS': 'of the table of sample weights',
    'local_contrast.ALONG': 'where contrasts are read', 'local_contrast.ACROSS': 'where contrasts are read',
    'glare.PER_CELL': 'samples that are read', 'glare.BINS': 'distances at which the light is measured',
    'pose.DEGREES_OF_FREEDOM': 'eight coordinates less six of a pose',
    'reading.DEPTHS': 'where the coarse decoding reads',
}


def is_number(node):
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return False
    flat = value if isinstance(value, (tuple, list)) else [value]
    return bool(flat) and all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in flat)


def constants(source):
    """Names of the numbers that a module or its classes define; a, b = 1, 2 are two."""
    found = []
    tree = ast.parse(source)
    bodies = [tree.body, *(node.body for node in tree.body if isinstance(node, ast.ClassDef))]
    for node in (node for body in bodies for node in body if isinstance(node, ast.Assign)):
        targets, values = [node.targets[0]], [node.value]
        if isinstance(targets[0], ast.Tuple) and isinstance(values[0], ast.Tuple):
            targets, values = targets[0].elts, values[0].elts
        found += [target.id for target, value in zip(targets, values)
                  if isinstance(target, ast.Name) and is_number(value)]
    return found


@pytest.mark.parametrize('source, names', [
    ('A = 1', ['A']), ('A, B = 0.5, -2', ['A', 'B']), ('A = (1, 2.0)', ['A']), ("A = 'x'", []), ('A = f(1)', []),
    ('class C:\n    A = 3', ['A']), ('def f():\n    a = 3', []), ('A = True', []),
])
def test_numbers_of_a_module_are_found(source, names):
    assert constants(source) == names


def test_every_threshold_of_the_detector_stands_there():
    elsewhere = {f'{path.stem}.{name}' for path in FOLDER.glob('*.py')
                 # numbers that judge point clouds, end a training, learn a camera's response, lay out an explanation or
                 # limit a photo stand with their code
                 if path.stem not in ('thresholds', 'depth', 'bundle_training', 'light', 'explanation',
                                      'explained_photo')
                 for name in constants(path.read_text(encoding='utf-8'))}
    assert elsewhere == set(NO_THRESHOLDS)


def numbers_of(name, value):
    """Yield (name as in the table, number) of a threshold and of what is in its tuples."""
    if not isinstance(value, tuple):
        yield name, value
        return
    fields = getattr(value, '_fields', None)
    for index, each in enumerate(value):
        yield from numbers_of(f'{name}.{fields[index]}' if fields else f'{name}[{index}]', each)


def test_each_is_used_and_nothing_else_is():
    sources = (*FOLDER.glob('*.py'), *(FOLDER.parents[2] / 'native').glob('*.cpp'))
    used = {name for path in sources for name in re.findall(r'\b(?:thresholds|limit)\.([A-Z][A-Z0-9_]*)',
                                                            path.read_text(encoding='utf-8'))}
    assert used == NAMES


def test_numbers_in_the_table_of_the_docs_are_those_of_the_detector():
    rows = dict(re.findall(r'^\| `([^`]+)` \| (\S+) \|', TABLE.read_text(encoding='utf-8'), re.M))
    numbers = {part: f'{number:.4g}' for name in NAMES for part, number in numbers_of(name, getattr(thresholds, name))}
    assert len(rows) > 30 and {part: numbers.get(part) for part in rows} == rows
