"""Every launch file of the repository passes roslaunch's own check, as the program roslaunch-check makes it.

Those that test data and the demo's output hold are programs of students, in packages of their own. A file may say that
it cannot be checked, and why: ``<!-- no roslaunch-check: ... -->``.
"""
import re
from pathlib import Path

import pytest
from roslaunch.rlutil import check_roslaunch

REPOSITORY = Path(__file__).resolve().parents[2]
LEFT_OUT = re.compile(r'test/data/|output/|(.*/)?\.')
LAUNCH_FILES = sorted(path for path in (found.relative_to(REPOSITORY) for found in REPOSITORY.rglob('*.launch'))
                      if not LEFT_OUT.match(str(path)))


def test_launch_files_are_found():
    assert Path('launch/turtlesim.launch') in LAUNCH_FILES


@pytest.mark.parametrize('path', [path for path in LAUNCH_FILES
                                  if '<!-- no roslaunch-check: ' not in (REPOSITORY / path).read_text()], ids=str)
def test_launch_file_passes_the_check_of_roslaunch(path):
    assert check_roslaunch(str(REPOSITORY / path)) is None
