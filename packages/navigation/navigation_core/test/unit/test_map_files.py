"""Tests of navigation_core.maps.map_files: bytes as map_saver writes them, cells as map_server reads them."""
import pathlib

import cv2
import numpy as np
import pytest

from navigation_core.maps.grid_map import GridMap
from navigation_core.maps.map_files import MapError, image_size, keep_earlier, read_description, read_image, saved
from navigation_core.poses import Pose

GRID = GridMap(np.array([[0, 100, -1], [25, 65, 26]]), 0.05, Pose(-1.5, 2.25, 0.5))
IMAGE = b'P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n3 2\n255\n' + bytes([254, 0, 205, 254, 0, 205])
TEXT = b'''image: map.pgm
resolution: 0.050000
origin: [-1.500000, 2.250000, 0.500000]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196

'''


def read_map(path):
    return read_image(read_description(path))


def written(folder, pixels, name='map.png', **changes):
    """Return the path of a map file with these pixels; a key whose value is None is left out."""
    cv2.imwrite(str(folder / name), np.array(pixels, np.uint8))
    keys = {'image': name, 'resolution': 0.1, 'origin': [0, 0, 0], 'negate': 0, 'occupied_thresh': 0.65,
            'free_thresh': 0.196, **changes}
    path = folder / 'map.yaml'
    path.write_text(''.join(f'{key}: {value}\n' for key, value in keys.items() if value is not None))
    return str(path)


def test_saved_files_are_those_of_map_saver_byte_for_byte_with_an_image_that_map_server_finds():
    """It looks in the folder of the YAML file, so that my/map.pgm would be my/my/map.pgm."""
    assert saved(GRID, 'my/map') == (IMAGE, TEXT)


def test_a_saved_map_is_read_again(tmp_path):
    image, text = saved(GRID, 'map')
    (tmp_path / 'map.pgm').write_bytes(image)
    (tmp_path / 'map.yaml').write_bytes(text)
    found = read_map(str(tmp_path / 'map.yaml'))
    assert found.cells.tolist() == [[0, 100, -1], [0, 100, -1]]
    assert (found.resolution, found.origin) == (0.05, GRID.origin)


@pytest.mark.parametrize('changes, cells', [
    ({}, [100, 100, -1, -1, 0, 0]),
    ({'negate': 1}, [0, -1, -1, 100, 100, 100]),
    ({'mode': 'scale'}, [100, 100, 72, 1, 0, 0]),
    ({'mode': 'raw'}, [0, 80, 120, -52, -50, -1]),
])
def test_modes(tmp_path, changes, cells):
    """Light 0, 80, 120, 204, 206, 255 is dark 1, .686, .529, .2, .192, 0; 1 + 98 (.529 - .196) / .454 = 72.96."""
    assert read_map(written(tmp_path, [[0, 80, 120, 204, 206, 255]], **changes)).cells[0].tolist() == cells


def test_colours_are_averaged_and_alpha_counts_as_in_the_original(tmp_path):
    pixels = [[[0, 0, 0, 255], [0, 0, 0, 0], [100, 100, 100, 0]]]
    assert read_map(written(tmp_path, pixels)).cells[0].tolist() == [100, 100, 100]  # light 63.75, 0, 75: dark > 0.65
    assert read_map(written(tmp_path, pixels, mode='scale')).cells[0].tolist() == [100, 100, -1]
    assert read_map(written(tmp_path, [[[0, 255, 255], [0, 0, 0]]])).cells[0].tolist() == [-1, 100]


@pytest.mark.parametrize('changes, said', [
    ({'resolution': None}, r'map.yaml: resolution is None; it must be a number'),
    ({'resolution': 'coarse'}, r"resolution is 'coarse'"),
    ({'resolution': 0}, r'resolution is 0; it must be more than 0'),
    ({'origin': '[0, 0]'}, r'origin is \[0, 0\]; it must be \[x, y, yaw\]'),
    ({'origin': '[0, 0, .nan]'}, r'origin is nan'),
    ({'mode': 'binary'}, r"mode is 'binary'; it must be one of trinary, scale, raw"),
    ({'image': None}, r'image is None'),
    ({'image': 'none.pgm'}, r'failed to open image file ".*none.pgm": No such file'),
    ({'image': 'map.yaml'}, r'is not a PGM, PNG, BMP or JPEG image'),
    ({'negate': '[]'}, r'negate is \[\]'),
])
def test_wrong_files_are_refused(tmp_path, changes, said):
    with pytest.raises(MapError, match=said):
        read_map(written(tmp_path, [[0]], **changes))


@pytest.mark.parametrize('content', ['', 'a text', '- 1', 'image: [', '\x00'])
def test_what_is_no_map_file_is_refused(tmp_path, content):
    path = tmp_path / 'map.yaml'
    path.write_text(content)
    with pytest.raises(MapError, match='is not a map file'):
        read_map(str(path))
    with pytest.raises(MapError, match='could not open') as failure:
        read_map(str(tmp_path / 'missing.yaml'))
    assert failure.value.missing


def test_an_enormous_image_is_refused_before_it_is_read(tmp_path):
    path = written(tmp_path, [[0]], image='large.pgm')
    (tmp_path / 'large.pgm').write_bytes(b'P5\n# a comment\n20000 20000\n255\n')
    with pytest.raises(MapError, match='20000 x 20000 pixels; a map has at most 25000000 cells'):
        read_map(path)
    image = cv2.imencode('.png', np.zeros((3, 5), np.uint8))[1].tobytes()
    assert image_size(image) == (5, 3) and image_size(b'GIF89a') == ()


def files_of(name, grid):
    return dict(zip((f'{name}.pgm', f'{name}.yaml'), saved(grid, name)))


def test_an_earlier_map_is_kept_whole_under_the_next_free_name(tmp_path):
    name = str(tmp_path / 'mymap')
    maps = [GridMap(np.full((2, 2), cell, np.int8), 0.05, Pose(0.0, 0.0, 0.0)) for cell in (0, 100, -1)]
    kept = []
    for one in maps:
        kept.append(keep_earlier(name, files_of(name, one)))
        for path, content in files_of(name, one).items():
            pathlib.Path(path).write_bytes(content)
    assert kept == ['', f'{name}_2', f'{name}_3']
    for path, cell in ((f'{name}_2', 0), (f'{name}_3', 100), (name, -1)):
        loaded = read_map(f'{path}.yaml')
        assert (loaded.cells == cell).all(), path
    assert keep_earlier(name, files_of(name, maps[-1])) == ''  # the same map once more
    assert len(list(tmp_path.iterdir())) == 6


@pytest.mark.parametrize('there', ['mymap.yaml', 'mymap.pgm'])
def test_half_a_map_is_kept_too(tmp_path, there):
    (tmp_path / there).write_text('x')
    kept = keep_earlier(str(tmp_path / 'mymap'), files_of(str(tmp_path / 'mymap'), GRID))
    assert kept == str(tmp_path / 'mymap_2')
    assert (tmp_path / there.replace('mymap', 'mymap_2')).read_text() == 'x' and len(list(tmp_path.iterdir())) == 2


def test_an_image_of_another_name_and_what_was_added_by_hand_stay(tmp_path):
    (tmp_path / 'm.pgm').write_bytes(b'P5')
    (tmp_path / 'm.yaml').write_text('# the kitchen\nimage: edited.png\nresolution: 0.1\n')
    kept = keep_earlier(str(tmp_path / 'm'), files_of(str(tmp_path / 'm'), GRID))
    assert pathlib.Path(f'{kept}.yaml').read_text() == '# the kitchen\nimage: edited.png\nresolution: 0.1\n'
    assert kept == str(tmp_path / 'm_2') and (tmp_path / 'm.pgm').exists()
