"""Client of a rosbridge server (see probing.py)."""
import json
import os
import select
import threading
import time

import rospy
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import Image

from figures import rate_in_window, stratified_phases
from probing import COME_UP, Silent, await_true, clock, repeat, say
from rostest_support.websocket_client import WebSocket, masked

PORT = '/rosbridge_websocket/actual_port'
ECHO = '/bench/echo'
FLOOD = '/bench/flood'
IMAGES = '/bench/images'
POSES = '/bench/poses'
VELOCITY = '/bench/cmd_vel'
PERIOD = 0.02  # [s] between two round trips
LARGE = 1 << 14  # [B]; a frame that is not larger is no image
LATE = 0.1  # [s] after which a message is late
STEP = 1.25  # between two rates
FLOOD_RATE = 20000  # [Hz] of POSE, more than a server in Python can do
FLOOD_TIME = 1.0  # [s]
DRIVE_RATE = 40  # [Hz] of a joystick
ONE_ANSWER = 60.0  # [s] until a message counts as lost
SUBSCRIBERS = 20  # among which the messages of the memory's measurement are shared out
SETTLE = 1.0  # [s]
PAGE_RATE = 10.0  # [Hz]
POSE_RATE = 62.5  # [Hz]
TWIST = {'linear': {'x': 0.5, 'y': 0.0, 'z': 0.0}, 'angular': {'x': 0.0, 'y': 0.0, 'z': 0.2}}
POSE = {'header': {'frame_id': 'map'}, 'pose': {'position': {'x': 1.5, 'y': -2.5, 'z': 0.0},
                                                'orientation': {'x': 0.0, 'y': 0.0, 'z': 0.6, 'w': 0.8}}}
ZERO = {part: dict.fromkeys('xyz', 0.0) for part in ('linear', 'angular')}


def connected():
    """Return a connection to the server once it listens. The master may still have the port of an earlier one."""
    deadline = clock() + COME_UP
    while True:
        try:
            return WebSocket(('127.0.0.1', rospy.get_param(PORT)), COME_UP)
        except (OSError, KeyError):
            if clock() > deadline:
                raise
        time.sleep(0.05)


def text(number, size=100):
    """Return a std_msgs/String of so many bytes with a number."""
    return {'data': f'{number:09d}'.ljust(size, 'x')}


def number_of(frame):
    """Return the number that ``text`` has put into a message, None for another frame."""
    if len(frame) > LARGE or b'"publish"' not in frame:
        return None
    return int(json.loads(frame)['msg']['data'][:9])


def echoing():
    """Return a Page that subscribes to its own messages."""
    page = connected()
    page.advertise(ECHO, 'std_msgs/String')
    page.subscribe(ECHO, 'std_msgs/String', queue_length=1000)
    deadline = clock() + COME_UP
    while clock() < deadline:
        page.send(op='publish', topic=ECHO, msg=text(0))
        if select.select([page], [], [], 0.2)[0] and any(number_of(frame) == 0 for frame in page.frames()):
            drop(page, 0.5)
            return page
    raise Silent('no message came back')


def drop(page, idle=ONE_ANSWER, end=float('inf')):
    """Drop messages until none has come for ``idle`` [s], or until ``end`` [s]."""
    while True:
        left = min(idle, end - clock())
        if left <= 0 or not select.select([page], [], [], left)[0]:
            return
        for _ in page.frames():
            pass


def round_trip(count, beside_images=False):
    """Report the times [s] until a message of 100 bytes comes back, subscribed to a stream of images, too, or not."""
    page = echoing()
    images = 0
    if beside_images:
        page.subscribe(IMAGES, 'sensor_msgs/Image')
        deadline = clock() + COME_UP
        while not images:
            images = sum(len(frame) > LARGE for frame in page.frames())
            if clock() > deadline:
                raise Silent('no image came')
    times, start = [], clock()
    phases = stratified_phases(count)
    for number, phase in enumerate(phases, 1):
        drop(page, end=start + PERIOD * (number + phase))
        begun = clock()
        page.send(op='publish', topic=ECHO, msg=text(number))
        while len(times) < number:
            if not select.select([page], [], [], ONE_ANSWER)[0] or clock() - begun > ONE_ANSWER:
                raise Silent(f'message {number} did not come back within {ONE_ANSWER:g} s')
            for frame in page.frames():
                images += len(frame) > LARGE
                if number_of(frame) == number:
                    times.append(clock() - begun)
    say(times=times, images=images / (clock() - start))


def rate(seconds):
    """Report the highest rate [Hz] of messages there and back of which at most 1 % are late."""
    page = echoing()

    def holds(hertz):
        late, reached = offered(page, hertz, seconds)
        drop(page, 0.5)
        return late <= 0.01 and reached >= 0.99 * hertz
    found, tried = 0.0, 200.0
    while holds(tried):
        found, tried = tried, tried * STEP
    for _ in range(2 if found else 0):  # between the last that held and the first that did not
        middle = (found * tried) ** 0.5
        found, tried = (middle, tried) if holds(middle) else (found, middle)
    say(rate=found)


def offered(page, hertz, seconds):
    """Send so many messages a second; return the share that is late, and the rate [Hz] that could be sent."""
    start, sent, timely, came = clock(), 0, 0, 0
    total, stamps = int(hertz * seconds), {}
    last_sent = start
    page.socket.setblocking(False)
    try:
        pending = bytearray()
        while came < total:
            now = clock()
            if now > start + seconds + 10 * LATE:
                break
            while sent < total and sent <= (now - start) * hertz:
                sent += 1
                stamps[sent] = start + (sent - 1) / hertz
                pending += masked({'op': 'publish', 'topic': ECHO, 'msg': text(sent)})
                last_sent = now
            left = start + sent / hertz - now if sent < total else LATE
            readable, writable, _ = select.select([page], [page] if pending else [], [], min(LATE, max(0.0005, left)))
            if writable:
                del pending[:page.socket.send(pending)]
            if readable:
                for frame in page.frames():
                    number = number_of(frame)
                    if number in stamps:
                        came += 1
                        timely += clock() - stamps[number] <= LATE
    finally:
        page.socket.setblocking(True)
        if pending:
            page.socket.sendall(pending)
    return 1.0 - timely / total, (sent - 1) / max(1e-9, last_sent - start)


def memory(count):
    """Deliver so many messages among SUBSCRIBERS pages; say how many after a tenth of them, and at the end."""
    pages = [connected() for _ in range(SUBSCRIBERS)]
    for page in pages:
        page.subscribe(ECHO, 'std_msgs/String', queue_length=1000)
    sender = echoing()
    counts = dict.fromkeys(pages, 0)
    steps, sent = (count // 10, count), 0
    for step in steps:
        while sum(counts.values()) < step:
            if sent * SUBSCRIBERS - sum(counts.values()) < 50 * SUBSCRIBERS:
                sender.send(op='publish', topic=ECHO, msg=text(sent + 1))
                sent += 1
            ready = select.select([*pages, sender], [], [], 0 if sent % 10 else 0.0005)[0]
            for page in ready:
                came = sum(1 for _ in page.frames())
                if page is not sender:
                    counts[page] += came
        say(delivered=sum(counts.values()))
        time.sleep(SETTLE)  # stay connected while the bench reads the memory


class Stopped:
    """Notes when a zero velocity arrives after a driving one."""

    def __init__(self):
        self.drove, self.stamp, self._event = threading.Event(), 0.0, threading.Event()
        self._subscriber = rospy.Subscriber(VELOCITY, rospy.AnyMsg, self._received, tcp_nodelay=True)

    def _received(self, message):
        if any(message._buff):
            self.drove.set()
            self._event.clear()
        elif self.drove.is_set():
            self.stamp = clock()
            self._event.set()

    def wait(self, seconds):
        """Return the time of the zero velocity."""
        if not self._event.wait(seconds):
            raise Silent(f'no zero velocity within {seconds:g} s')
        return self.stamp


def zero():
    """Report the time [s] until a zero velocity arrives that is sent behind a flood of other messages."""
    stopped = Stopped()
    page = connected()
    page.advertise(FLOOD, 'geometry_msgs/PoseStamped')
    page.advertise(VELOCITY, 'geometry_msgs/Twist')

    def driven():
        page.send(op='publish', topic=VELOCITY, msg=TWIST)
        return stopped.drove.wait(0.1)
    await_true(driven, COME_UP, 'a velocity')
    flood, drive, halt = (masked({'op': 'publish', 'topic': topic, 'msg': values}) for topic, values in (
        (FLOOD, POSE), (VELOCITY, TWIST), (VELOCITY, ZERO)))
    start, pending, made = clock(), bytearray(), 0
    total, every = int(FLOOD_RATE * FLOOD_TIME), FLOOD_RATE // DRIVE_RATE
    page.socket.setblocking(False)
    while made < total or pending:
        due = min(total, int((clock() - start) * FLOOD_RATE))
        while made < due:
            made += 1
            pending += drive if made % every == 0 else flood
            if made == total:
                pending += halt
        readable, writable, _ = select.select([page], [page] if pending else [], [], 0.0005)
        if writable:
            del pending[:page.socket.send(pending)]
        if readable:
            for _ in page.frames():
                pass
        if clock() > start + ONE_ANSWER:
            raise Silent('the server does not read')
    say(seconds=stopped.wait(ONE_ANSWER) - (start + FLOOD_TIME))


def pages(count, seconds):
    """Let so many pages get poses; report each page's rate [Hz]."""
    opened = [connected() for _ in range(count)]
    for page in opened:
        page.subscribe(POSES, 'geometry_msgs/PointStamped', throttle_rate=int(1000 / PAGE_RATE))
    came = {page: 0 for page in opened}
    deadline = clock() + COME_UP
    while not all(came.values()):
        for page in select.select(opened, [], [], 1.0)[0]:
            came[page] += sum(1 for _ in page.frames())
        if clock() > deadline:
            raise Silent(f'{sum(not poses for poses in came.values())} of {count} pages got no pose')
    stamps = {page: [] for page in opened}
    say(ready=True)
    start = clock()
    while clock() < start + seconds:
        for page in select.select(opened, [], [], 0.1)[0]:
            for frame in page.frames():
                if b'"publish"' in frame:
                    stamps[page].append(clock())
    elapsed = clock() - start
    say(rates=[rate_in_window(one, elapsed, 2.5 / PAGE_RATE) for one in stamps.values()])


def images():
    """Publish raw images at 30 Hz until the end."""
    image = Image(width=640, height=480, step=1920, encoding='rgb8', data=os.urandom(921600))
    _publish(rospy.Publisher(IMAGES, Image, queue_size=1), image, 30.0)


def poses():
    """Publish points at the rate of a turtle's poses until the end."""
    _publish(rospy.Publisher(POSES, PointStamped, queue_size=1, tcp_nodelay=True), PointStamped(), POSE_RATE)


def _publish(publisher, message, hertz):
    repeat(1.0 / hertz, lambda: publisher.publish(message))
    say(ready=True)
    threading.Event().wait()
