"""The node map_server: publishes the map of a YAML file, and answers services about it.

Threading contract: rospy's threads of the services; a new map is read in the thread of its call, then assigned.
"""
from __future__ import annotations

import sys
from typing import Sequence

import rospy
from nav_msgs.msg import MapMetaData
from nav_msgs.srv import GetMap, GetMapRequest, GetMapResponse, LoadMap, LoadMapRequest, LoadMapResponse

from navigation_core.maps import map_files
from navigation_core.maps.map_files import Description, MapError, read_description, read_image
from navigation_core.poses import Pose
from navigation_core.ros import grids
from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Number, Table, Text
from rospy_support.topics import Publisher

NAME = 'map_server'
USAGE = '''usage: rosrun map_server map_server MAP.yaml
  MAP.yaml: a map file, as map_saver writes it
or, as in old versions: rosrun map_server map_server IMAGE RESOLUTION
  RESOLUTION: metres for each pixel'''
PARAMETERS = Table(Text('~frame_id', 'map', filled=True), Boolean('~negate', False),
                   Number('~occupied_thresh', map_files.OCCUPIED_THRESH, 0.0, 1.0),
                   Number('~free_thresh', map_files.FREE_THRESH, 0.0, 1.0))  # the last three: without a YAML file


class MapServer:
    """Publishes ``map`` and ``map_metadata``, latched."""

    def __init__(self, described: Description) -> None:
        """Read the map of a Description, publish it, and offer the services."""
        self._frame = PARAMETERS['~frame_id'].read()
        self._grids = Publisher('map', grids.Grid, latch=True, queue_size=1)
        self._infos = Publisher('map_metadata', MapMetaData, latch=True, queue_size=1)
        self._load(described)
        rospy.Service('static_map', GetMap, self._get)
        rospy.Service('change_map', LoadMap, self._change)

    def _load(self, described: Description) -> None:
        rospy.loginfo('Loading map from image "%s"', described.image)
        grid = read_image(described)
        self._message = grids.to_message(grid, self._frame)
        rospy.loginfo('Read a %d X %d map @ %.3f m/cell', grid.width, grid.height, grid.resolution)
        self._infos.publish(self._message.info)
        self._grids.publish(self._message)

    def _get(self, _: GetMapRequest) -> GetMapResponse:
        rospy.loginfo('Sending map')
        return GetMapResponse(grids.as_lists(self._message))

    def _change(self, request: LoadMapRequest) -> LoadMapResponse:
        try:
            self._load(read_description(request.map_url))
        except MapError as error:
            rospy.logerr('The map stays: %s', error)
            return LoadMapResponse(result=LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST if error.missing
                                   else LoadMapResponse.RESULT_INVALID_MAP_DATA)
        return LoadMapResponse(grids.as_lists(self._message), LoadMapResponse.RESULT_SUCCESS)


def described_by(arguments: Sequence[str]) -> Description:
    """Return the Description that the command line asks for; raise MapError or SystemExit."""
    if len(arguments) == 1:
        return read_description(arguments[0])
    if len(arguments) != 2:
        sys.exit(USAGE)
    rospy.logwarn('Using deprecated map server interface. Please switch to new interface.')
    try:
        resolution = float(arguments[1])
        if not 0.0 < resolution < float('inf'):
            raise ValueError
    except ValueError:
        sys.exit(f'RESOLUTION is {arguments[1]}; it must be a positive number of metres.\n{USAGE}')
    negate, occupied, free = PARAMETERS.read('~negate', '~occupied_thresh', '~free_thresh')
    return Description(arguments[0], resolution, Pose(), negate, occupied, free, 'trinary')


def main() -> None:
    arguments = rospy.myargv(sys.argv)[1:]
    if not 1 <= len(arguments) <= 2:
        sys.exit(USAGE)
    nodes.init_node(NAME, PARAMETERS, anonymous=not nodes.launched())
    try:
        MapServer(described_by(arguments))
    except MapError as error:
        raise parameters.ParameterError(str(error)) from None
    rospy.spin()
