"""The page of browser.py in Chromium with software rendering on one core: `page_probe.py turtles | panels --port N`.

Prints one line of JSON: when the first picture is there, and the times between frames while many turtles draw; or the
stamps of a turtle's poses while all panels are open.
"""

import argparse
import json
import os
import sys
import threading

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Drawing
from turtlesim.srv import Spawn

from rostest_support.browser import MISSING, Browser
from turtlesim_probe import COME_UP, Receiver, await_true, clock, run_task, say

ARENA = 11.0  # [m]
STROKES = 10000  # before the page is opened; each turtle draws one a step
STEP = 0.016  # [s]
SETTLE = 3.0  # [s] after the last panel was opened
PANELS = '[...document.querySelectorAll("#menu a")].map(one => one.dataset.id)'
MARK = 'performance.getEntriesByName("first picture").length'
TIMES = ('JSON.stringify([performance.getEntriesByName("first picture")[0].startTime, '
         'performance.getEntriesByType("resource").reduce((sum, one) => sum + one.encodedBodySize, 0)])')


def turtles(options):
    """Let many turtles drive in circles; measure a page that shows them."""
    ended = _drive(_spawned(options.count))
    ended.wait(STROKES / options.count * STEP + 1.0)
    messages = []
    rospy.Subscriber('/turtlesim/drawing', Drawing, lambda message: messages.append(clock()))
    _use_one_core()
    with Browser() as browser:
        browser.get(f'http://localhost:{options.port}/')
        browser.until(lambda: browser.evaluate(MARK), 'a first picture')
        first, size = json.loads(browser.evaluate(TIMES))
        messages.clear()
        times = browser.frame_times(options.seconds)
        say(first=first, size=size, frames=times, drawing=len(messages) / options.seconds)
    ended.set()


def panels(options):
    """Let a turtle drive; report the stamps [s] of its poses while each panel is shown in a window of its own."""
    _use_one_core()
    await_true(lambda: _served('/spawn'), COME_UP, 'a simulator')
    ended = _drive(['turtle1'])
    address = f'http://localhost:{options.port}/'
    with Browser() as browser:
        browser.get(address)
        names = browser.until(lambda: browser.evaluate(PANELS), 'the menu')
        for name in names:
            browser.driver.switch_to.new_window('window')
            browser.get(f'{address}#/{name}')
            browser.until(lambda: browser.find('#link.good'), f'the panel {name}')
        receiver = Receiver(['turtle1'])
        ended.wait(SETTLE)
        start = len(receiver.stamps['turtle1'])
        ended.wait(options.seconds)
        say(stamps=receiver.stamps['turtle1'][start:], panels=len(names))
    ended.set()


def _use_one_core():
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # Chromium inherits it


def _drive(names):
    """Let turtles drive in circles until the Event that is returned is set."""
    driving = [rospy.Publisher(f'/{name}/cmd_vel', Twist, queue_size=1) for name in names]
    command = Twist()
    command.linear.x, command.angular.z = 1.0, 1.0
    ended = threading.Event()

    def drive():
        while not ended.wait(0.3):
            for publisher in driving:
                publisher.publish(command)
    threading.Thread(target=drive, daemon=True).start()
    return ended


def _spawned(count):
    spawn = rospy.ServiceProxy('/spawn', Spawn)
    await_true(lambda: _served('/spawn'), COME_UP, 'a simulator')
    places = [(1.0 + 9.0 * number / count, 1.0 + 9.0 * (7 * number % count) / count) for number in range(1, count)]
    return ['turtle1', *(spawn(x, y, number % 6, '').name for number, (x, y) in enumerate(places))]


def _served(name):
    try:
        rospy.wait_for_service(name, 0.1)
        return True
    except rospy.ROSException:
        return False


TASKS = {'turtles': turtles, 'panels': panels}


def main():
    """Run the task that the command line names."""
    parser = argparse.ArgumentParser(description='one measurement of the page')
    parser.add_argument('task', choices=sorted(TASKS))
    parser.add_argument('--port', type=int, required=True, help='of browser.py')
    parser.add_argument('--count', type=int, default=100, help='turtles')
    parser.add_argument('--seconds', type=float, default=5.0, help='window [s]')
    options = parser.parse_args()
    if MISSING:
        print(MISSING, file=sys.stderr)
        return 1
    return run_task(TASKS, options)


if __name__ == '__main__':
    sys.exit(main())
