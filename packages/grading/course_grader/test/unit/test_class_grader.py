"""A class graded by stand-ins for the attempts, which crash, hang, hide children or find the disk full."""
import concurrent.futures
import csv
import os
import signal
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import pytest

from course_grader import cli
from course_grader.classes import class_grader, graded, submissions
from course_grader.isolation import levels
from rostest_support.waiting import until
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

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
    """Return a command that runs ./run grade --all in a process of its own, with one exercise."""
    (tmp_path / 'obedient_attempt.py').write_text(ATTEMPT)
    program = (f'import functools, sys; sys.path[:] = {[str(tmp_path), *sys.path]!r}\n'
               'from course_grader import cli\n'
               'from course_grader.classes import grade_all\n'
               f'cli.exercises = lambda: {{"x": {str(tmp_path / "x.yaml")!r}}}\n'
               'grade_all.Supervisor = functools.partial(grade_all.Supervisor, "obedient_attempt")\n'
               f'sys.exit(cli.main({["--all", *arguments]!r}))')
    return [sys.executable, '-c', program]


def grade(tmp_path, programs, *arguments):
    """Grade a class; return (exit code, printed text, the table as rows)."""
    done = run(tmp_path, str(a_class(tmp_path, programs)), '--output', 'out', *arguments)
    return done.returncode, done.stdout + done.stderr, scores(tmp_path / 'out')


def run(tmp_path, *arguments):
    """Run grade_all to its end."""
    return subprocess.run(command(tmp_path, *arguments), timeout=60, capture_output=True, text=True, check=False,
                          cwd=tmp_path)


def scores(output):
    """Return the rows of scores.csv without columns after the mean."""
    with open(output / 'scores.csv', encoding='utf-8', newline='') as file:
        rows = list(csv.reader(file))
    return [row[:rows[0].index('mean') + 1] for row in rows]


def ended(pid):
    try:
        with open(f'/proc/{pid}/stat', encoding='utf-8') as file:
            return file.read().rsplit(')', 1)[1].split()[0] == 'Z'
    except (FileNotFoundError, ProcessLookupError):
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
    level = levels.decide(levels.machine())
    assert grades == [['student', 'exercise', 'score', 'verdict', 'reason', 'isolation'],
                      ['anna', 'x', '100', 'passed', '', level],
                      ['ben', 'x', '12.5', 'failed', 'it did not move', level]]
    page = (tmp_path / 'out' / 'index.html').read_text()
    assert '<td>a &lt;square&gt;</td>' in page and '<td>it &amp; more, seed 5</td>' in page


@pytest.mark.parametrize('text', [
    'sys.exit(0)', *nightly('raise RuntimeError', 'os.kill(os.getpid(), signal.SIGKILL)')])
def test_an_attempt_that_crashes_leaves_it_undecided(tmp_path, text):
    code, printed, rows = grade(tmp_path, {'anna': text, 'ben': PASS})
    assert code == 3
    assert rows[1:] == [['anna', 'undecided', ''], ['ben', '100', '100.0']]
    assert 'the grader ended without a result; see grader.txt' in (tmp_path / 'out' / 'index.html').read_text()
    assert 'anna x: undecided' in printed


@pytest.mark.nightly
@pytest.mark.parametrize('text', [HANG, HANG.replace('time.sleep(1000)', 'os.kill(os.getpid(), signal.SIGSTOP)')])
def test_an_attempt_that_hangs_is_ended_with_all_it_started(tmp_path, text):
    code, _, rows = grade(tmp_path, {'anna': text, 'ben': PASS}, '--limit', '1.5')
    assert code == 3 and rows[1:] == [['anna', 'undecided', ''], ['ben', '100', '100.0']]
    assert 'was stopped' in (tmp_path / 'out' / 'index.html').read_text()
    assert ended(int((tmp_path / 'out' / 'anna' / 'x' / 'pid').read_text()))


@pytest.mark.parametrize('sign', [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_everything_and_keeps_what_is_graded(tmp_path, sign):
    folder, output = a_class(tmp_path, {'anna': PASS, 'ben': HANG, 'carl': HANG}), tmp_path / 'out'
    running = subprocess.Popen(command(tmp_path, str(folder), '--output', str(output), '--jobs', '2'),
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    pids = [output / student / 'x' / 'pid' for student in ('ben', 'carl')]
    until(lambda: all(path.is_file() and path.read_text() for path in pids))
    running.send_signal(sign)
    said = running.communicate(timeout=30.0)[0].decode()
    assert running.returncode == 130 and 'Interrupted' in said
    assert all(ended(int(path.read_text())) for path in pids)
    with open(output / 'scores.csv', encoding='utf-8', newline='') as file:
        assert [row[1] for row in csv.reader(file)] == ['x', '100', 'undecided', 'undecided']


def test_what_was_graded_just_before_ctrl_c_counts(monkeypatch):
    def submit(work, *_):
        future = concurrent.futures.Future()
        if work != 'runs':
            future.set_result(work)
        return future

    def done(graded):
        told.append(graded)
        if len(told) == 1:
            raise KeyboardInterrupt
    told = []
    monkeypatch.setattr(class_grader, '_submit', submit)
    monkeypatch.setattr(class_grader, '_finished', lambda work, answer: answer())
    with pytest.raises(KeyboardInterrupt):
        class_grader.grade(['anna', 'ben', 'runs', 'carl'], concurrent.futures.ThreadPoolExecutor(1), None, done)
    assert sorted(told) == ['anna', 'ben', 'carl']


ODD = 'index.html', 'pages', 'esc\x1b[2J', 'x' * 255, '=1+1'  # names of students


def test_everything_that_was_handed_in_is_in_every_report(tmp_path, capsys):
    folder = a_class(tmp_path, {**dict.fromkeys(ODD, PASS), 'anna': f'{PASS}._replace(remarks=("a note",))'})
    (folder / 'anna' / 'old.zip').write_text('PK')
    (folder / 'loose.py').write_text('')
    (folder / 'empty').mkdir()
    code, said, rows = grade(tmp_path, {}, '--student-pages')
    assert code == 0
    assert {row[0]: row[1] for row in rows[1:]} == {
        **dict.fromkeys(['index.html', 'pages', 'esc?[2J', 'x' * 255, "'=1+1", 'anna'], '100'), 'empty': ''}
    left_out = ['loose.py: it lies in the folder of no student', 'anna/old.zip: it is an archive: unpack it',
                'empty: the folder is empty']
    assert 'Not graded:\n' + ''.join(f'  {text}\n' for text in left_out) in said
    out = tmp_path / 'out'
    grades = csv.reader((out / 'grades.csv').read_text().splitlines())
    assert [row[4] for row in grades if row[3] == 'not graded'] == left_out
    suite = ElementTree.parse(out / 'junit.xml').getroot()[-1]
    assert [case.get('name') for case in suite] == left_out and suite.get('skipped') == '3'
    assert all(f'<li>{text}</li>' in (out / 'index.html').read_text() for text in left_out)
    assert '<li>old.zip: it is an archive: unpack it</li>' in (out / 'pages' / 'anna.html').read_text()
    assert 'Note: a note' in (out / 'pages' / 'anna.html').read_text() and len(list((out / 'pages').iterdir())) == 7
    assert cli.main(['--merge', str(out), '--output', str(tmp_path / 'all')]) == 0
    assert 'anna/old.zip: it is an archive' in capsys.readouterr().out


def test_a_zip_of_a_platform_is_graded_as_it_comes(tmp_path):
    a_class(tmp_path, {})
    with zipfile.ZipFile(tmp_path / 'class.zip', 'w') as archive:
        archive.writestr('Anna Berg_12_assignsubmission_file_/mine.py', PASS)
        archive.writestr('Ben_13_assignsubmission_file_/notes.txt', 'x')
    done = run(tmp_path, 'class.zip', '--exercise', 'x', '--output', 'out')
    assert done.returncode == 0 and 'Ben/notes.txt: it is not a program' in done.stdout + done.stderr
    assert scores(tmp_path / 'out') == [['student', 'x', 'mean'], ['Anna Berg', '100', '100.0'], ['Ben', '', '0.0']]


@pytest.mark.nightly
def test_results_of_an_earlier_time_do_not_remain(tmp_path):
    old = tmp_path / 'out' / 'anna' / 'x'
    old.mkdir(parents=True)
    (old / 'result.json').write_text('old')
    (old / 'junit.xml').write_text('old')
    _, _, rows = grade(tmp_path, {'anna': 'sys.exit(0)'})
    assert rows[1] == ['anna', 'undecided', '']
    assert '"undecided"' in (old / 'result.json').read_text() and '<error' in (old / 'junit.xml').read_text()


WRONG_USAGE = [  # arguments, words of the error
    (['no_such_folder'], 'there is no folder no_such_folder (current folder: '),
    (['x.yaml'], 'x.yaml is neither a folder nor a ZIP; to grade one program, type: ./run grade EXERCISE -- x.yaml'),
    (['class', '--exercise', 'y'], 'y: there is no such exercise; give the path of an exercise file, or one of x'),
    (['broken.zip'], 'broken.zip cannot be read as a ZIP: File is not a zip file; download it again, or name the'),
    (['class', '--jobs', '0'], '--jobs: it is 0; it must be a whole number from 1 to'),
    (['class', '--shard', '3/2'], "'3/2' is not a part; write I/N, from 1/N to N/N, such as 1/4"),
    (['class', '--only', 'bob'], '--only bob: there is no such submission. Write STUDENT or STUDENT/EXERCISE, such as '
     'anna or anna/x'),
    (['class', '--weights', 'x=-1'], "'x=-1' is not a weight; write NAME=N, such as stop_at_x=2,black_path=0.5"),
    (['class', '--weights', 'y=1'], '--weights names y, but the exercises are x'),
    (['class', '--weights', 'x=0'], 'all exercises have the weight 0'),
    (['class', '--dask', 'tcp://10.0.0.5:8786'], 'is another machine, and whoever reaches a scheduler without TLS can'),
    (['class', '--dask', 'localhost'], "'localhost' is not the address of a scheduler; write tcp://127.0.0.1:8786"),
    (['class', '--output', 'x.yaml/out'], 'x.yaml/out: Not a directory. Choose another folder with --output DIR'),
    (['class', '--output', '/proc/nowhere'], '/proc/nowhere: No such file or directory. Choose another folder with'),
]


@pytest.mark.parametrize('arguments, said', [WRONG_USAGE[0], *nightly(*WRONG_USAGE[1:])])
def test_wrong_usage_is_explained(tmp_path, arguments, said):
    a_class(tmp_path, {'anna': PASS})
    (tmp_path / 'broken.zip').write_text('')
    done = run(tmp_path, *arguments)
    assert done.returncode == 2
    assert said in done.stdout + done.stderr and 'Traceback' not in done.stdout + done.stderr


@pytest.mark.nightly
def test_a_full_disk_is_named_and_the_table_printed(tmp_path):
    """/dev/full refuses every byte; the results go to it through a link."""
    folder, output = a_class(tmp_path, {'anna': PASS}), tmp_path / 'out'
    output.mkdir()
    (output / 'class.json').write_text('{}')  # of an earlier grading, whose results may be replaced
    (output / 'scores.csv').symlink_to('/dev/full')
    done = run(tmp_path, str(folder), '--output', str(output))
    assert done.returncode == 2 and '100  100.0' in done.stdout
    assert 'No space left on device. The disk is full: make room, or choose another folder' in done.stderr
    assert sorted(os.listdir(output)) == ['anna', 'class.json', 'scores.csv']


def test_a_change_of_the_mode_is_a_change(tmp_path):
    program = a_class(tmp_path, {'anna': PASS}) / 'anna' / 'x.py'
    digests = []
    for mode in (0o644, 0o755, 0o600):
        program.chmod(mode)
        submission = submissions.find(str(program.parents[1]), ['x'])[1][0]
        digests.append(graded.fingerprint_of(submission, graded.files_of(submission, []), str(tmp_path / 'x.yaml')))
    assert digests[0] == digests[2] != digests[1]


def test_what_has_not_changed_is_not_graded_again(tmp_path):
    """Each program appends to its own list, so that a second grading would be seen."""
    counting = f"open({str(tmp_path)!r} + '/' + folder.split('/')[-2], 'a').write('x'); "
    texts = {'anna': PASS, 'ben': FAIL, 'carl': PASS, 'dora': 'sys.exit()'}
    programs = {student: counting + text for student, text in texts.items()}
    grade(tmp_path, programs)
    folder = tmp_path / 'class'
    with open(folder / 'carl' / 'x.py', 'a', encoding='utf-8') as file:
        file.write(' # changed')
    (folder / 'ben' / 'helper.txt').write_text('new')
    assert '1 of 4 submissions have not changed' in run(tmp_path, str(folder), '--output', 'out').stdout
    counts = {student: len((tmp_path / student).read_text()) for student in programs}
    assert counts == {'anna': 1, 'ben': 2, 'carl': 2, 'dora': 2}  # dora is undecided: there is no verdict to keep
    (tmp_path / 'x.yaml').write_text('{title: Y, time: 5 s, checks: [{check: moves, length: 1 m, points: 100}]}')
    run(tmp_path, str(folder), '--output', 'out', '--only', 'anna')
    assert [len((tmp_path / student).read_text()) for student in programs] == [2, 2, 2, 2]
    rows = list(csv.reader((tmp_path / 'out' / 'scores.csv').read_text().splitlines()))
    assert [row[1] for row in rows] == ['x', '100', 'undecided', 'undecided', 'undecided']  # the others are out of date
    run(tmp_path, str(folder), '--output', 'out', '--only', 'anna/x', '--again')
    assert len((tmp_path / 'anna').read_text()) == 3


@pytest.mark.nightly
def test_parts_of_a_class_are_merged(tmp_path):
    folder = a_class(tmp_path, {name: PASS if name < 'c' else FAIL for name in ('anna', 'ben', 'carl', 'dora')})
    for part, code in (('1/3', 1), ('2/3', 0)):
        done = run(tmp_path, str(folder), '--output', part[0], '--shard', part)
        assert done.returncode == code, done.stderr  # of the part alone: 1/3 has anna and dora
    merge = [sys.executable, '-c', 'import sys; from course_grader.cli import main; sys.exit(main())', '--merge',
             str(tmp_path / '1'), str(tmp_path / '2'), '--output', str(tmp_path / 'all'), '--weights', 'x=3']
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    merged = subprocess.run(merge, timeout=60, capture_output=True, check=False, env=environment)
    assert merged.returncode == 1 and b'Not graded in any part: carl/x' in merged.stdout, merged.stderr
    assert scores(tmp_path / 'all') == [['student', 'x', 'mean'], ['anna', '100', '100.0'], ['ben', '100', '100.0'],
                                        ['carl', 'undecided', ''], ['dora', '12.5', '12.5']]
    assert (tmp_path / 'all' / 'ben' / 'x' / 'result.json').is_file()
    for content in ('{}', '{"title": "", "students": [], "exercises": [], "submissions": [["..", "x", "", ""]]}'):
        (tmp_path / '1' / 'class.json').write_text(content)
        merged = subprocess.run(merge, timeout=60, capture_output=True, check=False, env=environment)
        assert merged.returncode == 2 and b'cannot be read' in merged.stderr and b'Traceback' not in merged.stderr


@pytest.mark.nightly
def test_a_format_is_printed_alone(tmp_path):
    folder = a_class(tmp_path, {'anna': PASS, 'ben': FAIL})
    done = run(tmp_path, str(folder), '--output', 'out', '--format', 'csv')
    assert done.stdout == (tmp_path / 'out' / 'grades.csv').read_text() and 'ben x: failed' in done.stderr


@pytest.mark.parametrize('make', [os.mkfifo, lambda path: os.symlink('/dev/zero', path)], ids=['pipe', 'endless'])
def test_no_file_of_a_student_holds_up_the_class(tmp_path, make):
    folder = a_class(tmp_path, {'anna': PASS, 'ben': PASS})
    (folder / 'cleo').mkdir()
    make(folder / 'cleo' / 'x.cmd')
    make(folder / 'ben' / 'picture.png')
    done = run(tmp_path, str(folder), '--output', 'out')
    assert (done.returncode, scores(tmp_path / 'out')[1:]) == (
        1, [['anna', '100', '100.0'], ['ben', '100', '100.0'], ['cleo', '0', '0.0']])
    assert 'x.cmd: it is not a file' in done.stdout + done.stderr
    make(folder / 'anna' / 'y.py')
    one = submissions.Submission('anna', 'y', (), str(folder / 'anna'), program=str(folder / 'anna' / 'y.py'))
    assert list(graded.files_of(one, ())) == ['x.py']


@pytest.mark.nightly
def test_a_reader_that_ends_early_changes_nothing(tmp_path):
    folder = a_class(tmp_path, {f'student{number:02}': PASS for number in range(6)})
    reading, writing = os.pipe()
    with subprocess.Popen(command(tmp_path, str(folder), '--output', str(tmp_path / 'out'), '--jobs', '1'),
                          stdout=writing, stderr=subprocess.PIPE) as running:
        os.close(writing)
        os.read(reading, 10)
        os.close(reading)
        said = [line for line in running.stderr.read().decode().splitlines() if 'ISOLATION' not in line]
    assert (running.returncode, said) == (0, [])
    assert (tmp_path / 'out' / 'scores.csv').read_text().count('100.0') == 6


def test_any_name_of_a_folder_works(tmp_path):
    names = ['\N{turtle} team', '=1+1', 'a&b <i>', "o'neil", 'raw\udcff', '-rf', 'class.json ']
    code, _, rows = grade(tmp_path, dict.fromkeys(names, PASS), '--student-pages', '--anonymous')
    assert code == 0
    assert {row[0] for row in rows[1:]} == {'\N{turtle} team', "'=1+1", 'a&b <i>', "o'neil", 'raw\\xff', "'-rf",
                                            'class.json '}
    codes = (tmp_path / 'out' / 'anonymous.csv').read_text()
    assert len(codes.splitlines()) == 8 and 'team' not in codes
    known = (tmp_path / 'out' / 'codes.csv').read_text()
    assert run(tmp_path, 'class', '--output', 'out', '--anonymous').returncode == 0
    assert (tmp_path / 'out' / 'codes.csv').read_text() == known
    assert (tmp_path / 'out' / 'anonymous.csv').read_text() == codes


@pytest.mark.nightly
def test_the_best_of_several_attempts_counts(tmp_path):
    folder = a_class(tmp_path, {'anna': FAIL})
    (folder / 'anna' / 'x (2).py').write_text(PASS)
    (folder / 'anna' / 'old').mkdir()
    (folder / 'anna' / 'old' / 'x.py').write_text("got = verdict('failed', 50.0, ['slow'])")
    run(tmp_path, str(folder), '--output', 'out')
    said = 'there are 2 programs for one exercise (old/x.py, x.py): keep one, or let the best one count with --best'
    assert said in (tmp_path / 'out' / 'grades.csv').read_text()
    run(tmp_path, str(folder), '--output', 'out', '--best')
    assert 'anna,100,100.0' in (tmp_path / 'out' / 'scores.csv').read_text()
    assert (tmp_path / 'out' / 'grades.csv').read_text().count('anna,x,') == 3
