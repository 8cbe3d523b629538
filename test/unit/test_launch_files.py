"""Every launch file of the repository passes roslaunch's own check, as the program roslaunch-check makes it.

A file may say that it cannot be checked, and why: ``<!-- no roslaunch-check: ... -->``.
"""
from pathlib import Path

import pytest
from roslaunch.rlutil import check_roslaunch

REPOSITORY = Path(__file__).resolve().parents[2]
LAUNCH_FILES = sorted(path.relative_to(REPOSITORY) for path in REPOSITORY.rglob('*.launch')
                      if not any(part.startswith('.') for part in path.relative_to(REPOSITORY).parts))


def test_launch_files_are_found():
    assert Path('launch/turtlesim.launch') in LAUNCH_FILES


@pytest.mark.parametrize('path', [path for path in LAUNCH_FILES
                                  if '<!-- no roslaunch-check: ' not in (REPOSITORY / path).read_text()], ids=str)
def test_launch_file_passes_the_check_of_roslaunch(path):
    assert check_roslaunch(str(REPOSITORY / path)) is None
