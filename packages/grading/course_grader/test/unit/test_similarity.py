"""Similar programs of a class: copies are told, whatever their names and comments are."""
import re

import pytest

from course_grader.classes import similarity
from course_grader.classes.submissions import Submission
from unit_support.course_files import sample

BY_POSES = sample('follow_turtle/right_by_poses.py').read_text()
BY_TF = sample('follow_turtle/right_by_tf2.py').read_text()
RENAMED = {'poses': 'positions', 'leader': 'first', 'follower': 'second', 'twist': 'cmd', 'angle': 'a',
           'publisher': 'p'}


def disguised(text):
    """Return a program with other names, comments, and blank lines."""
    for old, new in RENAMED.items():
        text = re.sub(rf'\b{old}\b', new, text)
    return '# all my own work\n\n' + text.replace('\n', '  # yes\n\n', 5)


def test_a_copy_with_other_names_and_comments_is_told():
    pair, = similarity.pairs('x', {'anna': BY_POSES, 'ben': disguised(BY_POSES), 'carl': BY_TF}, {})
    assert (pair.first, pair.second) == ('anna', 'ben') and pair.share > 0.95
    assert pair.text() == f'x: anna and ben have {pair.share:.0%} in common'


def test_a_solution_of_the_repository_is_told():
    pair, = similarity.pairs('x', {'anna': BY_POSES}, {'solution a.py': BY_POSES, 'solution b.py': BY_TF})
    assert (pair.first, pair.second, pair.share) == ('anna', 'solution a.py', 1.0)


def test_what_many_have_was_given_and_what_is_short_tells_nothing():
    assert similarity.pairs('x', {f'student{number}': BY_POSES for number in range(10)}, {}) == []
    short = 'import rospy\nrospy.spin()\n'
    assert similarity.pairs('x', {'anna': short, 'ben': short}, {}) == []


@pytest.mark.parametrize('text', ['print "python 2"\n"', '#!/bin/bash\nrostopic pub $x', 'x = (\n', '\0',
                                  '\u2028 \x1b[31m'])
def test_any_text_can_be_compared(text):
    assert similarity.pairs('x', {'anna': text * 30, 'ben': text * 30}, {}) is not None


def test_both_stand_beside_each_other_and_bring_no_markup():
    pair = similarity.Pair('x', '<b>anna', 'ben', 1.0, ('print("<script>")\n', 'print(2)\n'))
    page = similarity.side_by_side(pair)
    assert '<script' not in page and '<b>anna' not in page and '&lt;script' in page
    assert similarity.side_by_side(pair._replace(texts=('x' * 2000, ''))) is None
    assert similarity.side_by_side(pair._replace(texts=('x\n' * 2000, ''))) is None


def test_a_class_is_compared_exercise_by_exercise(tmp_path):
    found = []
    for student, text in (('anna', BY_POSES), ('ben', disguised(BY_POSES))):
        (tmp_path / f'{student}.py').write_text(text)
        found.append(Submission(student, 'follow_turtle', (), '', program=str(tmp_path / f'{student}.py')))
    names = {(pair.first, pair.second) for pair in similarity.of_class(found)}
    assert names == {('anna', 'ben'), ('anna', 'solution right_by_poses.py'), ('ben', 'solution right_by_poses.py')}
    assert similarity.of_class([found[0]._replace(exercise='x'), found[1]._replace(exercise='y')]) == []
