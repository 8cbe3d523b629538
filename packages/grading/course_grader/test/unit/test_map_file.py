"""course_grader.attempt.map_file: maps that are handed in; only the student's own files are read."""
import os
import types

import cv2
import numpy as np
import pytest

from course_grader.attempt import map_file
from course_grader.rules import exercise
from kinematic_core.worlds import world_format
from kinematic_core.worlds.frames import LIDAR_Z
from navigation_core.maps import map_files
from navigation_core.maps.map_files import MapError
from navigation_core.maps.scores import true_map

EXERCISE = exercise.parse({
    'title': 'T', 'asks': '', 'time': '1 s', 'simulator': 'robotont', 'world': {'like': 'minimaze'},
    'start': {'x': '-2 m', 'y': '0 m'}, 'checks': [{'check': 'maps', 'of': 'file', 'points': 100, 'must': True}]})
YAML = 'image: {}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n'


@pytest.fixture
def saved(tmp_path):
    """Return the YAML file of the true map, which a student has saved somewhere else."""
    pgm, text = map_files.saved(true_map(world_format.parse(EXERCISE.world).outlines(LIDAR_Z), 0.05), 'mymap')
    (tmp_path / 'mymap.pgm').write_bytes(pgm)
    (tmp_path / 'mymap.yaml').write_bytes(text.replace(b'mymap.pgm', b'/home/anna/maps/mymap.pgm'))
    return tmp_path / 'mymap.yaml'


def graded(path, command=None):
    return map_file.grade(types.SimpleNamespace(exercise=EXERCISE, folder=str(path.parent), seed=1,
                                                command=(command or str(path),))).verdict


def test_true_map_passes_also_by_a_path_from_the_folder_of_the_command(saved):
    assert EXERCISE.of_map and graded(saved)[:2] == ('passed', 100.0)
    assert graded(saved, 'mymap.yaml').outcome == 'passed'


def test_map_with_a_wrong_resolution_fails(saved):
    saved.write_text(saved.read_text().replace('0.050000', '0.070000'))
    verdict = graded(saved)
    assert verdict.outcome == 'failed' and 'IoU 0.' in verdict.reasons[0].seen


def test_what_cannot_be_read_fails_with_the_reason(saved):
    saved.write_text('resolution: 0.05\n')
    assert graded(saved)[:2] == ('failed', 0.0) and 'image is None' in graded(saved).objections[0]
    assert 'could not open' in graded(saved, 'none.yaml').objections[0]


@pytest.mark.parametrize('name, make, said', [
    ('link.pgm', lambda path: os.symlink('/etc/passwd', path), 'is a link: hand in the file itself'),
    ('pipe.pgm', os.mkfifo, 'is not a file'),
    ('large.pgm', lambda path: path.touch() or os.truncate(path, map_file.MAX_IMAGE + 1),
     'at most 100 MB are read'),
    ('photo.jpg', lambda path: cv2.imwrite(str(path), np.zeros((9, 9), np.uint8)), 'it must be a PGM or PNG file'),
    ('../passwd', lambda path: None, 'No such file')])
def test_only_an_image_that_is_the_students_own_file_is_read(tmp_path, name, make, said):
    make(tmp_path / name)
    (tmp_path / 'map.yaml').write_text(YAML.format(name))
    with pytest.raises(MapError, match=said):
        map_file.read(str(tmp_path / 'map.yaml'))


def test_a_linked_map_is_refused(saved, tmp_path):
    os.symlink(saved, tmp_path / 'link.yaml')
    with pytest.raises(MapError, match='is a link'):
        map_file.read(str(tmp_path / 'link.yaml'))
