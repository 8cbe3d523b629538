"""Bundle files: the original's form, its oddities, and every way in which one can be wrong."""
import numpy as np
import pytest

from alvar_core import bundles, drawing

MARKER = '''<marker index="{0}" status="{1}">
    <corner x="-2.2" y="-2.2" z="0.0" /><corner x="2.2" y="-2.2" z="0.0" />
    <corner x="2.2" y="2.2" z="0.0" /><corner x="-2.2" y="2.2" z="0.0" />
</marker>'''
# on the side of a post, seen when the master is turned by 90 degrees about y
SIDEWAYS = '''<marker index="2" status="2">
    <corner x="2.5" y="-2.2" z="-0.3" /> <corner x="2.5" y="-2.2" z="-4.7" />
    <corner x="2.5" y="2.2" z="-4.7" /> <corner x="2.5" y="2.2" z="-0.3" />
</marker>'''


def text_of(*markers, count=None):
    lines = ['<?xml version="1.0" encoding="UTF-8" standalone="no" ?>',
             f'<multimarker markers="{count or len(markers)}">', *markers]
    return '\n'.join(lines) + '</multimarker>'


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / 'some.xml'
        path.write_text(text)
        return bundles.read(path)
    return read_text


def test_markers_of_a_post(read):
    bundle = read(text_of(MARKER.format(7, 2), SIDEWAYS))
    assert (bundle.master, bundle.ids, bundle.notes) == (7, (7, 2), ())
    assert bundle.corners[7] == pytest.approx(drawing.object_corners(0.044))
    rotation, position = bundles.marker_pose(bundle.corners[2])
    # its x points away along -z, its y up, so that it looks along x
    assert rotation == pytest.approx(np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), abs=1e-12)
    assert position == pytest.approx([0.025, 0, -0.025])
    assert bundle.sizes == pytest.approx({7: 0.044, 2: 0.044})


def test_what_is_written_is_read_again(read):
    corners = {3: drawing.object_corners(0.05) + [0.1, -0.2, 0.3], 1: drawing.object_corners(0.1)}
    bundle = read(bundles.xml(corners))
    assert bundle.master == 3 and bundle.ids == (3, 1)
    for index in (3, 1):
        assert bundle.corners[index] == pytest.approx(corners[index], abs=1e-9)


def test_a_marker_of_unknown_place_belongs_to_the_bundle(read):
    bundle = read(text_of(MARKER.format(7, 1), '<marker index="9" status="0"/>'))
    assert bundle.ids == (7, 9) and set(bundle.corners) == {7}


def test_more_markers_than_announced_are_ignored(read):
    bundle = read(text_of(MARKER.format(7, 1), SIDEWAYS, count=1))
    assert bundle.ids == (7,)
    assert bundle.notes == ('2 <marker> elements, but markers="1": those after the first 1 are ignored, as in '
                            'the original',)


def test_the_corner_that_createmarker_lost_is_completed(read):
    lost = MARKER.format(7, 1).replace('<corner x="-2.2" y="-2.2" z="0.0" />', '<corner x="0" y="0" z="0" />')
    bundle = read(text_of(lost))
    assert bundle.corners[7] == pytest.approx(drawing.object_corners(0.044))
    note, = bundle.notes
    assert note.startswith('marker 1 (index 7): the first corner lies at the centre')


def test_corners_that_are_not_a_square_are_noted(read):
    bundle = read(text_of(MARKER.format(7, 1).replace('x="2.2" y="2.2"', 'x="2.2" y="3.2"')))
    assert bundle.notes == ('marker 1 (index 7): the corners are not a square; the sides are 4.4, 5.4, 4.512, 4.4 cm, '
                            'its diagonals 6.966, 6.223 cm',)


GOOD = text_of(MARKER.format(7, 1), SIDEWAYS)


@pytest.mark.parametrize('right, wrong, said', [
    (GOOD, '', ': not XML: no element found: line 1, column 0'),
    ('</multimarker>', '', ': not XML: no element found: line 10'),
    ('UTF-8', 'no-such', ': not XML: unknown encoding'),
    ('multimarker', 'multi', '<multi>: the outermost element must be <multimarker markers="NUMBER OF MARKERS">'),
    (' markers="2"', '', '<multimarker>: markers is missing; a whole number of at least 1 is needed'),
    ('markers="2"', 'markers="two"', '<multimarker>: markers="two": a whole number of at least 1'),
    ('markers="2"', 'markers="3"', '<multimarker>: markers="3", but there are 2 <marker> elements'),
    ('index="7"', '', 'marker 1: index is missing'),
    ('index="7"', 'index="-7"', 'marker 1: index="-7": a whole number from 0 to 4294967295'),
    ('index="7"', 'index="2"', 'marker 2: index="2" appears twice'),
    ('status="2"', '', 'marker 2 (index 2): status is missing'),
    ('status="2"', 'status="1.5"', 'marker 2 (index 2): status="1.5": a whole number of at least 0'),
    ('<corner x="2.5" y="-2.2" z="-0.3" />', '', 'marker 2 (index 2): 3 <corner> elements; four are needed'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="2.5" y="-2.2"', 'marker 2 (index 2), corner 2: z is missing; a number of centi'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="2,5" y="-2.2" z="-4.7"', 'corner 2: x="2,5": a number of centimetres from'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="nan" y="-2.2" z="-4.7"', 'corner 2: x="nan": a number'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="1e300" y="-2.2" z="-4.7"', 'corner 2: x="1e300": a number'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="2.5" y="-2.2" z="-0.3"', 'marker 2 (index 2): the corners are not a square: two'),
    ('x="2.5" y="-2.2" z="-4.7"', 'x="2.5" y="2.2" z="-0.3"', 'marker 2 (index 2): the corners are not a square: two'),
])
def test_what_is_wrong_is_named(read, tmp_path, right, wrong, said):
    assert right in GOOD
    with pytest.raises(bundles.BundleError) as refused:
        read(GOOD.replace(right, wrong))
    assert str(refused.value).startswith(f'bundle file {tmp_path}/some.xml') and said in str(refused.value)


def test_only_unknown_places(read):
    with pytest.raises(bundles.BundleError, match='every marker has status="0"'):
        read(text_of('<marker index="9" status="0"/>'))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(bundles.BundleError, match='no.xml cannot be read: No such file or directory'):
        bundles.read(tmp_path / 'no.xml')
    (tmp_path / 'bytes.xml').write_bytes(bytes(range(256)))
    with pytest.raises(bundles.BundleError, match='bytes.xml: not XML'):
        bundles.read(tmp_path / 'bytes.xml')
