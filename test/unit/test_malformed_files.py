"""Files that people write: a malformed one gives the documented error, which names the file, and nothing else happens.

hypothesis changes the files of this repository: a stretch of the text, or one value in a YAML file or XML element.
"""
import copy
import time
from xml.etree import ElementTree

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from alvar_core import bundles, marker_sequence
from course_grader.rules import exercise
from plain_support import documents
from sim_scene import worlds
from unit_support import REPOSITORY
from unit_support.course_files import EXERCISES
from usb_cam.core import calibration

pytestmark = pytest.mark.slow
MAX_TEXT = 1000  # characters of an error
TIME_LIMIT = 20.0  # [s] on a loaded machine, for a refusal that takes far less than 1 s
CAMERA = marker_sequence.calibration_yaml([500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0], [0.1] + [0.0] * 4)
SDF = '''<sdf version="1.6"><world name="w"><scene><background>0.1 0.2 0.3 1</background></scene>
<model name="m"><pose>1 2 0.5 0 0 0.3</pose><link name="l"><pose>0 0 0 0 0 0</pose>
<collision name="c"><geometry><box><size>1 0.1 1</size></box></geometry></collision>
<visual name="v"><material><diffuse>1 0 0 1</diffuse></material></visual></link></model>
<model name="n"><link name="l"><collision name="c"><geometry><cylinder><radius>0.5</radius><length>1</length></cylinder>
</geometry></collision></link></model>
<model name="p"><pose>-3 0 0 0 0 0</pose><link name="l"><visual name="v"><geometry><mesh>
<uri>model://ar/Marker7.dae</uri><scale>1 1 1</scale></mesh></geometry></visual></link></model>
<state><model name="m"><pose>1 3 0.5 0 0 0</pose></model></state></world></sdf>'''
WORLDS = str(REPOSITORY / 'packages/robotont/robotont_gazebo/worlds')


def texts(pattern):
    """Return the contents of files of this repository."""
    found = [path.read_text(encoding='utf-8') for path in sorted(REPOSITORY.glob(pattern))]
    assert found
    return found


KINDS = {  # kind: (ending, contents, how it is read, its error)
    'world': ('.yaml', texts('packages/robotont/robotont_gazebo/worlds/*.yaml'),
              lambda path: worlds.load_world(path, WORLDS), worlds.WorldError),
    'sdf': ('.world', [SDF], lambda path: worlds.load_world(path, WORLDS), worlds.WorldError),
    'exercise': ('.yaml', [path.read_text(encoding='utf-8') for path in EXERCISES.values()], exercise.load,
                 exercise.ExerciseError),
    'calibration': ('.yaml', [CAMERA], calibration.read, calibration.CalibrationError),
    'bundle': ('.xml', texts('packages/vision/ar_track_alvar/bundles/*.xml'), bundles.read, bundles.BundleError),
}
YAML_VALUES = st.sampled_from([
    None, True, [], {}, [1], {'a': 1}, '', 'x', '1', -1, 0, 1e400, float('nan'), 10 ** 400, -0.5, [[]], {'name': []},
    '\0', 'a' * 2000, list(range(300)), '9' * 5000 + ' s', '(' * 200])
XML_VALUES = st.sampled_from([
    '', ' ', 'x', '1', '-1', 'nan', 'inf', '1e400', '1 2', '0 0 0 0 0 0', '9' * 5000, '1_0', '\u0663', '[1, 2]',
    '1e308 1e308 1e308', '1e308 1e308 1e308 0 0 0', 'file://../..', 'model://' + 'a/' * 2000])


def check(kind, path, content):
    """Read a file of this content; return the text of the error, or None."""
    _, _, read, error = KINDS[kind]
    path.write_bytes(content if isinstance(content, bytes) else content.encode('utf-8', 'surrogatepass'))
    try:
        read(str(path))
    except error as refusal:
        assert str(path) in str(refusal)
        assert len(str(refusal)) < MAX_TEXT + len(str(path))
        return str(refusal)
    return None


@pytest.fixture(scope='module', params=KINDS)
def kind(request):
    return request.param


@pytest.fixture(scope='module')
def path(kind, tmp_path_factory):
    return tmp_path_factory.mktemp(kind) / f'file{KINDS[kind][0]}'


PUNCTUATION = st.text('[]{}:-&*!|>\'"%@`,?<>/= \n\t0e.', max_size=6)
FUZZED = settings(deadline=None, max_examples=40, report_multiple_bugs=False,
                  suppress_health_check=[HealthCheck.function_scoped_fixture])


def test_unchanged_files_are_read(kind, path):
    assert [check(kind, path, content) for content in KINDS[kind][1]] == [None] * len(KINDS[kind][1])


@given(data=st.data())
@FUZZED
def test_changed_text(kind, path, data):
    content = data.draw(st.sampled_from(KINDS[kind][1])).encode()
    begin = data.draw(st.integers(0, len(content)))
    end = data.draw(st.integers(begin, min(len(content), begin + 40)))
    new = data.draw(st.one_of(st.binary(max_size=6), PUNCTUATION.map(str.encode)))
    check(kind, path, content[:begin] + new + content[end:])


@given(data=st.data())
@FUZZED
def test_changed_value(kind, path, data):
    content = data.draw(st.sampled_from(KINDS[kind][1]))
    if KINDS[kind][0] == '.yaml':
        document = yaml.safe_load(content)
        if document is None:
            return
        holders = list(containers(document))
        holder = data.draw(st.sampled_from(holders))
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        if keys:
            holder[data.draw(st.sampled_from(keys))] = copy.deepcopy(data.draw(YAML_VALUES))
        check(kind, path, yaml.safe_dump(document))
        return
    root = ElementTree.fromstring(content)
    element = data.draw(st.sampled_from(list(root.iter())))
    if element.attrib and data.draw(st.booleans()):
        element.set(data.draw(st.sampled_from(sorted(element.attrib))), data.draw(XML_VALUES))
    elif data.draw(st.booleans()):
        element.text = data.draw(XML_VALUES)
    elif len(element):
        element.remove(data.draw(st.sampled_from(list(element))))
    check(kind, path, ElementTree.tostring(root))


def containers(document):
    """Yield all lists and mappings in a document."""
    if isinstance(document, (dict, list)):
        yield document
        for entry in document.values() if isinstance(document, dict) else document:
            yield from containers(entry)


BOMB = 'a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'a{n}: &a{n} [{", ".join([f"*a{n - 1}"] * 10)}]\n' for n in range(1, 12))
ENTITIES = ('<!DOCTYPE a [<!ENTITY a0 "ha">'
            + ''.join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12)) + ']>')


@pytest.mark.parametrize('yaml_text, xml_text, message', [
    ('[' * 5000, '<a>' * 5000, ['line 1']),
    ('[' * 5000 + ']' * 5000, '<sdf><world>' + '<model>' * 5000 + '</model>' * 5000 + '</world></sdf>', ['100']),
    ('- ' * 5000 + 'a', '<multimarker markers="1">' + '<marker>' * 5000 + '</marker>' * 5000 + '</multimarker>',
     ['100']),
    (BOMB, f'{ENTITIES}<sdf>&a11;</sdf>', []),
    ('a: &a [*a]', '<sdf xmlns:a="b" xmlns:a="b"/>', []),
    ('boxes: ' + 'x' * 1_100_000,
     '<!DOCTYPE a SYSTEM "file:///etc/passwd" [<!ENTITY a SYSTEM "file:///etc/passwd">]><sdf>&a;</sdf>', []),
    ('a: !!python/object/apply:os.system [true]', '<?xml version="1.0" encoding="nonsense"?><sdf/>', []),
    ('a: !!int x', '<sdf/>', []), ('a: !!timestamp x', '<a:sdf/>', []), ('a: 2001-99-99', '<world/>', []),
    ('a: ' + '9' * 5000, '', []), ('{[a]: b}', '\0', []), ('a: \0', '<sdf>\0</sdf>', []), ('\xff', '<sdf><world/>', []),
])
def test_files_that_are_made_to_hurt(kind, path, yaml_text, xml_text, message):
    begin = time.monotonic()
    text = check(kind, path, yaml_text if KINDS[kind][0] == '.yaml' else xml_text)
    assert text and time.monotonic() < begin + TIME_LIMIT
    assert all(word in text for word in message)


def test_bytes_that_are_no_text_and_an_empty_file(kind, path):
    for content in (b'\xff\xfe\x00', b'\x80abc', bytes(range(256))):
        assert check(kind, path, content)
    assert check(kind, path, b'') or kind == 'world'  # an empty world


def test_too_large(kind, path, monkeypatch):
    monkeypatch.setattr(documents, 'MAX_XML', 100)
    monkeypatch.setattr(documents, 'MAX_YAML', 100)
    assert 'too large; at most 0.0001 MB are allowed' in check(kind, path, KINDS[kind][1][-1] + ' ' * 100)


def test_aliases_and_small_things_are_allowed():
    assert documents.parse_yaml('a: &x {b: [1, 2]}\nc: *x\nd: {<<: *x, e: 3.5}') == {
        'a': {'b': [1, 2]}, 'c': {'b': [1, 2]}, 'd': {'b': [1, 2], 'e': 3.5}}
    assert documents.parse_yaml('') is None
    assert documents.parse_yaml('[' * 100 + ']' * 100)
    root = documents.parse_xml('<?xml version="1.0"?><!DOCTYPE a><a b="&lt;">x<c/>&amp;</a>')
    assert (root.tag, root.attrib, root.text, root[0].tail) == ('a', {'b': '<'}, 'x', '&')


@pytest.mark.parametrize('entry, message', [
    ('{name: [1, 2], x: 0, y: 0, yaw: 0, length: 1, width: 1, height: 1}',
     'boxes[0]: name is [1, 2]; it must be a string'),
    ('{name: a, x: [1, 2], y: 0, yaw: 0, length: 1, width: 1, height: 1}',
     'a: x is [1, 2]; it must be a finite number'),
    ('{name: a, x: 0, y: 0, yaw: 0, length: 1, width: 1, height: 1, colour: {r: 1}}',
     "a: colour is {'r': 1}; it must be"),
    ('[1]', 'boxes[0] is [1]; it must be a mapping'),
])
def test_a_world_names_place_value_and_what_is_allowed(tmp_path, entry, message):
    assert message in check('world', tmp_path / 'a.yaml', f'boxes: [{entry}]')
