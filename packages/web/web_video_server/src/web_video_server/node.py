"""web_video_server: the node, the page that lists the image topics, and the viewer of one.

Threading contract: the loop of the server runs in a thread of its own; rospy's threads hand images over to it.
"""
import asyncio
import functools
import os
from typing import List

import jinja2
import rosgraph
import rospy
import tornado.web

from browser_servers.core import web
from browser_servers.core.query import KINDS
from browser_servers.sources import Sources
from browser_servers.streams import Page, Snapshot, Stream
from rospy_support import nodes, parameters, registration
from rospy_support.parameters import Boolean, Integer, Number, Table, Text
from rospy_support.servers import Report

RETRY = 5.0  # [s] until the next try where the port is taken
PARAMETERS = Table(
    Integer('~port', 8080, 0, 65535), Text('~address', '127.0.0.1'), Text('~token', '', secret=True),
    Text('~origins', ''), Text('~hosts', ''), Boolean('~null_origin', False),
    Text('~default_stream_type', 'mjpeg', KINDS),
    Integer('~max_streams', 50, 1, 1000), Boolean('~verbose', True), Integer('~server_threads', 1, 1, 100),
    Integer('~ros_threads', 2, 1, 100), Number('~publish_rate', -1.0, -1.0, 1000.0, 'Hz'))


IMAGE = 'sensor_msgs/Image'
TEMPLATES = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.join(os.path.dirname(__file__), 'templates')),
                               autoescape=True)


class Index(Page):
    """All image topics, with links."""

    async def get(self) -> None:
        try:
            topics = await asyncio.get_event_loop().run_in_executor(None, image_topics)
        except (rosgraph.MasterException, OSError) as error:
            self.refuse(503, f'the ROS master does not answer: {error}')
            return
        self.finish(TEMPLATES.get_template('index.html').render(topics=topics))


def image_topics() -> List[str]:
    """Ask the master; return the published topics that carry images."""
    return sorted(name for name, kind in rosgraph.Master(rospy.get_name()).getPublishedTopics('') if kind == IMAGE)


class Viewer(Page):
    """One stream in a page."""

    def get(self) -> None:
        query = self.query()
        if query is not None:
            self.finish(TEMPLATES.get_template('viewer.html').render(topic=query.topic, query=self.request.query))


class _Nothing(web.Missing, Page):
    """Any other address."""


def main() -> None:
    nodes.init_node('web_video_server', PARAMETERS)
    port, address, kind, max_streams = PARAMETERS.read('~port', '~address', '~default_stream_type', '~max_streams')
    report = Report()
    sockets = web.listen_when_free(port, address, RETRY, rospy.logwarn, rospy.is_shutdown)
    port = sockets[0].getsockname()[1]
    token, origins, hosts, null_origin = PARAMETERS.read('~token', '~origins', '~hosts', '~null_origin')
    access = web.make_access(address, token, origins, hosts, null_origin, rospy.logwarn, port)
    parameters.log_effective()
    registration.keep_parameter('~actual_port', port)

    def application() -> tornado.web.Application:
        return tornado.web.Application(
            [(r'/', Index), (r'/stream', Stream), (r'/stream_viewer', Viewer), (r'/snapshot', Snapshot),
             (r'.*', _Nothing, {'text': 'there are /, /stream, /stream_viewer and /snapshot'})],
            access=access, shown_by_files=True, refused=functools.partial(report, 'access'),
            warn=functools.partial(report, 'image'), sources=Sources(asyncio.get_event_loop()), default_kind=kind,
            streams=[0], max_streams=max_streams, log_function=lambda handler: None)
    server = web.Server(application, sockets)
    server.start()
    rospy.loginfo('Image topics are shown at http://%s:%d/', 'localhost' if address == '127.0.0.1' else address, port)
    rospy.spin()
    server.stop()
