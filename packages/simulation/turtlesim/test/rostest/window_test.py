#!/usr/bin/env python3
"""The simulator's window on a screen of its own (Xvfb): its contents, and the effects of closing it and of failures."""
import sys
import unittest

from rostest_support.common import ARENA, BACKGROUND, DEADLINE, SimulatorCase, own_simulator, run, until
from rostest_support.virtual_display import MISSING, VirtualDisplay

TITLE = 'TurtleSim'
RED = (200, 10, 20)


class WindowTest(SimulatorCase):

    simulator = None  # each test starts its own

    def simulator_on(self, display, *arguments):
        """Start a simulator on a display (DISPLAY's value), wait for its first pose; return its Process."""
        process = own_simulator(*arguments, DISPLAY=display, QT_QPA_PLATFORM='xcb')
        self.addCleanup(process.stop)
        self.pose()
        return process

    def screen(self):
        """Return a VirtualDisplay that is closed after the test."""
        if MISSING:
            print(MISSING, file=sys.stderr)
            raise unittest.SkipTest(MISSING)
        screen = VirtualDisplay()
        self.addCleanup(screen.close)
        return screen

    def window(self, screen):
        return until(lambda: screen.windows(TITLE), f'a window {TITLE!r}')[0]

    def test_window_shows_the_picture(self):
        """Background, turtle and lines are on the screen."""
        screen = self.screen()
        self.simulator_on(screen.name)
        window = self.window(screen)  # which has its title before its size
        until(lambda: screen.size(window) == (500, 500), 'a window of 500 x 500 px')
        until(lambda: screen.pixel(10, 10) == BACKGROUND, f'the background on the screen; {screen.pixel(10, 10)}')
        until(lambda: screen.pixel(250, 250) != BACKGROUND, 'a turtle in the middle')
        self.call('turtle1/set_pen', *RED, 9, 0)
        self.call('turtle1/teleport_absolute', ARENA, ARENA, 0.0)
        until(lambda: screen.pixel(350, 149) == RED, 'the line from the middle to the upper right corner')

    def test_window_closed_by_the_user_ends_the_simulator(self):
        """Closing the window ends the simulator."""
        screen = self.screen()
        simulator = self.simulator_on(screen.name)
        screen.ask_to_close(self.window(screen))
        self.assertEqual(0, simulator.process.wait(DEADLINE), simulator.output())


if __name__ == '__main__':
    run(WindowTest)
