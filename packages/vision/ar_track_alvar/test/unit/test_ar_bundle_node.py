"""ar_track_alvar.bundle_node: reading bundle files, and the examples in the package."""
from types import SimpleNamespace

import pytest
import rospy

from alvar_core import bundles, drawing
from alvar_core.printing import create_marker
from ar_track_alvar import bundle_node
from ar_track_alvar.bundle_node import MIRRORED
from rospy_support.parameters import ParameterError
from unit_support import REPOSITORY

FOLDER = REPOSITORY / 'packages' / 'vision' / 'ar_track_alvar' / 'bundles'
EXAMPLES = sorted(FOLDER.glob('*.xml'))


@pytest.fixture
def warnings(monkeypatch):
    said = []
    monkeypatch.setattr(rospy, 'loginfo', lambda *words: None)
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *words: said.append(text % words))
    return said


@pytest.mark.parametrize('path', EXAMPLES, ids=lambda path: path.name)
def test_examples_are_sound(path, warnings):
    bundle, = bundle_node.read_bundles(str(path))
    assert warnings == [] and len(bundle.corners) == len(bundle.ids) >= 2
    assert bundle.corners[bundle.master] == pytest.approx(drawing.object_corners(0.044), abs=1e-9)


def test_board_is_what_createmarker_makes_of_the_line_in_it():
    from alvar_core.printing import marker_files
    text = (FOLDER / 'board.xml').read_text()
    line = text[text.index('createMarker') + len('createMarker'):text.index(';')].split()
    markers = create_marker.CommandLine(line).markers
    made = marker_files.bundle_corners(marker_files.placed(markers))
    known = bundles.read(FOLDER / 'board.xml').corners
    assert list(made) == list(known) and all(made[n] == pytest.approx(known[n], abs=1e-9) for n in made)


def test_names_with_blanks(tmp_path, warnings):
    path = tmp_path / 'a board.xml'
    path.write_text((FOLDER / 'board.xml').read_text())
    assert [b.master for b in bundle_node.read_bundles(f'"{path}" {FOLDER}/post.xml')] == [8, 0]


def test_shared_markers_and_odd_files_are_warned_of(tmp_path, warnings):
    text = (FOLDER / 'board.xml').read_text()
    (tmp_path / 'other.xml').write_text(text.replace('"8"', '"50"').replace('markers="4"', 'markers="3"'))
    known = bundle_node.read_bundles(f'{FOLDER}/board.xml {tmp_path}/other.xml')
    assert [bundle.master for bundle in known] == [8, 50]
    assert warnings[0].startswith(f'Bundle file {tmp_path}/other.xml: 4 <marker> elements, but markers="3"')
    assert [text.split(';')[0] for text in warnings[1:]] == [
        f'Marker {n} belongs to {FOLDER}/board.xml and {tmp_path}/other.xml' for n in (9, 10)]


def test_sizes_are_those_of_the_first_bundle():
    small, large = (bundles.Bundle('', 1, (1, n), {1: drawing.object_corners(side), n: drawing.object_corners(side)})
                    for n, side in ((2, 0.05), (3, 0.1)))
    assert bundle_node.sizes_of([small, large]) == pytest.approx({1: 0.05, 2: 0.05, 3: 0.1})


@pytest.mark.parametrize('seen, told', [
    ((8, 9), ''), ([MIRRORED[8]], ''), ([MIRRORED[8], 200], ''), ([MIRRORED[8], MIRRORED[10]], 'mirror images')])
def test_mirrored_markers_are_warned_of(seen, told, warnings, monkeypatch):
    """Of one marker, another number would be as likely; 200 is in no bundle, nor is its mirror image."""
    node, said = object.__new__(bundle_node.BundleNode), []
    node._known = bundle_node.read_bundles(str(FOLDER / 'board.xml'))
    monkeypatch.setattr(node, 'complain', lambda _, text: said.append(text), raising=False)
    node._notice_mirrored([SimpleNamespace(id=number) for number in seen])
    assert [told in text for text in said] == [True] * bool(told)


@pytest.mark.parametrize('names, said', [
    ('', 'bundle_files must be set: the XML files'),
    ('  ', 'bundle_files must be set'),
    ('/no/such.xml', "bundle_files is '/no/such.xml': bundle file /no/such.xml cannot be read: No such file"),
    ('"half', 'No closing quotation; quote names with spaces as in a shell'),
])
def test_what_is_refused(names, said):
    with pytest.raises(ParameterError) as refused:
        bundle_node.read_bundles(names)
    assert said in str(refused.value)
