"""sim_scene.sdf: the solids of Gazebo worlds, and notes about skipped parts."""
import math

import pytest

from kinematic_core.worlds.floor_plan import GREY, Box, Cylinder, Panel, corners
from plain_support import InvalidInput
from sim_scene.sdf import read
from sim_scene.worlds import WorldError, load_world

LENGTH_TOLERANCE = 1e-6  # [m, rad]
BOX = '<geometry><box><size>2 1 0.5</size></box></geometry>'
CYLINDER = '<geometry><cylinder><radius>0.5</radius><length>1</length></cylinder></geometry>'


@pytest.fixture
def world(tmp_path):
    """Return a function that writes a <world> and returns its path."""
    def write(text, sdf='<sdf version="1.6"><world name="w">{}</world></sdf>'):
        path = tmp_path / 'w.world'
        path.write_text(sdf.format(text), encoding='utf-8')
        return str(path)
    return write


def model(link, name='m', pose='', more=''):
    return f'<model name="{name}"><static>1</static>{pose and f"<pose>{pose}</pose>"}{more}{link}</model>'


def link(shape, pose='0 0 0.25 0 0 0', name='l'):
    return f'<link name="{name}"><pose>{pose}</pose><collision name="c">{shape}</collision></link>'


def outline(box):
    return sorted((round(x, 5), round(y, 5)) for x, y in corners(box))


@pytest.mark.parametrize('text, shape', [
    (model(link(BOX)), Box('m/l', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5, 0.0, GREY)),
    (model(link(BOX, '1 2 1.25 0 0 0.3')), Box('m/l', 1.0, 2.0, 0.3, 2.0, 1.0, 0.5, 1.0, GREY)),
    # poses nest: the link 1 m ahead of a model that looks to the left is 1 m to the left of it
    (model(link(BOX, '1 0 0.25 0 0 0.2'), pose='5 6 0 0 0 1.5707963'),
     Box('m/l', 5.0, 7.0, math.pi / 2.0 + 0.2, 2.0, 1.0, 0.5, 0.0, GREY)),
    (model(link(CYLINDER, '1 2 0.5 0 0 0')), Cylinder('m/l', 1.0, 2.0, 0.5, 1.0, 0.0, GREY)),
    (model(link(CYLINDER, '1 2 0.5 3.14159265 0 0')), Cylinder('m/l', 1.0, 2.0, 0.5, 1.0, 0.0, GREY)),  # head down
    (model(link(BOX.replace('<geometry>', '<pose>0 3 0 0 0 0</pose><geometry>'))),
     Box('m/l', 0.0, 3.0, 0.0, 2.0, 1.0, 0.5, 0.0, GREY)),
    (model(model(link(BOX), name='inner', pose='0 1 0 0 0 0'), pose='0 2 0 0 0 0'),
     Box('m/inner/l', 0.0, 3.0, 0.0, 2.0, 1.0, 0.5, 0.0, GREY)),
    # without <pose>: in the middle, half in the floor, which is said
    (model(f'<link name="l"><visual name="v">{BOX}<material><script><name>Gazebo/Red</name></script></material>'
           '</visual></link>', pose='0 0 0.25 0 0 0'), Box('m/l', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5, 0.0, (255, 0, 0))),
    (model(link(BOX).replace('</link>', f'<visual name="v">{CYLINDER}<material><diffuse>1 0.5 0 1</diffuse></material>'
                             '</visual></link>')), Box('m/l', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5, 0.0, (255, 128, 0))),
])
def test_shape_is_read(world, text, shape):
    plan, warnings = read(world(text))
    (found,) = plan.solids()
    assert type(found) is type(shape) and found.name == shape.name and found.colour == shape.colour
    assert found[1:-1] == pytest.approx(shape[1:-1], abs=LENGTH_TOLERANCE)
    assert warnings == []


@pytest.mark.parametrize('turn, length, width, height', [
    # a box of 2 x 1 x 0.5 lying on another side, turned by 0.7 rad about the vertical: its outline is that of its two
    # level axes, its height that of the upright one
    ('0 0 0.7', 2.0, 1.0, 0.5), ('3.1415927 0 0.7', 2.0, 1.0, 0.5), ('0 3.1415927 0.7', 2.0, 1.0, 0.5),
    ('1.5707963 0 0.7', 2.0, 0.5, 1.0), ('0 1.5707963 0.7', 0.5, 1.0, 2.0), ('0 -1.5707963 0.7', 0.5, 1.0, 2.0),
])
def test_box_on_any_of_its_sides(world, turn, length, width, height):
    plan, warnings = read(world(model(link(BOX, f'3 4 2 {turn}'))))
    (box,) = plan.boxes
    assert outline(box) == outline(Box('b', 3.0, 4.0, 0.7, length, width, 1.0))
    assert (box.height, box.bottom + box.height / 2.0) == pytest.approx((height, 2.0))
    assert warnings == []


STATE = '''<state world_name="w"><model name="m"><pose>9 9 9 0 0 0</pose><scale>1 1 1</scale>
<link name="l"><pose>7 8 0.25 0 0 0.1</pose></link></model></state>'''


def test_state_goes_before_the_model(world):
    plan, warnings = read(world(STATE + model(link(BOX), pose='1 1 1 0 0 0')))
    assert plan.boxes[0][1:4] == pytest.approx((7.0, 8.0, 0.1)) and warnings == []
    # of a state that only knows the model, the link keeps its place in it
    state = STATE.replace('"l"', '"other"').replace('9 9 9', '9 9 0')
    plan, _ = read(world(state + model(link(BOX, '1 0 0.25 0 0 0'))))
    assert plan.boxes[0][1:4] == pytest.approx((10.0, 9.0, 0.0))


def test_colours_of_sky_and_floor(world):
    plane = ('<geometry><plane><normal>0 0 1</normal></plane></geometry>'
             '<material><ambient>0 1 0 1</ambient></material>')
    plan, warnings = read(world(
        '<scene><background>0.2 0.4 1 1</background></scene>'
        + model(f'<link name="l"><visual name="v">{plane}</visual></link>')))
    assert (plan.sky_colour, plan.ground_colour, warnings) == ((51, 102, 255), (0, 255, 0), [])
    assert plan.solids() == ()


def test_marker_models_are_panels(world):
    mesh = '<geometry><mesh><uri>model://marker3/meshes/Marker3.dae</uri><scale>0.8 0.8 0.8</scale></mesh></geometry>'
    plan, warnings = read(world(model(f'<link name="link"><visual name="v">{mesh}</visual></link>', name='marker3',
                                      pose='0 -2.89 0.05 0 0 -1.57')))
    (panel,) = plan.panels
    assert panel[:2] == ('marker3', 3)
    assert panel[2:-1] == pytest.approx(Panel('marker3', 3, 0.0, -2.89, -1.57)[2:-1])
    assert panel.path == ()
    assert warnings == []


ACTOR = '''<actor name="tag"><link name="l"><visual name="v"><geometry><mesh>
<uri>model://marker3/meshes/Marker3.dae</uri></mesh></geometry></visual></link><script><trajectory id="0" type="square">
<waypoint><time>5</time><pose>1 2 0.25 0 0 0.5</pose></waypoint>
<waypoint><time>15</time><pose>3 2 0.25 0 0 0</pose></waypoint></trajectory></script></actor>'''


def test_an_actor_that_is_a_marker_becomes_a_panel_with_a_path(world):
    plan, warnings = read(world(ACTOR))
    path = ((0.0, 1.0, 2.0, 0.5), (10.0, 3.0, 2.0, 0.0))
    assert plan.panels == (Panel('tag', 3, 1.0, 2.0, 0.5, 0.5, 0.35, 0.25, path),)
    assert warnings == []


def test_a_sphere_becomes_a_stack_of_cylinders(world):
    ball = '<geometry><sphere><radius>0.5</radius></sphere></geometry>'
    plan, warnings = read(world(model(link(ball, '1 2 0.5 0 0 0'))))
    slices = sorted(plan.cylinders, key=lambda cylinder: cylinder.bottom)
    assert warnings == [] and len(slices) == 10
    assert (slices[0].bottom, slices[-1].bottom + slices[-1].height) == pytest.approx((0.0, 1.0))
    for cylinder in slices:  # its middle is on the sphere
        assert math.hypot(cylinder.radius, cylinder.bottom + cylinder.height / 2 - 0.5) == pytest.approx(0.5)


def test_names_are_made_unique(world):
    plan, _ = read(world(model(link(BOX)) + model(link(BOX, '5 0 0.25 0 0 0'))
                         + model(link(CYLINDER, '0 9 0.5 0 0 0'))))
    assert [shape.name for shape in plan.solids()] == ['m/l', 'm/l_2', 'm/l_3']


@pytest.mark.parametrize('text, said', [
    (model(link('<geometry><capsule><radius>1</radius></capsule></geometry>')), 'm/l: <capsule> is left out'),
    (model(link('<geometry><mesh><uri>file://a.dae</uri></mesh></geometry>')),
     'm/l: <mesh> file://a.dae is left out: there is no such file in'),
    (model(link(BOX, '0 0 1 0.3 0 0')), 'm/l: the box is tilted; left out'),
    (model(link(CYLINDER, '0 0 1 1.5707963 0 0')), 'm/l: the cylinder is tilted'),
    (model(link(BOX, '0 0 0 0 0 0')), 'm/l: it reaches 0.250 m into the floor'),
    (model(link('<geometry><plane><normal>1 0 0</normal></plane></geometry>')), 'm/l: the <plane> is not the floor'),
    ('<include><uri>model://no_such_model</uri></include>',
     '<include> of model://no_such_model is left out: there is no such model in '),
    ('<actor name="walker"/>', '<actor> walker is left out'),
    (STATE.replace('<scale>1 1 1', '<scale>1 5 1') + model(link(BOX)), 'm: the <scale> 1 5 1 of its <state> is left'),
    (model(link(BOX).replace('<pose>', '<pose relative_to="other">')), 'its <pose> relative to other is used as'),
    (model(link(BOX)) + model(link(BOX), name='n'), '1 pairs of shapes overlap, among them m/l and n/l'),
])
def test_what_cannot_be_read_is_named(world, text, said):
    _, warnings = read(world(text))
    assert [warning for warning in warnings if said in warning], warnings


@pytest.mark.parametrize('text', [
    '<include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>',
    '<light name="sun"/><gravity>0 0 -9.8</gravity><plugin name="p" filename="f.so"/>',
    model('<link name="l"><collision name="c"><geometry><empty/></geometry></collision></link>'),
    model('<link name="l"><collision name="c"/></link>'),
])
def test_what_changes_nothing_is_not_mentioned(world, text):
    plan, warnings = read(world(text))
    assert plan.solids() == () and warnings == []


@pytest.mark.parametrize('sdf, said', [
    ('{{', 'not XML: not well-formed'),
    ('<sdf version="1.6"></sdf>',
     'not an SDF world: the file begins with <sdf>; it must be <sdf> with a <world> in it'),
    ('<robot name="r"/>', 'not an SDF world: the file begins with <robot>'),
    (f'<sdf><world>{model(link(BOX.replace("2 1 0.5", "2 1")))}</world></sdf>',
     "m/l: box: size is '2 1'; it must be 3 finite numbers"),
    (f'<sdf><world>{model(link(BOX.replace("2 1 0.5", "2 1 nan")))}</world></sdf>', "box: size is '2 1 nan'"),
    (f'<sdf><world>{model(link(BOX.replace("2 1 0.5", "0 1 1")))}</world></sdf>', 'm/l: length is 0; it must be above'),
    (f'<sdf><world>{model(link(BOX, "a b c 0 0 0"))}</world></sdf>', "m/l: pose is 'a b c 0 0 0'; it must be 6 finite"),
    (f'<sdf><world>{model(link(CYLINDER.replace("0.5", "")))}</world></sdf>', "m/l: cylinder: radius is ''"),
])
def test_world_that_makes_no_sense_is_refused(world, sdf, said):
    path = world('', sdf)
    with pytest.raises(InvalidInput, match=said):
        read(path)
    with pytest.raises(WorldError, match=said) as error:
        load_world(path, '.')
    assert str(error.value).startswith(f'{path}: ')


INNER = '''<sdf version="1.6"><model name="crate"><link name="l"><collision name="c">
<geometry><box><size>1 1 1</size></box></geometry></collision></link>{}</model></sdf>'''


def write_model(folder, name, text):
    (folder / 'models' / name).mkdir(parents=True)
    (folder / 'models' / name / 'model.sdf').write_text(text)


def test_included_models_stand_at_the_pose_of_the_include(world, tmp_path):
    write_model(tmp_path, 'crate', INNER.format(''))
    include = '<include><uri>model://crate</uri><pose>{} 0 0.5 0 0 0</pose></include>'
    plan, warnings = read(world(include.format(1) + include.format(4)))
    assert [(box.name, box.x, box.bottom) for box in plan.boxes] == [('crate/l', 1.0, 0.0), ('crate_0/l', 4.0, 0.0)]
    assert warnings == []


def test_model_config_names_the_file(world, tmp_path):
    write_model(tmp_path, 'crate', 'not read')
    (tmp_path / 'models' / 'crate' / 'new.sdf').write_text(INNER.format(''))
    (tmp_path / 'models' / 'crate' / 'model.config').write_text(
        '<model><sdf version="1.4">model.sdf</sdf><sdf version="1.6">new.sdf</sdf></model>')
    plan, warnings = read(world('<include><uri>model://crate</uri></include>'))
    assert len(plan.boxes) == 1
    assert warnings == ['crate/l: it reaches 0.500 m into the floor; here it stands on the floor']


def test_common_models_of_the_database_are_known_without_files(world):
    include = '<include><uri>model://grey_wall</uri><name>north</name><pose>0 3 0 0 0 0</pose></include>'
    plan, warnings = read(world(include))
    box, = plan.boxes
    assert (box.name, box.y, box.length, box.height, warnings) == ('north/link', 3.0, 7.5, 2.8, [])


def test_a_model_that_includes_itself_ends(world, tmp_path):
    write_model(tmp_path, 'crate', INNER.format('<include><uri>model://crate</uri></include>'))
    _, warnings = read(world('<include><uri>model://crate</uri></include>'))
    assert any('it lies in 10 others' in warning for warning in warnings)
