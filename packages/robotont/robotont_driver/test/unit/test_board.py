"""robotont_driver.core.board: LEDs and battery."""
import pytest

from kinematic_core.worlds.planar import STILL, Twist2D
from plain_support import InvalidInput
from robotont_driver.core.board import IDLE_CURRENT, LEDS, OFF, Board, power

RED, BLUE = (255, 0, 0), (0, 0, 255)


def test_leds_get_their_colours():
    board = Board()
    board.light(2, [RED, BLUE])
    board.light(LEDS - 1, [BLUE])
    assert board.leds == [OFF, OFF, RED, BLUE, *[OFF] * (LEDS - 5), BLUE]


@pytest.mark.parametrize('first, colours', [(LEDS, [RED]), (LEDS - 1, [RED, BLUE]), (2 ** 32 - 1, [RED])])
def test_leds_that_do_not_exist_change_nothing(first, colours):
    board = Board()
    with pytest.raises(InvalidInput, match=f'LEDs 0 to {LEDS - 1}'):
        board.light(first, colours)
    assert board.leds == [OFF] * LEDS


def test_driving_takes_more_current_whatever_the_direction():
    assert power(STILL).current == IDLE_CURRENT
    assert power(Twist2D(-0.5, 0.0, 0.0)) == power(Twist2D(0.0, 0.5, 0.0))
    assert power(Twist2D(0.5, 0.0, -1.0)).current > power(Twist2D(0.5, 0.0, 0.0)).current > IDLE_CURRENT
