#!/usr/bin/env python3
"""Call the service that adds two whole numbers, and tell it something more."""
import sys

from rospy_support.rospy_internals import connection_header
from rospy_tutorials import adding

COOKIES = 'peanut butter'


def ask(x, y):
    """Return the sum that the service answers."""
    service = adding.service('rosrun rospy_tutorials server_connection_header.py', headers={'cookies': COOKIES})
    print(f'Requesting {x}+{y} with cookies={COOKIES}', flush=True)
    answer = service(x, y)
    print("Server's connection headers were", connection_header(answer), flush=True)
    return answer.sum


if __name__ == '__main__':
    sys.exit(adding.run(ask))
