#!/usr/bin/env python3
"""Grades a submission to Classroom 50: the assignment has the name of the exercise, with - or _ between its words.

The runner starts this script in the student's repository. It exits with 0 if there is a score; otherwise the runner
reports an error.
"""
import os
import subprocess
import sys
from pathlib import Path

WORKSPACE = os.environ.get('TURTLE_ROBOTONT_WS', '/opt/turtle_robotont_ws')
GRADE = '. "$0"/env.bash && exec rosrun turtle_robotont grade.py "$@"'
KINDS = '.launch', '.py', '.bash'  # of programs; the first that exists counts


def main():
    """Return the exit code of the grader."""
    exercise = os.environ['ASSIGNMENT'].replace('-', '_')
    own = Path(os.environ.get('CLASSROOM50_BUNDLE_DIR', '.'), f'{exercise}.yaml')
    found = [path for kind in KINDS for path in sorted(Path().rglob(exercise + kind))
             if not any(part.startswith('.') for part in path.parts)]
    program = str((found or [Path(f'{exercise}.py')])[0].absolute())
    arguments = [str(own.absolute()) if own.is_file() else exercise, '--format=classroom50', '--output=/tmp/grades',
                 '--', program]
    return subprocess.run(['bash', '-c', GRADE, WORKSPACE, *arguments], check=False).returncode


if __name__ == '__main__':
    sys.exit(main())
