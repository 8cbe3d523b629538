"""course_grader.isolation.student_files: what a student hands in may be anything."""
import os

import pytest

from course_grader.isolation import student_files
from course_grader.isolation.student_files import MAX_SIZE, UnreadableFile


def test_a_file_is_read(tmp_path):
    (tmp_path / 'a').write_bytes(b'x' * MAX_SIZE)
    assert student_files.read(str(tmp_path / 'a')) == student_files.whole(str(tmp_path / 'a')) == b'x' * MAX_SIZE
    assert student_files.read(str(tmp_path / 'a'), 3) == b'xxx'


@pytest.mark.parametrize('make, said, begins', [
    (os.mkfifo, 'it is not a file', b''), (os.mkdir, 'it is not a file', b''),
    (lambda path: os.symlink('/dev/zero', path), 'it is not a file', b''),
    (lambda path: os.symlink('nowhere', path), 'it is not a file', b''),
    (lambda path: open(path, 'wb').write(b'x' * (MAX_SIZE + 1)), 'it has 1.0 MB; at most 1 MB are read', b'x'),
], ids=['pipe', 'folder', 'endless', 'nowhere', 'long'])
def test_what_cannot_be_read_whole_is_said(tmp_path, make, said, begins):
    make(tmp_path / 'package.xml')
    path = str(tmp_path / 'package.xml')
    assert student_files.read(path, 1) == begins
    with pytest.raises(UnreadableFile) as error:
        student_files.whole(path)
    assert str(error.value) == said
    if not os.path.isdir(path):
        with pytest.raises(UnreadableFile) as error:
            student_files.check_packages(str(tmp_path))
        assert str(error.value) == f'{path}: {said}'


def test_packages_with_files_are_fine(tmp_path):
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'package.xml').write_text('<package/>')
    student_files.check_packages(str(tmp_path))
