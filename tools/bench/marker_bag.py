"""Detections in the images of a rosbag: without ground truth, but with the stability of ids, corners and poses.

The bag must hold one image topic and its camera_info. A marker counts as visible from the first image to the last in
which a detector sees its id; recall is the share of these images in which it does. The scatter is the distance of an
image's value from the mean of both neighbouring images. A moving camera adds its acceleration to it.
"""
import numpy as np

from alvar_core.camera import CameraError
from aruco_baseline import ArucoBaseline
from class_scores import pair
from processes import BenchError
from report import aligned
from unit_support.marker_score import detector_of, rotation_between

RARE = 3  # images: an id that is seen in fewer is doubtful
SIZE = 0.05  # m: has no effect without ground truth
IMAGES = ('sensor_msgs/Image', 'sensor_msgs/CompressedImage')


def images_of(path):
    """Yield (grey image, Camera) of a bag; raise BenchError."""
    import rosbag  # noqa: PLC0415  only a bag needs ROS

    from ar_track_alvar.conversions import camera_of
    from rospy_support import images
    try:
        bag = rosbag.Bag(path)
    except (OSError, rosbag.ROSBagException) as error:
        raise BenchError(f'{path} cannot be read as a bag: {error}.') from error
    with bag:
        kinds = {topic: facts.msg_type for topic, facts in bag.get_type_and_topic_info().topics.items()}
        pictures = [topic for topic, kind in kinds.items() if kind in IMAGES]
        infos = [topic for topic, kind in kinds.items() if kind == 'sensor_msgs/CameraInfo']
        if len(pictures) != 1 or len(infos) != 1:
            raise BenchError(f'{path} has the image topics {pictures} and the camera_info topics {infos}: exactly one '
                             'of each is needed. Copy them with rosbag filter.')
        _, info, _ = next(bag.read_messages(infos))
        for _, message, _ in bag.read_messages(pictures):
            grey = images.grey(message)
            try:
                yield grey, camera_of(info, grey.shape[1], grey.shape[0])
            except CameraError as error:
                raise BenchError(f'{path}, {infos[0]}: {error}.') from error


class Seen:
    """The detections of one tool: {id: {number of the image: detection}}."""

    def __init__(self):
        self.by_id = {}

    def add(self, number, detections):
        """Note the detections in an image."""
        for each in detections:
            self.by_id.setdefault(each['id'], {})[number] = each

    def row(self, number):
        """Return the figures of an id as texts: recall, scatter of the worst corner and of the rotation."""
        seen = self.by_id.get(number, {})
        if len(seen) < RARE:
            return f'{len(seen)} images', '-', '-'
        span = max(seen) - min(seen) + 1
        threes = [(seen[k - 1], seen[k], seen[k + 1]) for k in seen if k - 1 in seen and k + 1 in seen]
        corner = [float(np.linalg.norm(np.array(b['corners']) - (np.array(a['corners']) + c['corners']) / 2,
                                       axis=1).max()) for a, b, c in threes]
        turn = [max(rotation_between(b['orientation'], each['orientation']) for each in (a, c)) for a, b, c in threes]
        return f'{100 * len(seen) / span:.1f} % of {span}', pair(corner), pair(turn, '{:.1f} / {:.1f}')


def report(path):
    """Return the table of a bag as text."""
    seen, count = {'here': Seen(), 'ArUco': Seen()}, 0
    detect, baseline = detector_of(SIZE), ArucoBaseline()
    for grey, camera in images_of(path):
        seen['here'].add(count, detect(grey, camera))
        seen['ArUco'].add(count, baseline.detect(grey, camera, SIZE))
        count += 1
    head = ('id', *(f'{tool}: {what}' for tool in seen for what in ('seen', 'corner px', 'rotation deg')))
    rows = [head] + [(str(number), *(cell for each in seen.values() for cell in each.row(number)))
                     for number in sorted(set().union(*(each.by_id for each in seen.values())), key=str)]
    return f'{path}: {count} images; scatter from image to image, median / 95th\n{aligned(rows)}'
