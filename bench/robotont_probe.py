"""Client of a robotont_gazebo and its camera, run by the bench as a process of its own.

`robotont_probe.py first TOPIC` or `listen TOPIC --seconds S [--turning]`; every answer is one line of JSON, the first
says that the subscriber is there. Messages are received as bytes (AnyMsg); stamps are of their arrival.
"""

import argparse
import time

import rospy
from geometry_msgs.msg import Twist, Vector3

from turtlesim_probe import COME_UP, await_true, clock, say

BUFFER = 1 << 24  # [bytes] more than a picture
COMMAND_PERIOD = 0.1  # [s]
TURN = 0.6  # [rad/s]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('task', choices=('first', 'listen'))
    parser.add_argument('topic')
    parser.add_argument('--seconds', type=float, default=1.0)
    parser.add_argument('--turning', action='store_true', help='turn: no picture is like the last')
    options = parser.parse_args()
    rospy.init_node('robotont_probe', anonymous=True)
    stamps = []
    rospy.Subscriber(options.topic, rospy.AnyMsg, lambda _: stamps.append(clock()), tcp_nodelay=True,
                     buff_size=BUFFER)
    if options.turning:
        driver = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        rospy.Timer(rospy.Duration(COMMAND_PERIOD), lambda _: driver.publish(Vector3(), Vector3(0.0, 0.0, TURN)))
    if options.task == 'first':
        say(listens=True)
    await_true(lambda: stamps, COME_UP, f'a message on {options.topic}')
    if options.task == 'first':
        say(stamp=stamps[0])
        return
    say(listens=True)
    time.sleep(options.seconds + 1.0)  # the bench settles for a second first
    end = clock()
    say(stamps=[stamp for stamp in stamps if stamp >= end - options.seconds])


if __name__ == '__main__':
    main()
