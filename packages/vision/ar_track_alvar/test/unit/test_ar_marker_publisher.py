"""What a Report sends for an image, and in which order."""
import types

import numpy as np
import pytest
import rospy
from std_msgs.msg import Header

from ar_track_alvar import marker_publisher
from ar_track_alvar.conversions import MarkerPose

MARKERS = [MarkerPose(number, np.eye(3), np.array([0.0, 0.0, 1.0]), 99, 0.1) for number in (3, 14)]


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
