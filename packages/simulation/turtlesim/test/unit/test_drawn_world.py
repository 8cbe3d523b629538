"""turtlesim.core.drawn_world: strokes and colour sensors in turtlesim's order."""
import pytest

from kinematic_core.worlds.turtle_world import BACKGROUND, PEN_COLOUR, Stroke
from turtlesim.core.canvas import Canvas
from turtlesim.core.drawn_world import DrawnWorld

RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (0, 0, 255)
T = 'turtle1'


@pytest.fixture
def drawn():
    return DrawnWorld()


def colours(readings):
    return {turtle.name: colour for turtle, colour, _ in readings}


def test_begins_with_turtle1_on_an_empty_canvas_of_the_colour_asked_for():
    for background, drawn in ((BACKGROUND, DrawnWorld()), (RED, DrawnWorld(RED))):
        assert set(chunks(drawn.canvas.tobytes())) == {bytes(background)}
        assert colours(drawn.step()) == {T: background}


def chunks(pixels):
    return [pixels[start:start + 3] for start in range(0, len(pixels), 3)]


def test_colour_is_read_before_the_motion_of_the_step_is_drawn(drawn):
    drawn.world.command(T, 1.0, 0.0, 0.0)
    assert colours(drawn.step()) == {T: BACKGROUND}
    turtle = drawn.world.turtles[T]
    assert drawn.canvas.color_at(turtle.x, turtle.y_down) == PEN_COLOUR  # it is drawn by now
    assert colours(drawn.step()) == {T: PEN_COLOUR}  # 0.72 px further, on the line's cap of 1.5 px


def test_colour_is_read_after_the_teleports_of_the_step_are_drawn(drawn):
    drawn.world.set_pen(T, *RED, 5, False)
    drawn.world.teleport_absolute(T, 2.0, 2.0, 0.0)
    drawn.world.set_pen(T, *GREEN, 5, False)  # at once: the teleport draws green
    assert colours(drawn.step()) == {T: GREEN}


def test_colour_is_read_where_the_turtle_is_after_its_motion(drawn):
    # a red line across (5, 3)..(5, 7) at 5 m; the turtle steps onto it in one step of 0.5 m = 31.25 m/s
    drawn.canvas.draw(Stroke(5.0, 4.0, 5.0, 8.0, RED, 9))
    drawn.world.set_pen(T, 0, 0, 0, 0, True)
    drawn.world.teleport_absolute(T, 4.5, 5.0, 0.0)
    assert colours(drawn.step()) == {T: BACKGROUND}
    drawn.world.command(T, 31.25, 0.0, 0.0)
    assert colours(drawn.step()) == {T: RED}


def test_teleports_are_drawn_in_their_order_the_later_over_the_earlier(drawn):
    drawn.world.teleport_absolute(T, 2.0, 2.0, 0.0)
    drawn.world.teleport_absolute(T, 3.0, 2.0, 0.0)
    drawn.step()
    expected = Canvas()
    middle = drawn.world.turtles[T].y_down
    stops = [(499.0 / 90.0, 499.0 / 90.0), (2.0, middle), (3.0, middle)]
    for old, new in zip(stops, stops[1:]):
        expected.draw(Stroke(*new, *old, PEN_COLOUR, 3))
    assert drawn.canvas.tobytes() == expected.tobytes()


@pytest.mark.parametrize('order', [('a', 'b'), ('b', 'a')])
def test_two_turtles_crossing_are_drawn_and_read_in_alphabetical_order_of_their_names(drawn, order):
    drawn.world.kill(T)
    for name in order:
        drawn.world.spawn(1.0, 1.0 if name == 'a' else 9.0, 0.0, name)
    drawn.world.set_pen('a', *RED, 3, False)
    drawn.world.set_pen('b', *BLUE, 3, False)
    for name in order:
        drawn.world.teleport_absolute(name, 5.0, 5.0, 0.0)
    # a draws red and reads it, then b draws blue over it and reads that
    assert colours(drawn.step()) == {'a': RED, 'b': BLUE}
    assert drawn.canvas.color_at(5.0, drawn.world.turtles['a'].y_down) == BLUE


@pytest.mark.parametrize('watcher, seen', [('b', RED), ('A', BACKGROUND)])
def test_motion_of_an_earlier_turtle_is_seen_by_a_later_one_in_the_same_step(drawn, watcher, seen):
    drawn.world.kill(T)
    drawn.world.spawn(5.0, 5.0, 0.0, watcher)
    drawn.world.spawn(4.99, 5.0, 0.0, 'a')
    drawn.world.set_pen('a', *RED, 3, False)
    drawn.world.command('a', 1.0, 0.0, 0.0)
    assert colours(drawn.step())[watcher] == seen


def test_wall_and_turtle_are_handed_on(drawn):
    drawn.world.command(T, 1000.0, 0.0, 0.0)  # 16 m a step
    ((turtle, _, wall),) = drawn.step()
    assert turtle is drawn.world.turtles[T]
    assert wall == pytest.approx((499.0 / 90.0 + 16.0, 499.0 / 90.0), abs=1e-6)  # [m] float32 of the arena
    ((_, _, wall),) = DrawnWorld().step()
    assert wall is None


def test_pen_up_leaves_the_canvas_alone(drawn):
    empty = drawn.canvas.tobytes()
    drawn.world.set_pen(T, 0, 0, 0, 0, True)
    drawn.world.command(T, 2.0, 0.0, 1.0)
    drawn.world.teleport_absolute(T, 2.0, 2.0, 0.0)
    for _ in range(20):
        drawn.step()
    assert drawn.canvas.tobytes() == empty


@pytest.mark.parametrize('background', [BACKGROUND, GREEN])
def test_reset_begins_anew_on_an_empty_canvas(drawn, background):
    drawn.world.spawn(1.0, 1.0, 0.0, 'a')
    drawn.world.teleport_absolute(T, 2.0, 2.0, 0.0)
    drawn.step()
    drawn.reset() if background == BACKGROUND else drawn.reset(background)
    assert list(drawn.world.turtles) == [T]
    assert set(chunks(drawn.canvas.tobytes())) == {bytes(background)}
