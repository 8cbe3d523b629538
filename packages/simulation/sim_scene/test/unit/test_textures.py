"""Patterns: panels carry their markers where they belong, smaller pictures keep the mean, the floor repeats."""
import numpy as np
import pytest

from alvar_core import code
from sim_scene import textures
from sim_scene.response import Response
from sim_scene.textures import INK, PAD, PANEL_PIXELS, PAPER

LINEAR, GAMMA = Response(1.0), Response(2.2)


def without_pad(mipmap, along=0, up=0):
    return mipmap.at(along, up)[0][PAD:-PAD, PAD:-PAD].astype(float)


@pytest.mark.parametrize('marker_id', [0, 1, 5, 255, 3000])
def test_panel_shows_its_cells_where_they_belong(marker_id):
    grey = without_pad(textures.panel(marker_id, 0.40, 0.28, LINEAR))
    cells = np.pad(code.encode(marker_id), 2)
    side = 0.28 / 0.40 * PANEL_PIXELS
    first, step = (PANEL_PIXELS - side) / 2, side / len(cells)
    middles = np.round(first + (np.arange(len(cells)) + 0.5) * step - 0.5).astype(int)
    assert np.array_equal(grey[np.ix_(middles, middles)] > 128, cells)
    assert (grey[:int(first)] == PAPER).all() and (grey[:, -int(first):] == PAPER).all()
    # The black square as a whole: as much ink as its area asks for, its white cells not counted.
    ink = (PAPER - grey).sum() / (PAPER - INK)
    assert ink == pytest.approx((~cells).sum() * step * step, rel=1e-3)


def test_panel_of_an_impossible_id_is_refused():
    with pytest.raises(code.CodeError):
        textures.panel(2 ** 40, 0.40, 0.28, LINEAR)


@pytest.mark.parametrize('response', [LINEAR, GAMMA], ids=['linear', 'gamma'])
@pytest.mark.parametrize('make', [lambda response: textures.panel(7, 0.4, 0.28, response),
                                  lambda response: textures.wall(0, True, response)], ids=['panel', 'wall'])
@pytest.mark.parametrize('along, up', [(1, 0), (0, 3), (2, 2), (12, 12)])
def test_smaller_pictures_have_the_same_mean_light(make, along, up, response):
    mipmap = make(response)
    means = [response.light(without_pad(mipmap, *level)).mean() for level in ((along, up), (0, 0))]
    assert response.values(means[0]) == pytest.approx(response.values(means[1]), abs=2.0)
    picture, _, per_metre_along, per_metre_up = mipmap.at(along, up)
    assert picture.shape[1] - 2 * PAD == pytest.approx(mipmap.length * per_metre_along)
    assert picture.shape[0] - 2 * PAD == pytest.approx(mipmap.height * per_metre_up)


@pytest.mark.parametrize('length, height', [(4.0, 2.0), (4.1, 0.5), (2.0, 2.5), (1000.0, 1000.0), (0.01, 900.0)])
def test_pictures_of_walls_have_room_and_one_size(length, height):
    wall = textures.wall(textures.coarser_for(length, height), False, LINEAR)
    assert wall.length >= length and wall.height >= height
    assert wall.at(0, 0)[0].shape == textures.wall(0, False, LINEAR).at(0, 0)[0].shape
    assert min(length, height) < 1 or wall.length < 2 * length or wall.height < 2 * height


@pytest.mark.parametrize('response', [LINEAR, GAMMA], ids=['linear', 'gamma'])
def test_floor_repeats_and_has_its_mean_in_every_size(response):
    mean = textures.floor_mean(np.full(3, 255.0), response)[0]
    for halved in range(4):
        tones = textures.floor(halved, response).astype(float)
        period = round(textures.PERIOD * textures.FLOOR_RESOLUTION / 2 ** halved)
        assert tones.shape == (period + 1, period + 1)
        assert np.array_equal(tones[0], tones[-1]) and np.array_equal(tones[:, 0], tones[:, -1])
        assert response.values(response.light(tones[:-1, :-1]).mean()) == pytest.approx(mean, abs=0.6)
