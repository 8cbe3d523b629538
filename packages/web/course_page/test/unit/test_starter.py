"""course_page.starter: programs that a page starts and stops, and requests that are refused."""
import asyncio
import json
import os
import sys
import time
import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import pytest

from course_page import recordings, running, starter

WAITS = 'import signal, sys, time; print("\\x1b[1mhere\\x1b[0m", flush=True); time.sleep(100)'
STARTABLES = (starter.Startable('waits', 'Waits', '', (sys.executable, '-c', WAITS)),
              starter.Startable('fails', 'Fails', '', (sys.executable, '-c', 'raise SystemExit("no laser")')),
              starter.Startable('absent', 'Absent', '', ('/no/such/program',)))


@pytest.fixture
def site(serve):
    programs = starter.Starter(STARTABLES)
    yield serve('/programs', [('/programs', starter.Programs)], starter=programs)
    programs.end()


def until(site, name, **values):
    """Wait until a program has these values."""
    site.until(lambda programs: [program for program in programs
                                 if program['name'] == name and values.items() <= program.items()])


def test_a_program_is_started_once_and_stopped(site):
    until(site, 'waits', state='stopped', output='')
    for _ in range(2):  # the second one changes nothing
        assert site.post({'name': 'waits', 'action': 'start'})[0] == 200
    until(site, 'waits', state='running', output='here')
    assert site.post({'name': 'waits', 'action': 'stop'})[0] == 200
    until(site, 'waits', state='stopped')
    assert site.post({'name': 'waits', 'action': 'stop'})[0] == 200


def test_a_program_that_fails_says_why_and_can_be_started_again(site):
    for _ in range(2):
        site.post({'name': 'fails', 'action': 'start'})
        until(site, 'fails', state='failed', output='no laser', reason='no laser')


@pytest.mark.parametrize('body, code, text', [
    ({'name': 'rm -rf', 'action': 'start'}, 400, 'a NAME from the list'),
    ({'name': ['waits'], 'action': 'start'}, 400, 'a NAME from the list'), ([], 400, 'the request must be'),
    ({'name': 'waits'}, 400, 'the request must be'), ({'name': 'waits', 'action': 'kill'}, 400, '"start" or "stop"'),
    ({'name': 'absent', 'action': 'start'}, 500, 'absent cannot be started: No such file')])
def test_other_requests_are_refused(site, body, code, text):
    assert site.post(body)[0] == code and text in site.post(body)[1]


def test_another_site_starts_nothing(site):
    assert site.post({'name': 'waits', 'action': 'start'}, Origin='http://elsewhere.example')[0] == 403
    until(site, 'waits', state='stopped')


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


FOREIGN = (starter.Startable('turtle', 'Turtle', '', (sys.executable, '-c', WAITS), ('/turtlesim', '/spawn'), (),
                             'the drawing'),
           starter.Startable('maze', 'Maze', '', (sys.executable, '-c', WAITS), ('/robot', '/odom'),
                             (('/robot/world', 'maze'),)),
           starter.Startable('posts', 'Posts', '', (sys.executable, '-c', WAITS), ('/robot', '/odom'),
                             (('/robot/world', 'posts'),)))


class Graph:
    """What the master knows, in place of it; ``ends``: which nodes end when they are asked to."""

    def __init__(self, monkeypatch, ends=True, together=()):
        self.holders, self.values, self.ended, self._ends = {}, {}, [], ends
        monkeypatch.setattr(running, 'look', lambda names, parameters=(): running.Seen(
            {name: users for name, users in self.holders.items() if name in names}, self.values))
        monkeypatch.setattr(running, 'end', self._end)
        monkeypatch.setattr(running, 'started_with_this_page', lambda nodes: set(nodes) & set(together))

    def _end(self, nodes_left):
        self.ended += sorted(nodes_left())
        if self._ends:
            self.holders.clear()
        return nodes_left()


def states(programs):
    programs._looked = -starter.LOOK_INTERVAL
    return {one['name']: one['state'] for one in asyncio.run(programs.state())}


@pytest.fixture
def programs(tmp_path):
    made = starter.Starter(FOREIGN, tmp_path)
    yield made
    made.end()


def test_what_was_started_in_a_terminal_runs_and_is_not_replaced_without_a_question(programs, monkeypatch):
    graph = Graph(monkeypatch)
    assert set(states(programs).values()) == {'stopped'}
    graph.holders = {'/turtlesim': {'/turtlesim'}, '/spawn': {'/turtlesim'}}
    assert states(programs) == {'turtle': 'elsewhere', 'maze': 'stopped', 'posts': 'stopped'}
    with pytest.raises(starter.Question) as question:
        asyncio.run(programs.start('turtle'))
    assert str(question.value) == ('"Turtle" runs already, started in a terminal. End it and start this? '
                                'It loses the drawing.')
    assert not graph.ended and states(programs)['turtle'] == 'elsewhere'
    asyncio.run(programs.start('turtle', instead=True))
    assert graph.ended == ['/turtlesim'] and states(programs)['turtle'] == 'running'


def test_which_world_runs_is_told_by_its_parameters(programs, monkeypatch):
    graph = Graph(monkeypatch)
    graph.holders, graph.values = {'/robot': {'/robot'}, '/odom': {'/robot'}}, {'/robot/world': 'posts'}
    assert states(programs) == {'turtle': 'stopped', 'maze': 'stopped', 'posts': 'elsewhere'}
    with pytest.raises(starter.Question, match='"Posts" runs already, started in a terminal'):
        asyncio.run(programs.start('maze'))
    graph.values = {'/robot/world': 'mine'}  # in no list
    assert set(states(programs).values()) == {'stopped'}
    with pytest.raises(starter.Question, match='^/robot runs already, started in a terminal'):
        asyncio.run(programs.start('maze'))
    graph.holders = {'/odom': {'/base'}}  # another robot
    with pytest.raises(starter.Question, match='^/base runs already'):
        asyncio.run(programs.start('maze'))


def test_a_world_of_the_page_is_ended_for_another_only_when_the_user_says_so(programs, monkeypatch):
    graph = Graph(monkeypatch)
    asyncio.run(programs.start('maze'))  # it has not registered yet
    first = programs._processes['maze']
    with pytest.raises(starter.Question, match='^"Maze" runs already. End it and start this[?]$'):
        asyncio.run(programs.start('posts'))
    assert first.runs()
    asyncio.run(programs.start('turtle'))  # is in nobody's way
    asyncio.run(programs.start('posts', instead=True))
    assert not first.runs() and not graph.ended
    assert states(programs) == {'turtle': 'running', 'maze': 'stopped', 'posts': 'running'}


def test_what_does_not_end_or_would_end_the_page_is_left(programs, monkeypatch):
    graph = Graph(monkeypatch, ends=False)
    graph.holders = {'/turtlesim': {'/turtlesim'}}
    with pytest.raises(recordings.Refused, match='/turtlesim did not end: end it in its terminal by Ctrl-C'):
        asyncio.run(programs.start('turtle', instead=True))
    graph = Graph(monkeypatch, together=['/turtlesim'])
    graph.holders = {'/turtlesim': {'/turtlesim'}}
    with pytest.raises(recordings.Refused, match='"Turtle" runs already. It was started together with this page'):
        asyncio.run(programs.start('turtle', instead=True))
    assert not graph.ended and states(programs)['turtle'] == 'elsewhere'


@pytest.mark.parametrize('argv, number, together', [
    (['browser', '__log:=x'], os.getpid(), {'/turtlesim'}), (['browser'], os.getpid(), set()),
    (['browser', '__log:=x'], 1, set())], ids=['one roslaunch', 'a terminal', 'another parent'])
def test_which_nodes_the_roslaunch_of_this_page_has_started(monkeypatch, argv, number, together):
    """Whatever the command of the parent is called: here it is that of pytest."""
    monkeypatch.setattr(sys, 'argv', argv)
    monkeypatch.setattr(running, 'Master', lambda timeout: SimpleNamespace(
        request=lambda calls: [(1, '', 'http://localhost:1/')]))
    monkeypatch.setattr(running, '_node', lambda uri: SimpleNamespace(getPid=lambda caller: (1, '', number)))
    assert running.started_with_this_page(['/turtlesim']) == together


def test_a_question_is_answered_by_another_request(monkeypatch, site):
    monkeypatch.setattr(starter.Starter, '_make_room', _question)
    code, text = site.post({'name': 'waits', 'action': 'start'})
    assert code == 200 and json.loads(text) == {'question': 'End it?'}
    assert 'question' in site.post({'name': 'waits', 'action': 'start', 'instead': 'yes'})[1]  # only true is a yes
    until(site, 'waits', state='stopped')
    assert site.post({'name': 'waits', 'action': 'start', 'instead': True})[0] == 200
    until(site, 'waits', state='running')


async def _question(self, one, instead):
    if not instead:
        raise starter.Question('End it?')


def test_without_a_master_or_room_nothing_is_recorded(tmp_path, monkeypatch):
    programs = starter.Starter(folder=tmp_path)
    with pytest.raises(recordings.Refused, match='no ROS master answers'):
        asyncio.run(programs.start('record'))
    monkeypatch.setattr(recordings, 'RESERVE', 1 << 40)
    with pytest.raises(recordings.Refused, match='stay free'):
        asyncio.run(programs.start('record'))
    told = {one['name']: one['about'] for one in asyncio.run(programs.state())}
    assert 'Not now: the disk of' in told['record']
    programs.end()


def test_a_recording_that_was_cut_off_is_indexed_or_offered(tmp_path):
    programs = starter.Starter((), tmp_path)
    for name, age in (('page_1.bag.active', 100), ('page_2.bag.active', 0), ('mine.bag.active', 100)):
        (tmp_path / name).write_text('')
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    rows = {one['name']: one for one in asyncio.run(programs.state())}
    assert {name: one['state'] == 'running' for name, one in rows.items()} == {
        'index page_1.bag.active': True, 'index page_2.bag.active': False, 'index mine.bag.active': False}
    programs.end()


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
