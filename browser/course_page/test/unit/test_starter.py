"""course_page.starter: programs that a page starts and stops, and requests that are refused."""
import asyncio
import json
import os
import sys
import time
import urllib.error
import urllib.request
import xml.etree.ElementTree as ElementTree

import pytest
import tornado.web

from course_page import starter
from rosbridge_core import web

DEADLINE = 20.0  # [s]
WAITS = 'import signal, sys, time; print("\\x1b[1mhere\\x1b[0m", flush=True); time.sleep(100)'
STARTABLES = (starter.Startable('waits', 'Waits', '', (sys.executable, '-c', WAITS)),
              starter.Startable('fails', 'Fails', '', (sys.executable, '-c', 'raise SystemExit("no laser")')),
              starter.Startable('absent', 'Absent', '', ('/no/such/program',)))


@pytest.fixture
def server():
    programs = starter.Starter(STARTABLES)
    made = web.Server(lambda: tornado.web.Application(
        [('/programs', starter.Programs)], access=web.make_access('127.0.0.1', '', '', '', False, str, 0),
        refused=lambda text: None, starter=programs, log_function=lambda handler: None), web.listen(0, '127.0.0.1'))
    made.start()
    yield made
    made.stop()
    programs.end()


def ask(server, body=None, **headers):
    """Return (code, text) of a request."""
    data = None if body is None else json.dumps(body).encode()
    try:
        with urllib.request.urlopen(urllib.request.Request(f'http://localhost:{server.port}/programs', data, headers),
                                    timeout=DEADLINE) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def until(server, name, **wanted):
    """Wait until a program has these values."""
    end = time.monotonic() + DEADLINE
    while True:
        shown = next(one for one in json.loads(ask(server)[1]) if one['name'] == name)
        if all(shown[key] == value for key, value in wanted.items()):
            return
        assert time.monotonic() < end, shown
        time.sleep(0.01)


def test_a_program_is_started_once_and_stopped(server):
    until(server, 'waits', state='stopped', output='')
    for _ in range(2):  # the second one changes nothing
        assert ask(server, {'name': 'waits', 'action': 'start'})[0] == 200
    until(server, 'waits', state='running', output='here')
    assert ask(server, {'name': 'waits', 'action': 'stop'})[0] == 200
    until(server, 'waits', state='stopped')
    assert ask(server, {'name': 'waits', 'action': 'stop'})[0] == 200


def test_a_program_that_fails_says_why_and_can_be_started_again(server):
    for _ in range(2):
        ask(server, {'name': 'fails', 'action': 'start'})
        until(server, 'fails', state='failed', output='no laser', reason='no laser')


@pytest.mark.parametrize('body, code, said', [
    ({'name': 'rm -rf', 'action': 'start'}, 400, 'a NAME from the list'),
    ({'name': ['waits'], 'action': 'start'}, 400, 'a NAME from the list'), ([], 400, 'the request must be'),
    ({'name': 'waits'}, 400, 'the request must be'), ({'name': 'waits', 'action': 'kill'}, 400, '"start" or "stop"'),
    ({'name': 'absent', 'action': 'start'}, 500, 'absent cannot be started: No such file')])
def test_other_requests_are_refused(server, body, code, said):
    assert ask(server, body)[0] == code and said in ask(server, body)[1]


def test_another_site_starts_nothing(server):
    assert ask(server, {'name': 'waits', 'action': 'start'}, Origin='http://elsewhere.example')[0] == 403
    until(server, 'waits', state='stopped')


def test_bags_of_the_folder_can_be_played_the_newest_first(tmp_path):
    programs = starter.Starter((), tmp_path)

    def state():
        return asyncio.run(programs.state())
    assert state() == []
    for number, name in enumerate(('old.bag', '-x.bag', 'other.txt')):
        (tmp_path / name).write_text('')
        os.utime(tmp_path / name, (number, number))
    assert [one['command'] for one in state()] == ['rosbag play ./-x.bag', 'rosbag play ./old.bag']
    (tmp_path / 'old.bag').unlink()
    assert [one['name'] for one in state()] == ['play -x.bag']
    with pytest.raises(KeyError):
        asyncio.run(programs.start('play ../x.bag'))
    programs.end()


def test_everything_ends_with_the_server():
    programs = starter.Starter(STARTABLES)
    asyncio.run(programs.start('waits'))
    process = programs._processes['waits']
    programs.end()
    assert not process.runs()
    asyncio.new_event_loop().run_until_complete(starter.Starter(STARTABLES).stop('waits'))


def test_the_list_names_launch_files_that_exist():
    import rospkg
    packages = rospkg.RosPack()
    for one in starter.STARTABLES:
        if one.name in starter.RECORDERS:
            continue
        command, package, file, *given = one.command
        assert command == 'roslaunch'
        arguments = ElementTree.parse(f'{packages.get_path(package)}/launch/{file}').getroot().iter('arg')
        assert {text.partition(':=')[0] for text in given} <= {argument.get('name') for argument in arguments}
