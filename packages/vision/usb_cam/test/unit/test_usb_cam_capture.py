"""usb_cam.core.capture: the thread between sources and sink, with sources under the control of the test."""
import threading
import time

import pytest

from rostest_support.waiting import until
from usb_cam.core.capture import Capture, FrameSchedule
from usb_cam.core.sources import EndOfSource, SourceError

DEADLINE = 20.0  # [s] for what takes milliseconds on an idle machine
RETRY = 0.01  # [s]


class Source:
    """A source that numbers its pictures; ``script`` {number of a grab: exception}."""

    def __init__(self, live=False, script=None, rate=500.0):
        self.live, self.script, self.rate = live, script or {}, rate
        self.grabs, self.closed = 0, False

    def grab(self):
        assert not self.closed
        self.grabs += 1
        if self.live:
            time.sleep(0.002)
        if self.grabs in self.script:
            raise self.script[self.grabs]

    def close(self):
        self.closed = True


class Sink:
    """Notes the calls of a Capture."""

    def __init__(self):
        self.looked_at, self.pictures, self.troubles, self.sources, self.ends = True, [], [], [], 0
        self.blocked = threading.Event()

    def wanted(self):
        return self.looked_at

    def opened(self, source):
        self.sources.append(source)

    def picture(self, source):
        self.pictures.append((len(self.sources), source.grabs))

    def trouble(self, text):
        self.troubles.append(text)

    def ended(self):
        self.ends += 1


@pytest.fixture
def sink():
    return Sink()


@pytest.fixture
def captured(sink):
    """Return a function that captures from the entries of a list, one per attempt, and repeats the last one."""
    made = []

    def begin(*entries):
        left = list(entries)

        def open_next():
            entry = left.pop(0) if len(left) > 1 else left[0]
            if isinstance(entry, Exception):
                raise entry
            return entry() if callable(entry) else entry
        made.append(Capture(open_next, sink, RETRY))
        return made[-1]
    yield begin
    for capture in made:
        capture.close()


def test_nothing_is_opened_before_start(captured, sink):
    capture = captured(Source())
    assert capture.stop() and not sink.sources
    capture.start()
    until(lambda: len(sink.pictures) > 3, 'pictures')
    assert sink.pictures[:3] == [(1, 1), (1, 2), (1, 3)]


def test_after_stop_there_are_no_pictures_the_source_is_closed_and_start_opens_it_again(captured, sink):
    capture = captured(Source)
    for round_ in (1, 2, 3):
        capture.start()
        until(lambda: (round_, 5) in sink.pictures, 'pictures')  # noqa: B023
        assert capture.stop()
        number = len(sink.pictures)
        assert sink.sources[-1].closed
        time.sleep(0.02)  # ten pictures long
        assert len(sink.pictures) == number and len(sink.sources) == round_


def test_stop_says_when_the_source_hangs_and_gives_way_to_a_later_start(captured, sink, monkeypatch):
    hangs, source = threading.Event(), Source()
    sink.picture = lambda _: hangs.wait(DEADLINE)
    capture = captured(source)
    capture.start()
    until(lambda: source.grabs, 'a grab')
    monkeypatch.setattr('usb_cam.core.capture.STOP_TIMEOUT', 0.05)
    assert not capture.stop()
    monkeypatch.setattr('usb_cam.core.capture.STOP_TIMEOUT', DEADLINE)
    capture.start()
    stopping = threading.Thread(target=capture.stop)
    stopping.start()
    until(lambda: not capture._running, 'the second stop')
    capture.start()
    stopping.join(DEADLINE / 2.0)
    assert not stopping.is_alive() and not hangs.is_set()
    hangs.set()


def test_trouble_is_told_and_tried_again_until_it_works(captured, sink):
    pulled = Source(script={3: SourceError('pulled out')})
    captured(SourceError('missing'), SourceError('busy'), pulled, SourceError('missing'), Source()).start()
    until(lambda: (2, 2) in sink.pictures, 'pictures of the second source')
    assert sink.troubles == ['missing', 'busy', 'pulled out', 'missing']
    assert pulled.closed and sink.pictures[:3] == [(1, 1), (1, 2), (2, 1)]


def test_at_the_end_it_waits_for_start(captured, sink):
    capture = captured(lambda: Source(script={3: EndOfSource()}))
    for round_ in (1, 2):
        capture.start()
        until(lambda: sink.ends == round_, 'the end')  # noqa: B023
    assert sink.pictures == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert all(source.closed for source in sink.sources) and not sink.troubles


def test_files_stand_still_while_nobody_looks_and_webcams_go_on_unseen(captured, sink):
    sink.looked_at = False
    file, webcam = Source(), Source(live=True)
    capture = captured(file)
    capture.start()
    until(lambda: sink.sources, 'an open file')
    captured(webcam).start()
    until(lambda: webcam.grabs > 5, 'grabs of the webcam')
    assert not sink.pictures and file.grabs == 0
    sink.looked_at = True
    capture.wake()
    until(lambda: file.grabs > 2, 'grabs of the file')


def test_stop_and_close_come_through_whatever_it_waits_for(captured, sink):
    begun = time.monotonic()
    for number, looked_at in enumerate((True, False), 1):
        sink.looked_at = looked_at
        capture = captured(Source(rate=0.01))
        capture.start()
        until(lambda: len(sink.sources) == number, 'an attempt')  # noqa: B023
        capture.close()
        assert not capture._thread.is_alive()
    assert time.monotonic() - begun < DEADLINE


def test_files_keep_their_rate(captured, sink):
    capture = captured(Source(rate=50.0))
    times = []
    sink.picture = lambda source: times.append(time.monotonic())
    capture.start()
    until(lambda: len(times) > 30, '31 pictures')
    capture.stop()
    # 30 periods of 20 ms; the median of the gaps does not mind a busy machine
    gaps = sorted(second - first for first, second in zip(times, times[1:]))
    assert gaps[len(gaps) // 2] == pytest.approx(0.02, abs=0.004)


# ------------------------------------------------------- deadlines on a grid, by a clock that only the test moves

ROUNDING = 1e-9  # [s]


class Clock:
    now = 1000.0

    def __call__(self):
        return self.now


def shown_at(rate, works):
    """Return when each of the pictures was begun, from 0 on, if working on them takes ``works`` [s]."""
    clock, times = Clock(), []
    schedule = FrameSchedule(rate, clock)
    for work in works:
        clock.now += max(0.0, schedule.time_left())
        schedule.advance()
        times.append(clock.now - 1000.0)
        clock.now += work
    return times


def test_pictures_keep_the_rate_whatever_each_takes():
    # 900 pictures at 30 Hz that take from 0 to 32 ms: number k begins at k / 30 s, without drift
    times = shown_at(30.0, [(number * 7 % 33) / 1000.0 for number in range(900)])
    assert times == pytest.approx([number / 30.0 for number in range(900)], abs=ROUNDING)


@pytest.mark.parametrize('late, expected', [
    (0.13, [0.0, 0.13, 0.2, 0.3]),  # a little: the grid is kept
    (0.57, [0.0, 0.57, 0.6, 0.7]),  # more than a period: missed images are skipped, without a burst, and the grid stays
])
def test_a_late_picture_puts_off_no_other(late, expected):
    assert shown_at(10.0, [late, 0.0, 0.0, 0.0]) == pytest.approx(expected, abs=ROUNDING)


def test_too_slow_for_the_rate_means_as_fast_as_it_goes_on_the_grid():
    assert shown_at(10.0, [0.25] * 4) == pytest.approx([0.0, 0.25, 0.5, 0.75], abs=ROUNDING)


def test_after_a_break_the_next_picture_is_due_at_once():
    clock = Clock()
    schedule = FrameSchedule(2.0, clock)
    schedule.advance()
    assert schedule.time_left() == pytest.approx(0.5, abs=ROUNDING)
    clock.now += 60.0
    schedule.restart()
    assert schedule.time_left() == 0.0
    schedule.advance()
    assert schedule.time_left() == pytest.approx(0.5, abs=ROUNDING)
