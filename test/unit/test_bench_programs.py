"""The suite programs of ./run bench: list, checkouts, conditions; a program that needs no network runs to its end."""
import re
import subprocess
import types

import pytest

import suite_programs
from processes import BenchError, stop_all

pytestmark = pytest.mark.slow

CONDITIONS = [{'topic'}, {'topic', 'count'}, {'topic', 'contains'}, {'topic', 'moved'},
              {'topic', 'near', 'tolerance'}, {'transform'}, {'output'}]
FIELDS = {'about', 'of', 'run', 'end', 'within', 'environment'}
LIST = suite_programs.LIST
TALKER = '''#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import PoseStamped
rospy.init_node('public')
poses = rospy.Publisher('pose', PoseStamped, queue_size=1)
pose = PoseStamped()
while not rospy.is_shutdown():
    pose.pose.position.x += 0.1
    poses.publish(pose)
    print('at', pose.pose.position.x, flush=True)
    rospy.sleep(0.05)
'''


@pytest.mark.parametrize('name', LIST['programs'])
def test_each_program_says_what_is_run_and_what_ends_it(name):
    program = LIST['programs'][name]
    assert {'about', 'of', 'run', 'end'} <= set(program) <= FIELDS and program['of'] and program['end']
    assert set(program['of']) <= set(LIST['repositories'])
    assert all(set(condition) in CONDITIONS for condition in program['end'])
    assert all(re.compile(condition.get('output', '')) for condition in program['end'])
    for command in program['run']:
        text = command['run'] if isinstance(command, dict) else command
        assert text.format(**dict.fromkeys(program['of'], '/folder'))  # names only its own repositories
        assert isinstance(command, str) or set(command) == {'run', 'after'}


def test_each_repository_has_a_commit_and_is_used():
    assert {name for program in LIST['programs'].values() for name in program['of']} == set(LIST['repositories'])
    for repository in LIST['repositories'].values():
        assert re.fullmatch(r'[\w-]+/[\w.-]+ [0-9a-f]{40}', repository)


@pytest.fixture
def public(tmp_path, monkeypatch):
    """Return the folder of a git repository with a program; the list has only that."""
    source = tmp_path / 'source'
    (source / 'scripts').mkdir(parents=True)
    (source / 'package.xml').write_text('<package><name>public</name></package>')
    (source / 'scripts' / 'talk.py').write_text(TALKER)
    (source / 'scripts' / 'talk.py').chmod(0o755)
    for command in (['init', '--quiet'], ['add', '.'],
                    ['-c', 'user.name=a', '-c', 'user.email=a@example.org', 'commit', '--quiet', '-m', 'One']):
        subprocess.run(['git', '-C', str(source), *command], check=True)
    commit = subprocess.run(['git', '-C', str(source), 'rev-parse', 'HEAD'], check=True, text=True,
                            capture_output=True).stdout.strip()
    monkeypatch.setattr(suite_programs, 'LIST', {
        'repositories': {'mine': f'{source} {commit}'},
        'programs': {'talk': {'about': 'a talker', 'of': ['mine'], 'within': 60, 'run': ['rosrun public talk.py'],
                              'end': [{'topic': '/pose', 'moved': 0.5}, {'output': r'at 0\.5'}]}}})
    monkeypatch.setattr(suite_programs, 'HOST', '')
    monkeypatch.setattr(suite_programs, '_folder', [tmp_path / 'checkouts'])
    return source


def test_missing_checkout_is_fetched_and_a_wrong_one_is_refused(public, tmp_path):
    path = suite_programs.checkout('mine', tmp_path / 'checkouts')
    assert (path / 'scripts' / 'talk.py').read_text() == TALKER
    assert suite_programs.checkout('mine', tmp_path / 'checkouts') == path
    suite_programs.LIST['repositories']['mine'] = f'{public} {40 * "0"}'
    with pytest.raises(BenchError, match=f'the list names 000000000000. Type: git -C {path} checkout 0000'):
        suite_programs.checkout('mine', tmp_path / 'checkouts')
    suite_programs.LIST['repositories']['other'] = f'{tmp_path}/nowhere {40 * "0"}'
    with pytest.raises(BenchError, match=r'other cannot be fetched from .*nowhere.*\./run bench programs FOLDER'):
        suite_programs.checkout('other', tmp_path / 'checkouts')
    assert not (tmp_path / 'checkouts' / 'other').exists()


@pytest.mark.nightly
def test_a_program_runs_to_its_end(public):
    pytest.importorskip('rospy')
    try:
        seconds = suite_programs.run_program('talk')(types.SimpleNamespace(), None)['talk'][0]
    finally:
        stop_all()
    assert 0.0 <= seconds <= 60.0
