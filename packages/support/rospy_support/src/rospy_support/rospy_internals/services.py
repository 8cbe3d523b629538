"""Services: requests that are read elsewhere, and services that answer from another thread."""
import select
import socket
import struct
import sys
import threading
from typing import Any, Callable, Dict, List, Optional, Tuple

import genpy
import rospy
import rospy.impl.tcpros_base
import rospy.impl.tcpros_service
from rospy.impl.registration import get_service_manager

from rospy_support.rospy_internals.topics import frame, to_bytes

ANY_TYPE = '*'  # instead of an md5sum: matches every type
SHUTDOWN_POLL = 0.5  # [s] between two checks whether a call can still be answered


def offered_services() -> List[Tuple[str, str]]:
    """Return (name, URI) of each service that this node offers."""
    return get_service_manager().get_services()


def find_service(header: Dict[str, str]) -> Any:
    """Return the service that a caller's header {field: text} names; raise LookupError with the reason of a refusal.

    A service has ``resolved_name`` and ``request_class``; see also ``service_header`` and ``respond``.
    """
    for field in ('md5sum', 'callerid'):
        if field not in header:
            raise LookupError(f"Missing required '{field}' field")
    found = get_service_manager().get_service(header['service'])
    if found is None:
        raise LookupError(f'[{rospy.get_name()}] is not a provider of [{header["service"]}]')
    if header['md5sum'] not in (ANY_TYPE, found.service_class._md5sum):
        raise LookupError(f'request from [{header["callerid"]}]: md5sums do not match: [{header["md5sum"]}] vs. '
                          f'[{found.service_class._md5sum}]')
    return found


def service_header(found: Any) -> Dict[str, str]:
    """Return the header {field: text} with which a service answers the header of its caller."""
    return found.protocol.get_header_fields()


def transport_of(found: Any, connection: socket.socket, header: Dict[str, str]) -> Any:
    """Return rospy's transport for a connection (socket) to a service; ``header`` {field: text} is the caller's."""
    transport = rospy.impl.tcpros_base.TCPROSTransport(found.protocol, found.resolved_name, header=header)
    transport.set_socket(connection, header['callerid'])
    return transport


def respond(found: Any, transport: Any, data: bytes) -> Optional[str]:
    """Call a service with a serialised request and write the answer; raise OSError if the caller has gone.

    Return why ``data`` (bytes) is not a request, or None. The fault: rospy never answers a request that is too short,
    and genpy accepts one whose last string is cut off, or with bytes after its last field.
    """
    request = found.request_class()
    try:
        request.deserialize(data)
        wrong = None if to_bytes(request) == data else 'its length does not match its fields'
    except (genpy.DeserializationError, genpy.SerializationError, UnicodeError) as error:
        wrong = str(error)
    if wrong is None:
        request._connection_header = transport.header
        found._handle_request(transport, request)
        return None
    wrong = f'{len(data)} bytes that are not a {request._type}: {wrong}'
    transport.socket.sendall(service_error(wrong))
    return wrong


def handle_request(self: Any, transport: Any, request: Any) -> None:
    """Replace ServiceImpl._handle_request.

    The fault: rospy reports a caller that has gone as an error of the handler, with a traceback.
    """
    try:
        response = rospy.impl.tcpros_service.convert_return_to_response(self.handler(request), self.response_class)
        self.seq += 1
        answer = b'\1' + frame(response, self.seq)
    except rospy.ServiceException as error:
        answer = service_error(f'service cannot process request: {error}')
    except Exception as error:
        self.error_handler(error, *sys.exc_info())
        answer = service_error(f'error processing request: {error}')
    transport.socket.sendall(answer)


def service_error(text: str) -> bytes:
    """Return the bytes of an answer that makes the caller raise a ServiceException with this text."""
    data = text.encode()
    return struct.pack('<BI', 0, len(data)) + data


class ServiceCall:
    """A request of a QueuedService. Call either ``answer`` or ``fail``, once, from any thread."""

    def __init__(self, service: Any, transport: Any, request: Any) -> None:
        self.service, self.request = service, request
        self._transport = transport
        self._unsent = b''
        self._answered = threading.Event()

    def answer(self, response: Any) -> None:
        """Send a response without waiting.

        The fault: a client that does not read stops the thread of the simulator that answers.
        """
        self._write(b'\x01' + frame(response))

    def fail(self, reason: str) -> None:
        """Send the reason of a failure, also without waiting."""
        self._write(service_error(reason))

    def _write(self, data: bytes) -> None:
        connection = self._transport.socket
        try:
            taken = select.poll()
            taken.register(connection, select.POLLOUT)
            # send() on a socket with a timeout waits despite MSG_DONTWAIT
            sent = connection.send(data, socket.MSG_DONTWAIT) if taken.poll(0) else 0
        except BlockingIOError:
            sent = 0
        except (OSError, TypeError, AttributeError):  # the client has gone; the socket is None once rospy has closed it
            sent = len(data)
        self._unsent = data[sent:]
        self._answered.set()

    def finish(self) -> None:
        """Wait for the answer, and send the rest of it. The thread of the connection calls this."""
        while not self._answered.wait(SHUTDOWN_POLL):
            if rospy.is_shutdown():
                return
        if self._unsent:
            self._transport.socket.sendall(self._unsent)


class QueuedService(rospy.Service):
    """A rospy.Service that passes its requests on as ServiceCalls instead of answering them itself."""

    def __init__(self, name: str, service_class: Any, hand_over: Callable[[ServiceCall], Any]) -> None:
        """``hand_over(call)`` is called in one of rospy's threads, which then waits until the call is answered."""
        self._hand_over = hand_over
        super().__init__(name, service_class, hand_over)

    def _handle_request(self, transport: Any, request: Any) -> None:
        call = ServiceCall(self, transport, request)
        self._hand_over(call)
        call.finish()
