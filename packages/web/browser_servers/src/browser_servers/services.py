"""The services that clients call and answer.

Threading contract: as in topics.py. Each call of a service, in either direction, has a thread of its own.
"""
import asyncio
import concurrent.futures
import itertools
import threading
from typing import Any, Dict, Optional, Protocol

import genpy
import rospy
import rosservice

from browser_servers import types
from browser_servers.core.conversion import json_values
from browser_servers.core.operations import Refused
from browser_servers.rosapi_answers import NAMESPACE, Answers
from browser_servers.topics import Slow

MAX_CALLS = 500  # of all clients at a time


class Server(Protocol):
    """A client that answers a service, such as a Session."""

    def request(self, service: str, request: str, arguments: Dict[str, Any]) -> None:
        """Send it a request."""


class AnsweredService:
    """A service that a client answers."""

    def __init__(self, name: str, kind: str, session: Server, loop: asyncio.AbstractEventLoop) -> None:
        self.session = session
        self.cls = types.service_class(kind)
        self._name, self._loop = name, loop
        self._numbers = itertools.count(1)
        self._open: Dict[Any, concurrent.futures.Future[Any]] = {}
        self._service = rospy.Service(name, self.cls, self._handle)

    def _handle(self, request: Any) -> Any:
        """Wait for the client's answer or its end; called by rospy."""
        answer: concurrent.futures.Future[Any] = concurrent.futures.Future()
        name = f'service_request:{self._name}:{next(self._numbers)}'
        self._open[name] = answer
        self._loop.call_soon_threadsafe(self.session.request, self._name, name, json_values(request))
        try:
            return answer.result()
        finally:
            self._open.pop(name, None)

    def respond(self, request: Any, values: Any, result: bool) -> None:
        """Take the client's answer to a request; one with fields counts whatever ``result`` is, as in the original."""
        answer = self._open.pop(request, None)
        if answer is None:
            raise Refused(f'{self._name} has no open request {request!r}')
        if result or isinstance(values, dict):
            try:
                answer.set_result(types.builder.build(self.cls._response_class, values or {}))
            except Refused as refused:
                answer.set_exception(rospy.ServiceException(str(refused)))
                raise
        else:
            answer.set_exception(rospy.ServiceException(str(values) if values else 'the client reports a failure'))

    def end(self, reason: str) -> None:
        """Unregister it; open requests fail."""
        for answer in list(self._open.values()):
            answer.set_exception(rospy.ServiceException(reason))
        self._service.shutdown(reason)


class Services:
    """The services of all clients."""

    def __init__(self, loop: asyncio.AbstractEventLoop, slow: Slow, answers: Answers) -> None:
        """``answers``: for calls of rosapi where rosapi_node does not run."""
        self._loop, self._slow = loop, slow
        self._answered: Dict[str, AnsweredService] = {}
        self._rosapi = answers
        self._calls = 0

    async def call(self, service: str, arguments: Any, kind: Optional[str]) -> Dict[str, Any]:
        """Return the answer of a service as a dict."""
        if self._calls >= MAX_CALLS:
            raise Refused(f'{MAX_CALLS} service calls are still unanswered; {service} is not called')
        self._calls += 1
        done: asyncio.Future[Dict[str, Any]] = self._loop.create_future()

        def finish(values: Dict[str, Any], error: Optional[Refused]) -> None:
            self._calls -= 1
            if done.done():  # the client has left
                return
            if error is None:
                done.set_result(values)
            else:
                done.set_exception(error)

        def work() -> None:
            values, refused = {}, None
            try:
                values = self._call(service, arguments, kind)
            except Exception as error:
                refused = error if isinstance(error, Refused) else Refused(_text(error))
            self._loop.call_soon_threadsafe(finish, values, refused)
        threading.Thread(target=work, daemon=True).start()
        return await done

    def _call(self, name: str, arguments: Any, kind: Optional[str]) -> Dict[str, Any]:
        """Call a service; those of rosapi are answered here if rosapi_node does not run."""
        resolved = rospy.resolve_name(name)
        own = resolved[len(NAMESPACE):] if resolved.startswith(NAMESPACE) else ''
        arguments = self._rosapi.fields(own, arguments)
        try:
            kind = rosservice.get_service_type(resolved) or kind
        except rosservice.ROSServiceIOException as error:
            raise Refused(f'the service {name} does not answer: {error}') from None
        if not kind and own in self._rosapi.services:
            cls = self._rosapi.services[own]
            answer = self._rosapi.call(own, types.builder.build(cls._request_class, arguments))
            return json_values(answer)
        if not kind:
            raise Refused(f'Service {name} does not exist. The command rosservice list shows those that do')
        cls = types.service_class(kind)
        request = types.builder.build(cls._request_class, arguments)
        return json_values(rospy.ServiceProxy(resolved, cls)(request))

    async def advertise(self, session: Server, service: str, kind: str) -> None:
        """Let a client answer a service; a later one replaces it."""
        before = self._answered.pop(service, None)
        if before is not None:
            await self._slow(before.end, f'another client answers {service} now')
        self._answered[service] = await self._slow(_registered, service, kind, session, self._loop)

    async def unadvertise(self, session: Server, service: str) -> None:
        answered = self._advertised_by(session, service)
        del self._answered[service]
        await self._slow(answered.end, f'the client does not answer {service} any more')

    def respond(self, session: Server, service: str, request: Any, values: Any, result: bool) -> None:
        self._advertised_by(session, service).respond(request, values, result)

    def _advertised_by(self, session: Server, service: str) -> AnsweredService:
        answered = self._answered.get(service)
        if answered is None or answered.session is not session:
            raise Refused(f'this client has not advertised the service {service}')
        return answered

    async def leave(self, session: Server) -> None:
        for name in [name for name, answered in self._answered.items() if answered.session is session]:
            await self.unadvertise(session, name)


def _registered(name: str, kind: str, session: Server, loop: asyncio.AbstractEventLoop) -> AnsweredService:
    try:
        return AnsweredService(name, kind, session, loop)
    except (rospy.ServiceException, rospy.ROSException, ValueError, OSError) as error:
        raise Refused(str(error)) from None


def _text(error: Exception) -> str:
    if isinstance(error, (rospy.ServiceException, genpy.MessageException, OSError)):
        return str(error)
    return f'{type(error).__name__}: {error}'
