"""integrations/: the scripts start the grader as each system needs it, whatever has been handed in."""
import json
import os
import pathlib
import subprocess
import sys

import pytest
import yaml

from unit_support import REPOSITORY

pytestmark = pytest.mark.slow
FOLDER = REPOSITORY / 'packages' / 'grading' / 'integrations'
GRADER = '''#!/bin/bash
python3 -c 'import json, sys; json.dump(sys.argv[1:], open(sys.argv[1], "w"))' "$STARTED" "$@"
exit 3
'''
START = {
    'classroom50': [sys.executable, str(FOLDER / 'classroom50' / 'autograder.py')],
    'gradescope': [str(FOLDER / 'gradescope' / 'run_autograder')],
    'vpl': ['bash', '-c', f'{FOLDER}/vpl/vpl_evaluate.sh && exec ./vpl_execution']}
each_system = pytest.mark.parametrize('system', START)


class System:
    """A folder as the system provides it, and a grader that notes its arguments."""

    def __init__(self, folder, name):
        self.name, self.folder = name, folder
        self.submission = folder / 'submission'  # of Gradescope; in the others the current folder
        self.teacher = {'classroom50': folder / 'bundle', 'gradescope': folder / 'source', 'vpl': self.submission}[name]
        for path in (self.submission, self.teacher, folder / 'ws'):
            path.mkdir(exist_ok=True)
        (folder / 'ws' / 'rosrun').write_text(GRADER)
        (folder / 'ws' / 'rosrun').chmod(0o755)
        (folder / 'ws' / 'env.bash').write_text('PATH=$TURTLE_ROBOTONT_WS:$PATH$NOT_SET\n')  # as ROS's own does
        (self.teacher / 'exercise.txt').write_text('stop_at_x\n')
        (self.submission / 'vpl_environment.sh').write_text('export VPL_GRADEMAX=10\n')

    def arguments(self):
        """Run the script; return the arguments of the grader."""
        place = {'ASSIGNMENT': 'stop-at-x', 'CLASSROOM50_BUNDLE_DIR': str(self.teacher), 'AUTOGRADER': str(self.folder),
                 'TURTLE_ROBOTONT_WS': str(self.folder / 'ws'), 'STARTED': str(self.folder / 'started')}
        done = subprocess.run(START[self.name], cwd=self.submission, env={**os.environ, **place}, check=False,
                              timeout=60)
        assert done.returncode == 3  # the grader's
        return json.loads((self.folder / 'started').read_text())[1:]


@each_system
@pytest.mark.parametrize('files, expected', [
    (['stop_at_x.py'], 'stop_at_x.py'),
    (['my demo/src/stop_at_x.py', 'other.py'], 'my demo/src/stop_at_x.py'),
    (['a/stop_at_x.py', 'z/stop_at_x.launch'], 'z/stop_at_x.launch'),
    (['other.py', '.git/stop_at_x.py'], None),
])
def test_the_handed_in_program_is_graded(tmp_path, system, files, expected):
    place = System(tmp_path, system)
    if system == 'vpl':
        files = [name for name in files if not name.startswith('.')]  # VPL keeps no such folders
    for name in files:
        (place.submission / name).parent.mkdir(parents=True, exist_ok=True)
        (place.submission / name).write_text('')
    package, script, exercise, form, output, dashes, program = place.arguments()
    assert (package, script, dashes) == ('turtle_robotont', 'grade.py', '--')
    assert (exercise, form) == ('stop_at_x', f'--format={system}') and output.startswith('--output=/')
    assert program == str(place.submission / expected) if expected else program.endswith('stop_at_x.py')
    assert pathlib.Path(program).exists() == bool(expected)


@each_system
def test_the_teachers_own_exercise_counts(tmp_path, system):
    place = System(tmp_path, system)
    (place.teacher / 'stop_at_x.yaml').write_text('')
    exercise, *_, program = place.arguments()[2:]
    assert exercise == str(place.teacher / 'stop_at_x.yaml') and program.endswith('stop_at_x.py')


@pytest.mark.parametrize('path, line', [
    ('github/grade.yml', 'path: submissions/${{ github.actor }}'),
    ('gitlab/.gitlab-ci.yml', 'cp -r "$CI_PROJECT_DIR" "/submissions/$GITLAB_USER_LOGIN"')])
def test_the_folder_of_a_push_has_the_name_of_the_student(path, line):
    """It was called me, so that all students were graded with the same values."""
    text = (FOLDER / path).read_text()
    assert line in text and 'submissions/me' not in text


@pytest.mark.parametrize('path', ['github/grade.yml', 'gitlab/.gitlab-ci.yml'])
def test_every_push_is_graded_as_a_class(path):
    text = (FOLDER / path).read_text()
    assert isinstance(yaml.safe_load(text), dict)
    assert '/opt/turtle_robotont/run grade --all' in text and '"$TURTLE_ROBOTONT" /opt/turtle_robotont' in text


@pytest.mark.parametrize('name', ['gradescope/setup.sh', 'gradescope/run_autograder', 'vpl/vpl_evaluate.sh'])
def test_scripts_can_be_started(name):
    assert os.access(FOLDER / name, os.X_OK)
    subprocess.run(['bash', '-n', str(FOLDER / name)], check=True)
