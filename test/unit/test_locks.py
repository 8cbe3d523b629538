"""The .lock files, which ./run installs: all required packages, with hashes, for every Python."""
import re

import pytest
from packaging.requirements import Requirement

from unit_support import REPOSITORY

FILES = sorted({*REPOSITORY.glob('*requirements.txt'), *REPOSITORY.glob('[a-z]*/**/*requirements.txt')})
PYTHONS = '3.8', '3.10', '3.11', '3.12', '3.13', '3.14'  # of Ubuntu 20.04 to Debian testing
HASH = re.compile(r'--hash=sha256:[0-9a-f]{64}')


def locked(path):
    """Return the requirements of a lock file; each must have a hash."""
    found = []
    for entry in re.split(r'\n(?=\S)', re.sub(r'^#.*\n', '', path.read_text(), flags=re.MULTILINE)):
        if entry.strip():
            assert HASH.search(entry), entry
            found.append(Requirement(entry.partition('\\\n')[0]))
    return found


def here(requirements, python):
    """Return those requirements that hold for a version of Python on Linux."""
    return [each for each in requirements if each.marker is None or each.marker.evaluate(
        {'python_version': python, 'python_full_version': f'{python}.0', 'sys_platform': 'linux',
         'implementation_name': 'cpython', 'platform_python_implementation': 'CPython'})]


def test_each_file_has_a_lock_file():
    locks = {*REPOSITORY.glob('*.lock'), *REPOSITORY.glob('[a-z]*/**/*.lock')} - {REPOSITORY / 'tools' / 'pip.lock'}
    assert len(FILES) >= 4 and locks == {path.with_suffix('.lock') for path in FILES}, 'type: tools/lock.bash'


@pytest.mark.parametrize('python', PYTHONS)
@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_lock_file_has_what_the_requirements_ask_for(path, python):
    pinned = here(locked(path.with_suffix('.lock')), python)
    versions = {each.name: re.fullmatch('==(.*)', str(each.specifier)).group(1) for each in pinned}
    assert len(versions) == len(pinned), 'one version for each Python'
    wanted = [Requirement(line) for line in path.read_text().splitlines() if line and not line.startswith('#')]
    assert [str(each) for each in here(wanted, python) if not each.specifier.contains(versions.get(
        each.name.replace('_', '-'), '0'))] == [], 'type: tools/lock.bash'
