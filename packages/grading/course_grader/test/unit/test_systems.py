"""course_grader.formats.systems: results for the systems of teachers, for any text of a student."""
import csv
import io
import json
import re
from xml.etree import ElementTree

import pytest

from course_grader.formats import systems
from course_grader.formats.systems import FORMATS, Runner
from unit_support.gradings import HOSTILE, VERDICTS, grading

RUNNER = {'CLASSROOM': 'ros', 'ASSIGNMENT': 'stop', 'SUBMISSION_TAG': 'submit/2026-11-22T10-00-00Z-abc1234',
          'COMMIT_URL': 'https://example.org/c', 'RELEASE_URL': 'https://example.org/r', 'USERNAME': 'anna'}
SCORED = [name for name in FORMATS if name not in ('text', 'junit', 'csv')]  # systems that read a score
PNG = b'\x89PNG of a path'
each_verdict = pytest.mark.parametrize('verdict', VERDICTS)


@pytest.fixture(name='runner')
def fixture_place(tmp_path):
    """A runner of every system: the folder of a repository, Gradescope's folders, the environment of both runners."""
    for name in ('submission', 'results'):
        (tmp_path / 'autograder' / name).mkdir(parents=True)
    (tmp_path / 'grades').mkdir()
    (tmp_path / 'grades' / 'path.png').write_bytes(PNG)
    environment = {**RUNNER, 'VPL_GRADEMIN': '0', 'VPL_GRADEMAX': '10'}
    return Runner(environment, str(tmp_path), str(tmp_path / 'autograder'))


def written(name, verdict, runner):
    """Write a format; return the Written."""
    result = systems.rendered(name, grading(verdict, f'{runner.folder}/grades'), runner)
    systems.write(result)
    return result


@pytest.mark.parametrize('environment, folders, expected', [
    ({}, (), 'text'), (RUNNER, (), 'classroom50'), ({'CLASSROOM': 'ros'}, (), 'text'),
    ({}, ('submission', 'results'), 'gradescope'), ({}, ('results',), 'text'),
    ({'VPL_GRADEMIN': '0', 'VPL_GRADEMAX': '10'}, (), 'vpl'), ({'GITHUB_ACTIONS': 'true', 'CI': 'true'}, (), 'text'),
])
def test_the_place_tells_the_format(tmp_path, environment, folders, expected):
    for name in folders:
        (tmp_path / name).mkdir()
    runner = Runner(environment, '.', str(tmp_path))
    assert systems.detect(runner) == expected
    systems.check(expected, runner)


def test_a_format_that_does_not_fit_the_place_is_refused(tmp_path):
    runner = Runner({'CLASSROOM': 'ros'}, '.', str(tmp_path / 'none'))
    with pytest.raises(systems.FormatError, match='needs ASSIGNMENT, SUBMISSION_TAG, COMMIT_URL, RELEASE_URL in the'):
        systems.check('classroom50', runner)
    with pytest.raises(systems.FormatError, match='there is no folder .*none; choose another format'):
        systems.check('gradescope', runner)


HIDDEN = {'after the deadline': 'after_due_date', 'never': 'hidden'}


@pytest.mark.parametrize('visible', HIDDEN)
@pytest.mark.parametrize('name', FORMATS)
def test_a_check_that_is_not_visible_is_in_no_format_but_gradescope(runner, name, visible):
    one = grading('failed', f'{runner.folder}/grades')
    moves, stops = one.decided.reasons
    decided = one.decided._replace(reasons=[moves, stops._replace(asked='a secret', visible=visible)], objections=[])
    result = systems.rendered(name, one._replace(decided=decided), runner)
    texts = [result.stdout, *(content for content in result.files.values() if isinstance(content, str))]
    assert ('a secret' in ''.join(texts)) == (name == 'gradescope')
    if name == 'gradescope':
        tests = json.loads(texts[1])['tests']
        assert [test['visibility'] for test in tests] == ['visible', HIDDEN[visible]]
        assert 'a secret' not in texts[0] + json.loads(texts[1])['output']
    if name not in ('junit', 'csv'):
        assert '80 points are for checks that are not shown yet' in ''.join(texts)


@each_verdict
@pytest.mark.parametrize('name', FORMATS)
def test_exit_codes(runner, name, verdict):
    outcome = VERDICTS[verdict].outcome
    graded = 0 if name in SCORED else 1
    assert written(name, verdict, runner).code == {'passed': 0, 'failed': graded, 'undecided': 3}[outcome]


@each_verdict
@pytest.mark.parametrize('name', [name for name in FORMATS if name not in ('csv', 'junit')])
def test_no_line_commands_a_log(runner, name, verdict):
    stdout = written(name, verdict, runner).stdout
    assert not re.search(r'^\s*::|##\w*\[|[\x00-\x08\x0b-\x1f\x7f-\x9f]', stdout, re.MULTILINE)
    grades = re.findall(r'^\s*(?:Grade|Comment) :=>>.*$', stdout, re.MULTILINE)
    assert len(grades) == (name == 'vpl' and VERDICTS[verdict].outcome != 'undecided')
    stdout.encode()


# Classroom 50

@each_verdict
def test_classroom50(runner, tmp_path, verdict):
    decided = VERDICTS[verdict]
    (tmp_path / 'result.json').write_text('{"score": 100}')  # of an earlier time, or the student's own
    (tmp_path / 'release-body.md').write_text('100')
    written('classroom50', verdict, runner)
    if decided.outcome == 'undecided':
        assert not (tmp_path / 'result.json').exists() and not (tmp_path / 'release-body.md').exists()
        return
    result = json.loads((tmp_path / 'result.json').read_text())
    assert result['schema'] == 'classroom50/result/v1'
    assert (result['classroom'], result['assignment'], result['owner']) == ('ros', 'stop', 'anna')
    assert (result['score'], result['max-score']) == (int(decided.score), 100)
    assert all(0 <= test['score'] <= test['max-score'] for test in result['tests']) and result['tests']
    assert all(test['passed'] for test in result['tests']) == (decided.outcome == 'passed')
    assert re.fullmatch(r'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ', result['datetime'])
    assert (tmp_path / 'path.png').read_bytes() == PNG
    body = (tmp_path / 'release-body.md').read_text()
    heading, _, fence, *_ = body.split('\n')
    assert heading == f'### Stop at x = 10: {decided.outcome}, {int(decided.score)} of 100'
    assert body.rstrip('\n').endswith(fence.replace('text', '')) and body.count(fence.replace('text', '')) == 2


def test_a_link_of_the_student_is_replaced_not_followed(runner, tmp_path):
    (tmp_path / 'victim').write_text('stays')
    (tmp_path / 'result.json').symlink_to(tmp_path / 'victim')
    written('classroom50', 'passed', runner)
    assert (tmp_path / 'victim').read_text() == 'stays'
    assert json.loads((tmp_path / 'result.json').read_text())['score'] == 100


# Gradescope

KEYS = {'score', 'execution_time', 'output', 'output_format', 'visibility', 'stdout_visibility', 'tests'}
TEST_KEYS = {'name', 'number', 'score', 'max_score', 'status', 'output', 'output_format', 'visibility'}


@each_verdict
def test_gradescope(runner, tmp_path, verdict):
    decided = VERDICTS[verdict]
    path = tmp_path / 'autograder' / 'results' / 'results.json'
    path.write_text('{"score": 100}')
    written('gradescope', verdict, runner)
    if decided.outcome == 'undecided':  # the first submission: Gradescope says that the autograder failed
        assert not path.exists()
        return
    result = json.loads(path.read_text())
    assert set(result) == KEYS and all(set(test) == TEST_KEYS for test in result['tests'])
    assert (result['score'], result['execution_time']) == (decided.score, 12)
    assert sum(test['score'] for test in result['tests']) == pytest.approx(decided.score)
    assert {test['status'] for test in result['tests']} <= {'passed', 'failed'}
    assert all(test['status'] == 'passed' for test in result['tests']) == (decided.outcome == 'passed')
    assert '<script' not in result['output'] and 'src="data:image/png;base64,' in result['output']


@pytest.mark.parametrize('metadata, expected', [
    ('{"previous_submissions": [{"score": 10.0}, {"score": 62.5}]}', 62.5),
    ('{"previous_submissions": []}', None), ('{"previous_submissions": [{"score": null}]}', None), ('[', None),
])
def test_an_undecided_grading_keeps_the_score_in_gradescope(runner, tmp_path, metadata, expected):
    (tmp_path / 'autograder' / 'submission_metadata.json').write_text(metadata)
    path = tmp_path / 'autograder' / 'results' / 'results.json'
    written('gradescope', 'hostile undecided', runner)
    assert path.exists() == (expected is not None)
    if path.exists():
        result = json.loads(path.read_text())
        assert result['score'] == expected and 'tests' not in result
        assert 'The score of your last submission stays' in result['output'] and '<script' not in result['output']


# VPL, by the rules with which Moodle reads it: the last grade, and all comments

def vpl_reads(stdout):
    """Return (grade or None, comments)."""
    grades = re.findall(r'^Grade :=>>(.*)$', stdout, re.MULTILINE)
    comments = re.findall(r'^[ \t]*<\|--[ \t]*\n(.*?)^[ \t]*--\|>[ \t]*$', stdout, re.MULTILINE | re.DOTALL)
    return (grades[-1].strip() if grades else None), comments


@each_verdict
def test_vpl(runner, verdict):
    decided = VERDICTS[verdict]
    grade, comments = vpl_reads(written('vpl', verdict, runner).stdout)
    assert grade == (None if decided.outcome == 'undecided' else f'{round(decided.score / 10, 2):g}')  # of 0 to 10
    assert len(comments) == 1
    first, *others = comments[0].rstrip('\n').split('\n')
    assert first == f'-Stop at x = 10: {decided.outcome.upper()}, {decided.score:g} of 100'
    assert all(line.startswith('>') for line in others)  # preformatted


@pytest.mark.parametrize('environment, expected', [
    ({'VPL_GRADEMIN': '1', 'VPL_GRADEMAX': '6'}, '5.38'), ({}, '87.5'),
    ({'VPL_GRADEMIN': '', 'VPL_GRADEMAX': ''}, '87.5'),
])
def test_vpl_grades_lie_between_the_limits_of_the_activity(environment, expected):  # 1 + 5 * 0.875 = 5.375
    stdout = systems.rendered('vpl', grading('passed with less'), Runner(environment)).stdout
    assert vpl_reads(stdout)[0] == expected


# Autolab, JUnit, CSV

@each_verdict
def test_autolab_reads_the_last_line(runner, verdict):
    decided = VERDICTS[verdict]
    last = written('autolab', verdict, runner).stdout.split('\n')[-1]
    if decided.outcome == 'undecided':
        assert last == 'No score: there is no verdict.'
    else:
        assert json.loads(last) == {'scores': {'stop_at_x': decided.score}}


CASES = {  # verdict: what its testcases hold: that of the verdict, then one for each check
    'passed': ['', '', ''], 'passed with less': ['', '', ''], 'failed': ['failure', '', 'failure'],
    'shortcut': ['failure', '', ''], 'not started': ['failure'], 'undecided': ['error', 'skipped', 'skipped'],
    'hostile': ['failure', '', 'failure'], 'hostile undecided': ['error', 'skipped']}


@each_verdict
def test_junit_has_a_testcase_for_each_check(runner, verdict):
    stdout = written('junit', verdict, runner).stdout
    suites = ElementTree.fromstring(stdout)
    suite, = suites
    cases = suite.findall('testcase')
    assert [(one.get('name'), one.get('value')) for one in suite[0]] == [('isolation', 'uid')]
    found = [[tag for tag in ('failure', 'error', 'skipped') if case.find(tag) is not None] for case in cases]
    assert [''.join(tags) for tags in found] == CASES[verdict]
    for tag, key in (('failure', 'failures'), ('error', 'errors'), ('skipped', 'skipped')):
        assert suite.get(key) == str(CASES[verdict].count(tag)) and suites.get(key) in (suite.get(key), None)
    assert suite.get('tests') == suites.get('tests') == str(len(cases))
    names = [case.get('name') for case in cases]
    assert names[0] == 'verdict' and len(set(names)) == len(names)
    assert not re.search('[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]', stdout)


@each_verdict
def test_csv_is_a_row_without_formulas(runner, verdict):
    row, = csv.DictReader(io.StringIO(written('csv', verdict, runner).stdout))
    decided = VERDICTS[verdict]
    undecided = decided.outcome == 'undecided'
    assert (row['exercise'], row['verdict']) == ('stop_at_x', decided.outcome)
    assert row['score'] == ('' if undecided else f'{decided.score:g}')
    assert row['isolation'] == 'uid'
    assert bool(row['reason']) == (decided.outcome != 'passed')
    assert not any(re.match(r'\s*[=+@-]', value) for value in row.values())


def test_the_reason_is_the_check_that_lost_most():
    decided = VERDICTS['failed']._replace(objections=[])
    assert decided.main_reason().startswith('24.5 of 80: asked: a stop at x = 10')
    assert VERDICTS['passed with less'].main_reason() == ''
    assert HOSTILE in VERDICTS['hostile'].main_reason()
