"""web_video_server: the node.

Threading contract: the loop of the server runs in a thread of its own; rospy's threads hand images over to it.
"""
import asyncio
import functools
import sys
import time

import rospy
import tornado.web

from browser_servers.core import web
from browser_servers.core.query import KINDS
from browser_servers.sources import Sources
from browser_servers.streams import Page, Snapshot, Stream
from rospy_support import nodes, parameters, registration
from rospy_support.parameters import Boolean, Integer, Number, Table, Text
from rospy_support.servers import Report
from web_video_server.pages import Index, Viewer

RETRY = 5.0  # [s] until the next try where the port is taken
PARAMETERS = Table(
    Integer('~port', 8080, 0, 65535), Text('~address', '127.0.0.1'), Text('~token', '', secret=True),
    Text('~origins', ''), Text('~hosts', ''), Boolean('~null_origin', False),
    Text('~default_stream_type', 'mjpeg', KINDS),
    Integer('~max_streams', 50, 1, 1000), Boolean('~verbose', True), Integer('~server_threads', 1, 1, 100),
    Integer('~ros_threads', 2, 1, 100), Number('~publish_rate', -1.0, -1.0, 1000.0, 'Hz'))


class _Nothing(web.Missing, Page):
    """Any other address."""


def main():
    nodes.init_node('web_video_server', PARAMETERS)
    port, address, kind, most = PARAMETERS.read('~port', '~address', '~default_stream_type', '~max_streams')
    report = Report()
    sockets = _listen(port, address)
    port = sockets[0].getsockname()[1]
    access = web.make_access(address, *PARAMETERS.read('~token', '~origins', '~hosts', '~null_origin'),
                             rospy.logwarn, port)
    parameters.log_effective()
    registration.keep_parameter('~actual_port', port)

    def application():
        return tornado.web.Application(
            [(r'/', Index), (r'/stream', Stream), (r'/stream_viewer', Viewer), (r'/snapshot', Snapshot),
             (r'.*', _Nothing, {'text': 'there are /, /stream, /stream_viewer and /snapshot'})],
            access=access, shown_by_files=True, refused=functools.partial(report, 'access'),
            warn=functools.partial(report, 'image'), sources=Sources(asyncio.get_event_loop()), default_kind=kind,
            streams=[0], most=most, log_function=lambda handler: None)
    server = web.Server(application, sockets)
    server.start()
    rospy.loginfo('Image topics are shown at http://%s:%d/', 'localhost' if address == '127.0.0.1' else address, port)
    rospy.spin()
    server.stop()


def _listen(port, address):
    while True:
        try:
            return web.listen(port, address)
        except OSError as error:
            rospy.logwarn('Cannot listen at %s, port %d (%s). Trying again in %g s; for another port, type _port:=8081',
                          address, port, error.strerror or error, RETRY)
            time.sleep(RETRY)
            if rospy.is_shutdown():
                sys.exit(0)
