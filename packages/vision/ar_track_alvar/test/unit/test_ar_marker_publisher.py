"""ar_track_alvar.marker_publisher: which transform an image gets, and what a Report sends for it, in which order."""
import types

import genpy
import numpy as np
import pytest
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Header

from ar_track_alvar import marker_publisher
from ar_track_alvar.conversions import MarkerPose
from ar_track_alvar.marker_publisher import OutputFrame, TransformMissing

MARKERS = [MarkerPose(number, np.eye(3), np.array([0.0, 0.0, 1.0]), 99, 0.1) for number in (3, 14)]
TOLERANCE = 0.1  # [s]


def transform(parent, child, x, seconds=0.0):
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id, made.header.stamp = parent, genpy.Time.from_sec(seconds)
    made.transform.translation.x, made.transform.rotation.w = x, 1.0
    return made


@pytest.fixture
def output(monkeypatch):
    monkeypatch.setattr(tf2_ros, 'TransformListener', lambda buffer: None)
    made = OutputFrame('map', TOLERANCE)
    assert made.camera_pose('other', rospy.Time(1), last_try=False) is None  # makes the buffer
    return made


def x_of(output, seconds, last_try=False, frame='camera'):
    pose = output.camera_pose(frame, genpy.Time.from_sec(seconds), last_try)
    return pose if pose is None else pose[1][0]


def test_the_camera_s_own_frame_needs_no_tf(monkeypatch):
    monkeypatch.setattr(tf2_ros, 'Buffer', None)
    rotation, translation = OutputFrame('map', TOLERANCE).camera_pose('map', rospy.Time(5), last_try=False)
    assert (rotation == np.eye(3)).all() and (translation == 0).all()


def test_the_transform_at_the_stamp_is_taken(output):
    for seconds in (10.0, 11.0):
        output._buffer.set_transform(transform('map', 'camera', seconds, seconds), 'test')
    assert x_of(output, 10.25) == pytest.approx(10.25)


def test_static_transforms_are_good_for_any_stamp(output):
    output._buffer.set_transform_static(transform('map', 'camera', 3.0), 'test')
    assert x_of(output, 1.0) == x_of(output, 1e6) == 3.0


def test_a_transform_that_comes_late_is_waited_for_and_then_replaced_by_the_newest(output):
    output._buffer.set_transform(transform('map', 'camera', 1.0, 10.0), 'test')
    assert x_of(output, 10.05) is None
    assert x_of(output, 10.05, last_try=True) == 1.0
    with pytest.raises(TransformMissing):
        x_of(output, 10.2, last_try=True)  # older than the tolerance
    output._buffer.set_transform(transform('map', 'camera', 2.0, 10.2), 'test')
    assert x_of(output, 10.05) == pytest.approx(1.25)


def test_the_newest_is_not_taken_for_an_older_picture(output):
    """A picture from before the first transform: the newest one is 'at most so much older', not newer."""
    output._buffer.set_transform(transform('map', 'camera', 1.0, 10.0), 'test')
    with pytest.raises(TransformMissing, match='extrapolation'):
        x_of(output, 9.95, last_try=True)


def test_a_missing_frame_is_named_with_those_that_exist(output):
    output._buffer.set_transform_static(transform('odom', 'base', 1.0), 'test')
    with pytest.raises(TransformMissing, match=r"camera's frame camera to map: .*exist: base, odom$"):
        x_of(output, 1.0, last_try=True)


def test_no_frames_at_all_and_no_frame_id(output):
    with pytest.raises(TransformMissing, match='none, as no node publishes tf'):
        x_of(output, 1.0, last_try=True)
    with pytest.raises(TransformMissing, match='no frame_id'):
        x_of(output, 1.0, frame='')


def test_clear_forgets_what_moved(output):
    output._buffer.set_transform(transform('map', 'camera', 1.0, 10.0), 'test')
    output._buffer.set_transform_static(transform('camera', 'lens', 1.0), 'test')
    output.clear()
    assert x_of(output, 10.0) is None
    output._buffer.set_transform(transform('map', 'camera', 1.0, 2.0), 'test')
    assert x_of(output, 2.0, frame='lens') == 2.0


@pytest.fixture
def report(monkeypatch):
    """Return a Report in the frame of the camera, the (topic, message) that it sends, and topics without subscribers.

    """
    sent, unwanted = [], set()

    def publisher(name, *_args, **_kwds):
        return types.SimpleNamespace(publish=lambda message: sent.append((name, message)),
                                     wanted=lambda: name not in unwanted)

    monkeypatch.setattr(marker_publisher, 'LatestPublisher', publisher)
    statistics = types.SimpleNamespace(published=lambda seconds: None)
    return marker_publisher.Report('camera', 0.1, statistics, None), sent, unwanted


def test_transforms_precede_the_poses(report):
    """A callback of ar_pose_marker may ask tf for the marker at the stamp of the message, as with the original."""
    node, sent, _ = report
    node.publish(0.0, Header(frame_id='camera', stamp=rospy.Time(7)), MARKERS)
    assert [topic for topic, _ in sent] == ['/tf', 'ar_pose_marker', 'visualization_marker', 'visualization_marker']
    assert [each.child_frame_id for each in sent[0][1].transforms] == ['ar_marker_3', 'ar_marker_14']
    assert {each.header.stamp for each in sent[0][1].transforms} == {sent[1][1].header.stamp} == {rospy.Time(7)}


def test_images_without_a_marker_have_an_empty_message_alone(report):
    node, sent, _ = report
    node.publish(0.0, Header(frame_id='camera'), [])
    assert [(topic, message.markers) for topic, message in sent] == [('ar_pose_marker', [])]


@pytest.mark.parametrize('topic', ['/tf', 'visualization_marker'])
def test_messages_for_nobody_are_not_made(report, topic):
    """For four markers they take 0.3 ms of processor time."""
    node, sent, unwanted = report
    unwanted.add(topic)
    node.publish(0.0, Header(frame_id='camera'), MARKERS)
    assert topic not in {name for name, _ in sent} and 'ar_pose_marker' in {name for name, _ in sent}
