"""A class graded by stand-ins for the attempts, which crash, hang, hide children or find the disk full."""
import csv
import os
import pathlib
import signal
import subprocess
import sys
import time
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from course_grader.classes import class_grader, grade_all, submissions
from course_grader.formats import class_report
from course_grader.rules import scoring

# An attempt that does what the file it is to grade says
ATTEMPT = r'''
import os, signal, subprocess, sys, time
from course_grader.supervision.job import Attempted
from course_grader.rules import scoring
from course_grader.rules.observation import Observed
def run(job):
    def verdict(outcome='passed', score=100.0, objections=()):
        reasons = [scoring.Reason('draws', 100.0, 100.0, 'a <square>', f'it & more, seed {job.seed}')]
        return Attempted(scoring.Verdict(outcome, score, reasons, list(objections)), Observed())
    names = {**globals(), 'verdict': verdict, 'folder': job.output}
    exec(open(job.command[0]).read(), names)
    return names['got']
'''
PASS = 'got = verdict()'
FAIL = "got = verdict('failed', 12.5, ['it did not move'])"
HANG = '''
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
child = subprocess.Popen(['sleep', '1000'], start_new_session=True, env={})
open(os.path.join(folder, 'pid'), 'w').write(str(child.pid))
time.sleep(1000)
'''


def a_class(tmp_path, programs):
    """Write {student: text} as programs for the exercise x; return the folder."""
    folder = tmp_path / 'class'
    for student, text in programs.items():
        (folder / student).mkdir(parents=True)
        (folder / student / 'x.py').write_text(text)
    (tmp_path / 'x.yaml').write_text('{title: X, time: 5 s, checks: [{check: moves, length: 1 m, points: 100}]}')
    return folder


def command(tmp_path, *arguments):
    """Return a command that runs grade_all in a process of its own, as ./run grade does."""
    (tmp_path / 'obedient_attempt.py').write_text(ATTEMPT)
    program = (f'import functools, sys; sys.path[:] = {[str(tmp_path), *sys.path]!r}\n'
               'from course_grader.classes import grade_all\n'
               'grade_all.Supervisor = functools.partial(grade_all.Supervisor, "obedient_attempt")\n'
               f'sys.exit(grade_all.main({list(arguments)!r}, {{"x": {str(tmp_path / "x.yaml")!r}}}))')
    return [sys.executable, '-c', program]


def grade(tmp_path, programs, *arguments):
    """Grade a class; return (exit code, printed text, the table as rows)."""
    folder, output = a_class(tmp_path, programs), tmp_path / 'out'
    done = subprocess.run(command(tmp_path, str(folder), '--output', str(output), *arguments), timeout=60,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, cwd=tmp_path)
    with open(output / 'scores.csv', encoding='utf-8', newline='') as file:
        return done.returncode, done.stdout.decode(), list(csv.reader(file))


def ended(pid):
    try:
        with open(f'/proc/{pid}/stat', encoding='utf-8') as file:
            return file.read().rsplit(')', 1)[1].split()[0] == 'Z'
    except FileNotFoundError:
        return True


def test_a_class_gets_its_table(tmp_path):
    code, said, rows = grade(tmp_path, {'anna': PASS, 'ben': FAIL}, '--seed', '5', '--jobs', '2')
    assert code == 1
    assert rows == [['student', 'x', 'mean'], ['anna', '100', '100.0'], ['ben', '12.5', '12.5']]
    assert 'ben x: failed, 12.5 of 100' in said and ': it did not move' in said
    anna, ben = ElementTree.parse(tmp_path / 'out' / 'junit.xml').getroot()
    assert (anna.get('name'), anna.get('failures'), ben.get('name'), ben.get('failures')) == (
        'anna: x', '0', 'ben: x', '1')  # the verdict; the check has all its points
    assert ben.find('testcase[@name="verdict"]/failure').get('message') == 'it did not move'
    grades = list(csv.reader((tmp_path / 'out' / 'grades.csv').read_text().splitlines()))
    assert grades == [['student', 'exercise', 'score', 'verdict', 'reason'], ['anna', 'x', '100', 'passed', ''],
                      ['ben', 'x', '12.5', 'failed', 'it did not move']]
    page = (tmp_path / 'out' / 'index.html').read_text()
    assert 'asked: a &lt;square&gt;; seen: it &amp; more, seed 5' in page


@pytest.mark.parametrize('text', ['sys.exit(0)', 'raise RuntimeError', 'os.kill(os.getpid(), signal.SIGKILL)'])
def test_an_attempt_that_crashes_leaves_it_undecided(tmp_path, text):
    code, printed, rows = grade(tmp_path, {'anna': text, 'ben': PASS})
    assert code == 3
    assert rows[1:] == [['anna', 'undecided', ''], ['ben', '100', '100.0']]
    assert 'the grader ended without a result; see grader.txt' in (tmp_path / 'out' / 'index.html').read_text()
    assert 'anna x: undecided' in printed


@pytest.mark.parametrize('text', [HANG, HANG.replace('time.sleep(1000)', 'os.kill(os.getpid(), signal.SIGSTOP)')])
def test_an_attempt_that_hangs_is_ended_with_all_it_started(tmp_path, text):
    code, _, rows = grade(tmp_path, {'anna': text, 'ben': PASS}, '--limit', '1.5')
    assert code == 3 and rows[1:] == [['anna', 'undecided', ''], ['ben', '100', '100.0']]
    assert 'the grader needed more than 2 s and was stopped' in (tmp_path / 'out' / 'index.html').read_text()
    assert ended(int((tmp_path / 'out' / 'anna' / 'x' / 'pid').read_text()))


@pytest.mark.parametrize('sign', [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_everything_and_keeps_what_is_graded(tmp_path, sign):
    folder, output = a_class(tmp_path, {'anna': PASS, 'ben': HANG, 'carl': HANG}), tmp_path / 'out'
    running = subprocess.Popen(command(tmp_path, str(folder), '--output', str(output), '--jobs', '2'),
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    pids = [output / student / 'x' / 'pid' for student in ('ben', 'carl')]
    end = time.monotonic() + 30.0
    while not all(path.is_file() and path.read_text() for path in pids):
        assert time.monotonic() < end
        time.sleep(0.02)
    running.send_signal(sign)
    said = running.communicate(timeout=30.0)[0].decode()
    assert running.returncode == 130 and 'Interrupted' in said
    assert all(ended(int(path.read_text())) for path in pids)
    with open(output / 'scores.csv', encoding='utf-8', newline='') as file:
        assert [row[1] for row in csv.reader(file)] == ['x', '100', 'undecided', 'undecided']


def test_results_of_an_earlier_time_do_not_remain(tmp_path):
    old = tmp_path / 'out' / 'anna' / 'x'
    old.mkdir(parents=True)
    (old / 'result.json').write_text('old')
    (old / 'junit.xml').write_text('old')
    _, _, rows = grade(tmp_path, {'anna': 'sys.exit(0)'})
    assert rows[1] == ['anna', 'undecided', '']
    assert '"undecided"' in (old / 'result.json').read_text() and '<error' in (old / 'junit.xml').read_text()


@pytest.mark.parametrize('arguments, said', [
    (['no_such_folder'], 'there is no folder no_such_folder (current folder: '),
    (['x.yaml'], 'x.yaml is not a folder; to grade one program, type: ./run grade EXERCISE -- x.yaml'),
    (['class', '--exercise', 'y'], 'y: there is no such exercise; give the path of an exercise file, or one of x'),
    (['class', '--exercise', 'x'], 'class contains no program'),
    (['class', '--jobs', '0'], '--jobs is 0; it must be 1 or more'),
    (['class', '--output', 'x.yaml/out'], 'x.yaml/out: Not a directory. Choose another folder with --output DIR'),
    (['class', '--output', '/proc/nowhere'], '/proc/nowhere: No such file or directory. Choose another folder with'),
])
def test_wrong_usage_is_explained(tmp_path, arguments, said):
    a_class(tmp_path, {'anna': PASS})
    done = subprocess.run(command(tmp_path, *arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          timeout=60, cwd=tmp_path, check=False)
    assert done.returncode == 2
    assert said in done.stdout.decode() and 'Traceback' not in done.stdout.decode()


def test_a_full_disk_is_named_and_the_table_printed(tmp_path):
    """/dev/full refuses every byte; the results go to it through a link."""
    folder, output = a_class(tmp_path, {'anna': PASS}), tmp_path / 'out'
    output.mkdir()
    (output / 'scores.csv').symlink_to('/dev/full')
    done = subprocess.run(command(tmp_path, str(folder), '--output', str(output)), timeout=60,
                          capture_output=True, check=False)
    assert done.returncode == 2
    assert 'No space left on device. The disk is full: make room, or choose another folder' in done.stderr.decode()
    assert 'anna       100  100.0' in done.stdout.decode() or '100  100.0' in done.stdout.decode()
    assert sorted(os.listdir(output)) == ['anna', 'scores.csv']


def test_the_page_links_small_pictures_and_survives_any_text(tmp_path):
    folder = tmp_path / 'anna & co' / 'x'
    folder.mkdir(parents=True)
    cv2.imwrite(str(folder / 'path.png'), np.full((600, 600, 3), 200, np.uint8))
    who = submissions.Submission('anna & co', 'x', ('a.py', '<b>'), '/')
    graded = class_grader.Graded(who, 'failed', 40.0, ('seen: <script>\x00\x1b[31m', 'second'), 1.5, str(folder))
    page = class_report.as_html('A class', ['anna & co', 'ben'], ['x', 'y'], [graded], str(tmp_path))
    assert 'src="data:image/png;base64,' in page and 'href="anna%20%26%20co/x/path.png"' in page
    assert '<script>' not in page and '\x00' not in page and '\x1b' not in page
    assert class_report.cells(['anna & co', 'ben'], ['x', 'y'], [graded]) == [
        ['student', 'x', 'y', 'mean'], ['anna & co', '40', '', '20.0'], ['ben', '', '', '0.0']]


def test_the_line_of_a_grading_has_the_reason_that_cost_most():
    reasons = [scoring.Reason('moves', 20.0, 20.0, 'a path', '9 m'), scoring.Reason('stops', 8.0, 80.0, 'a stop', '11')]
    verdict = scoring.Verdict('failed', 28.0, reasons, [])
    graded = class_grader.Graded(submissions.Submission('anna', 'x', ('a.py',), '/'), 'failed', 28.0,
                                 ('20 of 20: asked: a path', '8 of 80: asked: a stop'), 1.5, '/', verdict)
    assert grade_all.progress(graded, 2, 9) == ('[2/9] anna x: failed, 28 of 100, 1.5 s: '
                                                '8 of 80: asked: a stop; seen: 11')


def test_help_is_that_of_the_command():
    assert '--exercise NAME' in grade_all.parser().format_help()
    assert str(pathlib.Path('output') / 'grades') in grade_all.parser().format_help()
