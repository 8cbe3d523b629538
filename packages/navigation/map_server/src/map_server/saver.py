"""The program map_saver: writes the next map of the topic ``map`` as NAME.pgm and NAME.yaml; keeps an earlier map.

Threading contract: rospy's thread stores the map; the main thread waits for it and writes.
"""
from __future__ import annotations

import argparse
import queue
import sys
from typing import Callable, Sequence

import rospy
from nav_msgs.msg import OccupancyGrid

from navigation_core.maps.map_files import keep_earlier, saved
from navigation_core.ros import grids
from plain_support import unwritten, write_together
from rospy_support import nodes

NAME = 'map_saver'
PATIENCE = 10.0  # [s] after which it says what it waits for


def whole(smallest: int) -> Callable[[str], int]:
    """Return a converter for argparse: whole numbers from ``smallest`` to 100."""
    def convert(text: str) -> int:
        value = int(text)
        if not smallest <= value <= 100:
            raise argparse.ArgumentTypeError(f'{value} must be between {smallest} and 100')
        return value
    return convert


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options; exit with 2 and a text on wrong usage."""
    parser = argparse.ArgumentParser(prog='rosrun map_server map_saver', description=__doc__.splitlines()[0])
    parser.add_argument('--occ', type=whole(1), default=65, metavar='N', help='cells of at least N %% are black [65]')
    parser.add_argument('--free', type=whole(0), default=25, metavar='N', help='cells of at most N %% are white [25]')
    parser.add_argument('-f', default='map', metavar='NAME', dest='name', help='of the files, without an ending [map]')
    options = parser.parse_args(arguments)
    if options.free >= options.occ:
        parser.error(f'--free {options.free} must be smaller than --occ {options.occ}')
    return options


def save(message: OccupancyGrid, options: argparse.Namespace) -> None:
    info = message.info
    rospy.loginfo('Received a %d X %d map @ %.3f m/pix', info.width, info.height, info.resolution)
    image, text = saved(grids.from_message(message), options.name, options.occ, options.free)
    files = {f'{options.name}.pgm': image, f'{options.name}.yaml': text}
    kept = keep_earlier(options.name, files)
    if kept:
        rospy.logwarn('There is a map %s already; it is now called %s', options.name, kept)
    for path in files:
        rospy.loginfo('Writing map occupancy data to %s', path)
    write_together(files)
    rospy.loginfo('Done\n')


def main() -> None:
    options = parse(rospy.myargv(sys.argv)[1:])
    nodes.init_node(NAME)
    received: queue.Queue[OccupancyGrid] = queue.Queue()
    rospy.loginfo('Waiting for the map')
    topic = rospy.Subscriber('map', grids.Grid, received.put, queue_size=1, buff_size=2 ** 25)
    message = None
    while message is None:
        try:
            message = received.get(timeout=PATIENCE)
        except queue.Empty:
            if rospy.is_shutdown():
                return
            rospy.logwarn('No message on %s yet. Start a node that publishes a map, such as rosrun gmapping '
                          'slam_gmapping, or remap: map:=/your/topic', topic.resolved_name)
    try:
        save(message, options)
    except OSError as error:
        sys.exit(f"Couldn't save the map: {unwritten(error, 'choose another folder: -f FOLDER/NAME')}")
    except ValueError as error:
        sys.exit(f'The map on {topic.resolved_name} cannot be saved: {error}')
