"""navigation_core.ros.scan_source: which scans are used, and what is said of those that are not."""
import math
from types import SimpleNamespace

import pytest
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan

from navigation_core.poses import Pose
from navigation_core.ros.scan_source import STARTING, ScanSource


@pytest.fixture
def source(monkeypatch):
    """Return a ScanSource without ROS, the scans that it has used, and its warnings."""
    made, used, warnings = object.__new__(ScanSource), [], []
    transform = TransformStamped()
    transform.transform.rotation.w = 1.0

    def lookup(_target, frame, *_):
        if frame == 'no_such_frame':
            raise tf2_ros.LookupException('it does not exist')
        return transform
    made.buffer = SimpleNamespace(lookup_transform=lookup)
    made._base, made._odom, made._limits, made._mounts = 'base_footprint', 'odom', (-1.0, -1.0, -1.0), {}
    made._scans, made._last, made._failing_since = SimpleNamespace(resolved_name='/scan'), None, None
    made._throttle = SimpleNamespace(warn=lambda _kind, text, *values: warnings.append(text % values))
    made._on_scan = lambda odometry, scan, stamp: used.append((odometry, scan, stamp))
    return made, used, warnings


def receive(source, monkeypatch, seconds, frame='hokuyo_link', ranges=(1.0, math.inf), increment=0.5):
    monkeypatch.setattr(rospy, 'get_time', lambda: seconds)
    message = LaserScan(angle_min=-1.0, angle_increment=increment, range_min=0.1, range_max=30.0, ranges=ranges)
    message.header.stamp, message.header.frame_id = rospy.Time(seconds), frame
    source._on_message(message)


def test_a_scan_is_used_with_the_pose_of_the_odometry(source, monkeypatch):
    receive(source[0], monkeypatch, 5.0)
    (odometry, scan, stamp), = source[1]
    assert (odometry, stamp, len(scan.points)) == (Pose(), rospy.Time(5), 1) and not source[2]


@pytest.mark.parametrize('scan, said', [
    ({'ranges': (math.nan, math.inf, 0.0, -1.0)}, 'none of its 4 ranges is a finite number from 0.1 to 30 m'),
    ({'increment': 0.0}, 'the scan must cover more than 0'),
    ({'frame': 'no_such_frame'}, 'there is no transform of odom -> base_footprint -> no_such_frame')])
def test_useless_scans_are_named(source, monkeypatch, scan, said):
    """Without a transform, not within the time in which nodes start."""
    for seconds in (5.0, 5.1 + STARTING):
        receive(source[0], monkeypatch, seconds, **scan)
    assert not source[1] and said in source[2][-1]
    assert len(source[2]) == (1 if 'frame' in scan else 2)
