"""Every launch file of the repository passes roslaunch's own check, as the program roslaunch-check makes it.

Those of the course, of test data and of the demo's output are programs of students, in packages of their own. A file
may say that it cannot be checked, and why: ``<!-- no roslaunch-check: ... -->``.

The package.xml of the root leaves out packages of the rooms; a launch file of it that starts one names it in a comment.
"""
import re
from pathlib import Path

import pytest
from roslaunch.rlutil import check_roslaunch

from unit_support import REPOSITORY
from unit_support.cases import nightly

pytestmark = pytest.mark.slow
LEFT_OUT = re.compile(r'course/|test/data/|output/|(.*/)?\.')
LAUNCH_FILES = sorted(path for path in (found.relative_to(REPOSITORY) for found in REPOSITORY.rglob('*.launch'))
                      if not LEFT_OUT.match(str(path)))
OF_THE_ROOMS = {path.parent.name for path in REPOSITORY.glob('packages/**/package.xml')}


def test_launch_files_are_found():
    assert Path('launch/turtlesim.launch') in LAUNCH_FILES


CHECKED = [path for path in LAUNCH_FILES if '<!-- no roslaunch-check: ' not in (REPOSITORY / path).read_text()]


@pytest.mark.parametrize('path', [*CHECKED[::3], *nightly(*CHECKED[1::3], *CHECKED[2::3])], ids=str)
def test_launch_file_passes_the_check_of_roslaunch(path):
    complaint = check_roslaunch(str(REPOSITORY / path)) or ''
    lacking = re.fullmatch(r'Missing package dependencies: turtle_robotont/package\.xml: (.*)', complaint)
    if not lacking or path.parts[0] != 'launch':
        assert complaint == ''
        return
    named = ' '.join(re.findall(r'<!--.*?-->', (REPOSITORY / path).read_text(), re.DOTALL))
    packages = set(lacking.group(1).split(', '))
    assert packages <= set(re.findall(r'\w+', named)) and packages <= OF_THE_ROOMS
