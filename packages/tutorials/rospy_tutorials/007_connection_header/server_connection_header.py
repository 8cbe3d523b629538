#!/usr/bin/env python3
"""A service that adds two whole numbers, and prints who has asked."""
import rospy
from rospy_tutorials.srv import AddTwoInts, AddTwoIntsResponse


def add(request):
    """Return the response to one request; rospy calls this function."""
    header = request._connection_header  # a dictionary
    print(f'Request from {header["callerid"]}')
    if 'cookies' in header:
        print(f'Request gave me {header["cookies"]} cookies')
    print(f'Returning [{request.a} + {request.b} = {request.a + request.b}]')
    return AddTwoIntsResponse(request.a + request.b)


def main():
    """Offer the service until Ctrl-C."""
    rospy.init_node('add_two_ints_server')
    rospy.Service('add_two_ints', AddTwoInts, add)
    rospy.spin()


if __name__ == '__main__':
    main()
