"""Every number that decides what is found is in thresholds.py, is used, swept, and documented."""
import ast
import pathlib
import re

import pytest

import sensitivity
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


def test_each_is_used_and_nothing_else_is():
    assert set(sensitivity.modules_using()) == NAMES


def test_each_is_swept():
    parts = sensitivity.parts()
    assert {part.threshold for part in parts} == NAMES and len({part.name for part in parts}) == len(parts) > 100
    for part in parts:
        assert sensitivity.changed(part, -1) != part.number != sensitivity.changed(part, 1)
        before = getattr(thresholds, part.threshold)
        with sensitivity.set_to(part, -7):
            inner = getattr(thresholds, part.threshold)
            for index in part.path:
                inner = inner[index]
            assert inner == -7 and type(getattr(thresholds, part.threshold)) is type(before) or not part.path
        assert getattr(thresholds, part.threshold) is before


def test_the_table_in_the_docs_is_of_these_numbers():
    rows = re.findall(r'^\| `([^`]+)` \| (\S+) \|', TABLE.read_text(encoding='utf-8'), re.M)
    assert rows == [(part.name, f'{part.number:.4g}') for part in sensitivity.parts()]
