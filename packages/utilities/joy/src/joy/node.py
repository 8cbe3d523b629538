"""The node joy_node: publishes the axes and buttons of a joystick.

Threading contract: the main thread reads the device and publishes.
"""
import os
import select
import time

import rospy
from sensor_msgs.msg import Joy

from joy.core.joystick import EVENT, READ_AT_ONCE, Joystick, why_not
from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Number, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher

PARAMETERS = Table(Text('~dev', '/dev/input/js0'), Number('~deadzone', 0.05, 0.0, 0.9),
                   Number('~autorepeat_rate', 0.0, 0.0, 1000.0, 'Hz'),
                   Number('~coalesce_interval', 0.001, 0.0, 1.0, 's'), Boolean('~sticky_buttons', False))
RETRY = 1.0  # [s] of wall time until the next attempt to open the device
POLL = 0.2  # [s] between two checks for a shutdown
REPEAT = 30.0  # [s] between two reports of the same problem


class JoyNode:
    """Publishes the joystick ``~dev``."""

    def __init__(self):
        """Read the parameters and register the topic."""
        self._device, deadzone, rate, self._interval, self._sticky = PARAMETERS.read(
            '~dev', '~deadzone', '~autorepeat_rate', '~coalesce_interval', '~sticky_buttons')
        self._deadzone, self._period = deadzone, 1.0 / rate if rate else None
        self._throttle = WallThrottle(REPEAT)
        self._publisher = Publisher('joy', Joy, queue_size=1)
        parameters.log_effective()

    def run(self):
        """Read the joystick until shutdown; if it is missing, wait for it."""
        while not rospy.is_shutdown():
            try:
                file = os.open(self._device, os.O_RDONLY | os.O_NONBLOCK)
            except OSError as error:
                reason = why_not(self._device) or f'{self._device}: {error.strerror}.'
                if self._throttle.due('missing', reason, changed=0.0):
                    rospy.logerr('%s Retrying.', reason)
                time.sleep(RETRY)
                continue
            try:
                rospy.loginfo('Opened the joystick %s. The dead zone is %g.', self._device, self._deadzone)
                self._throttle.forget('missing')
                self._read(file)
            finally:
                os.close(file)

    def _read(self, file):
        """Publish the events of an open device until it is unplugged."""
        joystick = Joystick(self._deadzone, self._sticky)
        changed = False
        while not rospy.is_shutdown():
            wait = self._interval if changed else min(self._period or POLL, POLL)
            if select.select([file], [], [], wait)[0]:
                try:
                    data = os.read(file, READ_AT_ONCE * EVENT.size)
                except OSError as error:
                    rospy.logerr('%s: %s. Was it unplugged?', self._device, error.strerror)
                    return
                if not data:
                    rospy.logerr('%s does not answer any more. Was it unplugged?', self._device)
                    return
                changed = joystick.feed(data) or changed
            elif changed or self._period:
                changed = False
                self._publish(joystick)

    def _publish(self, joystick):
        message = Joy(axes=joystick.axes, buttons=joystick.buttons)
        message.header.stamp, message.header.frame_id = rospy.Time.now(), self._device
        self._publisher.publish(message)


def main():
    """Run joy_node."""
    nodes.init_node('joy_node', PARAMETERS)
    JoyNode().run()
