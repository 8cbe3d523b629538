"""A Linux joystick, /dev/input/js*: its events, and the axes and buttons that follow from them. No ROS.

Axes are -1 to 1, positive to the left and forwards, 0 in the dead zone; buttons are 0 or 1. Both appear in the order of
the driver, as soon as it has named them.
"""
import glob
import os
import struct
from typing import List, Optional

EVENT = struct.Struct('IhBB')  # time [ms], value, kind, number: struct js_event of linux/joystick.h
BUTTON, AXIS, INITIAL = 0x01, 0x02, 0x80  # kinds; INITIAL is added to those that tell the state at the start
FARTHEST = 32767  # value of an axis
MOST = 64  # axes or buttons; more are no joystick
READ_AT_ONCE = 64  # events
DEVICES = '/dev/input/js*'


class Joystick:
    """The state that follows from the events. ``axes`` and ``buttons`` are public and read-only."""

    def __init__(self, deadzone: float = 0.05, sticky_buttons: bool = False) -> None:
        """``deadzone``: the part of an axis around its middle that counts as 0; sticky buttons toggle when pressed."""
        self.axes: List[float] = []
        self.buttons: List[int] = []
        self._deadzone, self._sticky = deadzone, sticky_buttons

    def feed(self, data: bytes) -> bool:
        """Process the complete events in ``data``; return whether anything has changed."""
        before = [*self.axes], [*self.buttons]
        for _, value, kind, number in EVENT.iter_unpack(data[:len(data) - len(data) % EVENT.size]):
            if number >= MOST:
                continue
            if kind & ~INITIAL == AXIS:
                self.axes += [0.0] * (number + 1 - len(self.axes))
                self.axes[number] = self._scaled(value)
            elif kind & ~INITIAL == BUTTON:
                self.buttons += [0] * (number + 1 - len(self.buttons))
                if not self._sticky:
                    self.buttons[number] = int(bool(value))
                elif value and not kind & INITIAL:
                    self.buttons[number] = 1 - self.buttons[number]
        return before != (self.axes, self.buttons)

    def _scaled(self, value: int) -> float:
        zone = self._deadzone * FARTHEST
        beyond = value - zone if value > zone else value + zone if value < -zone else 0.0
        return max(-1.0, min(1.0, -beyond / (FARTHEST - zone))) if beyond else 0.0


def why_not(device: str) -> Optional[str]:
    """Return why a joystick cannot be opened, and what to do; None if it can."""
    others = 'No joystick is connected: there is no /dev/input/js*. A container needs docker run --device=/dev/input.'
    found = sorted(glob.glob(DEVICES))
    if found:
        others = f'Joysticks here: {", ".join(found)}.'
    if not os.path.exists(device):
        return f'{device} does not exist. {others}'
    if not os.access(device, os.R_OK):
        return f'{device} cannot be read. Type sudo usermod -aG input $USER, log out and in again. {others}'
    return None
