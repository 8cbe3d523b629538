"""The page of browser.py in Chromium with software rendering on one core (see probing.py)."""
import http.client
import itertools
import json
import os
import select
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
from topic_probe import awaited, drive

PERIOD = 0.3  # [s] between two commands
STROKES = 10000  # before the page is opened; each turtle draws one a step
STEP = 0.016  # [s]
POSE = '/turtle1/pose'
PLACE = struct.Struct('<3f')  # x, y and theta of a pose
WATCHED = {'#/turtle': '/turtlesim/drawing', '#/plot?fields=/turtle1/pose/x': POSE}  # panels: what they must not lose
RECORDED = 12.0  # [s] of what a page sends
RECORDER = '''
window.soak = {count: 0, last: '', connections: 0, recording: true, sent: []};
window.WebSocket = class extends WebSocket {
  constructor(...place) {
    super(...place);
    soak.connections += 1;
    this.addEventListener('message', ({data}) => {
      const head = data.slice(0, 200);
      if (!head.includes('"publish"') || !head.includes(TOPIC)) return;
      soak.count += 1;
      soak.last = data;
    });
  }
  send(data) {
    if (soak.recording) soak.sent.push([performance.now(), data]);
    super.send(data);
  }
};'''
FILES = '[...new Set(performance.getEntriesByType("resource").map(one => new URL(one.name).pathname))]'
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


def soak(port, count, seconds):
    """Keep two pages open in Chromium, one with the turtle and one with a plot, among ``count`` pages; the others are
    clients without a browser, because a class has a browser on each student's machine. About each minute, say how many
    are connected, how many messages all have lost so far, and the heaps [MB] of the two.
    """
    if MISSING:
        raise Silent(MISSING)
    _spawner()
    drive(['turtle1/cmd_vel'], turn=1.0, period=PERIOD)
    numbers = {'/turtlesim/drawing': lambda message: message['number'], POSE: PoseNumbers()}
    with Browser() as browser:
        pages = [Page(browser, f'http://localhost:{port}/{place}', topic) for place, topic in WATCHED.items()]
        time.sleep(RECORDED)
        for page in pages:
            page.end_record()
        crowd = Crowd(port, [pages[number % len(pages)] for number in range(count - len(pages))])
        losses = [Loss(one, numbers[one.topic]) for one in (*pages, *crowd.clients)]
        steps = 2 * max(1, round(seconds / 120))
        start = clock()
        for step in range(1, steps + 1):
            time.sleep(max(0.0, start + seconds * step / steps - clock()))
            heaps = [page.heap() for page in pages]
            say(minutes=(clock() - start) / 60, half=step == steps // 2, ended=step == steps, heaps=heaps,
                connected=sum(page.is_connected() for page in pages) + sum(one.open for one in crowd.clients),
                lost=[loss.count() for loss in losses], unanswered=crowd.unanswered, why=crowd.ended)


class Page:
    """A page in a window of its own, in the foreground. It records what it sends and receives."""

    def __init__(self, browser, address, topic):
        self.topic, self._browser = topic, browser
        browser.driver.switch_to.new_window('window')
        self._handle = browser.driver.current_window_handle
        browser.devtools('Page.addScriptToEvaluateOnNewDocument', source=RECORDER.replace('TOPIC', json.dumps(topic)))
        browser.get(address)
        browser.until(lambda: browser.find('#link.good') and self.seen()[0], address, COME_UP)

    def _evaluate(self, expression):
        self._browser.driver.switch_to.window(self._handle)
        return self._browser.evaluate(expression)

    def end_record(self):
        """Note the files that were loaded, the operations that were sent, and those of the second half."""
        sent = self._evaluate('soak.sent.splice(0)')
        half = self._evaluate('soak.recording = false, performance.now()') - 1e3 * RECORDED / 2
        self.files = self._evaluate(FILES)
        self.operations = [json.loads(data) for _, data in sent]
        self.repeated = [json.loads(data) for time, data in sent if time > half]

    def seen(self):
        """Return how many messages have come, and the last one as JSON."""
        return self._evaluate('[soak.count, soak.last]')

    def is_connected(self):
        """Return whether its first connection is open."""
        return self._evaluate('soak.connections === 1 && document.querySelector("#link.good") !== null')

    def heap(self):
        """Return what it keeps in memory [MB]."""
        self._browser.driver.switch_to.window(self._handle)
        self._browser.devtools('HeapProfiler.collectGarbage')
        return self._browser.devtools('Runtime.getHeapUsage')['usedSize'] / 1e6


class PoseNumbers:
    """The number of each pose of turtle1, in their order; a turtle that drives is at no place twice in a lap."""

    def __init__(self):
        self._numbers, self._counter = {}, itertools.count()
        rospy.Subscriber(POSE, rospy.AnyMsg, self._received, tcp_nodelay=True)

    def _received(self, message):
        self._numbers[message._buff[:PLACE.size]] = next(self._counter)

    def __call__(self, message):
        place = PLACE.pack(message['x'], message['y'], message['theta'])
        await_true(lambda: place in self._numbers, COME_UP, f'the pose {message} at a subscriber')
        return self._numbers[place]


class Loss:
    """Counts the messages that one page or client has lost from now on."""

    def __init__(self, receiver, number):
        self._receiver, self._number = receiver, number
        await_true(lambda: receiver.seen()[0], COME_UP, f'a message of {receiver.topic}')
        self._begin = self._missing()

    def _missing(self):
        count, last = self._receiver.seen()
        return self._number(json.loads(last)['msg']) - count

    def count(self):
        """Return their number."""
        return self._missing() - self._begin


class Follower:
    """A client without a browser: it loads the files of a Page, sends what that has sent, and reads what comes."""

    def __init__(self, port, page):
        self.topic, self.open, self._page, self._seen = page.topic, True, page, (0, '')
        self.http = http.client.HTTPConnection('localhost', port, timeout=COME_UP)
        for file in page.files:
            if not self.request(file):
                raise Silent(f'{file} is not answered')
        self.socket = connected(port)
        self.ask(page.operations)

    def request(self, path):
        """Return whether a request is answered; on a new connection if the server has closed an idle one."""
        for _ in range(2):
            try:
                self.http.request('GET', path)
                answer = self.http.getresponse()
                answer.read()
                return answer.status == 200
            except (OSError, http.client.HTTPException):
                self.http.close()
        return False

    def ask(self, operations):
        """Send operations."""
        self.due = clock() + RECORDED / 2
        for operation in operations:
            self.socket.send(**operation)

    def read(self):
        """Read what has come; then ask again, as the page does."""
        for received in self.socket.frames():
            if b'"publish"' in received[:200] and self.topic.encode() in received[:200]:
                self._seen = self._seen[0] + 1, received
        if clock() > self.due:
            self.ask(self._page.repeated)

    def seen(self):
        """Return how many messages have come, and the last one as JSON."""
        return self._seen

    def fileno(self):
        """Return the socket's, for select."""
        return self.socket.fileno()


class Crowd:
    """Followers of some pages. One thread reads, another requests the server's status once a second for each."""

    def __init__(self, port, pages):
        self.clients, self.unanswered, self.ended = [], 0, ''
        for work in (self._read, self._poll):  # from the start: the server ends a connection that is not read
            threading.Thread(target=work, daemon=True).start()
        for page in pages:
            self.clients.append(Follower(port, page))

    def _read(self):
        while True:
            for client in select.select([one for one in self.clients if one.open], [], [], PERIOD)[0]:
                try:
                    client.read()
                except OSError as error:
                    client.open, self.ended = False, f'{client.topic}: {error}'

    def _poll(self):
        start = clock()
        for second in itertools.count(1):
            for client in list(self.clients):
                self.unanswered += not client.request('/status')
            time.sleep(max(0.0, start + second - clock()))


def visitors(port, count, seconds):
    """Let clients connect; one third closes the connection, one resets it, one reads nothing. Report the stamps [s] of
    the poses of a client that only listens.
    """
    _spawner()
    drive(['turtle1/cmd_vel'], turn=1.0, period=PERIOD)
    witness, stamps, stalled = connected(port), [], []
    witness.subscribe(POSE, 'turtlesim/Pose', queue_length=1000)

    def read():
        while True:
            stamps.extend(clock() for received in witness.frames() if b'"publish"' in received)
    threading.Thread(target=read, daemon=True).start()
    await_true(lambda: stamps, COME_UP, 'a pose at the client beside the pages')
    stamps.clear()
    start = clock()
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
    say(stamps=stamps, stalled=len(stalled))


def _one_core_browser():
    if MISSING:
        raise Silent(MISSING)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # Chromium inherits it
    return Browser()


def _spawner():
    rospy.wait_for_service('/spawn', COME_UP)
    return rospy.ServiceProxy('/spawn', Spawn)
