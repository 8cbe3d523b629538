"""The pages of web_video_server: the list of image topics, and the viewer of one.

Threading contract: everything runs in the loop's thread, except asking the master.
"""
import asyncio
import os

import jinja2
import rosgraph
import rospy

from browser_servers.streams import Page

IMAGE = 'sensor_msgs/Image'
TEMPLATES = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.join(os.path.dirname(__file__), 'templates')),
                               autoescape=True)


def image_topics():
    """Ask the master; return the published topics that carry images."""
    return sorted(name for name, kind in rosgraph.Master(rospy.get_name()).getPublishedTopics('') if kind == IMAGE)


class Index(Page):
    """All image topics, with links."""

    async def get(self):
        try:
            topics = await asyncio.get_event_loop().run_in_executor(None, image_topics)
        except (rosgraph.MasterException, OSError) as error:
            self.refuse(503, f'the ROS master does not answer: {error}')
            return
        self.finish(TEMPLATES.get_template('index.html').render(topics=topics))


class Viewer(Page):
    """One stream in a page."""

    def get(self):
        wanted = self.query()
        if wanted is not None:
            self.finish(TEMPLATES.get_template('viewer.html').render(topic=wanted.topic, query=self.request.query))
