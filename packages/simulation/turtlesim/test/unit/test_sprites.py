"""The pictures of the turtles: which design, where, which way they face, and that the canvas shows round them."""
import math

import pytest

from kinematic_core.worlds.turtle_world import BACKGROUND

np = pytest.importorskip('numpy')
cv2 = pytest.importorskip('cv2')

from turtlesim.core import sprites  # noqa: E402

METRE = 45.0  # px
REACH = 23  # [px] no part of a turtle is farther from its position


def empty():
    return np.full((500, 500, 3), BACKGROUND, np.uint8)


def covered(frame):
    """Return rows and columns of the pixels that differ from the background."""
    return np.nonzero((frame != np.array(BACKGROUND, np.uint8)).any(axis=2))


def white_middle(frame):
    """The (x, y) of the middle of all white pixels: the eyes of a turtle without white in its shell."""
    rows, columns = np.nonzero((frame > 225).all(axis=2))
    return columns.mean(), rows.mean()


def test_designs_follow_from_the_name():
    assert [sprites.design_of(f'turtle{number}') for number in range(1, 8)] == [3, 7, 9, 4, 6, 8, 0]
    assert sprites.DESIGNS[sprites.design_of('turtle1')][2].__name__ == '_scutes'


def test_all_designs_differ_clearly():
    pictures = [sprites._turned(design, 0)[0].astype(int) for design in range(len(sprites.DESIGNS))]
    assert len(pictures) >= 8
    for number, one in enumerate(pictures):
        for other in pictures[:number]:
            assert np.abs(one - other).mean() > 8.0


@pytest.mark.parametrize('theta', [0.0, math.pi / 2, math.pi, -math.pi / 2, math.pi / 4, 2.5, -3.1, 7.0, -40.0])
def test_a_turtle_faces_along_theta(theta):
    x, y = white_middle(sprites.render(empty(), [('turtle1', 250 / METRE, 250 / METRE, theta)]))
    # the white of the eyes is 15 px from the middle; y points down in the picture, theta is counter-clockwise
    assert x - 250 == pytest.approx(15 * math.cos(theta), abs=1)
    assert y - 250 == pytest.approx(-15 * math.sin(theta), abs=1)


@pytest.mark.parametrize('theta', [0.0, 0.8, 2.0, -1.2])
@pytest.mark.parametrize('design', range(len(sprites.DESIGNS)))
def test_no_sprite_is_cut_off_by_its_square(design, theta):
    through = sprites._turned(design, round(math.degrees(theta)) % 360)[1]
    rim = np.concatenate((through[0], through[-1], through[:, 0], through[:, -1]))
    assert rim.min() >= 225  # at most a trace of the outline


def test_a_turtle_stays_near_its_position():
    rows, columns = covered(sprites.render(empty(), [('turtle1', 100.2 / METRE, 300.7 / METRE, 0.6)]))
    assert np.hypot(columns - 100.2, rows - 300.7).max() <= REACH + 1
    assert columns.mean() == pytest.approx(100.2, abs=2)
    assert rows.mean() == pytest.approx(300.7, abs=2)


@pytest.mark.parametrize(('x', 'y'), [(0, 0), (499, 0), (0, 499), (499, 499), (250, 0), (-10, 250), (510, 250)])
def test_turtles_are_cut_at_the_border(x, y):
    whole = np.full((700, 700, 3), BACKGROUND, np.uint8)
    shifted = sprites.render(whole, [('turtle1', (x + 100) / METRE, (y + 100) / METRE, 1.0)])
    frame = sprites.render(empty(), [('turtle1', x / METRE, y / METRE, 1.0)])
    assert (frame == shifted[100:600, 100:600]).all()
    assert covered(frame)[0].size


@pytest.mark.parametrize(('x', 'y'), [(-30, 10), (10, 530), (1e9, -1e9), (-1e30, 1e30)])
def test_turtles_outside_leave_the_picture_alone(x, y):
    assert (sprites.render(empty(), [('turtle1', x / METRE, y / METRE, 0.0)]) == empty()).all()


def test_the_canvas_itself_stays_and_shows_round_the_turtle():
    canvas = empty()
    canvas[:, 250:] = (10, 200, 30)
    before = canvas.copy()
    canvas.setflags(write=False)
    frame = sprites.render(canvas, [('turtle1', 250 / METRE, 250 / METRE, 0.0)])
    assert (canvas == before).all()
    outside = np.hypot(*(np.indices((500, 500)) - 250)) > REACH
    assert (frame[outside] == before[outside]).all()


def test_later_names_lie_on_top_whatever_the_order():
    one, two = ('turtle1', 5.0, 5.0, 0.0), ('turtle2', 5.2, 5.0, 1.0)
    frame = sprites.render(empty(), [two, one])
    assert (frame == sprites.render(empty(), [one, two])).all()
    assert (frame == sprites.render(sprites.render(empty(), [one]), [two])).all()
    assert (frame != sprites.render(sprites.render(empty(), [two]), [one])).any()


def test_pictures_repeat():
    turtles = [(f'turtle{number}', number / 3, 5.0, number * 0.7) for number in range(30)]
    first = sprites.render(empty(), turtles)
    sprites._turned.cache_clear()
    assert (sprites.render(empty(), turtles) == first).all()


def test_the_cache_is_bounded():
    for step in range(400):
        sprites.render(empty()[:60, :60], [('turtle1', 0.5, 0.5, math.radians(step % 360)), ('x', 0.5, 0.5, step / 57)])
    assert sprites._turned.cache_info().currsize <= sprites.KEPT


def test_png_keeps_every_pixel_and_the_order_of_the_colours():
    frame = sprites.render(empty(), [('turtle1', 5.0, 5.0, 0.5)])
    data = np.frombuffer(sprites.encode_png(frame), np.uint8)
    assert (cv2.imdecode(data, cv2.IMREAD_COLOR)[:, :, ::-1] == frame).all()
