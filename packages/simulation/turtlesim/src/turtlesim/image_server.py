"""Serve the simulator's image with its turtles: as topics, as a file on request, and in a window.

A separate thread makes the images, and only while there is a subscriber or a window. OpenCV is loaded for the first
image, so that a simulator without a viewer starts at once and stays small.
"""
import os
import threading
import time
from typing import Any

import rospy
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerResponse

from kinematic_core.worlds.turtle_world import CANVAS_SIZE
from plain_support import create_numbered, unwritten
from plain_support.doctor import findings
from rospy_support import threads
from rospy_support.parameters import Boolean, Computed, Number, Table, Text
from rospy_support.topics import Publisher, SubscriptionListener
from turtlesim.shared_world import SharedWorld

FRAME_ID = 'turtlesim_canvas'
PARAMETERS = Table(Boolean('~window', True), Number('~image_rate', 25.0, 0.1, 62.5, 'Hz'),
                   Text('~snapshot_dir', Computed('the working directory')))


class ImageServer:
    """Serves ``~image_raw`` (rgb8), ``~image_raw/compressed`` (PNG), ``~snapshot`` and the window of a SharedWorld."""

    def __init__(self, shared: SharedWorld) -> None:
        """Read the parameters, register topics and service, open the window if there is a display."""
        self._shared = shared
        self._period = 1.0 / PARAMETERS['~image_rate'].read()
        self._frame_lock = threading.Lock()
        self._frame_state: Any = None
        self._last_frame: Any = None  # an array
        self._wanted = threading.Event()
        self._closed = threading.Event()
        listener = SubscriptionListener(self._wanted.set)
        self._image = Publisher('~image_raw', Image, listener, queue_size=1)
        self._compressed = Publisher('~image_raw/compressed', CompressedImage, listener, queue_size=1)
        self._window: Any = None
        self._window_failed = False
        rospy.Service('~snapshot', Trigger, self._snapshot)
        reason = _no_window()
        if reason:
            rospy.loginfo('%s', findings.no_window(reason, rospy.resolve_name('~snapshot')))
        else:
            from turtlesim.window import Window
            self._window = Window('TurtleSim', self._on_window_failure)
            self._wanted.set()
        self._thread = threads.keep_running('pictures', self._serve)

    def close(self) -> None:
        self._closed.set()
        self._wanted.set()
        if self._window:
            self._window.close()
        self._thread.join(1.0)

    def _serve(self) -> None:
        while not self._closed.is_set():
            self._wanted.wait()
            self._wanted.clear()
            due = time.monotonic()
            while self._has_viewer() and not self._closed.is_set():
                self._show(self._frame())
                due = max(due + self._period, time.monotonic())  # a late image is not caught up
                self._closed.wait(due - time.monotonic())
                if self._window and self._window.closed:
                    rospy.signal_shutdown('the window was closed')

    def _has_viewer(self) -> bool:
        window = self._window and not self._window_failed
        return bool(window or self._image.get_num_connections() or self._compressed.get_num_connections())

    def _on_window_failure(self, reason: str) -> None:
        self._window_failed = True
        rospy.logwarn('%s', reason)

    def _show(self, frame: Any) -> None:
        from rospy_support import images
        header = Header(stamp=rospy.Time.now(), frame_id=FRAME_ID)
        if self._image.get_num_connections():
            self._image.publish(images.to_image(frame, 'rgb8', header))
        if self._compressed.get_num_connections():
            self._compressed.publish(images.to_compressed(frame[:, :, ::-1], 'png', header, 'rgb8'))
        if self._window:
            self._window.show(frame)

    def _frame(self) -> Any:
        """Return the image, (500, 500, 3) uint8 RGB, made again only when something has changed."""
        import numpy

        from turtlesim.core import sprites
        with self._frame_lock:
            state = self._shared.image()
            if state != self._frame_state:
                pixels, turtles = state
                canvas = numpy.frombuffer(pixels, numpy.uint8).reshape(CANVAS_SIZE, CANVAS_SIZE, 3)
                self._last_frame, self._frame_state = sprites.render(canvas, turtles), state
            return self._last_frame

    def _snapshot(self, _: Any) -> TriggerResponse:
        from turtlesim.core import sprites
        frame = self._frame()
        stem = rospy.get_name().strip('/').replace('/', '_')
        directory = PARAMETERS['~snapshot_dir'].read(os.getcwd())
        with self._frame_lock:
            try:
                path = create_numbered(directory, stem, '.png', sprites.encode_png(frame))
            except OSError as error:
                instead = f'choose another folder: rosparam set {rospy.resolve_name("~snapshot_dir")} FOLDER'
                return TriggerResponse(False, f'no picture was saved: {unwritten(error, instead)}')
        rospy.loginfo('Saved %s', path)
        return TriggerResponse(True, path)


def _no_window() -> str:
    """Return why no window is opened; '' if one is."""
    if not PARAMETERS['~window'].read():
        return f'{rospy.resolve_name("~window")} is false'
    return '' if os.environ.get('DISPLAY') else 'DISPLAY is not set'
