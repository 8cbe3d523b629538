"""The stand-ins for rqt: each opens a panel of the course's page instead of a window."""
import argparse
import json
import os
import re
import signal
import socket
import subprocess
import sys
import urllib.parse
import urllib.request
from typing import Any, Dict, List, NamedTuple, Optional, Set, Tuple

import rosgraph
import rospy

from rospy_support.master import Master, NoMaster

SERVER = 'rosrun', 'course_page', 'browser'  # it prints the line that ADDRESS finds
NODE = '/browser'
PORT = 8000  # of the page; test_container.py holds it equal in the files of the container, launch files and docs
PORT_PARAMETER = re.compile(r'(.*/browser\w*)/actual_port')
ADDRESS = re.compile(r'^Open (http://\S+) in a browser')
ANSWER_TIMEOUT = 2.0  # [s] of a request to a server


class RunningPage(NamedTuple):
    """A server on this machine: its address, and the name of its node; '' while it waits for a master."""

    address: str
    node: str


class Program(NamedTuple):
    """A program of rqt: the panel that it opens, and the key of the address for its arguments ('': it takes none)."""

    panel: str
    key: str = ''
    nargs: str = '?'


PROGRAMS = {'rqt_console': Program('console'), 'rqt_graph': Program('graph'),
            'rqt_image_view': Program('image', 'topic'), 'rqt_plot': Program('plot', 'fields', '*'),
            'rqt_reconfigure': Program('reconfigure'), 'rqt_tf_tree': Program('frames'),
            'rqt_topic': Program('topics')}
PLUGINS = {**{name: program.panel for name, program in PROGRAMS.items()},  # of rqt -s
           'rqt_service_caller': 'services', 'rqt_publisher': 'topics', 'rqt_top': 'nodes'}


def main() -> None:
    """Open the panel of the program that was typed, and serve the page until Ctrl-C unless another server does."""
    program = PROGRAMS.get(os.path.basename(sys.argv[0]))
    show(_chosen_plugin() if program is None else _chosen(program))


def _chosen(program: Program) -> str:
    """Return the address of a panel, with what is typed after the program's name."""
    parser = argparse.ArgumentParser(description=f'Opens the panel {program.panel} of the page in a browser.')
    if program.key:
        parser.add_argument(program.key, nargs=program.nargs, help='what to show; default: chosen there')
    arguments, ignored = parser.parse_known_args(rospy.myargv()[1:])
    _report_ignored(ignored)
    given = getattr(arguments, program.key) if program.key else None
    return fragment(program.panel, program.key, ' '.join(given) if isinstance(given, list) else given)


def _chosen_plugin() -> str:
    """Return the address of the page for rqt, or of the panel of the plug-in that -s names."""
    parser = argparse.ArgumentParser(prog='rqt', description='Opens the page of the course in a browser.')
    parser.add_argument('-s', '--standalone', metavar='PLUGIN', help=f'one panel only: {", ".join(PLUGINS)}')
    arguments, ignored = parser.parse_known_args(rospy.myargv()[1:])
    plugin = (arguments.standalone or '').partition('/')[0].partition('.')[0]
    if plugin and plugin not in PLUGINS:
        parser.error(f'there is no plug-in {plugin} here; choose from {", ".join(PLUGINS)}')
    _report_ignored(ignored)
    return fragment(PLUGINS.get(plugin, ''))


def fragment(panel: str, key: str = '', value: Optional[str] = None) -> str:
    """Return the part of an address behind its #."""
    return f'/{panel}' + (f'?{urllib.parse.urlencode({key: value})}' if value else '')


def _report_ignored(arguments: List[str]) -> None:
    if arguments:
        print(f'Ignored, because there is no Qt here: {" ".join(arguments)}', file=sys.stderr)


def show(panel: str) -> None:
    """Open the page at a panel, the address's part behind #; serve it until Ctrl-C unless another server does."""
    page = running_page()
    if page is not None:
        _open(f'{page.address}#{panel}')
        return
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    server = subprocess.Popen(SERVER, stdout=subprocess.PIPE, text=True)
    try:
        for line in server.stdout or ():
            match = ADDRESS.match(line)
            if match:
                _open(f'{match.group(1)}#{panel}')
                print('The server of the page runs until you press Ctrl-C here.', flush=True)
            else:
                print(line, end='', flush=True)
    except KeyboardInterrupt:  # a terminal's Ctrl-C also reaches the server
        server.send_signal(signal.SIGINT)
    sys.exit(server.wait())


def running_page() -> Optional[RunningPage]:
    """Return the RunningPage of this machine that shows this master, or None."""
    for node, (uri, port) in _registered().items():
        if uri and _status(port).get('node') == uri:
            return RunningPage(f'http://localhost:{port}/', node)
    status = _status(PORT)  # a server that waits for a master has not registered yet
    if not status.get('node') and same_master(str(status.get('uri')), rosgraph.get_master_uri()):
        return RunningPage(f'http://localhost:{PORT}/', '')
    return None


def _registered() -> Dict[str, Tuple[str, Any]]:
    """Return {name: (address, port)} of the servers' nodes that the master knows."""
    master = Master(ANSWER_TIMEOUT)
    try:
        (_, _, names), = master.request([('getParamNames',)])
        nodes = [match.group(1) for match in map(PORT_PARAMETER.fullmatch, names or ()) if match]
        addresses = master.request([('lookupNode', node) for node in nodes])
        ports = master.request([('getParam', f'{node}/actual_port') for node in nodes])
    except NoMaster:
        return {}
    return {node: (uri, port) for node, (_, _, uri), (_, _, port) in zip(nodes, addresses, ports)}


def name_is_taken() -> bool:
    """Return whether the master knows a node with the usual name; registering another one would end it."""
    try:
        (code, _, _), = Master(ANSWER_TIMEOUT).request([('lookupNode', NODE)])
    except NoMaster:
        return False
    return code == 1


def _status(port: Any) -> Dict[str, Any]:
    """Return what the server at a port of this machine says; {} if there is none, or another program."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # http_proxy is not for this machine
    try:
        with opener.open(f'http://localhost:{int(port)}/status', timeout=ANSWER_TIMEOUT) as answer:
            status = json.load(answer)
    except (OSError, ValueError, TypeError):
        return {}
    return status if isinstance(status, dict) else {}


def same_master(first: str, second: str) -> bool:
    """Return whether two URIs are those of one master: the port is the same, and an address of the host."""
    try:
        return bool(_addresses(first) & _addresses(second))
    except (OSError, ValueError):
        return False


def _addresses(uri: str) -> Set[Tuple[str, int]]:
    parts = urllib.parse.urlsplit(uri)
    if not (parts.hostname and parts.port):
        return set()
    found = socket.getaddrinfo(parts.hostname, parts.port, type=socket.SOCK_STREAM)
    return {(str(address[0]).replace('::1', '127.0.0.1'), int(address[1])) for *_, address in found}


def _open(address: str) -> None:
    print(f'Open {address} in a browser.', flush=True)
    open_page(address)


def open_page(address: str) -> None:
    """Show an address in the browser of $BROWSER or of the desktop; report an error."""
    command = os.environ.get('BROWSER') or 'xdg-open'
    try:
        subprocess.Popen([command, address], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                         stderr=subprocess.DEVNULL, start_new_session=True)
    except OSError as error:
        print(f'No browser could be opened with {command} ({error.strerror}): open {address} yourself.', flush=True)
