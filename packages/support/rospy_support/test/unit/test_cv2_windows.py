"""cv2's windows: what the functions do in one process; rostest/cv2_windows_test.py has programs and topics."""
import os
import pathlib
import subprocess
import sys
import textwrap
import time

import cv2
import cv2_windows
import numpy as np
import pytest

from rostest_support.virtual_display import MISSING, VirtualDisplay

pytestmark = pytest.mark.slow

FOLDER = pathlib.Path(cv2_windows.__file__).parent
DEADLINE = 30.0  # [s] for a process that has nothing to do, on a busy machine
NO_MASTER = 'http://localhost:1'
IMAGE = np.full((4, 6, 3), 7, np.uint8)


@pytest.fixture(autouse=True)
def _apart(monkeypatch):
    """No display, no node, and no window of the test before."""
    monkeypatch.delenv('DISPLAY', raising=False)
    monkeypatch.setattr(cv2_windows, '_connect', lambda: None)
    cv2.destroyAllWindows()
    cv2_windows._events.clear()


def program(body, **environment):
    """Run a Python program; return (output, errors)."""
    done = subprocess.run([sys.executable, '-c', textwrap.dedent(body)], capture_output=True, text=True, check=False,
                          timeout=DEADLINE,
                          env={**os.environ, 'ROS_MASTER_URI': NO_MASTER, 'DISPLAY': '', **environment})
    return done.stdout, done.stderr


# ------------------------------------------------------------------------------------------------ which OpenCV gets it

def test_a_program_without_opencv_loads_nothing():
    assert program('import sys; print({"cv2", "cv2_windows", "rospy"} & set(sys.modules))')[0] == 'set()\n'


@pytest.mark.parametrize('switch, expected', [('0', False), ('', True), ('1', True)])
def test_one_variable_switches_it_off(switch, expected):
    out, err = program('import cv2; print(cv2.imshow.__module__ == "cv2_windows")', TURTLE_ROBOTONT_CV2_WINDOWS=switch)
    assert out == f'{expected}\n', err


@pytest.mark.parametrize('gui, expected', [('GTK3', False), ('QT5', False), ('NONE', True)])
def test_an_opencv_with_windows_stays_as_it_is(tmp_path, gui, expected):
    (tmp_path / 'cv2.py').write_text(f'def imshow(name, image):\n pass\n'
                                     f'def getBuildInformation():\n return "  GUI:      {gui}\\n  GTK+:   NO"\n')
    out, err = program('import cv2; print(cv2.imshow.__module__ == "cv2_windows")',
                       PYTHONPATH=f'{tmp_path}:{os.environ.get("PYTHONPATH", "")}')
    assert out == f'{expected}\n', err


# -------------------------------------------------------------------------------------------------------------- images

@pytest.mark.parametrize('image, shown', [
    (np.array([[0, 7]], np.uint8), [[0, 7]]),
    (np.array([[[7], [8]]], np.uint8), [[7, 8]]),
    (np.array([[[1, 2, 3, 255]]], np.uint8), [[[1, 2, 3]]]),
    (np.array([[255, 256, 65535]], np.uint16), [[0, 1, 255]]),
    (np.array([[0.0, 0.5, 2.0, -1.0, np.nan]]), [[0, 128, 255, 0, 0]]),
    (np.array([[1.0]], np.float32), [[255]]),
])
def test_an_image_is_shown_in_8_bits(image, shown):
    cv2.imshow('w', image)
    assert cv2_windows._windows['w'].image.tolist() == shown


def test_an_image_is_shown_as_it_was():
    image = IMAGE.copy()
    cv2.imshow('w', image)
    image[:] = 0
    assert cv2_windows._windows['w'].image.tolist() == IMAGE.tolist()


@pytest.mark.parametrize('image', [None, np.empty((0, 3), np.uint8), np.zeros((2, 2, 2), np.uint8), 'a.png'])
def test_what_is_no_image_is_an_error_as_with_windows(image):
    with pytest.raises(cv2.error):
        cv2.imshow('w', image)
    assert cv2.getWindowProperty('w', cv2.WND_PROP_VISIBLE) == 0.0


@pytest.mark.parametrize('name, topic', [('mask', 'mask'), ('Hough circles: 1', 'Hough_circles__1'),
                                         ('2', '2'), ('жёлтый', '______'), ('', '_')])
def test_a_window_has_a_legal_topic(name, topic):
    cv2.namedWindow(name)
    assert cv2_windows._windows[name].topic == f'/cv_window/{topic}'


# ---------------------------------------------------------------------------------------------------------------- keys

@pytest.mark.parametrize('key, code, all_bits', [
    ('q', 113, 113), ('Q', 81, 81), (' ', 32, 32), ('Escape', 27, 27), ('Enter', 13, 13),
    ('ArrowLeft', 81, 65361), ('ä', 228, 228)])
def test_a_key_has_the_code_of_highgui(key, code, all_bits):
    cv2.namedWindow('w')
    for _ in range(2):
        cv2_windows._report('key', 'w', cv2_windows._code(key))
    assert (cv2.waitKey(0), cv2.waitKeyEx(0), cv2.pollKey()) == (code, all_bits, -1)


@pytest.mark.parametrize('delay', [1, 100])
def test_without_a_key_the_delay_passes(delay):
    start = time.monotonic()
    assert cv2.waitKey(delay) == -1
    assert time.monotonic() - start >= delay / 1000.0


def test_for_ever_ends_at_once_without_a_window():
    cv2_windows._report('key', 'gone', 27)
    assert cv2.waitKey(0) == -1
    assert cv2.waitKey() == -1


def test_closing_the_last_window_ends_the_wait():
    cv2.imshow('w', IMAGE)
    cv2_windows._report('close', 'w')
    assert cv2.waitKey(0) == -1
    assert cv2.getWindowProperty('w', cv2.WND_PROP_VISIBLE) == 0.0


def test_ctrl_c_ends_a_wait_for_ever():
    out, err = program("""
        import os, signal, threading, cv2, numpy
        cv2.imshow('w', numpy.zeros((2, 2), numpy.uint8))
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        cv2.waitKey(0)
    """)
    assert err.endswith('KeyboardInterrupt\n') and out == ''


def test_a_program_without_display_and_master_says_what_to_type():
    _, err = program("""
        import cv2, numpy
        cv2.imshow('w', numpy.zeros((2, 2), numpy.uint8))
        cv2.waitKey(2000)
    """)
    assert 'neither a display for the windows nor a ROS master. Type roscore' in err and err.count('\n') == 1


# --------------------------------------------------------------------------------------------------- trackbars, mouse

def test_trackbars_move_within_their_range_and_call_back_in_wait_key():
    calls = []
    cv2.namedWindow('w')
    cv2.createTrackbar('t', 'w', 3, 10, calls.append)
    assert cv2.getTrackbarPos('t', 'w') == 3
    cv2_windows._report('trackbar', 'w', 't', 99)
    cv2_windows._report('trackbar', 'w', 'gone', 1)
    assert (cv2.getTrackbarPos('t', 'w'), calls) == (3, [])
    assert cv2.waitKey(1) == -1
    assert (cv2.getTrackbarPos('t', 'w'), calls) == (10, [10])
    cv2.setTrackbarMax('t', 'w', 8)
    cv2.setTrackbarMin('t', 'w', 2)
    cv2.setTrackbarPos('t', 'w', -1)
    cv2.setTrackbarPos('t', 'w', 2)
    assert (cv2.getTrackbarPos('t', 'w'), calls) == (2, [10, 8, 2])


@pytest.mark.parametrize('function, arguments, said', [
    ('getTrackbarPos', ('t', 'no'), "NULL window: 'no'"),
    ('createTrackbar', ('t', 'no', 0, 1, None), "NULL window: 'no'"),
    ('setMouseCallback', ('no', print), "NULL window: 'no'"),
    ('getTrackbarPos', ('no', 'w'), "NULL trackbar: 'no' in the window 'w'. It has: 't'"),
])
def test_a_wrong_name_is_an_error_that_says_so(function, arguments, said):
    cv2.namedWindow('w')
    cv2.createTrackbar('t', 'w', 0, 1, None)
    with pytest.raises(cv2.error, match=said):
        getattr(cv2, function)(*arguments)


def test_the_mouse_calls_back_with_its_buttons():
    calls = []
    cv2.namedWindow('w')
    cv2.setMouseCallback('w', lambda *values: calls.append(values), 'mine')
    for event in (cv2.EVENT_LBUTTONDOWN, cv2.EVENT_MOUSEMOVE, cv2.EVENT_LBUTTONUP, cv2.EVENT_MOUSEMOVE):
        cv2_windows._report('mouse', 'w', event, 5, 6)
    cv2_windows._report('mouse', 'w', cv2.EVENT_RBUTTONDOWN, 5, 6, cv2.EVENT_FLAG_CTRLKEY)
    assert cv2.waitKey(1) == -1
    assert [(event, flags) for event, _, _, flags, _ in calls] == [
        (cv2.EVENT_LBUTTONDOWN, cv2.EVENT_FLAG_LBUTTON), (cv2.EVENT_MOUSEMOVE, cv2.EVENT_FLAG_LBUTTON),
        (cv2.EVENT_LBUTTONUP, 0), (cv2.EVENT_MOUSEMOVE, 0),
        (cv2.EVENT_RBUTTONDOWN, cv2.EVENT_FLAG_RBUTTON + cv2.EVENT_FLAG_CTRLKEY)]
    assert calls[0][1:3] == (5, 6) and calls[0][4] == 'mine'


# ------------------------------------------------------------------------------------------------------------- display

@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_a_display_has_a_window_until_its_user_closes_it():
    with VirtualDisplay() as display:
        process = subprocess.Popen([sys.executable, '-c', textwrap.dedent("""
            import cv2, numpy
            cv2.imshow('on a display', numpy.full((100, 200, 3), (200, 0, 100), numpy.uint8))
            cv2.createTrackbar('t', 'on a display', 1, 5, None)
            print(cv2.waitKey(0), cv2.getWindowProperty('on a display', cv2.WND_PROP_VISIBLE))
        """)], stdout=subprocess.PIPE, text=True, env={**os.environ, 'ROS_MASTER_URI': NO_MASTER,
                                                       'DISPLAY': display.name})
        end = time.monotonic() + DEADLINE
        while time.monotonic() < end and not (
                display.windows('on a display') and display.size(display.windows('on a display')[0])[1] > 110
                and display.pixel(100, 100) == (100, 0, 200)):
            time.sleep(0.05)
        assert display.pixel(100, 100) == (100, 0, 200)
        display.ask_to_close(display.windows('on a display')[0])
        assert process.communicate(timeout=DEADLINE)[0] == '-1 0.0\n'


def test_a_display_that_is_gone_is_said_and_the_program_goes_on():
    out, err = program("""
        import cv2, numpy
        cv2.imshow('w', numpy.zeros((2, 2), numpy.uint8))
        print(cv2.waitKey(1500))
    """, DISPLAY=':9999')
    assert out == '-1\n' and 'cv2: no window: couldn\'t connect to display ":9999"' in err
