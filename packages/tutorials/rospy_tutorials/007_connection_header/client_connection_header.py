#!/usr/bin/env python3
"""Call the service that adds two whole numbers, and send it a header when it connects."""
import random
import sys

import rospy
from rospy_tutorials.srv import AddTwoInts

COMMAND = 'rosrun rospy_tutorials client_connection_header.py'


def ask(x, y):
    """Return the sum."""
    rospy.wait_for_service('add_two_ints')
    cookies = 'peanut butter'
    add_two_ints = rospy.ServiceProxy('add_two_ints', AddTwoInts, headers={'cookies': cookies})
    print(f'Requesting {x}+{y} with cookies={cookies}')
    answer = add_two_ints(x, y)
    print("Server's connection headers were", answer._connection_header)
    return answer.sum


def main():
    """Add the numbers of the command line, or random ones."""
    arguments = rospy.myargv()[1:]
    if not arguments:
        arguments = [random.randint(-50000, 50000), random.randint(-50000, 50000)]
    try:
        x, y = [int(argument) for argument in arguments]
    except ValueError:
        sys.exit(f'Two whole numbers are needed, or none. Type: {COMMAND} 3 4')
    try:
        print(f'{x} + {y} = {ask(x, y)}')
    except rospy.ServiceException as error:
        sys.exit(f'Service call failed: {error}')


if __name__ == '__main__':
    try:
        main()
    except KeyboardInterrupt:
        pass  # Ctrl-C
