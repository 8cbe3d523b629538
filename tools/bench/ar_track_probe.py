"""A camera and a subscriber for an individualMarkersNoKinect (see probing.py).

Messages are received as bytes (AnyMsg) and matched with the images by their stamp.
"""
import json
import struct
import time

import numpy as np
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from sensor_msgs.msg import CameraInfo, Image

from alvar_core.camera import default_camera
from probing import COME_UP, Silent, clock, say
from rospy_support import images
from rostest_support.marker_scenes import Scene, image_of, random_markers
from rostest_support.markers import camera_info
from unit_support import course_video

NODE = 'marker_detect'
FRAME = 'camera'
HEADER = struct.Struct('<3I')  # seq, seconds, nanoseconds: the start of an AlvarMarkers
MARKERS, RATE = 4, 30.0  # in an image; [Hz] of images
SIZE = 0.1  # [m] of the markers


def shown(colour):
    """Return an Image of MARKERS markers."""
    rng, camera, scene = np.random.default_rng(1), default_camera(), Scene(clutter=6)
    placed = random_markers(rng, camera, scene, MARKERS, side=(40, 110), max_tilt=45.0, size=SIZE)
    picture = image_of(rng, camera, placed, scene)
    return images.to_image(np.repeat(picture[:, :, None], 3, 2) if colour else picture, 'rgb8' if colour else 'mono8')


class Camera:
    """Publishes images in turn at a rate, notes the time of each by its stamp, and receives the node's answers."""

    def __init__(self, pictures):
        self._pictures, self._info = pictures, camera_info()
        self.sent, self.received = {}, {}
        self.frames, self.answers = {}, {}  # by the stamp: the number of the image, the answer as bytes
        self._images = rospy.Publisher('camera_image', Image, queue_size=1, tcp_nodelay=True)
        self._infos = rospy.Publisher('camera_info', CameraInfo, queue_size=1, tcp_nodelay=True)
        self._subscriber = rospy.Subscriber('ar_pose_marker', rospy.AnyMsg, self._store, tcp_nodelay=True)

    def _store(self, message):
        now = clock()
        _, seconds, nanoseconds = HEADER.unpack(message._buff[:HEADER.size])
        self.received.setdefault((seconds, nanoseconds), now)
        self.answers[seconds, nanoseconds] = message._buff

    def run(self, done):
        """Publish until done(); raise Silent when COME_UP has passed since the start without an answer."""
        begun = due = clock()
        number = 0
        while not done() and not rospy.is_shutdown():
            if not self.received and clock() - begun > COME_UP:
                raise Silent(f'no ar_pose_marker within {COME_UP:g} s')
            stamp, image = rospy.Time.now(), self._pictures[number % len(self._pictures)]
            for message in (self._info, image):
                message.header.stamp, message.header.frame_id = stamp, FRAME
            self._infos.publish(self._info)
            self.frames[stamp.secs, stamp.nsecs] = number % len(self._pictures)
            self.sent[stamp.secs, stamp.nsecs] = clock()
            self._images.publish(image)
            number += 1
            due += 1.0 / RATE
            time.sleep(max(0.0, due - clock()))

    def run_for(self, seconds):
        """Publish for this time [s]."""
        end = clock() + seconds
        self.run(lambda: clock() > end)


def watch(limit, seconds, settle=1.0, colour=False, path=None, truth=None):
    """Set the node's parameters, show it images, and report the messages in ``seconds`` after ``settle`` [s].

    The images are of markers, or those of a video of course_video at ``path``; ``truth`` is the file of what it shows.
    Reports: ready; that the first message has come; the start of the window; times [s] from the call of publish() to
    the message at a subscriber, and stamps [s] of the messages; of a video, what course_video.compared returns.
    """
    size = course_video.SIZE if path else SIZE
    for name, value in (('output_frame', FRAME), ('marker_size', 100.0 * size), ('max_frequency', limit)):
        rospy.set_param(f'{NODE}/{name}', value)
    pictures = [images.to_image(image, 'bgr8') for image in course_video.frames_of(path)] if path else [shown(colour)]
    camera = Camera(pictures)
    say(ready=True)
    camera.run(lambda: camera.received)
    say(first=True)
    camera.run_for(settle)
    camera.sent.clear()
    camera.received.clear()
    say(begun=True)
    camera.run_for(seconds)
    answered = {stamp: at for stamp, at in list(camera.received.items()) if stamp in camera.sent}
    say(times=[at - camera.sent[stamp] for stamp, at in answered.items()], stamps=sorted(camera.received.values()))
    if path:
        with open(truth, encoding='utf-8') as file:
            by_frame = json.load(file)
        say(**course_video.compared([(by_frame[camera.frames[stamp]], _markers_in(camera.answers[stamp]))
                                     for stamp in answered]))


def _markers_in(data):
    """Return (id, pose (7,)) of the markers in an AlvarMarkers as bytes."""
    poses = [(marker.id, marker.pose.pose) for marker in AlvarMarkers().deserialize(data).markers]
    return [(number, [getattr(part, axis) for part, axes in ((pose.position, 'xyz'), (pose.orientation, 'xyzw'))
                      for axis in axes]) for number, pose in poses]
