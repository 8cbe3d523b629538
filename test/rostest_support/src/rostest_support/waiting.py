"""Wait for what another thread or process does; without ROS, for units, too."""
import time

DEADLINE = 60.0  # [s] for things that take well under a second on an idle machine
POLL = 0.01  # [s]


def until(condition, what='', deadline=DEADLINE):
    """Poll ``condition`` until it is true; return its value.

    After ``deadline`` [s], raise AssertionError with ``what``, a text or a function that returns one.
    """
    end = time.monotonic() + deadline
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f'not within {deadline:g} s: {what() if callable(what) else what or condition}')
        time.sleep(POLL)
