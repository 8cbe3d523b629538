"""joy.core.joystick: events of Linux, dead zone, sticky buttons, and what is said about missing devices."""
import pytest

from joy.core import joystick
from joy.core.joystick import AXIS, BUTTON, EVENT, INITIAL, Joystick


def events(*each):
    """Return the bytes of events (kind, number, value)."""
    return b''.join(EVENT.pack(0, value, kind, number) for kind, number, value in each)


@pytest.mark.parametrize('value, axis', [
    (0, 0.0), (1638, 0.0), (-1638, 0.0),  # 5 % of 32767
    (32767, -1.0), (-32767, 1.0), (-32768, 1.0),
    (17203, -0.5),  # the middle between the dead zone's edge, 1638.35, and 32767
])
def test_axes_are_scaled_beyond_the_dead_zone(value, axis):
    stick = Joystick()
    stick.feed(events((AXIS, 0, value)))
    assert stick.axes == pytest.approx([axis], abs=1e-4)


def test_the_driver_names_axes_and_buttons_first():
    stick = Joystick()
    assert stick.feed(events((BUTTON | INITIAL, 1, 0), (AXIS | INITIAL, 2, 0)))
    assert (stick.axes, stick.buttons) == ([0.0, 0.0, 0.0], [0, 0])
    assert stick.feed(events((BUTTON, 0, 1)))
    assert stick.buttons == [1, 0]
    assert not stick.feed(events((BUTTON, 0, 1)))


def test_sticky_buttons_toggle_when_pressed():
    stick = Joystick(sticky_buttons=True)
    seen = []
    for value in (1, 0, 1, 0):
        stick.feed(events((BUTTON, 0, value)))
        seen.append(stick.buttons[0])
    assert seen == [1, 1, 0, 0]


def test_broken_data_changes_nothing():
    stick = Joystick()
    assert not stick.feed(b'123') and not stick.feed(events((AXIS, 200, 5), (0x40, 0, 1)))
    assert (stick.axes, stick.buttons) == ([], [])


def test_a_missing_device_is_explained(monkeypatch):
    monkeypatch.setattr(joystick.glob, 'glob', lambda _: [])
    assert joystick.why_not('/dev/input/js9').startswith('/dev/input/js9 does not exist. No joystick is connected')
    monkeypatch.setattr(joystick.glob, 'glob', lambda _: ['/dev/input/js0'])
    assert joystick.why_not('/dev/input/js9') == '/dev/input/js9 does not exist. Joysticks here: /dev/input/js0.'
