"""Grade the sample submissions of an exercise; check verdicts, reasons, and that nothing is left behind.

usage: check_grading.py SAMPLES FOLDER     such as course/03_stop_at_x/samples/stop_at_x
       check_grading.py some_exercises FOLDER
       check_grading.py course_nodes FOLDER
       check_grading.py same_ten_times FOLDER
       check_grading.py hints FOLDER
       check_grading.py red_team_LEVEL FOLDER        the quick ones of check_red_team.py, fewer for a change

some_exercises grades, as one class, one sample of each exercise in SOME, which a change could break in different ways.

A sample `right_*` has to pass, and so has the answer that the page of the course prints. The first two lines of another
one say what has to come out: `# expected: failed: TEXT`, where TEXT is a part of the reasons, or `# expected: passed`.
They are graded as a class. course_nodes grades the nodes of this course and of the tutorials, which an isolated program
does not see, by the commands in test/data/course_nodes. same_ten_times grades one submission ten times, four at once,
and wants ten equal verdicts. hints grades the wrong programs of test/data/mistakes.yaml: each must get its hint, and
what is told as certain must be that. FOLDER takes all files. Exit code 0 when all is as it should be, else a text says
what is not.
"""
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import uuid
from pathlib import Path

import psutil

import check_red_team
from collection.rostests import CHANGE
from course_grader.classes import submissions
from course_grader.rules import exercise as exercises
from plain_support import course, processes
from unit_support import REPOSITORY, course_files

DATA = REPOSITORY / 'test' / 'data'
EXERCISES = course.exercises(REPOSITORY / 'course')
SOME = {  # exercise: its sample; no two are graded by the same means, or handed in the same way
    'ar_maze': 'right',  # markers and walls of a robot's world
    'command_server': 'right',  # calls of services
    'fibonacci_server': 'wrong',  # goals of an action
    'follow_turtle': 'right',  # a second turtle, and tf
    'hand_in_map': 'wrong',  # a file instead of a program
    'launch_two_turtles': 'wrong',  # a launch file
    'log_levels': 'right',  # log messages
    'own_messages': 'wrong',  # a package with messages, built first
    'print_poses': 'wrong',  # printed lines
    'robot_forward': 'wrong',  # odometry
    'set_pose': 'right',  # the nodes of navigation
    'tf_broadcaster': 'wrong',  # transforms of a program
    'two_robots': 'right'}
GRADER = [sys.executable, str(REPOSITORY / 'packages' / 'grading' / 'course_grader' / 'scripts' / 'grade')]
MARK = 'TURTLE_ROBOTONT_CHECK'
SEED = 7  # a failure can be repeated: ./run grade EXERCISE --seed 7 -- SUBMISSION
TIMEOUT, TIMEOUT_OF_HINTS = 500, 850  # [s]; the grader's own limits are shorter
GRADED = {'result.json', 'junit.xml', 'output.txt'}
OF_A_CLASS = {'submission.json'}
OF_A_SESSION = {'grader.txt', 'master.txt', 'simulator.txt', 'record.csv',
                'path.png', 'path.svg',  # without a path there is no picture
                *(f'{name}.txt' for name in exercises.BESIDE)}
JOBS = 2
REPEATED, TIMES, AT_ONCE = 'stop_at_x/right_borderline.py', 10, 4  # barely passes with the SEED
RED_TEAM = 'red_team_'
EXIT_CODES = {'passed': 0, 'failed': 1}


def expectation(path):
    """Return (outcome, part of the reasons) that the name or the head of a sample announces."""
    if not path.name.startswith('wrong_'):
        return 'passed', ''
    head = path.read_text(encoding='utf-8').split('\n')[:2]
    found = re.search(r'expected: (passed|failed: (\S.*?))(?: -->)?$', '\n'.join(head), re.MULTILINE)
    assert found, f'{path} says nothing of what is expected in its first two lines'
    return found.group(1).partition(':')[0], found.group(2) or ''


def run(arguments, folder, timeout=TIMEOUT):
    """Run the grader with places of its own; return (exit code, output, leftovers as texts)."""
    shutil.rmtree(folder, ignore_errors=True)
    places = {name: folder / name.lower() for name in ('HOME', 'TMPDIR', 'WORK')}
    for place in places.values():
        place.mkdir(parents=True)
    mark = uuid.uuid4().hex
    environment = {**os.environ, MARK: mark, 'HOME': str(places['HOME']), 'TMPDIR': str(places['TMPDIR']),
                   'PYTHONDONTWRITEBYTECODE': '1'}
    environment.pop('ROS_LOG_DIR', None)
    environment.pop('ROS_HOME', None)
    processes.adopt_orphans()
    done = subprocess.run([*GRADER, *arguments], cwd=places['WORK'], env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, check=False)
    own, mark = psutil.Process(), f'{MARK}={mark}'
    left = [f'process {process.pid}' for process in processes.related(mark, own)]
    processes.end(lambda: processes.related(mark, own))
    left += [str(path) for place in places.values() for path in place.rglob('*')]
    return done.returncode, done.stdout.decode('utf-8', 'replace'), left


def samples_of(exercise):
    """Return the printed answer and the samples of an exercise."""
    return course.answers(EXERCISES[exercise])


def check_samples(path, folder):
    """Return the errors in the gradings of the samples of an exercise."""
    if (path / 'package.xml').exists():
        return check_packages(path, folder)
    asked, flat = exercises.load(EXERCISES[path.name]), folder.with_name(f'{folder.name}_flat')
    shutil.copytree(path, flat)
    if course.printed_answer(EXERCISES[path.name]):
        shutil.copy(course.printed_answer(EXERCISES[path.name]), flat)
    _, found, _ = submissions.find_flat(str(flat), path.name, lambda _: asked.of_map)
    expected = {(sample.student, path.name): expectation(Path(sample.program)) for sample in found}
    return check_class([str(flat), '--exercise', path.name], expected, folder)


def check_packages(path, folder):
    """Return the errors in the gradings of launch files, and of programs beside them, in a package for each student."""
    students, expected = folder.with_name(f'{folder.name}_students'), {}
    for sample in samples_of(path.name):
        expected.update(hand_in(path.name, sample, students / sample.stem))
    return check_class([str(students)], expected, folder)


def hand_in(exercise, sample, student):
    """Copy a sample, and what lies beside samples that are no programs, for a student; return the expected result."""
    student.mkdir(parents=True, exist_ok=True)
    package = EXERCISES[exercise].parent / 'samples' / exercise
    if sample.suffix != '.py':
        shutil.copytree(package, student, ignore=shutil.ignore_patterns('right_*', 'wrong_*'), dirs_exist_ok=True)
    shutil.copy(sample, student / f'{exercise}{sample.suffix}')
    for image in package.glob('*.pgm'):
        shutil.copy(image, student)
    return {(student.name, exercise): expectation(sample)}


def check_some_exercises(folder):
    """Return what is wrong with the gradings of the samples of SOME: of each, the first of its kind."""
    students, expected = folder.with_name(f'{folder.name}_students'), {}
    for exercise, kind in SOME.items():
        sample = next(path for path in samples_of(exercise) if path.name.startswith('wrong_') is (kind == 'wrong')
                      and path.suffix in ('.py', '.launch', '.yaml'))
        is_package = (EXERCISES[exercise].parent / 'samples' / exercise / 'package.xml').exists()
        expected.update(hand_in(exercise, sample, students / (f'{kind}_{exercise}' if is_package else kind)))
    return check_class([str(students)], expected, folder)


def check_course_nodes(path, folder):
    """Return the errors in the gradings of the commands in the folder of one student."""
    return check_class([str(path), '--isolation', 'none'],
                       {(file.parent.name, file.stem): ('passed', '') for file in path.glob('*/*')}, folder)


def check_class(arguments, expected, folder):
    """Grade a class; return the errors. ``expected``: {(student, exercise): (outcome, part of the reasons)}."""
    code, said, left = run(['--all', *arguments, '--seed', str(SEED), '--jobs', str(JOBS), '--output',
                            str(folder / 'class')], folder)
    print(said)
    wrong = [f'{name} was left behind' for name in left]
    wanted = max(EXIT_CODES[outcome] for outcome, _ in expected.values())
    if code != wanted:
        wrong.append(f'the exit code of the class is {code}, expected is {wanted}')
    for (student, exercise), (outcome, text) in expected.items():
        wrong += [f'{student} {exercise}: {line}'
                  for line in check_result(folder / 'class' / student / exercise, outcome, text)]
    return wrong


def check_result(folder, outcome, text):
    """Return the errors in the files of a grading."""
    if not (folder / 'result.json').is_file():
        return ['there is no result.json']
    result = json.loads((folder / 'result.json').read_text(encoding='utf-8'))
    reasons = ' '.join([*result['objections'],
                        *(f'{reason["asked"]}; {reason["seen"]}' for reason in result['reasons'])])
    files = set(os.listdir(folder))
    wrong = [f'{name} is in the output folder' for name in files - GRADED - OF_A_SESSION - OF_A_CLASS]
    wrong += [f'{name} is missing' for name in GRADED - files]
    if result['outcome'] != outcome:
        wrong.append(f'it is {result["outcome"]}, expected is {outcome}')
    if outcome == 'passed' and result['score'] != 100.0:
        wrong.append(f'the score is {result["score"]}, expected is 100')
    if text not in reasons:
        wrong.append(f'the reasons do not hold {text!r}: {reasons}')
    if wrong:
        wrong.append(json.dumps(result, indent=1))
    return wrong


def check_repeats(path, folder):
    """Return what differs when a class of equal submissions is graded at once."""
    group = folder.parent / f'{folder.name}_class'
    shutil.rmtree(group, ignore_errors=True)
    for number in range(TIMES):
        student = group / f'student{number}'
        student.mkdir(parents=True)
        shutil.copy(path, student / f'{path.parent.name}.py')
    code, said, left = run(['--all', str(group), '--seed', str(SEED), '--jobs', str(AT_ONCE),
                            '--output', str(folder / 'out')], folder)
    print(said)
    wrong = [f'{name} was left behind' for name in left] + ([f'the exit code is {code}'] if code else [])
    results = [json.loads(file.read_text(encoding='utf-8')) for file in sorted(folder.glob('out/*/*/result.json'))]
    verdicts = {json.dumps([result['outcome'], result['score'], result['objections'],
                            [reason['points'] for reason in result['reasons']]]) for result in results}
    if len(results) != TIMES or len(verdicts) != 1:
        wrong.append(f'{len(results)} results, {len(verdicts)} different verdicts:\n' + '\n'.join(verdicts))
    with open(folder / 'out' / 'scores.csv', encoding='utf-8', newline='') as file:
        rows = list(csv.reader(file))
    if [row[1] for row in rows[1:]] != ['100'] * TIMES:
        wrong.append(f'the table is {rows}')
    return wrong


def check_hints(folder):
    """Return which wrong programs did not get their hint, or got another one that is told as certain."""
    students, wrong = folder.with_name(f'{folder.name}_students'), []
    mistakes = course_files.mistakes()
    for number, (exercise, program, _) in enumerate(mistakes):
        student = students / f'{number:03}'
        student.mkdir(parents=True)
        (student / f'{exercise}.py').write_text(program, encoding='utf-8')
    _, said, _ = run(['--all', str(students), '--seed', str(SEED), '--jobs', str(JOBS), '--output',
                      str(folder / 'out')], folder, TIMEOUT_OF_HINTS)
    print(said)
    for number, (exercise, program, hint) in enumerate(mistakes):
        result = json.loads((folder / 'out' / f'{number:03}' / exercise / 'result.json').read_text(encoding='utf-8'))
        given = result['hints'][:1] if result['certain'] else result['hints']
        if not any(re.search(hint, text) for text in given):
            wrong.append(f'{exercise}: the hint {hint!r} is not in {result["hints"]}:\n{program}')
    return wrong


def main(arguments):
    """Check as the command line says; return the exit code."""
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    name, folder = arguments[0], Path(arguments[1]).absolute()
    if name.startswith(RED_TEAM):
        names = check_red_team.OF_A_CHANGE if CHANGE in os.environ else check_red_team.QUICK
        return check_red_team.main([name[len(RED_TEAM):], str(folder), *names])
    if name == 'same_ten_times':
        wrong = check_repeats(EXERCISES['stop_at_x'].parent / 'samples' / REPEATED, folder)
    elif name == 'some_exercises':
        wrong = check_some_exercises(folder)
    elif name == 'hints':
        wrong = check_hints(folder)
    elif name == 'course_nodes':
        wrong = check_course_nodes(DATA / 'course_nodes', folder)
    else:
        wrong = check_samples(REPOSITORY / name, folder)
    for text in wrong:
        print(f'WRONG: {text}')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
