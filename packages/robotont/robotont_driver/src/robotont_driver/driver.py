"""The node driver_node: the robot of base.py with a simulated circuit board. Threads: see base.py."""
from typing import Sequence

import rospy
from robotont_msgs.msg import ColorRGB, LedModulePixel, LedModuleSegment, PowerSupply

from kinematic_core.worlds.robot_world import RobotWorld
from plain_support import InvalidInput
from robotont_driver.base import RATE, DriverNode
from robotont_driver.core.board import Board, power
from rospy_support import nodes, reachability
from rospy_support.parameters import Table, Text
from rospy_support.topics import LatestPublisher, Publisher

POWER_STEPS = RATE  # steps between two messages about the battery
PARAMETERS = Table(Text('odom/frame', 'odom', filled=True), Text('odom/child_frame', 'base_footprint', filled=True))


class BoardNode(DriverNode):
    """A DriverNode with the LEDs and the battery of a simulated board."""

    def __init__(self, frames: Table) -> None:
        """Register everything."""
        self._board = Board()
        self._power = LatestPublisher('power_supply', PowerSupply)
        self._leds = Publisher('~leds', LedModuleSegment, latch=True, queue_size=1)
        self._leds.publish(self._all_leds())
        super().__init__(frames)
        rospy.Subscriber('led_pixel', LedModulePixel, lambda pixel: self._light(pixel.idx, [pixel.color]))
        rospy.Subscriber('led_segment', LedModuleSegment, lambda part: self._light(part.idx_start, part.colors))

    def stepped(self, world: RobotWorld) -> None:
        """Publish the state of the battery once a second."""
        if world.steps % POWER_STEPS == 0:
            output = power(world.twist)
            self._power.publish(PowerSupply(current=output.current, voltage=output.voltage, estop_pressed=False))

    def _light(self, first: int, colours: Sequence[ColorRGB]) -> None:
        try:
            with self.lock:
                self._board.light(first, [(colour.r, colour.g, colour.b) for colour in colours])
                self._leds.publish(self._all_leds())
        except InvalidInput as refusal:
            self.refusals.warn('leds', 'Ignored a message for the LEDs: %s', refusal)

    def _all_leds(self) -> LedModuleSegment:
        return LedModuleSegment(idx_start=0, colors=[ColorRGB(*colour) for colour in self._board.leds])


def main() -> None:
    """Run driver_node."""
    nodes.init_node('driver_node', PARAMETERS)
    rospy.loginfo('There is no circuit board here: its robot, LEDs and battery are simulated.')
    reachability.watch()
    BoardNode(PARAMETERS).run()
