"""The stand-ins for rqt: each folder equals the others except for its name; the name decides which panel opens.

A page that shows the same master is found, however its address is spelled, and its node is never ended.
"""
import http.server
import pathlib
import sys
import threading

import pytest

from course_page import panels

RQT = pathlib.Path(__file__).resolve().parents[3] / 'rqt'
FOLDERS = sorted(RQT.glob('rqt_*'))


def test_every_folder_has_its_panel():
    assert {folder.name for folder in FOLDERS} == {'rqt_gui', *panels.PROGRAMS}


@pytest.mark.parametrize('folder', FOLDERS, ids=lambda folder: folder.name)
def test_folders_differ_in_names_only(folder):
    program = (RQT / 'rqt_gui' / 'scripts' / 'rqt').read_text()
    names = ['rqt', 'rqt_gui'] if folder.name == 'rqt_gui' else [folder.name]
    scripts = sorted(path for path in (folder / 'scripts').iterdir() if path.name != '__pycache__')
    assert [path.name for path in scripts] == names
    assert {path.read_text() for path in scripts} == {program}
    assert (folder / 'setup.py').samefile(RQT / 'rqt_gui' / 'setup.py')
    if folder.name != 'rqt_gui':
        assert (folder / 'CMakeLists.txt').read_text() == \
            (RQT / 'rqt_graph' / 'CMakeLists.txt').read_text().replace('rqt_graph', folder.name)


@pytest.mark.parametrize('typed, address', [
    ('rqt', '/'), ('rqt_gui', '/'), ('rqt -s rqt_plot', '/plot'), ('rqt --standalone rqt_top/Top', '/nodes'),
    ('rqt_graph', '/graph'), ('rqt_tf_tree', '/frames'), ('rqt_reconfigure', '/reconfigure'),
    ('rqt_console', '/console'), ('rqt_topic --force-discover', '/topics'),
    ('rqt_image_view', '/image'), ('rqt_image_view /camera/image_raw', '/image?topic=%2Fcamera%2Fimage_raw'),
    ('rqt_plot /a/x /a/y', '/plot?fields=%2Fa%2Fx+%2Fa%2Fy'),
])
def test_the_name_decides(typed, address, monkeypatch):
    shown = []
    monkeypatch.setattr(panels, 'show', shown.append)
    monkeypatch.setattr(sys, 'argv', ['/any/folder/' + typed.split()[0], *typed.split()[1:]])
    panels.main()
    assert shown == [address]


def test_unknown_plug_in_is_named(monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['rqt', '-s', 'rqt_bag'])
    with pytest.raises(SystemExit):
        panels.main()
    assert 'there is no plug-in rqt_bag here; choose from rqt_console' in capsys.readouterr().err


@pytest.mark.parametrize('one, other, same', [
    ('http://localhost:12200', 'http://127.0.0.1:12200', True), ('http://localhost:1', 'http://localhost:1/', True),
    ('http://[::1]:12200/', 'http://localhost:12200', True), ('http://LOCALHOST:12200', 'http://localhost:12200', True),
    ('http://localhost:12200', 'http://localhost:12201', False), ('http://127.0.0.1:1', 'http://10.77.0.1:1', False),
    ('http://localhost', 'http://localhost', False), ('nonsense', 'http://localhost:1', False),
    ('http://localhost:port', 'http://localhost:1', False), ('None', 'None', False),
])
def test_addresses_of_masters_are_compared_as_addresses(one, other, same):
    assert panels.same_master(one, other) is same


LOCAL, FAR = 'http://localhost:40001/', 'http://laptop:40002/'


@pytest.mark.parametrize('parameters, answers, found', [
    ({}, {}, None),
    ({}, {8000: {'uri': 'http://127.0.0.1:11311/', 'node': ''}}, ('http://localhost:8000/', '')),  # waits for a master
    ({}, {8000: {'uri': 'http://127.0.0.1:11312/', 'node': ''}}, None),
    ({'/browser': (LOCAL, 8005)}, {8005: {'uri': 'http://other:1', 'node': LOCAL}},
     ('http://localhost:8005/', '/browser')),
    ({'/browser': (LOCAL, 8005)}, {8005: {'uri': 'http://localhost:11311', 'node': FAR}}, None),  # a stale parameter
    ({'/browser': ('', 8005)}, {8005: {'uri': '', 'node': ''}}, None),  # its node has ended
    ({'/browser': (FAR, 8000)}, {}, None),  # on another machine, which this one's browser cannot reach
    ({'/browser': (FAR, 8000), '/ns/browser_1': (LOCAL, 8001)}, {8001: {'node': LOCAL}},
     ('http://localhost:8001/', '/ns/browser_1')),
    ({'/browser': (LOCAL, 'x')}, {}, None),
])
def test_a_page_is_found_by_the_node_that_the_master_knows(parameters, answers, found, monkeypatch):
    monkeypatch.setattr(panels, '_registered', lambda: parameters)
    monkeypatch.setattr(panels, '_status', lambda port: answers.get(port, {}))
    monkeypatch.setattr(panels.rosgraph, 'get_master_uri', lambda: 'http://localhost:11311')
    assert panels.running_page() == found


class Master:
    """A master that knows some parameters and nodes."""

    def __init__(self, known):
        self.known = known

    def request(self, calls):
        """Return the answers, as a master words them."""
        return [[1, '', list(self.known)] if method == 'getParamNames' else
                [1, '', self.known[argument[0]]] if argument[0] in self.known else [-1, 'unknown', '']
                for method, *argument in calls]


def test_the_master_is_asked_for_the_servers(monkeypatch):
    known = {'/browser': LOCAL, '/browser/actual_port': 8000, '/browser_7/actual_port': 8001,
             '/rosbridge_websocket/actual_port': 9090}
    monkeypatch.setattr(panels, 'Master', lambda timeout: Master(known))
    assert panels._registered() == {'/browser': (LOCAL, 8000), '/browser_7': ('', 8001)}
    assert panels.name_is_taken()
    del known['/browser']
    assert not panels.name_is_taken()


class Status(http.server.BaseHTTPRequestHandler):
    """Answers as the server of the page."""

    def do_GET(self):
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b'{"master": "here"}')

    def log_message(self, *_):
        """Say nothing."""


@pytest.mark.parametrize('variable', ['http_proxy', 'HTTP_PROXY', 'all_proxy'])
def test_a_proxy_is_not_asked_for_a_page_on_this_machine(monkeypatch, variable):
    monkeypatch.setenv(variable, 'http://127.0.0.1:9')
    for name in ('no_proxy', 'NO_PROXY'):
        monkeypatch.delenv(name, raising=False)
    with http.server.HTTPServer(('127.0.0.1', 0), Status) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        assert panels._status(server.server_port) == {'master': 'here'}
        server.shutdown()
