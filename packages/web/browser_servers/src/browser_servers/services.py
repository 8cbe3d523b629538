"""The services that clients call and answer.

Threading contract: as in topics.py. Each call of a service, in either direction, has a thread of its own.
"""
import concurrent.futures
import itertools
import threading

import genpy
import rospy
import rosservice

from browser_servers import types
from browser_servers.core.conversion import json_values
from browser_servers.core.operations import Refused
from browser_servers.rosapi_answers import NAMESPACE

MAX_CALLS = 500  # of all clients at a time


class Answered:
    """A service that a client answers."""

    def __init__(self, name, kind, session, loop):
        self.session = session
        self.cls = types.service_class(kind)
        self._name, self._loop = name, loop
        self._numbers, self._open = itertools.count(1), {}
        self._service = rospy.Service(name, self.cls, self._asked)

    def _asked(self, request):
        """Wait for the client's answer or its end; called by rospy."""
        answer = concurrent.futures.Future()
        name = f'service_request:{self._name}:{next(self._numbers)}'
        self._open[name] = answer
        self._loop.call_soon_threadsafe(self.session.ask, self._name, name, json_values(request))
        try:
            return answer.result()
        finally:
            self._open.pop(name, None)

    def respond(self, request, values, result):
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

    def end(self, reason):
        """Unregister it; open requests fail."""
        for answer in list(self._open.values()):
            answer.set_exception(rospy.ServiceException(reason))
        self._service.shutdown(reason)


class Services:
    """The services of all clients."""

    def __init__(self, loop, slow, answers):
        """``slow``: as in Topics; ``answers``: an Answers, for calls of rosapi where rosapi_node does not run."""
        self._loop, self._slow = loop, slow
        self._answered, self._rosapi = {}, answers
        self._calls = 0

    async def call(self, name, arguments, kind):
        """Return the answer of a service as a dict."""
        if self._calls >= MAX_CALLS:
            raise Refused(f'{MAX_CALLS} service calls are still unanswered; {name} is not called')
        self._calls += 1
        done = self._loop.create_future()

        def tell(set_outcome, value):
            if not done.done():
                set_outcome(value)

        def work():
            try:
                outcome = done.set_result, self._call(name, arguments, kind)
            except Exception as error:
                outcome = done.set_exception, error if isinstance(error, Refused) else Refused(_text(error))
            self._loop.call_soon_threadsafe(tell, *outcome)
            self._loop.call_soon_threadsafe(self._called)
        threading.Thread(target=work, daemon=True).start()
        return await done

    def _called(self):
        self._calls -= 1

    def _call(self, name, arguments, kind):
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

    async def advertise(self, session, name, kind):
        """Let a client answer a service; a later one replaces it."""
        before = self._answered.pop(name, None)
        if before is not None:
            await self._slow(before.end, f'another client answers {name} now')
        self._answered[name] = await self._slow(_registered, name, kind, session, self._loop)

    async def unadvertise(self, session, name):
        answered = self._answered.get(name)
        if answered is None or answered.session is not session:
            raise Refused(f'this client has not advertised the service {name}')
        del self._answered[name]
        await self._slow(answered.end, f'the client does not answer {name} any more')

    def respond(self, session, name, request, values, result):
        answered = self._answered.get(name)
        if answered is None or answered.session is not session:
            raise Refused(f'this client has not advertised the service {name}')
        answered.respond(request, values, result)

    async def leave(self, session):
        for name in [name for name, one in self._answered.items() if one.session is session]:
            await self.unadvertise(session, name)


def _registered(name, kind, session, loop):
    try:
        return Answered(name, kind, session, loop)
    except (rospy.ServiceException, rospy.ROSException, ValueError, OSError) as error:
        raise Refused(str(error)) from None


def _text(error):
    if isinstance(error, (rospy.ServiceException, genpy.MessageException, OSError)):
        return str(error)
    return f'{type(error).__name__}: {error}'
