"""The access of all clients to ROS: their topics and services.

Threading contract: as in topics.py.
"""
import asyncio
import concurrent.futures
from typing import Any, Awaitable, Callable

from browser_servers.core.session import Session
from browser_servers.rosapi_answers import Answers
from browser_servers.services import Services
from browser_servers.topics import Topics

THREADS = 8  # that ask the master; a registration takes a few milliseconds


class RosBridge:
    """The Bridge of all sessions."""

    def __init__(self, loop: asyncio.AbstractEventLoop, unregister_timeout: float, answers: Answers) -> None:
        """``unregister_timeout`` [s]; ``answers``: for calls of rosapi."""
        executor = concurrent.futures.ThreadPoolExecutor(THREADS, 'registration')

        def slow(function: Callable[..., Any], *arguments: Any) -> Awaitable[Any]:
            return loop.run_in_executor(executor, function, *arguments)
        self._topics = topics = Topics(loop, slow, unregister_timeout)
        self._services = services = Services(loop, slow, answers)
        self.is_velocity, self.publish, self.stop = topics.is_velocity, topics.publish, topics.stop
        self.advertise, self.unadvertise = topics.advertise, topics.unadvertise
        self.subscribe, self.unsubscribe = topics.subscribe, topics.unsubscribe
        self.call, self.respond = services.call, services.respond
        self.advertise_service, self.unadvertise_service = services.advertise, services.unadvertise

    async def leave(self, session: Session) -> None:
        await self._topics.leave(session)
        await self._services.leave(session)
