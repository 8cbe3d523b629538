"""course_grader.isolation.levels: the level of a machine, and the texts about it."""
import subprocess
import sys

import pytest

from course_grader.isolation import levels
from course_grader.isolation.levels import NAMESPACE, NONE, UID, Machine

ALL, ROOT, NOTHING = Machine(), Machine('EPERM', ''), Machine('EPERM', 'only root')


@pytest.mark.parametrize('machine, wanted, required, level', [
    (ALL, None, NONE, NAMESPACE), (ROOT, None, NONE, UID), (NOTHING, None, NONE, NONE),
    (ALL, UID, NONE, UID), (ALL, NONE, NONE, NONE), (ALL, None, NAMESPACE, NAMESPACE), (ROOT, None, UID, UID),
    (ALL, None, UID, NAMESPACE),
])
def test_the_strongest_level_is_taken_unless_another_one_is_wanted(machine, wanted, required, level):
    assert levels.decide(machine, wanted, required) == level


@pytest.mark.parametrize('machine, wanted, required, said', [
    (ROOT, NAMESPACE, NONE, '--isolation namespace is not possible here: EPERM'),
    (NOTHING, UID, NONE, '--isolation uid is not possible here: only root'),
    (ROOT, None, NAMESPACE, '--require-isolation namespace is not possible: programs would be graded at the level uid '
     '(namespace: EPERM)'),
    (NOTHING, None, UID, 'at the level none (namespace: EPERM; uid: only root)'),
    (ALL, NONE, UID, 'at the level none.'),
])
def test_less_than_asked_is_refused_with_the_reason(machine, wanted, required, said):
    with pytest.raises(levels.TooWeak) as error:
        levels.decide(machine, wanted, required)
    assert said in str(error.value)


def test_what_is_weaker_is_said_aloud():
    assert levels.warning(NAMESPACE, ALL) == ''
    assert levels.warning(UID, ROOT).startswith('ISOLATION uid (EPERM)')
    assert levels.warning(NONE, NOTHING).startswith('NO ISOLATION (EPERM)')


def test_root_of_a_container_that_has_no_other_user_cannot_give_one():
    """A program that should get one was not started, and that counted as its own failure."""
    apart = ['unshare', '--user', '--map-root-user']
    if subprocess.run([*apart, 'true'], stderr=subprocess.DEVNULL, check=False).returncode:
        pytest.skip('no user namespaces here')
    program = 'from course_grader.isolation import levels; print(levels.machine().uid)'
    said = subprocess.run([*apart, sys.executable, '-c', program], stdout=subprocess.PIPE, check=True).stdout.decode()
    assert said.startswith('root cannot become another user here: ')
