"""The node laserscan_to_distance: the nearest obstacle to the left, ahead and to the right, for each scan."""
from sensor_msgs.msg import LaserScan

from kinematic_core.worlds.sectors import split
from robotont_laserscan_to_distance.msg import LaserScanSplit
from sim_ros.distances import run


def message_of(scan: LaserScan) -> LaserScanSplit:
    """Return the LaserScanSplit of a LaserScan."""
    right, center, left = split(scan.ranges)
    return LaserScanSplit(header=scan.header, left_min=left.nearest, center_min=center.nearest,
                          right_min=right.nearest, left_mean=left.mean, center_mean=center.mean, right_mean=right.mean)


def main() -> None:
    """Run laserscan_to_distance."""
    run(LaserScanSplit, message_of, 'scan', 'scan_to_distance')
