"""cv2.imshow, waitKey, createTrackbar and the like, where OpenCV is built without windows (opencv-python-headless).

sitecustomize.py beside this file says how it gets into all programs of a workspace; an OpenCV with windows stays as it
is. Each window is a topic:

    /cv_window/NAME                  sensor_msgs/Image, latched: what imshow was given last
    /cv_window/NAME/key              std_msgs/String: a key for waitKey, as a character or by its name in KEYS
    /cv_window/NAME/mouse            geometry_msgs/Point: x and y [px], z: the number of the event, such as 1 for
                                     cv2.EVENT_LBUTTONDOWN
    /cv_window/NAME/trackbar/TRACKBAR   std_msgs/Int32: sets the position
    /cv_window/NAME/trackbars        std_msgs/String, latched: JSON, a list of {name, value, least, most}

Where there is a display, it is also a real window, of the process cv2_screen.py. A program that is no node becomes one
for its topics, unless it imports rospy, because then it will call init_node itself.

Every program that imports cv2 imports this module, so what only windows need is imported where they need it.

Threads: callbacks of topics and the reader of cv2_screen.py only append to ``_events``; waitKey takes them in order,
and calls the program's callbacks in its own thread, as highgui does.
"""
import collections
import os
import re
import sys
import threading
import time

POLL_INTERVAL = 0.05  # [s] between two checks whether the program has become a node, or its node has ended
REPEAT_PERIOD = 1.0  # [s] between two messages of a still image: browsers show one of a stream only when the next comes
MASTER_POLL = 1.0  # [s] of a program that is no node
MOUSE_MOVE, DOWN, UP = 0, {1: 1, 2: 2, 3: 4}, {4: 1, 5: 2, 6: 4}  # events, with their button's bit in the flags
KEYS = {'Enter': 13, 'Escape': 27, 'Backspace': 8, 'Tab': 9, 'Delete': 65535, 'Home': 65360, 'End': 65367,
        'ArrowLeft': 65361, 'ArrowUp': 65362, 'ArrowRight': 65363, 'ArrowDown': 65364, 'PageUp': 65365,
        'PageDown': 65366}  # browsers' names: codes of waitKeyEx under X; waitKey returns the last 8 bits
SCREEN = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'cv2_screen.py')
REPLACED = ('imshow', 'namedWindow', 'destroyWindow', 'destroyAllWindows', 'waitKey', 'waitKeyEx', 'pollKey',
            'createTrackbar', 'getTrackbarPos', 'setTrackbarPos', 'setTrackbarMin', 'setTrackbarMax',
            'setMouseCallback', 'moveWindow', 'resizeWindow', 'setWindowTitle', 'getWindowProperty',
            'setWindowProperty', 'getWindowImageRect', 'startWindowThread')

_windows = {}  # name: _Window
_events = collections.deque()  # (kind, name of the window, values)
_arrived = threading.Condition()
_connecting = threading.RLock()
_originals = {}
_screen = None
_starter = None  # the thread that makes a node of a program that is none


def repair():
    """Replace the functions of cv2 for windows, if they are empty."""
    cv2 = sys.modules['cv2']
    if cv2.imshow is not imshow and re.search(r'GUI:\s+NONE', cv2.getBuildInformation()):
        _originals.update(cv2=cv2, imshow=cv2.imshow)
        for name in REPLACED:
            setattr(cv2, name, globals()[name])


# ------------------------------------------------------------------------------------------------- functions of cv2

def namedWindow(winname, flags=1):
    """Open a window."""
    _window(winname, opened=True)
    _connect()


def imshow(winname, mat):
    """Show an image in a window, which is opened if it is not there."""
    image = _displayable(mat)
    if image is None:
        _originals['imshow'](winname, mat)  # raises the error of highgui
        return
    window = _window(winname, opened=True)
    window.image = image
    if _screen:
        _screen.show(winname, image)
    _connect()
    window.publish()


def destroyWindow(winname):
    """Close a window."""
    window = _windows.pop(winname, None)
    if window:
        window.close()


def destroyAllWindows():
    """Close all windows."""
    for name in list(_windows):
        destroyWindow(name)


def waitKey(delay=0):
    """Return the next key's code of 8 bits within ``delay`` [ms], or -1; without a delay, wait as long as it takes."""
    code = waitKeyEx(delay)
    return code if code == -1 else code & 0xff


def waitKeyEx(delay=0):
    """Return the next key's code as waitKey does, with all its bits."""
    end = time.monotonic() + delay / 1000.0 if delay > 0 else float('inf')
    repeat = time.monotonic() + REPEAT_PERIOD
    while True:
        _connect()
        code = _take_events()
        left = end - time.monotonic()
        if time.monotonic() > repeat:
            repeat += REPEAT_PERIOD
            for window in list(_windows.values()):
                window.publish()
        if code is not None:
            return code
        if left <= 0.0 or _has_ended() or (delay <= 0 and not _windows):
            return -1
        with _arrived:
            _arrived.wait_for(lambda: _events, min(left, POLL_INTERVAL))


def pollKey():
    """Return the code of a key that has been pressed, or -1."""
    code = _take_events()
    return -1 if code is None else code & 0xff


def createTrackbar(trackbarName, windowName, value, count, onChange=lambda _: None):
    """Add a trackbar from 0 to ``count`` to a window."""
    trackbar = _window(windowName).trackbars[trackbarName] = _Trackbar(trackbarName, count, onChange)
    trackbar.value = trackbar.clipped(value)
    _show_trackbar(windowName, trackbar)
    _connect()


def getTrackbarPos(trackbarname, winname):
    """Return the position of a trackbar."""
    return _trackbar(trackbarname, winname).value


def setTrackbarPos(trackbarname, winname, pos):
    """Move a trackbar."""
    trackbar = _trackbar(trackbarname, winname)
    _move_trackbar(trackbar, pos)
    _show_trackbar(winname, trackbar)


def setTrackbarMin(trackbarname, winname, minval):
    """Set the lowest position of a trackbar."""
    trackbar = _trackbar(trackbarname, winname)
    trackbar.least = minval
    setTrackbarPos(trackbarname, winname, trackbar.value)


def setTrackbarMax(trackbarname, winname, maxval):
    """Set the highest position of a trackbar."""
    trackbar = _trackbar(trackbarname, winname)
    trackbar.most = maxval
    setTrackbarPos(trackbarname, winname, trackbar.value)


def setMouseCallback(windowName, onMouse, param=None):
    """Call ``onMouse(event, x, y, flags, param)`` for what the mouse does in a window."""
    _window(windowName).on_mouse = onMouse and (lambda *values: onMouse(*values, param))
    _connect()


def moveWindow(winname, x, y):
    """Move a window on the display."""
    if _screen and winname in _windows:
        _screen.tell('move', winname, x=x, y=y)


def setWindowTitle(winname, title):
    """Set the title of a window on the display."""
    if _screen and winname in _windows:
        _screen.tell('title', winname, title=title)


def resizeWindow(winname, *_):
    """Do nothing: a window has the size of its image."""


def setWindowProperty(winname, prop_id, prop_value):
    """Do nothing: a window has the size of its image."""


def getWindowProperty(winname, prop_id):
    """Return 1.0 for the visibility (cv2.WND_PROP_VISIBLE) and automatic size of a window, 0.0 for all else."""
    cv2 = _originals['cv2']
    return float(winname in _windows and prop_id in (cv2.WND_PROP_VISIBLE, cv2.WND_PROP_AUTOSIZE))


def getWindowImageRect(winname):
    """Return (x, y, width, height) [px] of a window's image."""
    image = _window(winname).image
    return (0, 0, 0, 0) if image is None else (0, 0, image.shape[1], image.shape[0])


def startWindowThread():
    """Do nothing."""
    return 0


# ----------------------------------------------------------------------------------------------------------- windows

class _Trackbar:
    def __init__(self, name, most, on_change):
        self.name, self.value, self.least, self.most, self.on_change = name, 0, 0, most, on_change

    def clipped(self, value):
        return max(self.least, min(self.most, int(value)))


class _Window:
    """A window, and its topics once the program is a node. ``image`` is BGR or grey, of 8 bits."""

    def __init__(self, name):
        self.name, self.image, self.trackbars = name, None, {}
        self.on_mouse, self.buttons = None, 0
        self.topic = f'/cv_window/{_legal(name)}'
        self.publisher = self.trackbars_publisher = None
        self.subscribers = {}

    def connect(self, rospy):
        """Make the topics that are missing."""
        if self.publisher is None:
            from geometry_msgs.msg import Point
            from sensor_msgs.msg import Image
            from std_msgs.msg import String
            self.publisher = rospy.Publisher(self.topic, Image, latch=True, queue_size=1)
            self._listen(rospy, 'key', String, lambda message: ('key', _code(message.data)))
            self._listen(rospy, 'mouse', Point, lambda point: ('mouse', int(point.z), int(point.x), int(point.y)))
            print(f'cv2: the window {self.name!r} is the topic {self.topic}: ./run view shows it', file=sys.stderr)
            self.publish()
        for name in list(self.trackbars):
            part = f'trackbar/{_legal(name)}'
            if part not in self.subscribers:
                from std_msgs.msg import Int32, String
                self.trackbars_publisher = self.trackbars_publisher or rospy.Publisher(
                    f'{self.topic}/trackbars', String, latch=True, queue_size=1)
                self._listen(rospy, part, Int32, lambda message, name=name: ('trackbar', name, message.data))
                self.publish_trackbars()

    def _listen(self, rospy, part, kind, event):
        def receive(message):
            kind, *values = event(message)
            _report(kind, self.name, *values)
        self.subscribers[part] = rospy.Subscriber(f'{self.topic}/{part}', kind, receive)

    def publish(self):
        """Publish the image, if there are an image and a node."""
        if self.publisher is None or self.image is None:
            return
        import rospy
        from sensor_msgs.msg import Image
        height, width = self.image.shape[:2]
        message = Image(height=height, width=width, encoding='mono8' if self.image.ndim == 2 else 'bgr8',
                        step=self.image.nbytes // height, data=self.image.tobytes())
        message.header.stamp = rospy.get_rostime()
        _publish(self.publisher, message)

    def publish_trackbars(self):
        """Publish the trackbars, if there is a node."""
        if self.trackbars_publisher:
            import json
            _publish(self.trackbars_publisher, json.dumps([
                {'name': name, 'value': trackbar.value, 'least': trackbar.least, 'most': trackbar.most}
                for name, trackbar in self.trackbars.items()]))

    def close(self):
        if _screen:
            _screen.tell('close', self.name)
        for connection in (self.publisher, self.trackbars_publisher, *self.subscribers.values()):
            if connection:
                connection.unregister()


def _window(name, opened=False):
    """Return a window; open it, or raise highgui's error, if it is not there."""
    global _screen
    if name not in _windows:
        if not opened:
            raise _originals['cv2'].error(f'(-27:Null pointer) NULL window: {name!r}. Call cv2.namedWindow({name!r}) '
                                          'before')
        _windows[name] = _Window(name)
        if _screen is None and os.environ.get('DISPLAY'):
            _screen = _Screen()
        if _screen:
            _screen.tell('open', name)
    return _windows[name]


def _trackbar(name, window):
    """Return a trackbar, or raise highgui's error."""
    trackbars = _window(window).trackbars
    if name not in trackbars:
        raise _originals['cv2'].error(f'(-27:Null pointer) NULL trackbar: {name!r} in the window {window!r}. It has: '
                                      f'{", ".join(map(repr, trackbars)) or "none"}')
    return trackbars[name]


def _move_trackbar(trackbar, value):
    before, trackbar.value = trackbar.value, trackbar.clipped(value)
    if trackbar.value != before and trackbar.on_change:
        trackbar.on_change(trackbar.value)


def _show_trackbar(window, trackbar):
    _windows[window].publish_trackbars()
    if _screen:
        _screen.tell('trackbar', window, name=trackbar.name, value=trackbar.value, least=trackbar.least,
                     most=trackbar.most)


def _displayable(mat):
    """Return an image as highgui would show it, BGR or grey of 8 bits, in memory of its own; None if it would not."""
    import numpy as np
    image = mat.get() if hasattr(mat, 'get') else mat  # a UMat
    if not isinstance(image, np.ndarray) or not image.size or image.ndim not in (2, 3):
        return None
    if image.ndim == 3 and image.shape[2] not in (1, 3, 4):
        return None
    if image.ndim == 3:
        image = image[:, :, 0] if image.shape[2] == 1 else image[:, :, :3]
    if image.dtype == np.uint8:
        return np.array(image, order='C')
    if image.dtype == np.uint16:
        return (image >> 8).astype(np.uint8)
    if image.dtype in (np.float32, np.float64):
        return np.clip(np.nan_to_num(image) * 255.0 + 0.5, 0, 255).astype(np.uint8)
    return None


# ------------------------------------------------------------------------------------------------------------ events

def _report(kind, window, *values):
    with _arrived:
        _events.append((kind, window, values))
        _arrived.notify_all()


def _take_events():
    """Call the program's callbacks for what has happened until the next key; return its code, or None."""
    while True:
        with _arrived:
            if not _events:
                return None
            kind, name, values = _events.popleft()
        window = _windows.get(name)
        if window is None:
            continue
        if kind == 'key' and values[0] is not None:
            return values[0]
        if kind == 'close':
            destroyWindow(name)
        elif kind == 'trackbar' and values[0] in window.trackbars:
            trackbar = window.trackbars[values[0]]
            _move_trackbar(trackbar, values[1])
            _show_trackbar(name, trackbar)
        elif kind == 'mouse':
            _call_mouse(window, *values)


def _call_mouse(window, event, x, y, flags=0):
    """``flags``: cv2.EVENT_FLAG_... of the keyboard and of buttons that another source has seen."""
    window.buttons = (window.buttons | DOWN.get(event, 0)) & ~UP.get(event, 0)
    if window.on_mouse:
        window.on_mouse(event, x, y, flags | window.buttons)


def _code(key):
    """Return the code of a key by its name or character; None for another text."""
    return KEYS.get(key, ord(key) if len(key) == 1 else None)


def _legal(name):
    """Return a name as a part of a topic."""
    return re.sub(r'\W', '_', name, flags=re.ASCII) or '_'


# --------------------------------------------------------------------------------------------------------------- ROS

def _publish(publisher, message):
    import rospy
    try:
        publisher.publish(message)
    except rospy.ROSException:
        pass  # the node is ending


def _has_ended():
    rospy = sys.modules.get('rospy')
    return hasattr(rospy, 'is_shutdown') and rospy.is_shutdown()


def _connect():
    """Make the topics of the windows, once the program is a node."""
    global _starter
    rospy = sys.modules.get('rospy')
    if rospy and hasattr(rospy, 'get_node_uri') and rospy.get_node_uri() and not rospy.is_shutdown():
        with _connecting:
            for window in list(_windows.values()):
                window.connect(rospy)
    elif rospy is None and _starter is None and _windows:
        _starter = threading.Thread(target=_become_node, name='cv2 windows', daemon=True)
        _starter.start()


def _become_node():
    """Start a node as soon as there is a master, unless the program imports rospy."""
    import rosgraph
    told = bool(_screen)
    while 'rospy' not in sys.modules:
        if rosgraph.is_master_online():
            import rospy

            from rospy_support import servers
            servers.protect()
            rospy.init_node('cv2_windows', argv=[], anonymous=True, disable_signals=True)
            return
        if not told:
            print('cv2: there is neither a display for the windows nor a ROS master. Type roscore in another terminal, '
                  'and ./run view in a third: it shows them in a browser.', file=sys.stderr)
            told = True
        time.sleep(MASTER_POLL)


# ----------------------------------------------------------------------------------------------------------- display

class _Screen:
    """The windows on the display: a process, to which one thread writes, and from which another one reads."""

    def __init__(self):
        import subprocess
        self._process = subprocess.Popen([sys.executable, '-I', SCREEN], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         start_new_session=True)
        self._change = threading.Condition()
        self._orders = []
        self._images = {}  # name of a window: the newest image
        for target in (self._write, self._read):
            threading.Thread(target=target, name='cv2 screen', daemon=True).start()

    def tell(self, order, window, **values):
        with self._change:
            self._orders.append(dict(values, do=order, window=window))
            self._change.notify()

    def show(self, window, image):
        with self._change:
            self._images[window] = image
            self._change.notify()

    def _write(self):
        try:
            while True:
                with self._change:
                    self._change.wait_for(lambda: self._orders or self._images)
                    orders, self._orders, images, self._images = self._orders, [], self._images, {}
                for order in orders:
                    self._send(order)
                for name, image in images.items():
                    kind, pixels = (b'P5', image) if image.ndim == 2 else (b'P6', image[:, :, ::-1])
                    data = b'%s %d %d 255\n' % (kind, image.shape[1], image.shape[0]) + pixels.tobytes()
                    self._send({'do': 'show', 'window': name, 'bytes': len(data)}, data)
        except OSError:
            pass  # the process has ended, and has said why

    def _send(self, order, data=b''):
        import json
        self._process.stdin.write(json.dumps(order).encode() + b'\n' + data)
        self._process.stdin.flush()

    def _read(self):
        import json
        for line in self._process.stdout:
            _report(*json.loads(line))
