"""course_page.grading: what the page offers to grade, one grading at a time, and requests that are refused."""
import asyncio
import os
import sys

import pytest

from course_grader.isolation import sourced
from course_page import grading
from plain_support import course

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
def site(serve, grader):
    return serve('/grading', [('/grading', grading.Gradings), ('/grading/choices', grading.Choices),
                              ('/grading/path.png', grading.Picture)], grader=grader)


def until(site, name):
    return site.until(lambda state: state['state'] == name)


def request(site, name):
    """Return the request to grade one of the programs."""
    path = next(path for path in site.get('/choices')['programs'] if path.endswith(f'/{name}.py'))
    return {'exercise': 'circle', 'program': path}


def test_a_program_is_graded_with_its_verdict(site):
    assert until(site, 'none')['number'] == 0
    assert site.send(path='/path.png')[0] == 404
    body = request(site, 'good')
    for number in (1, 2):
        assert site.post(body)[0] == 200
        state = until(site, 'graded')
        assert (state['number'], state['result']['score'], state['output']) == (number, 100.0, '  0.10  here')
    assert state['log'] == 'Grading circle --' and state['picture']
    assert state['command'] == f'./run grade circle --seed 7 -- {body["program"]}'
    assert site.send(path='/path.png') == (200, 'PNG')


def test_one_runs_at_a_time_and_can_be_stopped(site):
    body = request(site, 'wait')
    site.post(body)
    code, text = site.post(body)
    assert code == 400 and 'wait.py is being graded; one grading runs at a time' in text
    assert until(site, 'running')['program'] == body['program']
    assert site.post({})[0] == 200
    assert until(site, 'failed')['result'] is None
    assert site.post({})[0] == 200


def test_what_the_grader_prints_instead_of_a_verdict_is_shown(site):
    site.post(request(site, 'absent'))
    assert 'circle: no such package' in until(site, 'failed')['log']


@pytest.mark.parametrize('body, error', [
    ([], 'the request must be'), ({'exercise': 'circle'}, 'the request must be'), ('{', 'the request must be'),
    ({'exercise': '--all', 'program': 'good'}, "there is no exercise '--all'"),
    ({'exercise': ['circle'], 'program': 'good'}, 'there is no exercise'),
    ({'exercise': 'circle', 'program': '/bin/true'}, "'/bin/true' is not a program of the list; save it in"),
    ({'exercise': 'circle', 'program': {}}, 'is not a program of the list')])
def test_nothing_else_is_started(site, body, error):
    code, text = site.post(body)
    assert code == 400 and error in text
    assert until(site, 'none')


def test_another_site_grades_nothing(site):
    body = request(site, 'good')
    for path in ('', '/choices', '/path.png'):
        assert site.send(path=path, Origin='http://elsewhere.example')[0] == 403
    for headers in ({'Origin': 'http://elsewhere.example'}, {'Host': 'evil.example'}):
        assert site.post(body, **headers)[0] == 403
    until(site, 'none')


def test_without_a_grader_the_page_is_told_why(tmp_path):
    for command, error in (((sys.executable, '-c', 'raise SystemExit("no such package")'), 'no such package'),
                          (('/no/such/program',), 'No such file')):
        found = grading.Grader(str(tmp_path), command)
        choices = asyncio.new_event_loop().run_until_complete(found.choices())
        assert choices['exercises'] == [] and error in choices['error']
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
    (tmp_path / 'ws' / 'ours').symlink_to(course.repository())
    found = grading.programs(grading.folders(str(tmp_path / 'ws'), {}))
    assert [os.path.relpath(path, tmp_path / 'ws') for path in found] == [
        'x.bash', 'tool', 'b.launch', 'a/new.py', 'a/old.py']


def test_the_folders_are_those_of_the_user(tmp_path):
    own = tmp_path / 'src'
    own.mkdir()
    repository = str(course.repository())
    assert os.path.isfile(f'{repository}/run')
    environment = {grading.SOURCED: f'{own}:/usr/share',
                   'ROS_PACKAGE_PATH': f'{own}:{tmp_path}/gone:{repository}:/opt/ros/x'}
    assert grading.folders(str(tmp_path), environment) == [tmp_path, own]
    assert grading.folders(repository, {}) == []
    assert grading.SOURCED == sourced.PACKAGE_PATH
