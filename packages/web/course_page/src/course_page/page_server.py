"""browser: one process that serves the page in web/, its WebSocket to ROS, and images as video.

It also starts without a ROS master, because the page then explains what to do; hence it has options, not parameters.

Threading contract: the loop of the server runs in a thread of its own, from the start; rospy is initialised in the
main thread as soon as a master answers.
"""
import argparse
import asyncio
import collections
import functools
import ipaddress
import json
import os
import socket
import sys
import threading
import time
from typing import Any, Collection, Deque, List, Optional, Sequence

import rosapi.srv
import rosgraph
import rospy
import tornado.web
from rosapi.msg import TypeDef
from rosgraph_msgs.msg import Log

from browser_servers.bridge import RosBridge
from browser_servers.core import web
from browser_servers.core.access import OFF
from browser_servers.core.conversion import json_values
from browser_servers.core.encodings import Message
from browser_servers.core.session import Settings
from browser_servers.rosapi_answers import Answers
from browser_servers.sources import Sources
from browser_servers.streams import Snapshot, Stream
from browser_servers.websocket import Clients, RosbridgeWebSocket, websocket_rule
from course_page import grading
from course_page.marker_photo import MarkerPhoto, Photos
from course_page.panels import NODE, PORT, name_is_taken, open_page, running_page
from course_page.starter import Programs, Starter
from plain_support import course, packages
from rospy_support import nodes, registration
from rospy_support.master import Master, NoMaster
from rospy_support.servers import Report

POLL_INTERVAL = 0.5  # [s] between two requests to a master
ANSWER_TIMEOUT = 1.0  # [s] of such a request
MAX_CLIENTS = MAX_STREAMS = 100
UNREGISTER = 10.0  # [s] that a topic stays advertised after its last client
RATE = 5000.0  # [1/s] messages of a page
PING, PONG = 2.0, 6.0  # [s] between two pings, and in which a page must answer
ADDRESS = 'TURTLE_ROBOTONT_ADDRESS'  # of the environment: where to listen in a container, whose port is published
LOG_TOPIC, LOG_LENGTH = '/rosout_agg', 1000  # what nodes have logged before a page opens its console
NOT_YET = 'no ROS master answers at {uri}; type roscore in a terminal'


class Page(web.Files):
    """The files of the page; a browser runs only scripts from here."""

    def set_extra_headers(self, path: str) -> None:
        super().set_extra_headers(path)
        self.set_header('Content-Security-Policy', policy(self.request.host, self.settings['access'].origins))
        self.set_header('Referrer-Policy', 'no-referrer')


def policy(host: str, origins: Collection[str]) -> str:
    """Return the Content-Security-Policy of a page from ``host``, a name or address with its port.

    ``origins``: of other pages that may connect; behind a proxy that changes the Host, it is one of these.
    """
    own = [host, *(origin.partition('://')[2] for origin in origins if '://' in origin)]
    sockets = ' '.join(f'ws://{name} wss://{name}' for name in own)
    return ("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
            f"connect-src 'self' {sockets}; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
            "frame-ancestors 'self'")


class Probe:
    """Asks the master for all pages together, at most once in POLL_INTERVAL."""

    def __init__(self) -> None:
        self._time = 0.0  # of the last request
        self._answer: Optional[asyncio.Future[bool]] = None

    async def answers(self) -> bool:
        """Return whether the master answers, or has answered just now."""
        now = time.monotonic()
        if self._answer is None or (self._answer.done() and now - self._time > POLL_INTERVAL):
            self._time = now
            self._answer = asyncio.get_event_loop().run_in_executor(None, master_answers)
        return await asyncio.shield(self._answer)


class Status(web.Guarded):
    """The state of server and master as JSON, for a page without a connection to ROS."""

    async def get(self) -> None:
        answers = await self.settings['probe'].answers()
        ready = self.settings['ready'].is_set()
        self.answer_json(json.dumps({
            'master': answers, 'ready': ready, 'uri': rosgraph.get_master_uri(), 'name': rospy.get_name(),
            'node': rospy.get_node_uri() if ready else '', 'driving': self.settings['clients'].driving()}))


class LogKeeper:
    """Keeps the last messages that nodes have logged; a subscriber like the session of a page, in the loop's thread."""

    def __init__(self) -> None:
        self.messages: Deque[Message] = collections.deque(maxlen=LOG_LENGTH)

    def deliver(self, message: Message, kept: bool = False) -> None:
        self.messages.append(message)


class Logged(web.Guarded):
    """The messages of ``settings['log']``, a LogKeeper, as JSON."""

    def get(self) -> None:
        self.answer_json(json.dumps([json_values(Log().deserialize(message.data))
                                     for message in self.settings['log'].messages]))


class Steps(web.Guarded):
    """The list of the steps of the course, and which panels show what happens in each, as JSON."""

    def get(self) -> None:
        steps = course.steps(course.installed())
        self.answer_json(json.dumps([{'number': step.number, 'title': step.title, 'folder': step.folder.name,
                                      'panels': step.panels} for step in steps]))


class Socket(RosbridgeWebSocket):
    """The WebSocket of a page, or of another client."""

    async def get(self, *arguments: Any, **keywords: Any) -> None:
        """Accept a client once a ROS master answers."""
        if self.settings['ready'].is_set():
            await super().get(*arguments, **keywords)
        else:
            self.refuse(503, NOT_YET.format(uri=rosgraph.get_master_uri()))


def master_answers() -> bool:
    try:
        return bool(Master(ANSWER_TIMEOUT).request([('getPid',)]))
    except NoMaster:
        return False


class PageServer:
    """The server; it listens when it is made."""

    def __init__(self, options: argparse.Namespace) -> None:
        """Take the options of the command line; end the process if the port cannot be used."""
        self._server = web.Server(self._application, _listen(options.address, options.port))
        self.ready = threading.Event()
        self._log = LogKeeper()
        self._bridge: RosBridge  # made by _application
        self._starter = Starter(folder=options.programs, outlives=options.outlives)
        self._grader = grading.Grader(options.programs)
        self.port = self._server.port
        local = options.address in ('127.0.0.1', 'localhost', '::1')
        published = options.address == os.environ.get(ADDRESS)  # then only the address of the host leads here
        self._access = web.make_access(options.address, options.token, options.origins, options.hosts, False, _print,
                                       self._server.port, published)
        token = '' if local or self._access.token == OFF else f'?token={self._access.token}'
        self.address = f'http://{_host(options.address)}:{self._server.port}/{token}'
        self._folder = options.folder
        self._turtles = str(packages.folder('turtlesim') / 'images')

    def _application(self) -> tornado.web.Application:
        """Make the application, in the loop's thread."""
        report = Report()
        self._bridge = RosBridge(asyncio.get_event_loop(), UNREGISTER, Answers(rosapi.srv, TypeDef))
        clients = Clients(self._bridge, Settings(rate=RATE, burst=2 * RATE), MAX_CLIENTS,
                          functools.partial(report, 'client'), lambda clients: None)
        return tornado.web.Application(
            [websocket_rule(Socket, clients), (r'/status', Status),
             (r'/log', Logged), (r'/programs', Programs), (r'/grading', grading.Gradings),
             (r'/grading/choices', grading.Choices), (r'/grading/path.png', grading.Picture),
             (r'/marker_photo', MarkerPhoto), (r'/course/steps', Steps),
             (r'/course/(\w+/(?:README\.md|\w+\.(?:png|svg)))', web.Files, {'path': str(course.installed())}),
             (r'/stream', Stream), (r'/snapshot', Snapshot),
             (r'/turtles/(.*)', web.Files, {'path': self._turtles}),
             (r'/(.*)', Page, {'path': self._folder, 'default_filename': 'index.html'})],
            access=self._access, clients=clients, probe=Probe(), log=self._log, starter=self._starter,
            grader=self._grader, photos=Photos(),
            refused=functools.partial(report, 'access'), warn=functools.partial(report, 'image'), ready=self.ready,
            sources=Sources(asyncio.get_event_loop()), default_kind='mjpeg', streams=[0], max_streams=MAX_STREAMS,
            use_compression=False, ping_interval=PING, ping_timeout=PONG,
            websocket_max_message_size=Settings().largest, log_function=lambda handler: None)

    def start(self) -> None:
        self._server.start()

    def connect(self) -> None:
        """Let pages use ROS, now that rospy is initialised."""
        asyncio.run_coroutine_threadsafe(self._keep_log(), self._server.loop)
        self.ready.set()

    async def _keep_log(self) -> None:
        await self._bridge.subscribe(self._log, LOG_TOPIC, Log._type)

    def stop(self) -> None:
        """End, with the programs that pages have started."""
        self._server.stop()
        self._starter.end()
        self._grader.end()


def _listen(address: str, port: int) -> List[socket.socket]:
    try:
        return web.listen(port, address)
    except OSError as error:
        if not port:
            sys.exit(f'Cannot listen at {address}: {error.strerror or error}.')
        _print(f'Cannot listen at {address}, port {port} ({error.strerror or error}); a free port is used instead.')
        return _listen(address, 0)


def _host(address: str) -> str:
    """Return the host to type in a browser on this machine for an address to listen at."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if parsed.is_unspecified or parsed.is_loopback:
        return 'localhost'
    return f'[{parsed}]' if parsed.version == 6 else str(parsed)


def _print(text: str) -> None:
    print(text, flush=True)


def options_of(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='browser.py', description='Shows and drives the course in a browser.')
    parser.add_argument('--port', type=int, default=PORT, help='where to listen; 0: a free port (default: %(default)s)')
    parser.add_argument('--address', default=os.environ.get(ADDRESS) or '127.0.0.1',
                        help='127.0.0.1: only this machine; 0.0.0.0: all networks, then other machines need the token '
                        f'(default: %(default)s; the variable {ADDRESS} sets it)')
    parser.add_argument('--token', default='',
                        help='token that other machines must send; default: a new one; off: none')
    parser.add_argument('--origins', default='',
                        help='further sites whose pages may connect, separated by commas; any: all')
    parser.add_argument('--hosts', default='', help='further names of this machine, separated by commas')
    parser.add_argument('--folder', default=str(packages.folder('course_page') / 'web'),
                        help='a page of your own instead of this one')
    parser.add_argument('--programs', default='.', metavar='DIR', help='where the panel Grade looks for '
                        'programs, besides the sourced workspaces, and Start for bags (default: the current folder)')
    parser.add_argument('--outlives', action='store_true', help='for launch files: the page runs on when '
                        'the other nodes of its launch file end')
    parser.add_argument('--open', nargs='?', const='true', default='false', choices=('true', 'false'),
                        help='also open the page, with $BROWSER or xdg-open')
    options = parser.parse_args(arguments)
    if not 0 <= options.port <= 65535:
        parser.error(f'argument --port: {options.port} is not a port; it must be 0 to 65535')
    if not os.path.isfile(os.path.join(options.folder, 'index.html')):
        parser.error(f'argument --folder: {options.folder} has no index.html')
    if not os.path.isdir(options.programs):
        parser.error(f'argument --programs: {options.programs} is not a folder')
    options.folder, options.programs = os.path.realpath(options.folder), os.path.realpath(options.programs)
    return options


def _is_served_already(options: argparse.Namespace, port: Optional[int] = None) -> bool:
    """Return whether another server shows this master, and print that; ``port``: that of this server."""
    page = running_page()
    if page is None or page.address == f'http://localhost:{port}/':
        return False
    _print(f'The page is at {page.address} already: open that in a browser. This second server ends now. To start one '
         f'with other options, end the first one: {f"rosnode kill {page.node}" if page.node else "press Ctrl-C there"}')
    if options.open == 'true':
        open_page(page.address)
    return True


def _start_node(port: int) -> None:
    """Initialise rospy; a node that has the usual name already, on another machine for example, keeps it."""
    if name_is_taken():
        given = [argument for argument in sys.argv if not argument.startswith('__name:=')]
        nodes.init_node('browser', argv=given, anonymous=True)
        _print(f'Another node is called {NODE}: this one is {rospy.get_name()}.')
    else:
        nodes.init_node('browser')
    registration.keep_parameter('~actual_port', port)


def main() -> None:
    options = options_of(rospy.myargv()[1:])
    if _is_served_already(options):
        return
    server = PageServer(options)
    server.start()
    _print(f'Open {server.address} in a browser.')
    if options.open == 'true':
        open_page(server.address)
    try:
        while not master_answers():
            if rospy.is_shutdown():
                return
            time.sleep(POLL_INTERVAL)
        if not _is_served_already(options, server.port):
            _start_node(server.port)
            server.connect()
            rospy.spin()
    finally:
        server.stop()
