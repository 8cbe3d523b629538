"""The access of all clients to ROS: their topics and services.

Threading contract: as in topics.py.
"""
import concurrent.futures

from browser_servers.core.session import Bridge
from browser_servers.services import Services
from browser_servers.topics import Topics

THREADS = 8  # that ask the master; a registration takes a few milliseconds


class RosBridge(Bridge):
    """The Bridge of all sessions."""

    def __init__(self, loop, unregister_timeout, answers):
        """``unregister_timeout`` [s]; ``answers``: an Answers, for calls of rosapi."""
        executor = concurrent.futures.ThreadPoolExecutor(THREADS, 'registration')

        def slow(function, *arguments):
            return loop.run_in_executor(executor, function, *arguments)
        self._topics = Topics(loop, slow, unregister_timeout)
        self._services = Services(loop, slow, answers)
        self.is_velocity, self.publish = self._topics.is_velocity, self._topics.publish
        self.advertise, self.unadvertise = self._topics.advertise, self._topics.unadvertise
        self.subscribe, self.unsubscribe = self._topics.subscribe, self._topics.unsubscribe
        self.call, self.respond = self._services.call, self._services.respond
        self.advertise_service, self.unadvertise_service = self._services.advertise, self._services.unadvertise

    def stop(self, topic):
        self._topics.publish(None, topic, {})

    async def leave(self, session):
        await self._topics.leave(session)
        await self._services.leave(session)
