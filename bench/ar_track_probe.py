"""A camera and a subscriber for an individualMarkersNoKinect, run by the bench as a process of its own.

`ar_track_probe.py watch` shows rendered markers to the node that the bench starts, and prints one line of JSON when it
is ready, when the window opens, and with what came: times [s] from the call of publish() to the message at a
subscriber, and stamps [s] of the messages. Messages are received as bytes (AnyMsg) and matched by their stamp.
"""

import argparse
import gc
import json
import struct
import time

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, Image

from alvar_core.camera import default_camera
from rospy_support import images
from rostest_support.marker_scenes import Scene, image_of, random_markers

clock = time.perf_counter  # CLOCK_MONOTONIC on Linux: one clock for all processes
NODE = 'marker_detect'
FRAME = 'camera'
HEADER = struct.Struct('<3I')  # seq, seconds, nanoseconds: how AlvarMarkers begins
COME_UP = 20.0  # [s] for a node to answer
SIZE = 0.1  # [m] of the markers


class Silent(RuntimeError):
    """The node did not do what the probe waited for."""


def say(**document):
    """Print one answer."""
    print(json.dumps(document), flush=True)


def shown(width, height, markers, colour):
    """Return the Image and the CameraInfo of this many markers."""
    rng = np.random.default_rng(1)
    camera, scene = default_camera(width, height), Scene(width=width, height=height, clutter=6)
    placed = random_markers(rng, camera, scene, markers, side=(40, 110), max_tilt=45.0, size=SIZE)
    picture = image_of(rng, camera, placed, scene)
    if colour:
        picture = np.repeat(picture[:, :, None], 3, 2)
    info = CameraInfo(width=width, height=height, distortion_model='plumb_bob', D=[0.0] * 5,
                      K=camera.matrix.ravel().tolist(), R=np.eye(3).ravel().tolist(),
                      P=np.column_stack([camera.matrix, np.zeros(3)]).ravel().tolist())
    return images.to_image(picture, 'rgb8' if colour else 'mono8'), info


class Camera:
    """Publish an image at a rate, note the time of each by its stamp, and receive the node's answers."""

    def __init__(self, image, info, rate):
        self._image, self._info, self._period = image, info, 1.0 / rate
        self.sent, self.received = {}, {}
        self._images = rospy.Publisher('camera_image', Image, queue_size=1, tcp_nodelay=True)
        self._infos = rospy.Publisher('camera_info', CameraInfo, queue_size=1, tcp_nodelay=True)
        self._subscriber = rospy.Subscriber('ar_pose_marker', rospy.AnyMsg, self._take, tcp_nodelay=True)

    def _take(self, message):
        now = clock()
        _, seconds, nanoseconds = HEADER.unpack(message._buff[:HEADER.size])
        self.received.setdefault((seconds, nanoseconds), now)

    def run(self, done):
        """Publish until done(); raise Silent when COME_UP has passed since the start without an answer."""
        begun = due = clock()
        while not done() and not rospy.is_shutdown():
            if not self.received and clock() - begun > COME_UP:
                raise Silent(f'no ar_pose_marker within {COME_UP:g} s')
            stamp = rospy.Time.now()
            for message in (self._info, self._image):
                message.header.stamp, message.header.frame_id = stamp, FRAME
            self._infos.publish(self._info)
            self.sent[stamp.secs, stamp.nsecs] = clock()
            self._images.publish(self._image)
            due += self._period
            time.sleep(max(0.0, due - clock()))

    def run_for(self, seconds):
        """Publish for this time [s]."""
        end = clock() + seconds
        self.run(lambda: clock() > end)


def watch(options):
    """Set the node's parameters, say that all is ready, show markers, and report what comes in options.seconds."""
    for name, value in (('output_frame', FRAME), ('marker_size', 100.0 * SIZE), ('max_frequency', options.limit)):
        rospy.set_param(f'{NODE}/{name}', value)
    camera = Camera(*shown(options.width, options.height, options.markers, options.colour), options.rate)
    say(ready=True)
    camera.run(lambda: camera.received)
    say(first=min(camera.received.values()))
    camera.run_for(options.settle)
    camera.sent.clear()
    camera.received.clear()
    say(begun=clock())
    camera.run_for(options.seconds)
    say(times=[at - camera.sent[stamp] for stamp, at in list(camera.received.items()) if stamp in camera.sent],
        stamps=sorted(camera.received.values()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('task', choices=('watch',))
    parser.add_argument('--rate', type=float, default=30.0, help='images per second')
    parser.add_argument('--limit', type=float, default=8.0, help='max_frequency of the node')
    parser.add_argument('--width', type=int, default=640)
    parser.add_argument('--height', type=int, default=480)
    parser.add_argument('--markers', type=int, default=4)
    parser.add_argument('--colour', action='store_true', help='rgb8 instead of mono8')
    parser.add_argument('--seconds', type=float, default=2.0)
    parser.add_argument('--settle', type=float, default=1.0)
    options = parser.parse_args()
    rospy.init_node('ar_track_probe', anonymous=True, disable_signals=True)
    gc.disable()
    try:
        watch(options)
    except Silent as error:
        say(error=str(error))


if __name__ == '__main__':
    main()
