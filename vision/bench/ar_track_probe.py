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

import course_video
from alvar_core.camera import default_camera
from probing import COME_UP, Silent, clock, say
from rospy_support import images
from rostest_support.marker_scenes import Scene, image_of, random_markers

NODE = 'marker_detect'
FRAME = 'camera'
HEADER = struct.Struct('<3I')  # seq, seconds, nanoseconds: the start of an AlvarMarkers
MARKERS, RATE = 4, 30.0  # in an image; [Hz] of images
SIZE = 0.1  # [m] of the markers


def shown(width, height, colour):
    """Return an Image of MARKERS markers, and its CameraInfo."""
    rng = np.random.default_rng(1)
    camera, scene = default_camera(width, height), Scene(width=width, height=height, clutter=6)
    placed = random_markers(rng, camera, scene, MARKERS, side=(40, 110), max_tilt=45.0, size=SIZE)
    picture = image_of(rng, camera, placed, scene)
    if colour:
        picture = np.repeat(picture[:, :, None], 3, 2)
    return images.to_image(picture, 'rgb8' if colour else 'mono8'), _info_of(camera, width, height)


def _info_of(camera, width, height):
    return CameraInfo(width=width, height=height, distortion_model='plumb_bob', D=[0.0] * 5,
                      K=camera.matrix.ravel().tolist(), R=np.eye(3).ravel().tolist(),
                      P=np.column_stack([camera.matrix, np.zeros(3)]).ravel().tolist())


class Camera:
    """Publishes images in turn at a rate, notes the time of each by its stamp, and receives the node's answers."""

    def __init__(self, pictures, info):
        self._pictures, self._info = pictures, info
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


def watch(limit, seconds, settle=1.0, width=640, height=480, colour=False):
    """Set the node's parameters, show markers, and report the messages in ``seconds`` after ``settle`` [s].

    Reports: ready; the time of the first message; the start of the window; times [s] from the call of publish() to
    the message at a subscriber, and stamps [s] of the messages.
    """
    for name, value in (('output_frame', FRAME), ('marker_size', 100.0 * SIZE), ('max_frequency', limit)):
        rospy.set_param(f'{NODE}/{name}', value)
    image, info = shown(width, height, colour)
    _measure(Camera([image], info), seconds, settle)


def video(path, truth, limit, seconds, settle=1.0):
    """Do the same with a video of course_video; also report what is found in the frames that were answered.

    Also reports: what course_video.compared returns; ``truth`` is the file of what they show.
    """
    for name, value in (('output_frame', FRAME), ('marker_size', 100.0 * course_video.SIZE), ('max_frequency', limit)):
        rospy.set_param(f'{NODE}/{name}', value)
    width, height = course_video.WIDTH, course_video.HEIGHT
    camera = Camera([images.to_image(image, 'bgr8') for image in course_video.frames_of(path)],
                    _info_of(default_camera(width, height), width, height))
    with open(truth, encoding='utf-8') as file:
        shown_by_frame = json.load(file)
    answered = _measure(camera, seconds, settle)
    say(**course_video.compared([(shown_by_frame[camera.frames[stamp]], _markers_in(camera.answers[stamp]))
                                 for stamp in answered]))


def _markers_in(data):
    """Return (id, pose (7,)) of the markers in an AlvarMarkers as bytes."""
    poses = [(marker.id, marker.pose.pose) for marker in AlvarMarkers().deserialize(data).markers]
    return [(number, [getattr(part, axis) for part, axes in ((pose.position, 'xyz'), (pose.orientation, 'xyzw'))
                      for axis in axes]) for number, pose in poses]


def _measure(camera, seconds, settle):
    """Report as ``watch`` says; return the stamps that were answered."""
    say(ready=True)
    camera.run(lambda: camera.received)
    say(first=min(camera.received.values()))
    camera.run_for(settle)
    camera.sent.clear()
    camera.received.clear()
    say(begun=clock())
    camera.run_for(seconds)
    answered = {stamp: at for stamp, at in list(camera.received.items()) if stamp in camera.sent}
    say(times=[at - camera.sent[stamp] for stamp, at in answered.items()], stamps=sorted(camera.received.values()))
    return list(answered)
