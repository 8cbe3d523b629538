"""The page of browser.py in Chromium with software rendering on one core (see probing.py)."""
import json
import os
import time

import rospy
from turtlesim.msg import Drawing
from turtlesim.srv import Spawn

from probing import COME_UP, Silent, clock, say
from rostest_support.browser import MISSING, Browser
from topic_probe import drive

PERIOD = 0.3  # [s] between two commands
STROKES = 10000  # before the page is opened; each turtle draws one a step
STEP = 0.016  # [s]
MARK = 'performance.getEntriesByName("first picture").length'
TIMES = ('JSON.stringify([performance.getEntriesByName("first picture")[0].startTime, '
         'performance.getEntriesByType("resource").reduce((sum, one) => sum + one.encodedBodySize, 0)])')


def turtles(port, count, seconds):
    """Let many turtles drive in circles; measure a page that shows them."""
    if MISSING:
        raise Silent(MISSING)
    rospy.wait_for_service('/spawn', COME_UP)
    spawn = rospy.ServiceProxy('/spawn', Spawn)
    places = [(1.0 + 9.0 * number / count, 1.0 + 9.0 * (7 * number % count) / count) for number in range(1, count)]
    names = ['turtle1', *(spawn(x, y, number % 6, '').name for number, (x, y) in enumerate(places))]
    drive([f'{name}/cmd_vel' for name in names], turn=1.0, period=PERIOD)
    time.sleep(STROKES / count * STEP + 1.0)
    messages = []
    rospy.Subscriber('/turtlesim/drawing', Drawing, lambda message: messages.append(clock()))
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # Chromium inherits it
    with Browser() as browser:
        browser.get(f'http://localhost:{port}/')
        browser.until(lambda: browser.evaluate(MARK), 'a first picture')
        first, size = json.loads(browser.evaluate(TIMES))
        messages.clear()
        times = browser.frame_times(seconds)
        say(first=first, size=size, frames=times, drawing=len(messages) / seconds)
