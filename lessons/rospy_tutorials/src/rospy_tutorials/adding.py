"""Clients of add_two_ints: programs that call a service without being a node."""
import random
import re
import sys

import rosgraph
import rospy

from rospy_tutorials.srv import AddTwoInts

SERVICE = 'add_two_ints'
REMINDER = 5.0  # [s] while the service is not there
LARGEST_DRAWN = 50000
LIMITS = -2 ** 63, 2 ** 63 - 1  # of an int64


def service(server, headers=None):
    """Wait for the service and return its ServiceProxy; ``server``: the command that starts it."""
    while True:
        try:
            rospy.wait_for_service(SERVICE, REMINDER)
            return rospy.ServiceProxy(SERVICE, AddTwoInts, headers=headers)
        except rospy.ROSException:
            print(f'Waiting for the service {rospy.resolve_name(SERVICE)}. Start it in another terminal: {server}',
                  file=sys.stderr, flush=True)


def numbers(arguments):
    """Return the two numbers of the command line, or random ones; raise ValueError where there is something else."""
    if not arguments:
        return random.randint(-LARGEST_DRAWN, LARGEST_DRAWN), random.randint(-LARGEST_DRAWN, LARGEST_DRAWN)
    if len(arguments) != 2:
        raise ValueError(f'it takes two numbers, or none; there are {len(arguments)}')
    for text in arguments:
        if not re.fullmatch(r'[+-]?[0-9]+', text) or not LIMITS[0] <= int(text) <= LIMITS[1]:
            raise ValueError(f'{text!r} is not a whole number from {LIMITS[0]} to {LIMITS[1]}')
    return tuple(map(int, arguments))


def run(ask):
    """Print the sum of the numbers of the command line, which ``ask(x, y)`` returns; return the exit code."""
    program, *arguments = rospy.myargv()
    try:
        x, y = numbers(arguments)
    except ValueError as error:
        print(f'{error}\n{program} [x y]', file=sys.stderr)
        return 1
    try:
        if not rosgraph.is_master_online():
            raise OSError(f'no ROS master at {rosgraph.get_master_uri()}; start one with roscore')
        print(f'{x} + {y} = {ask(x, y)}', flush=True)
        return 0
    except (rospy.ServiceException, OSError) as error:
        print(f'Service call failed: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
