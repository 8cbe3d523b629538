#!/usr/bin/env python3
"""A service that adds two whole numbers, and prints who has asked."""
import rospy
from rospy_tutorials.srv import AddTwoInts, AddTwoIntsResponse

from rospy_support import nodes
from rospy_support.rospy_internals import connection_header


def add(request):
    """Return the answer to a request."""
    header = connection_header(request)
    print(f'Request from {header.get("callerid", "unknown")}', flush=True)
    if 'cookies' in header:
        print(f'Request gave me {header["cookies"]} cookies', flush=True)
    print(f'Returning [{request.a} + {request.b} = {request.a + request.b}]', flush=True)
    return AddTwoIntsResponse(request.a + request.b)


def main():
    """Serve until the shutdown."""
    nodes.init_node('add_two_ints_server')
    rospy.Service('add_two_ints', AddTwoInts, add)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
