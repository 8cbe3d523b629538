"""sim_scene.meshes and sdf: mesh files of a Gazebo world as boxes and walls, and notes about the others."""
import itertools
import math
import struct

import pytest

from sim_scene.sdf import read

LENGTH_TOLERANCE = 1e-6  # [m, rad]
# two triangles for each side of a box, as numbers of its corners 0 to 7: bit 2 of the number is x, bit 1 y, bit 0 z
SIDES = ((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
         (1, 5, 7), (1, 7, 3))
WALL = list(itertools.product((-0.05, 0.05), (-1.0, 1.0), (0.0, 0.5)))  # 0.1 x 2 x 0.5, its origin at the bottom
COLLADA = '''<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset><unit meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array>{numbers}</float_array></source><source id="n"><float_array>9 9 9</float_array></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene>
  <node><matrix>{matrix}</matrix><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes></COLLADA>'''


def stl(corners):
    triangles = [[corners[number] for number in side] for side in SIDES]
    return bytes(80) + struct.pack('<I', len(SIDES)) + b''.join(
        struct.pack('<12fH', 0, 0, 0, *itertools.chain(*triangle), 0) for triangle in triangles)


def stl_in_letters(corners):
    return 'solid wall\n' + ''.join('facet normal 0 0 0\nouter loop\n' + ''.join(
        f'vertex {x} {y} {z}\n' for x, y, z in (corners[number] for number in side)) + 'endloop\nendfacet\n'
        for side in SIDES)


def collada(corners, unit=1.0, up='Z_UP', matrix='1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'):
    numbers = ' '.join(f'{number / unit:g}' for number in itertools.chain(*corners))
    return COLLADA.format(unit=unit, up=up, numbers=numbers, matrix=matrix)


@pytest.fixture
def world(tmp_path, monkeypatch):
    """Return a function that writes a world with a wall of a mesh, 1 m ahead and turned by 0.3 rad, and reads it."""
    monkeypatch.delenv('GAZEBO_RESOURCE_PATH', raising=False)
    monkeypatch.delenv('GAZEBO_MODEL_PATH', raising=False)

    def write(content, file='meshes/wall.dae', uri='file://meshes/wall.dae', scale='1 1 1', turn='0 0 0.3'):
        if content is not None:
            (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
        path = tmp_path / 'worlds' / 'w.world'
        path.parent.mkdir(exist_ok=True)
        path.write_text(
            f'<sdf version="1.6"><world name="w"><model name="m"><link name="l"><pose>1 0 0 {turn}</pose>'
            f'<collision name="c"><geometry><mesh><uri>{uri}</uri><scale>{scale}</scale></mesh></geometry></collision>'
            '</link></model></world></sdf>', encoding='utf-8')
        return read(str(path))
    return write


@pytest.mark.parametrize('content, file', [
    (collada(WALL), 'meshes/wall.dae'), (collada(WALL, unit=0.01), 'meshes/wall.dae'), (stl(WALL), 'meshes/wall.stl'),
    (stl_in_letters(WALL), 'meshes/wall.STL'), (collada(WALL, up='Y_UP'), 'meshes/wall.dae'),  # as in Gazebo
])
def test_mesh_that_is_a_box_is_one(world, content, file):
    plan, warnings = world(content, file, f'file://{file}')
    (box,) = plan.boxes
    assert warnings == []
    assert box[1:-1] == pytest.approx((1.0, 0.0, 0.3, 0.1, 2.0, 0.5, 0.0), abs=LENGTH_TOLERANCE)


def test_scale_moves_the_middle_too(world):
    ahead = [(x + 1.0, y, z) for x, y, z in WALL]
    plan, warnings = world(collada(ahead), scale='2 0.5 3')
    (box,) = plan.boxes
    # the middle is 2 m ahead of the link, which looks 0.3 rad to the left
    assert box[1:-1] == pytest.approx((1.0 + 2.0 * math.cos(0.3), 2.0 * math.sin(0.3), 0.3, 0.2, 1.0, 1.5, 0.0),
                                      abs=LENGTH_TOLERANCE)
    assert warnings == []


@pytest.mark.parametrize('file, uri', [
    ('worlds/wall.dae', 'wall.dae'), ('worlds/meshes/wall.dae', 'file://meshes/wall.dae'),
    ('models/wall/wall.dae', 'model://wall/wall.dae'), ('elsewhere/wall/wall.dae', 'model://wall/wall.dae'),
])
def test_mesh_is_found(world, tmp_path, monkeypatch, file, uri):
    monkeypatch.setenv('GAZEBO_MODEL_PATH', f'/nowhere:{tmp_path}/elsewhere')
    plan, warnings = world(collada(WALL), file, uri)
    assert len(plan.boxes) == 1 and warnings == []


ROOF = [(x, 0.0 if z else y, z) for x, y, z in WALL]
UNDER_THE_FLOOR = [(x, y, z - 1.0) for x, y, z in ROOF]


def facets(triangles):
    """Return an STL file with these triangles."""
    return bytes(80) + struct.pack('<I', len(triangles)) + b''.join(
        struct.pack('<12fH', 0, 0, 0, *itertools.chain(*triangle), 0) for triangle in triangles)


def sheet(x, y, other_x, other_y, top=0.5):
    """Return the two triangles of an upright rectangle."""
    low, high = [(x, y, 0.0), (other_x, other_y, 0.0)], [(x, y, top), (other_x, other_y, top)]
    return [(*low, high[1]), (low[0], high[1], high[0])]


def posts(number):
    """Return an STL file with sheets 2 cm wide side by side."""
    return facets([triangle for k in range(number) for triangle in sheet(0.1 * k, 0.0, 0.1 * k + 0.02, 0.0)])


def test_walls_of_a_mesh_are_thin_boxes(world):
    """An L of two sheets, 2 m and 1 m long: each is one box, although it has two triangles."""
    plan, warnings = world(facets(sheet(0.0, 0.0, 2.0, 0.0) + sheet(2.0, 0.0, 2.0, 1.0, top=1.0)), 'meshes/wall.stl',
                           'file://meshes/wall.stl', turn='0 0 0')
    assert warnings == []
    long, short = sorted(plan.boxes, key=lambda box: -box.length)
    assert long[1:-1] == pytest.approx((2.0, 0.0, 0.0, 2.0, 0.02, 0.5, 0.0), abs=0.006)  # lines are 1 cm apart
    assert short[1:-1] == pytest.approx((3.0, 0.5, math.pi / 2.0, 1.0, 0.02, 1.0, 0.0), abs=0.006)


def test_triangles_of_collada_are_read_with_their_polygons(world):
    numbers = '0 0 0 2 0 0 2 0 0.5 0 0 0.5'
    text = COLLADA.format(unit=1.0, up='Z_UP', numbers=numbers, matrix='1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1').replace(
        '</mesh>', '<polylist><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" '
        'offset="1"/><vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist></mesh>')
    plan, warnings = world(text, turn='0 0 0')
    box, = plan.boxes
    assert warnings == [] and (box.length, box.height) == pytest.approx((2.0, 0.5), abs=0.006)


@pytest.mark.parametrize('node, bottom', [
    ('<matrix>1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1</matrix>', 2.0), ('<translate>0 0 1</translate>', 1.0),
    ('<scale>1 1 1</scale><translate>0 0 0.5</translate><rotate>0 0 1 180</rotate>', 0.5),
])
def test_nodes_of_collada_move_their_geometry(world, node, bottom):
    text = collada(WALL).replace('<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>', node)
    plan, warnings = world(text)
    box, = plan.boxes
    assert warnings == [] and box.bottom == pytest.approx(bottom, abs=LENGTH_TOLERANCE)


@pytest.mark.parametrize('content, file, said', [
    (None, 'meshes/wall.dae', 'there is no such file in '),
    (collada(ROOF), 'meshes/wall.dae', 'it is not a box, and has no triangles'),
    (collada(WALL[:4]), 'meshes/wall.dae', 'it is not a box, and has no triangles'),
    (stl(UNDER_THE_FLOOR), 'meshes/wall.stl', 'it is not a box, and no part of it stands 0.15 m above the floor'),
    (posts(310), 'meshes/wall.stl', 'it is not a box, and its outline 0.15 m above the floor has 31'),
    (collada([(math.nan, 0.0, 0.0)]), 'meshes/wall.dae', 'it has no vertices, or not all of them are finite'),
    (collada([]), 'meshes/wall.dae', 'it has no vertices'), (b'', 'meshes/wall.stl', 'it has no vertices'),
    (stl(WALL)[:-7], 'meshes/wall.stl', 'it has no vertices'),
    (collada([(1.0, 2.0, 3.0)]).replace('1 2 3', '1 2'), 'meshes/wall.dae', 'it cannot be read: '),
    ('<COLLADA', 'meshes/wall.dae', 'it cannot be read: '), ('v 1 2 3', 'meshes/wall.obj', 'only .stl and .dae'),
])
def test_other_meshes_are_left_out_with_the_reason(world, content, file, said):
    plan, (warning,) = world(content, file, f'file://{file}')
    assert plan.solids() == ()
    assert warning.startswith(f'm/l: <mesh> file://{file} is left out: {said}')


def test_leaning_mesh_is_left_out(world):
    plan, warnings = world(collada(WALL), turn='0.2 0 0')
    assert plan.solids() == () and warnings == ['m/l: the box is tilted; left out']
