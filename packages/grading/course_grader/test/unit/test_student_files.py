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
        assert student_files.unusable_packages(str(tmp_path)) == f'{path}: {said}'


def test_packages_with_files_are_fine(tmp_path):
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'package.xml').write_text('<package/>')
    (tmp_path / 'b').symlink_to('a')
    assert student_files.unusable_packages(str(tmp_path)) is None


@pytest.mark.parametrize('text, said', [
    ('<package>\n<name>a</name>\n', 'not XML: no element found: line 3, column 0, so ROS does not find the package: '),
    ('<package>\n<author>A & B</author>\n</package>', 'not XML: not well-formed (invalid token): line 2, column 11, '),
    ('<package>\n<a>\n</package>', 'not XML: mismatched tag: line 3, column 2, so ROS does not find'),
    ('<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', 'line 1: it defines the entity b'),
])
def test_a_package_that_is_not_xml_is_named_with_the_line(tmp_path, text, said):
    (tmp_path / 'package.xml').write_text(text)
    assert student_files.unusable_packages(str(tmp_path)).startswith(f'{tmp_path}/package.xml: {said}')


def test_a_link_to_the_folder_of_somebody_else_is_named(tmp_path):
    (tmp_path / 'anna').mkdir()
    (tmp_path / 'anna' / 'up').symlink_to('..')
    assert 'anna/up is a link to a folder of somebody else' in student_files.unusable_packages(str(tmp_path / 'anna'))


def test_deep_folders_are_walked_to_a_limit(tmp_path):
    folder = tmp_path
    for _ in range(student_files.MAX_DEPTH + 2):
        folder = folder / 'd'
        folder.mkdir()
    deep = []
    assert len(list(student_files.walk(str(tmp_path), deep.append))) == student_files.MAX_DEPTH + 1
    assert len(deep) == 1
    assert 'is a folder in more than 50 others' in student_files.unusable_packages(str(tmp_path))
