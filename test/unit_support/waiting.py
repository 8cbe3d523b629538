"""Wait for what another thread or process does."""
import time

DEADLINE = 60.0  # [s] for what takes a part of one on an idle machine
POLL = 0.005  # [s]


def until(condition, what='', deadline=DEADLINE):
    """Poll ``condition`` until it is true; return its value. After ``deadline`` [s], raise AssertionError."""
    end = time.monotonic() + deadline
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < end, f'not within {deadline:g} s: {what or condition}'
        time.sleep(POLL)
