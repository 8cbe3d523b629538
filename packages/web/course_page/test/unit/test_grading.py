"""course_page.grading: what the page offers to grade, one grading at a time, and requests that are refused."""
import asyncio
import json
import os
import sys
import time
import urllib.error
import urllib.request

import pytest
import tornado.web

from browser_servers.core import web
from course_grader.isolation import sourced
from course_page import grading

DEADLINE = 30.0  # [s]
GRADER = '''import json, os, sys, time
if sys.argv[1] == '--list':
    print(json.dumps([{'name': 'circle', 'title': 'A circle', 'asks': 'Drive.'}]))
    sys.exit()
folder, program = sys.argv[2].partition('=')[2], sys.argv[4]
print('Grading', sys.argv[1], sys.argv[3], flush=True)
text = open(program).read()
if text == 'wait':
    time.sleep(100)
if text == 'absent':
    sys.exit('circle: no such package')
os.makedirs(folder)
open(folder + '/path.png', 'wb').write(b'PNG')
open(folder + '/output.txt', 'w').write('  0.10  here')
json.dump({'seed': 7, 'outcome': 'passed', 'score': 100.0}, open(folder + '/result.json', 'w'))
'''


@pytest.fixture
def grader(tmp_path):
    (tmp_path / 'grader.py').write_text(GRADER)
    home = tmp_path / 'home'
    (home / 'pkg' / 'scripts').mkdir(parents=True)
    for name in ('good', 'wait', 'absent'):
        (home / 'pkg' / 'scripts' / f'{name}.py').write_text(name)
    made = grading.Grader(str(home), (sys.executable, str(tmp_path / 'grader.py')))
    yield made
    made.end()


@pytest.fixture
def server(grader):
    made = web.Server(lambda: tornado.web.Application(
        [('/grading', grading.Gradings), ('/grading/choices', grading.Choices), ('/grading/path.png', grading.Picture)],
        access=web.make_access('127.0.0.1', '', '', '', False, str, 0), refused=lambda text: None, grader=grader,
        log_function=lambda handler: None), web.listen(0, '127.0.0.1'))
    made.start()
    yield made
    made.stop()


def ask(server, path='', body=None, **headers):
    """Return (code, text) of a request."""
    data = None if body is None else json.dumps(body).encode()
    try:
        with urllib.request.urlopen(urllib.request.Request(
                f'http://localhost:{server.port}/grading{path}', data, headers), timeout=DEADLINE) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def until(server, *states):
    end = time.monotonic() + DEADLINE
    while True:
        state = json.loads(ask(server)[1])
        if state['state'] in states:
            return state
        assert time.monotonic() < end, state
        time.sleep(0.02)


def program(server, name):
    return next(path for path in json.loads(ask(server, '/choices')[1])['programs'] if path.endswith(f'/{name}.py'))


def test_a_program_is_graded_with_its_verdict(server):
    assert until(server, 'none')['number'] == 0
    assert ask(server, '/path.png')[0] == 404
    path = program(server, 'good')
    for number in (1, 2):
        assert ask(server, body={'exercise': 'circle', 'program': path})[0] == 200
        state = until(server, 'graded')
        assert (state['number'], state['result']['score'], state['output']) == (number, 100.0, '  0.10  here')
    assert state['said'] == 'Grading circle --' and state['picture']
    assert state['line'] == f'./run grade circle --seed 7 -- {path}'
    assert ask(server, '/path.png') == (200, 'PNG')


def test_one_runs_at_a_time_and_can_be_stopped(server):
    asked = {'exercise': 'circle', 'program': program(server, 'wait')}
    ask(server, body=asked)
    code, said = ask(server, body=asked)
    assert code == 400 and 'wait.py is being graded; one grading runs at a time' in said
    assert until(server, 'running')['program'] == asked['program']
    assert ask(server, body={})[0] == 200
    assert until(server, 'failed')['result'] is None
    assert ask(server, body={})[0] == 200


def test_what_the_grader_says_instead_of_a_verdict_is_shown(server):
    ask(server, body={'exercise': 'circle', 'program': program(server, 'absent')})
    assert 'circle: no such package' in until(server, 'failed')['said']


@pytest.mark.parametrize('body, said', [
    ([], 'the request must be'), ({'exercise': 'circle'}, 'the request must be'), ('{', 'the request must be'),
    ({'exercise': '--all', 'program': 'good'}, "there is no exercise '--all'"),
    ({'exercise': ['circle'], 'program': 'good'}, 'there is no exercise'),
    ({'exercise': 'circle', 'program': '/bin/true'}, "'/bin/true' is not a program of the list; save it in"),
    ({'exercise': 'circle', 'program': {}}, 'is not a program of the list')])
def test_nothing_else_is_started(server, body, said):
    code, text = ask(server, body=body)
    assert code == 400 and said in text
    assert until(server, 'none')


def test_another_site_grades_nothing(server):
    for path in ('', '/choices', '/path.png'):
        assert ask(server, path, Origin='http://elsewhere.example')[0] == 403
    asked = {'exercise': 'circle', 'program': program(server, 'good')}
    assert ask(server, body=asked, Origin='http://elsewhere.example')[0] == 403
    assert ask(server, body=asked, Host='evil.example')[0] == 403
    until(server, 'none')


def test_without_a_grader_the_page_is_told_why(tmp_path):
    for command, said in (((sys.executable, '-c', 'raise SystemExit("no such package")'), 'no such package'),
                          (('/no/such/program',), 'No such file')):
        found = grading.Grader(str(tmp_path), command)
        choices = asyncio.new_event_loop().run_until_complete(found.choices())
        assert choices['exercises'] == [] and said in choices['error']
        found.end()


def test_programs_are_found_the_newest_first(tmp_path):
    names = ('a/old.py', 'a/new.py', 'b.launch', 'tool', 'x.bash', 'notes.txt', 'plain.sh', '.hidden/c.py',
             'build/d.py', 'a/setup.py', 'a/__init__.py')
    for number, name in enumerate(names):
        path = tmp_path / 'ws' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('')
        path.chmod(0o755 if name in ('tool', 'x.bash') else 0o644)
        os.utime(path, (1000 + number, 1000 + number))
    (tmp_path / 'ws' / 'link.py').symlink_to('/etc/passwd')
    (tmp_path / 'ws' / 'round').symlink_to(tmp_path / 'ws')
    (tmp_path / 'ws' / 'ours').symlink_to(grading.REPOSITORY)
    found = grading.programs(grading.folders(str(tmp_path / 'ws'), {}))
    assert [os.path.relpath(path, tmp_path / 'ws') for path in found] == [
        'x.bash', 'tool', 'b.launch', 'a/new.py', 'a/old.py']


def test_the_folders_are_those_of_the_user(tmp_path):
    own = tmp_path / 'src'
    own.mkdir()
    repository = grading.REPOSITORY
    assert os.path.isfile(f'{repository}/run')
    environment = {grading.SOURCED: f'{own}:/usr/share',
                   'ROS_PACKAGE_PATH': f'{own}:{tmp_path}/gone:{repository}:/opt/ros/x'}
    assert grading.folders(str(tmp_path), environment) == [tmp_path, own]
    assert grading.folders(repository, {}) == []
    assert grading.SOURCED == sourced.PACKAGE_PATH
