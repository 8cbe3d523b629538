"""course_grader.classes.downloads: what Moodle, Canvas and Gradescope give to download."""
import os
import stat
import time
import zipfile

import pytest

from course_grader.classes import downloads, submissions
from course_grader.formats.platforms import Origin

MOODLE = {'Anna Berg_1234_assignsubmission_file_/stop_at_x.py': 'anna',
          'Anna Berg_1234_assignsubmission_file_/src/helper.py': 'helper',
          'Ben Li_77_assignsubmission_file/black_path.py': 'ben',
          'Ben Li_78_assignsubmission_file_/stop_at_x.py': 'another Ben',
          'Ben Li_78_assignsubmission_onlinetext_/onlinetext.html': 'see my file'}
MOODLE_FLAT = {'Anna Berg_1234_assignsubmission_file_stop_at_x.py': 'anna'}
CANVAS = {'berganna_1234_5678_stop_at_x.py': 'anna', 'liben_LATE_77_5679_stop_at_x-1.py': 'ben',
          'liben_LATE_77_5680_black_path.py': 'ben'}
METADATA = ('submission_34:\n  :submitters:\n  - :name: Anna Berg\n    :sid: 1\n'
            '  :created_at: 2026-11-20 18:05:48.123456000 Z\n'
            'submission_35:\n  :submitters:\n  - :name: Ben Li\n  - :name: Carl\n')
GRADESCOPE = {'assignment_12_export/submission_metadata.yml': METADATA,
              'assignment_12_export/submission_34/stop_at_x.py': 'anna',
              'assignment_12_export/submission_35/src/stop_at_x.py': 'ben and carl',
              'assignment_12_export/submission_36/stop_at_x.py': 'nobody knows'}
PLAIN = {'class/anna/stop_at_x.py': 'anna', 'class/ben/stop_at_x.py': 'ben'}


def packed(path, files):
    with zipfile.ZipFile(path, 'w') as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return str(path)


def written(folder, files):
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return str(folder)


def content(folder):
    return {os.path.relpath(os.path.join(parent, name), folder): open(os.path.join(parent, name)).read()
            for parent, _, names in os.walk(folder) for name in names}


EXPECTED = [
    (MOODLE, {'Anna Berg/stop_at_x.py': 'anna', 'Anna Berg/src/helper.py': 'helper', 'Ben Li 77/black_path.py': 'ben',
              'Ben Li 78/stop_at_x.py': 'another Ben', 'Ben Li 78/onlinetext.html': 'see my file'}),
    (MOODLE_FLAT, {'Anna Berg/stop_at_x.py': 'anna'}),
    (CANVAS, {'berganna/stop_at_x.py': 'anna', 'liben/stop_at_x.py': 'ben', 'liben/black_path.py': 'ben'}),
    (GRADESCOPE, {'Anna Berg/stop_at_x.py': 'anna', 'Ben Li and Carl/src/stop_at_x.py': 'ben and carl',
                  'submission_36/stop_at_x.py': 'nobody knows'}),
    (PLAIN, {'anna/stop_at_x.py': 'anna', 'ben/stop_at_x.py': 'ben'})]


@pytest.mark.parametrize('files, expected', EXPECTED, ids=['moodle', 'flat', 'canvas', 'gradescope', 'plain'])
def test_a_zip_becomes_a_folder_for_each_student(tmp_path, files, expected):
    folder, left_out, _ = downloads.folder_of_class(packed(tmp_path / 'a.zip', files), str(tmp_path / 'out'))
    assert content(folder) == expected and left_out == []
    folder, _, _ = downloads.folder_of_class(packed(tmp_path / 'a.zip', files), str(tmp_path / 'out'))  # once more
    assert content(folder) == expected


@pytest.mark.parametrize('files, expected', EXPECTED[:4], ids=['moodle', 'flat', 'canvas', 'gradescope'])
def test_a_zip_may_be_unpacked(tmp_path, files, expected):
    folder, _, _ = downloads.folder_of_class(written(tmp_path / 'a', files), str(tmp_path / 'out'))
    assert content(folder) == expected


@pytest.mark.parametrize('files, origin', [
    (MOODLE, Origin('moodle', {'Anna Berg': '1234', 'Ben Li 77': '77', 'Ben Li 78': '78'})),
    (CANVAS, Origin('canvas', {'berganna': '1234', 'liben': '77'},
                    {'liben/stop_at_x.py': 'late', 'liben/black_path.py': 'late'})),
    (GRADESCOPE, Origin('gradescope', {'Anna Berg': '34', 'Ben Li and Carl': '35', 'submission_36': '36'},
                        {'Anna Berg/stop_at_x.py': '2026-11-20 20:05'})),
    (PLAIN, Origin())], ids=['moodle', 'canvas', 'gradescope', 'plain'])
def test_the_numbers_and_dates_of_the_platform_are_kept(tmp_path, files, origin, monkeypatch):
    monkeypatch.setenv('TZ', 'UTC-2')  # as in Tartu
    time.tzset()
    try:
        found = downloads.folder_of_class(packed(tmp_path / 'a.zip', files), str(tmp_path / 'out'))[2]
    finally:
        monkeypatch.undo()
        time.tzset()
    assert found == origin


def test_the_only_student_of_a_platform_may_hand_in_folders(tmp_path):
    files = {'Anna Berg_1234_assignsubmission_file_/src/topic_demo/stop_at_x.py': 'anna'}
    folder, _, _ = downloads.folder_of_class(packed(tmp_path / 'a.zip', files), str(tmp_path / 'out'))
    assert content(folder) == {'Anna Berg/src/topic_demo/stop_at_x.py': 'anna'}


def test_the_dates_of_the_files_are_kept(tmp_path):
    with zipfile.ZipFile(tmp_path / 'a.zip', 'w') as archive:
        for name, date in (('anna', (2026, 11, 20, 18, 5, 30)), ('ben', (1980, 0, 0, 0, 0, 0))):
            archive.writestr(zipfile.ZipInfo(f'{name}/stop_at_x.py', date), '')
    folder, _, _ = downloads.folder_of_class(str(tmp_path / 'a.zip'), str(tmp_path / 'out'))
    dates = [os.path.getmtime(os.path.join(folder, name, 'stop_at_x.py')) for name in ('anna', 'ben')]
    assert dates == [time.mktime((2026, 11, 20, 18, 5, 30, 0, 0, -1)), 0.0]  # a month 0 is no date


def test_any_other_folder_is_taken_as_it_is(tmp_path):
    folder = written(tmp_path / 'a', {'anna/stop_at_x.py': '', 'a_1_2_b.py': ''})
    assert downloads.folder_of_class(folder, str(tmp_path / 'out')) == (folder, [], Origin())
    assert not (tmp_path / 'out').exists()


def test_files_beside_those_of_the_students_are_listed(tmp_path):
    path = packed(tmp_path / 'a.zip', {**MOODLE, 'notes.txt': 'x'})
    assert [one.text() for one in downloads.folder_of_class(path, str(tmp_path / 'out'))[1]] == [
        f'notes.txt: {submissions.NOBODYS}']


def test_nothing_is_written_outside_and_the_rest_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(downloads, 'MAX_FILE', 1000)
    path = tmp_path / 'a.zip'
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
        for name in ('anna/stop_at_x.py', '../out.py', 'ben/../../out.py', '/out.py', 'ben//a.py', 'ben/' + 'x' * 300,
                     'ben/' + 'd/' * 60 + 'a', 'ben/twice', 'ben/twice'):
            archive.writestr(name, 'x')
        archive.writestr('ben/large', 'x' * 1001)
        link = zipfile.ZipInfo('ben/link')
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, '/etc/passwd')
        script = zipfile.ZipInfo('ben/script')
        script.external_attr = 0o100755 << 16
        archive.writestr(script, '#!/bin/sh\n')
    folder, left_out, _ = downloads.folder_of_class(str(path), str(tmp_path / 'out'))
    assert content(folder) == {'anna/stop_at_x.py': 'x', 'ben/twice': 'x', 'ben/script': '#!/bin/sh\n'}
    assert sorted(name for name in os.listdir(tmp_path)) == ['a.zip', 'out']
    assert [one.reason.partition(':')[0] for one in left_out] == [
        *['its path leads to another folder'] * 4, *['its path is too long'] * 2, 'it cannot be unpacked',
        'it has 0 MB; at most 0 MB are read', 'it is a link, or no file']
    assert os.access(os.path.join(folder, 'ben', 'script'), os.X_OK)


@pytest.mark.parametrize('data', [b'', b'PK', b'PK\x03\x04' + b'x' * 100])
def test_a_file_that_is_no_zip_is_named(tmp_path, data):
    (tmp_path / 'a.zip').write_bytes(data)
    with pytest.raises(downloads.DownloadError, match='a.zip cannot be read as a ZIP: .*download it again'):
        downloads.folder_of_class(str(tmp_path / 'a.zip'), str(tmp_path / 'out'))


@pytest.mark.parametrize('zipped', [False, True])
def test_a_folder_of_the_teacher_with_the_name_of_ours_is_not_replaced(tmp_path, zipped):
    """The submissions themselves may lie in a folder handed_in, and the results be wanted beside it."""
    source = written(tmp_path / 'handed_in', MOODLE)
    if zipped:
        source = packed(tmp_path / 'class.zip', MOODLE)
    before = sorted(os.walk(tmp_path))
    with pytest.raises(downloads.DownloadError, match='replaced.* Choose another folder with --output DIR'):
        downloads.folder_of_class(source, str(tmp_path))
    assert sorted(os.walk(tmp_path)) == before
