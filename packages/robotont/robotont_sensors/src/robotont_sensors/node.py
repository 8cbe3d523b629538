"""The node laserscan_to_distance of the older course: the same as in robotont_laserscan_to_distance, other names."""
from sensor_msgs.msg import LaserScan

from kinematic_core.worlds.sectors import split
from robotont_sensors.msg import LaserScanSplit
from sim_ros.distances import run


def message_of(scan: LaserScan) -> LaserScanSplit:
    """Return the LaserScanSplit of a LaserScan."""
    right, center, left = split(scan.ranges)
    return LaserScanSplit(stamp=scan.header.stamp, leftMin=left.nearest, centerMin=center.nearest,
                          rightMin=right.nearest, leftMean=left.mean, centerMean=center.mean, rightMean=right.mean)


def main() -> None:
    """Run laserscan_to_distance."""
    run(LaserScanSplit, message_of, '/scan', '/scan_to_distance')
