"""The node fake_driver_node: see base.py."""
from robotont_driver.base import DriverNode
from rospy_support import nodes, reachability
from rospy_support.parameters import Table, Text

PARAMETERS = Table(Text('~odom_frame', 'odom', filled=True), Text('~base_frame', 'base_footprint', filled=True))


def main() -> None:
    """Run fake_driver_node."""
    nodes.init_node('fake_driver_node', PARAMETERS)
    reachability.watch()
    DriverNode(PARAMETERS).run()
