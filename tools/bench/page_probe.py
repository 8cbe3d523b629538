"""The page of browser.py in Chromium with software rendering on one core (see probing.py)."""
import json
import os
import time

import rospy
from turtlesim.msg import Drawing
from turtlesim.srv import Spawn

from probing import COME_UP, Silent, clock, say
from rostest_support.browser import MISSING, Browser
from topic_probe import awaited, drive

PERIOD = 0.3  # [s] between two commands
STROKES = 10000  # before the page is opened; each turtle draws one a step
STEP = 0.016  # [s]
POSE = '/turtle1/pose'
SETTLE = 3.0  # [s] after the last panel was opened
PANELS = '[...document.querySelectorAll("#menu a")].map(one => one.dataset.id)'
MARK = 'performance.getEntriesByName("first picture").length'
TIMES = ('JSON.stringify([performance.getEntriesByName("first picture")[0].startTime, '
         'performance.getEntriesByType("resource").reduce((sum, one) => sum + one.encodedBodySize, 0)])')


def turtles(port, count, seconds):
    """Let many turtles drive in circles; measure a page that shows them."""
    spawn = _spawner()
    places = [(1.0 + 9.0 * number / count, 1.0 + 9.0 * (7 * number % count) / count) for number in range(1, count)]
    names = ['turtle1', *(spawn(x, y, number % 6, '').name for number, (x, y) in enumerate(places))]
    drive([f'{name}/cmd_vel' for name in names], turn=1.0, period=PERIOD)
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
    drive(['turtle1/cmd_vel'], turn=1.0, period=PERIOD)
    address = f'http://localhost:{port}/'
    with _one_core_browser() as browser:
        browser.get(address)
        names = browser.until(lambda: browser.evaluate(PANELS), 'the menu')
        for name in names:
            browser.driver.switch_to.new_window('window')
            browser.get(f'{address}#/{name}')
            browser.until(lambda: browser.find('#link.good'), f'the panel {name}')
        stamps = awaited(POSE)
        time.sleep(SETTLE)
        stamps.clear()
        time.sleep(seconds)
        say(stamps=stamps, panels=len(names))


def _one_core_browser():
    if MISSING:
        raise Silent(MISSING)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # Chromium inherits it
    return Browser()


def _spawner():
    rospy.wait_for_service('/spawn', COME_UP)
    return rospy.ServiceProxy('/spawn', Spawn)
