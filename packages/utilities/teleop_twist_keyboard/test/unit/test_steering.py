"""The effects of the keys of teleop_twist_keyboard."""
import pytest

from twist_keyboard.core.steering import HELP, HELP_AFTER, STILL, Steering, keys_in


def steering():
    return Steering(0.5, 1.0, 1000.0, 1000.0)


@pytest.mark.parametrize('key, velocity', [
    ('i', (0.5, 0, 0, 0)), (',', (-0.5, 0, 0, 0)), ('j', (0, 0, 0, 1.0)), ('l', (0, 0, 0, -1.0)),
    ('u', (0.5, 0, 0, 1.0)), ('o', (0.5, 0, 0, -1.0)), ('m', (-0.5, 0, 0, -1.0)), ('.', (-0.5, 0, 0, 1.0)),
    ('J', (0, 0.5, 0, 0)), ('L', (0, -0.5, 0, 0)), ('U', (0.5, 0.5, 0, 0)), ('O', (0.5, -0.5, 0, 0)),
    ('I', (0.5, 0, 0, 0)), ('<', (-0.5, 0, 0, 0)), ('M', (-0.5, 0.5, 0, 0)), ('>', (-0.5, -0.5, 0, 0)),
    ('t', (0, 0, 0.5, 0)), ('b', (0, 0, -0.5, 0)),
    ('k', STILL), (' ', STILL), ('\x1b[A', STILL),
])
def test_keys_that_drive(key, velocity):
    driver = steering()
    driver.press('i')
    assert driver.press(key) == []
    assert driver.velocity == pytest.approx(velocity)


@pytest.mark.parametrize('key, speed, turn', [
    ('q', 0.55, 1.1), ('z', 0.45, 0.9), ('w', 0.55, 1.0), ('x', 0.45, 1.0), ('e', 0.5, 1.1), ('c', 0.5, 0.9)])
def test_keys_that_change_speeds_keep_the_direction(key, speed, turn):
    driver = steering()
    driver.press('u')
    assert driver.press(key)[-1].startswith('currently:')
    assert driver.velocity == pytest.approx((speed, 0, 0, turn))


def test_limits():
    driver = Steering(1.0, 2.0, 1.05, 2.1)
    assert driver.press('q') == ['Linear speed limit reached!', 'Angular speed limit reached!',
                                 'currently:\tspeed 1.05\tturn 2.1 ']


def test_help_comes_again():
    driver = steering()
    lines = [driver.press('q') for _ in range(2 * HELP_AFTER)]
    assert [number for number, said in enumerate(lines, 1) if HELP in said] == [HELP_AFTER, 2 * HELP_AFTER]


@pytest.mark.parametrize('text, keys', [
    ('ii', ['i', 'i']), ('\x1b[A', ['\x1b[A']), ('i\x1bOAl', ['i', '\x1bOA', 'l']), ('\x1b[1;5Cj', ['\x1b[1;5C', 'j']),
    ('\x1b', ['\x1b']), ('\x03', ['\x03']), ('', []), ('ä', ['ä'])])
def test_keys_in_what_a_terminal_sends(text, keys):
    assert keys_in(text) == keys
