"""rosbridge_websocket: the node.

Threading contract: the loop runs in a thread of its own and does everything for clients; rospy's threads hand messages
over to it.
"""
import asyncio
import functools
import gc
import sys
from typing import Callable, List, Tuple, TypeVar

import rosapi.srv
import rospy
import tornado.web
from rosapi.msg import TypeDef
from rosbridge_msgs.msg import ConnectedClient, ConnectedClients
from std_msgs.msg import Int32

from browser_servers.bridge import RosBridge
from browser_servers.core import web
from browser_servers.core.operations import globs
from browser_servers.core.session import Settings
from browser_servers.rosapi_answers import Answers
from browser_servers.websocket import Clients, RosbridgeWebSocket, websocket_rule
from rospy_support import nodes, parameters, registration
from rospy_support.parameters import Boolean, Integer, Number, Table, Text
from rospy_support.servers import Report

Value = TypeVar('Value')
LARGEST = 1e9  # [B]
SWITCH = 0.0005  # [s] until another thread gets its turn, so that the loop does not wait for one that reads an image
PAGE = ('This is a rosbridge server: connect to it with a WebSocket, as roslibjs and roslibpy do. It shows no page '
        'because ~folder is not set.')

PARAMETERS = Table(
    Integer('~port', 9090, 0, 65535), Text('~address', '127.0.0.1'), Text('~token', '', secret=True),
    Text('~origins', ''), Text('~hosts', ''), Boolean('~websocket_null_origin', False), Text('~folder', ''),
    Number('~deadman', 0.0, 0.0, 60.0, 's'), Integer('~max_clients', 200, 1, 10000),
    Number('~max_message_size', 1e7, 1000, LARGEST, 'B', infinite='None'),
    Number('~max_rate', 20000.0, 1.0, 1e6, 'Hz'), Number('~slow_client_timeout', 10.0, 0.5, 3600.0, 's'),
    Number('~fragment_timeout', 600.0, 0.1, 86400.0, 's'), Number('~unregister_timeout', 10.0, 0.0, 86400.0, 's'),
    Number('~retry_startup_delay', 5.0, 0.1, 3600.0, 's'), Number('~websocket_ping_interval', 5.0, 0.0, 3600.0, 's'),
    Number('~websocket_ping_timeout', 30.0, 0.1, 3600.0, 's'), Boolean('~use_compression', False),
    Text('~topics_glob', '[*]'), Text('~services_glob', '[*]'), Text('~params_glob', '[*]'),
    Text('~certfile', ''), Text('~keyfile', ''), Boolean('~authenticate', False), Boolean('~bson_only_mode', False),
    Number('~delay_between_messages', 0.0, 0.0, 60.0, 's'), Text('~websocket_external_port', 'None'))


class ClientTopics:
    """The topics that list the connected clients."""

    def __init__(self) -> None:
        self._count = rospy.Publisher('client_count', Int32, latch=True, queue_size=10)
        self._clients = rospy.Publisher('connected_clients', ConnectedClients, latch=True, queue_size=10)
        self.publish([])

    def publish(self, clients: List[Tuple[str, float]]) -> None:
        """Publish the clients: (address, time of the connection [s]) of each."""
        self._clients.publish([ConnectedClient(address, rospy.Time.from_sec(start)) for address, start in clients])
        self._count.publish(len(clients))


class RosbridgeNode:
    """The node's server."""

    def __init__(self, port: int, address: str) -> None:
        """Read the parameters; rospy is initialised."""
        read = PARAMETERS.read
        self._globs = read('~topics_glob', '~services_glob', '~params_glob')
        self._report, self._client_topics = Report(), ClientTopics()
        largest, self._max_clients = read('~max_message_size', '~max_clients')
        deadman, rate, slow, fragments = read('~deadman', '~max_rate', '~slow_client_timeout', '~fragment_timeout')
        topics, services = (tuple(globs(text)) for text in self._globs[:2])
        self._settings = Settings(
            int(min(largest, LARGEST)), fragments, deadman, rate, 2 * rate, slow, topics,
            (*services, '/rosapi/*') if services else ())  # else a client could inspect nothing
        certificate, key, authenticate, bson = read('~certfile', '~keyfile', '~authenticate', '~bson_only_mode')
        for name, value in (('authenticate', authenticate), ('bson_only_mode', bson)):
            if value:
                raise parameters.ParameterError(f'parameter {rospy.resolve_name("~" + name)} is true; it must be '
                                                'false: this server has a token instead of rosauth, and no BSON')
        delay, = read('~retry_startup_delay')
        sockets = web.listen_when_free(port, address, delay, rospy.logwarn, rospy.is_shutdown)
        self._server = web.Server(self._application, sockets, (certificate, key) if certificate and key else None)
        self._scheme = 'wss' if certificate and key else 'ws'
        token, origins, hosts, null_origin = read('~token', '~origins', '~hosts', '~websocket_null_origin')
        self._access = web.make_access(address, token, origins, hosts, null_origin, rospy.logwarn, self._server.port)
        self._address = address
        self._http = read('~folder', '~websocket_ping_interval', '~websocket_ping_timeout', '~use_compression',
                          '~unregister_timeout')
        registration.keep_parameter('~actual_port', self._server.port)
        parameters.log_effective()

    def _application(self) -> tornado.web.Application:
        folder, interval, timeout, compress, unregister = self._http
        bridge = RosBridge(asyncio.get_event_loop(), unregister, Answers(rosapi.srv, TypeDef, *self._globs))
        clients = Clients(bridge, self._settings, self._max_clients, functools.partial(self._report, 'client'),
                          self._client_topics.publish)
        return tornado.web.Application(
            [websocket_rule(RosbridgeWebSocket, clients), *web.folder_rules(folder, PAGE)],
            access=self._access, refused=functools.partial(self._report, 'access'), use_compression=compress,
            ping_interval=interval, ping_timeout=timeout,
            websocket_max_message_size=self._settings.largest, log_function=lambda handler: None)

    def run(self) -> None:
        self._server.start()
        gc.freeze()  # present objects stay; searching them for garbage would delay messages by milliseconds
        rospy.loginfo('Rosbridge WebSocket server started at %s://%s:%d', self._scheme, self._address,
                      self._server.port)
        rospy.spin()
        self._server.stop()


def main() -> None:
    nodes.init_node('rosbridge_websocket', PARAMETERS)
    sys.setswitchinterval(SWITCH)
    port, address = PARAMETERS.read('~port', '~address')
    RosbridgeNode(_option('--port', port, int), _option('--address', address, str) or '0.0.0.0').run()


def _option(name: str, default: Value, convert: Callable[[str], Value]) -> Value:
    """Return the value of a command-line option, as in the original."""
    arguments = sys.argv[1:]
    if name not in arguments:
        return default
    try:
        return convert(arguments[arguments.index(name) + 1])
    except (IndexError, ValueError):
        sys.exit(f'The option {name} needs a value, as in {name} {default}.')
