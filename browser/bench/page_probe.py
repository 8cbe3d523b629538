"""The page of browser.py in Chromium with software rendering on one core (see probing.py)."""
import json
import os
import socket
import struct
import threading
import time

import rospy
from turtlesim.msg import Drawing
from turtlesim.srv import Spawn

from probing import COME_UP, Silent, await_true, clock, say
from rosbridge_probe import connected
from rostest_support.browser import MISSING, Browser
from turtlesim_probe import Receiver, drive

PERIOD = 0.3  # [s] between two commands
STROKES = 10000  # before the page is opened; each turtle draws one a step
STEP = 0.016  # [s]
POSE = '/turtle1/pose'
OPENED = 120.0  # [s] until one more of many pages is connected
SMALL = 240, 240  # [px] of each of many pages: a machine without a GPU cannot draw them all in their usual size
ON_THE_WAY = 3  # poses that one of two clients may have when they are counted
SETTLE = 3.0  # [s] after the last panel was opened
PANELS = '[...document.querySelectorAll("#menu a")].map(one => one.dataset.id)'
MARK = 'performance.getEntriesByName("first picture").length'
TIMES = ('JSON.stringify([performance.getEntriesByName("first picture")[0].startTime, '
         'performance.getEntriesByType("resource").reduce((sum, one) => sum + one.encodedBodySize, 0)])')


def turtles(port, count, seconds):
    """Let many turtles drive in circles; measure a page that shows them."""
    spawn = _spawner()
    places = [(1.0 + 9.0 * number / count, 1.0 + 9.0 * (7 * number % count) / count) for number in range(1, count)]
    drive(['turtle1', *(spawn(x, y, number % 6, '').name for number, (x, y) in enumerate(places))], turn=1.0,
          period=PERIOD)
    time.sleep(STROKES / count * STEP + 1.0)
    messages = []
    rospy.Subscriber('/turtlesim/drawing', Drawing, lambda message: messages.append(clock()))
    with _one_core_browser() as browser:
        browser.get(f'http://localhost:{port}/')
        browser.until(lambda: browser.evaluate(MARK), 'a first picture')
        first, size = json.loads(browser.evaluate(TIMES))
        messages.clear()
        times = browser.frame_times(seconds)
        say(first=first, size=size, frames=times, drawing=len(messages) / seconds)


def panels(port, seconds):
    """Let a turtle drive; report the stamps [s] of its poses while each panel is shown in a window of its own."""
    _spawner()
    drive(['turtle1'], turn=1.0, period=PERIOD)
    address = f'http://localhost:{port}/'
    with _one_core_browser() as browser:
        browser.get(address)
        names = browser.until(lambda: browser.evaluate(PANELS), 'the menu')
        for name in names:
            browser.driver.switch_to.new_window('window')
            browser.get(f'{address}#/{name}')
            browser.until(lambda: browser.find('#link.good'), f'the panel {name}')
        receiver = Receiver(['turtle1'])
        time.sleep(SETTLE)
        start = len(receiver.stamps['turtle1'])
        time.sleep(seconds)
        say(stamps=receiver.stamps['turtle1'][start:], panels=len(names))


def soak(port, count, seconds):
    """Open many pages, each in a window of its own; report their heaps [MB] at the end, their growth since half of the
    time, and how many poses a client beside them has lost.
    """
    _spawner()
    drive(['turtle1'], turn=1.0, period=PERIOD)
    places = '#/turtle', '#/plot?fields=/turtle1/pose/x'
    if MISSING:
        raise Silent(MISSING)
    with Browser() as browser:
        for number in range(count):
            browser.driver.switch_to.new_window('window')
            browser.resize(*SMALL)
            browser.get(f'http://localhost:{port}/{places[number % len(places)]}')
            browser.until(lambda: browser.find('#link.good'), f'page {number + 1}', OPENED)
        handles = browser.driver.window_handles[1:]
        witness, receiver = Witness(port), Receiver(['turtle1'])
        heard, sent = len(witness.stamps), len(receiver.stamps['turtle1'])
        time.sleep(seconds / 2)
        before = [_heap(browser, handle) for handle in handles]
        time.sleep(seconds / 2)
        after = [_heap(browser, handle) for handle in handles]
        sent, heard = len(receiver.stamps['turtle1']) - sent, len(witness.stamps) - heard
    say(heap=after, grown=[late - early for early, late in zip(before, after)], lost=max(0, sent - heard - ON_THE_WAY))


def _heap(browser, handle):
    """Return what a page keeps in memory [MB]."""
    browser.driver.switch_to.window(handle)
    browser.devtools('HeapProfiler.collectGarbage')
    return browser.devtools('Runtime.getHeapUsage')['usedSize'] / 1e6


class Witness:
    """A client of the page's server that gets all poses of a turtle: ``stamps`` [s]."""

    def __init__(self, port):
        self.stamps = []
        self._socket = connected(port)
        self._socket.subscribe(POSE, 'turtlesim/Pose', queue_length=1000)
        threading.Thread(target=self._run, daemon=True).start()
        await_true(lambda: self.stamps, COME_UP, 'a pose at the client beside the pages')

    def _run(self):
        while True:
            for received in self._socket.frames():
                if b'"publish"' in received:
                    self.stamps.append(clock())


def visitors(port, count, seconds):
    """Let clients connect; one third closes the connection, one resets it, one reads nothing. Report the stamps [s] of
    the poses of a client that only listens.
    """
    _spawner()
    drive(['turtle1'], turn=1.0, period=PERIOD)
    witness, stalled, start = Witness(port), [], clock()
    witness.stamps.clear()
    for number in range(count):
        time.sleep(max(0.0, start + seconds * number / count - clock()))
        client = connected(port)
        client.subscribe(POSE, 'turtlesim/Pose')
        client.subscribe('/turtlesim/image_raw', 'sensor_msgs/Image')
        if number % 3 == 0:
            stalled.append(client)
            continue
        if number % 3 == 1:
            client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))  # close() resets it
        client.close()
    time.sleep(SETTLE)
    say(stamps=witness.stamps, stalled=len(stalled))


def _one_core_browser():
    if MISSING:
        raise Silent(MISSING)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # Chromium inherits it
    return Browser()


def _spawner():
    rospy.wait_for_service('/spawn', COME_UP)
    return rospy.ServiceProxy('/spawn', Spawn)
