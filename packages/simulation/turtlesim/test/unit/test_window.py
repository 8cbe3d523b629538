"""The simulator's window: the stream of pictures by hand, the window itself on a screen of its own (Xvfb)."""
import pathlib
import signal
import subprocess
import sys
import time

import pytest

import turtlesim.window
from rostest_support.virtual_display import MISSING, VirtualDisplay
from rostest_support.waiting import until
from turtlesim.window import ImageReader, Window

pytestmark = pytest.mark.slow

SIZE = 500  # [px] width and height
RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (69, 86, 255)
UNNOTICED = 0.008  # [s] half a step of the simulator: all that show may take, median of many


def plain(colour):
    return bytes(colour) * (SIZE * SIZE)


def ppm(width, height, colour, header=b'P6 %d %d 255\n'):
    return header % (width, height) + bytes(colour) * (width * height)


class TestImageReader:

    def test_returns_a_picture_when_it_is_complete(self):
        reader, picture = ImageReader(), ppm(3, 2, RED)
        assert [reader.feed(picture[i:i + 1]) for i in range(len(picture))] == [None] * (len(picture) - 1) + [picture]

    def test_returns_the_newest_of_several_and_keeps_what_is_begun(self):
        reader = ImageReader()
        assert reader.feed(ppm(3, 2, RED) + ppm(3, 2, GREEN) + ppm(3, 2, BLUE)[:10]) == ppm(3, 2, GREEN)
        assert reader.feed(ppm(3, 2, BLUE)[10:]) == ppm(3, 2, BLUE)

    def test_a_picture_whose_colours_look_like_a_header_is_one_picture(self):
        picture = b'P6 2 4 255\n' + b'P6 1 1 255\n   P6 1 1 255'[:24]
        assert ImageReader().feed(picture) == picture

    @pytest.mark.parametrize('header', [b'P6\n%d %d\n255\n', b'P6 %d\n%d 255 '])
    def test_header_forms(self, header):
        picture = ppm(3, 2, RED, header)
        assert ImageReader().feed(picture) == picture

    @pytest.mark.parametrize('beginning', [b'\x89PNG\r\n', b'P6 500 500 65535\n', b'P5 9 9 255\n'])
    def test_refuses_what_is_no_such_picture(self, beginning):
        with pytest.raises(ValueError, match='is not a PPM image'):
            ImageReader().feed(beginning + bytes(40))


@pytest.fixture
def display(monkeypatch):
    if MISSING:
        pytest.skip(MISSING)
    with VirtualDisplay() as screen:
        monkeypatch.setenv('DISPLAY', screen.name)
        yield screen


@pytest.fixture
def reports():
    return []


@pytest.fixture
def window(display, reports):
    window = Window('TurtleSim', report=reports.append)
    yield window
    window.close()


def shown_window(display, title='TurtleSim'):
    until(lambda: display.windows(title), f'a window {title!r}')
    return display.windows(title)[0]


def test_has_its_size_and_title(display, window):
    assert display.size(shown_window(display)) == (SIZE, SIZE)
    assert (window.open, window.closed) == (True, False)


def test_shows_every_pixel_in_its_place_and_colour(display, window):
    picture = bytearray(plain(BLUE))
    picture[:3] = RED
    picture[3 * (SIZE - 1):3 * SIZE] = GREEN
    picture[-3:] = (1, 2, 3)
    window.show(bytes(picture))
    until(lambda: display.pixel(0, 0) == RED, 'the red pixel')
    assert [display.pixel(x, y) for x, y in ((1, 0), (499, 0), (499, 499), (0, 499), (498, 499))] == [
        BLUE, GREEN, (1, 2, 3), BLUE, BLUE]
    assert display.pixel(500, 0) == display.pixel(0, 500) == (0, 0, 0)  # nothing beside the window


def test_shows_arrays(display, window):
    numpy = pytest.importorskip('numpy')
    picture = numpy.zeros((SIZE, SIZE, 3), numpy.uint8)
    picture[20, 30] = RED
    window.show(picture)
    until(lambda: display.pixel(30, 20) == RED, 'the red pixel in column 30, row 20')


def test_ends_up_with_the_last_of_many_pictures_and_shows_some_on_the_way(display, window):
    shown_window(display)
    seen = set()
    pictures = [plain((number, 0, 0)) for number in range(1, 256, 2)]
    for picture in pictures:
        window.show(picture)
        seen.add(display.pixel(250, 250))
        time.sleep(0.005)
    until(lambda: display.pixel(250, 250) == (255, 0, 0), 'the last picture')
    assert len(seen) > 3


def test_sends_no_more_pictures_than_anybody_can_see(display, window, monkeypatch):
    sent = []
    monkeypatch.setattr(turtlesim.window, '_send', lambda _, picture: sent.append(picture))
    start = time.monotonic()
    pictures = [plain((number, 0, 0)) for number in range(100)]
    for picture in pictures:
        window.show(picture)
        time.sleep(0.005)
    until(lambda: sent[-1] is pictures[-1], 'the newest picture')
    assert 3 < len(sent) <= (time.monotonic() - start) * 30 + 1
    for _ in range(5):  # again: nothing to do
        window.show(pictures[-1])
        time.sleep(0.04)
    window.show(pictures[0])
    until(lambda: sent[-1] is pictures[0], 'another picture')
    assert sent.count(pictures[-1]) == 1


def test_a_stopped_window_does_not_hold_up_the_simulator(display, window):
    shown_window(display)
    display.process.send_signal(signal.SIGSTOP)  # nothing is drawn any more
    try:
        pictures, times = [plain((number, 0, 0)) for number in range(100)], []
        for picture in pictures:
            start = time.perf_counter()
            window.show(picture)
            times.append(time.perf_counter() - start)
            time.sleep(0.005)
    finally:
        display.process.send_signal(signal.SIGCONT)
    assert sorted(times)[50] < UNNOTICED and max(times) < 1.0
    until(lambda: display.pixel(250, 250) == (99, 0, 0), 'the newest picture')


@pytest.mark.parametrize('size', [0, 3 * SIZE * SIZE - 1, 4 * SIZE * SIZE])
def test_refuses_pictures_of_another_size(window, size):
    with pytest.raises(ValueError, match=f'an image of {size} bytes; it must be 500 x 500 px of 3 bytes'):
        window.show(bytes(size))


def test_the_user_can_close_it(display, window, reports):
    display.ask_to_close(shown_window(display))
    until(lambda: window.closed, 'window.closed')
    assert not window.open and not reports
    window.show(plain(RED))  # too late, and no error
    assert not display.windows('TurtleSim')


def test_close_closes_it_and_is_not_the_user(display, window, reports):
    shown_window(display)
    window.close()
    assert (window.open, window.closed, reports) == (False, False, [])
    until(lambda: not display.windows('TurtleSim'), 'no window')
    window.close()  # once more does no harm


def test_a_window_that_hangs_is_closed_all_the_same(display, window, reports):
    shown_window(display)
    display.process.send_signal(signal.SIGSTOP)
    try:
        window.show(plain(RED))
        window.close()
    finally:
        display.process.send_signal(signal.SIGCONT)
    assert (window.open, window.closed, reports) == (False, False, [])


def test_a_display_that_dies_is_reported_and_is_not_the_user(display, window, reports):
    shown_window(display)
    display.close()
    until(lambda: reports, 'a report')
    assert 'The simulator continues without a window' in reports[0]
    assert (window.open, window.closed) == (False, False)


def test_ends_when_the_simulator_is_killed(display):
    code = f'import sys, time; sys.path[:0] = {sys.path!r}; from turtlesim.window import Window\n'
    simulator = subprocess.Popen([sys.executable, '-c', code + 'Window("orphan"); time.sleep(60)'])
    try:
        shown_window(display, 'orphan')
    finally:
        simulator.kill()
        simulator.wait()
    until(lambda: not display.windows('orphan'), 'no window')


def test_ctrl_c_in_the_terminal_reaches_the_simulator_alone(window):
    assert pathlib.Path(f'/proc/{window._process.pid}/stat').read_text().split()[5] == str(window._process.pid)


@pytest.mark.parametrize('value', [':4711', '', None])
def test_a_display_that_is_not_there_is_reported(monkeypatch, reports, value):
    if value is None:
        monkeypatch.delenv('DISPLAY', raising=False)
    else:
        monkeypatch.setenv('DISPLAY', value)
    window = Window(report=reports.append)
    until(lambda: reports, 'a report')
    assert f'DISPLAY={value or ""} does not answer' in reports[0]
    assert 'set DISPLAY' in reports[0] and '/turtlesim/snapshot' in reports[0] and 'continues without' in reports[0]
    window.show(plain(RED))
    assert (window.open, window.closed) == (False, False)
    window.close()
    assert len(reports) == 1


def test_a_missing_tkinter_is_reported(monkeypatch, tmp_path, reports):
    (tmp_path / 'tkinter.py').write_text('raise ImportError("No module named _tkinter")')
    monkeypatch.syspath_prepend(str(tmp_path))
    window = Window(report=reports.append)
    until(lambda: reports, 'a report')
    assert 'sudo apt install python3-tk' in reports[0] and 'continues without a window' in reports[0]
    window.close()


def test_without_report_the_text_goes_to_standard_error(monkeypatch, capfd):
    monkeypatch.setenv('DISPLAY', ':4711')
    window = Window()
    until(lambda: 'continues without a window' in capfd.readouterr().err, 'the text')
    window.close()


def test_importing_the_module_loads_no_tk():
    code = f'import sys; sys.path[:0] = {sys.path!r}; import turtlesim.window; print("tkinter" in sys.modules)'
    assert subprocess.check_output([sys.executable, '-c', code]) == b'False\n'
