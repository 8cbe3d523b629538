"""ALVAR's code: all numbers of resolution 5, orientations, wrong cells, larger resolutions, text, bad input."""
import numpy as np
import pytest

from alvar_core import code

NUMBERS = np.array([code.encode(number) for number in range(256)])


def drawn(cells):
    return [''.join('.' if white else '#' for white in row) for row in cells]


def test_markers_drawn_by_hand():
    # 0: no data bit is set, so every data cell is white; the fixed cells are the middle row and four cells about it.
    assert drawn(NUMBERS[0]) == ['..#..', '..#..', '.#.#.', '.....', '.....']
    # 5 = 0000 0101: blocks 0000 -> 00000000 and 0101 -> p p 0 p 1 0 1 p = 0 1 0 0 1 0 1 1.
    assert drawn(NUMBERS[5]) == ['..#..', '..#..', '.#.#.', '.#...', '#..##']
    assert drawn(NUMBERS[255]) == ['#####', '#####', '.#.#.', '##.##', '##.##']


@pytest.mark.parametrize('turns', range(4))
def test_every_number_in_every_orientation(turns):
    for number, cells in enumerate(NUMBERS):
        found = code.decode(np.rot90(cells, -turns))
        assert (found.value, found.turns, found.corrected) == (number, turns, 0)


def test_patterns_differ_by_four_cells_under_every_turn():
    turned = np.array([np.rot90(cells, k) for k in range(4) for cells in NUMBERS]).reshape(1024, 25)
    distance = (turned[:, None] != turned[None]).sum(2)
    np.fill_diagonal(distance, 25)
    assert distance.min() == 4


def test_one_wrong_cell_anywhere_is_put_right():
    for number in range(0, 256, 7):
        for cell in range(25):
            cells = NUMBERS[number].copy()
            cells.flat[cell] ^= True
            found = code.decode(cells)
            assert (found.value, found.corrected) == (number, 1)


def test_two_wrong_cells_are_never_another_number():
    rng = np.random.default_rng(1)
    for number in range(256):
        cells = NUMBERS[number].copy()
        cells.flat[rng.choice(25, 2, replace=False)] ^= True
        assert code.decode(cells) is None


def test_a_mirrored_marker_is_not_read_as_itself():
    values = [code.decode(np.fliplr(cells)) for cells in NUMBERS]
    assert sum(v is not None and v.value == n and v.turns == 0 for n, v in enumerate(values)) < 20


@pytest.mark.parametrize('value, resolution', [
    (255, 5), (256, 7), (1000, 7), (65535, 7), (2 ** 20, 7), (2 ** 32 - 1, 9)])
def test_larger_numbers_take_the_smallest_resolution(value, resolution):
    cells = code.encode(value)
    assert len(cells) == resolution
    for turns in range(4):
        found = code.decode(np.rot90(cells, -turns))
        assert (found.kind, found.value, found.turns) == (code.NUMBER, value, turns)


@pytest.mark.parametrize('text', ['hello', 'www.vtt.fi', 'a', 'robotont:4', 'with space'])
def test_text(text):
    cells = code.encode(text)
    found = code.decode(np.rot90(cells, -1))
    assert (found.kind, found.value, found.turns) == (code.STRING, text, 1)


def test_larger_markers_put_one_cell_right_in_each_block():
    cells = code.encode(1000, strong=True)
    wrong = cells.copy()
    wrong[0, 0] ^= True
    assert code.decode(wrong).value == 1000


def test_a_given_resolution_is_used():
    assert code.encode(3, resolution=9).shape == (9, 9)
    assert code.decode(code.encode(3, resolution=9)).value == 3


@pytest.mark.parametrize('value', [-1, 2 ** 32, 1.5, True, 'ä', ''])
def test_what_no_marker_can_hold(value):
    with pytest.raises(code.CodeError):
        code.encode(value)


@pytest.mark.parametrize('resolution', [4, 6, 3, 33, True, 5.5])
def test_impossible_resolutions(resolution):
    with pytest.raises(code.CodeError, match='odd number from 5'):
        code.encode(1, resolution=resolution)


def test_text_does_not_fit_in_five():
    with pytest.raises(code.CodeError, match='holds only a number'):
        code.encode('a', resolution=5)


def test_each_mirrored_number_is_a_valid_one():
    """Those of 16 are the same."""
    mirrored = code.mirrored_numbers()
    assert sorted(mirrored) == list(range(256)) and all(mirrored[mirrored[number]] == number for number in range(256))
    assert sum(mirrored[number] == number for number in range(256)) == 16
    assert mirrored[5] == code.decode(np.fliplr(code.encode(5))).value != 5
