"""./run markers: unusable folders are named with the reason."""
import json
import resource

import cv2
import numpy as np
import pytest

from alvar_core import drawing, markers_cli

CAMERAS = {'c': {'K': [500, 0, 320, 0, 500, 240, 0, 0, 1], 'D': []}}


@pytest.mark.parametrize('content, said', [
    (None, 'is neither a PNG or JPEG, nor a folder with one, or with a frames.json'),
    ('no JSON', 'frames.json: Expecting value'),
    ([], 'frames.json: it holds a list; it must be a mapping'), ({'frames': []}, "'cameras' is missing"),
    ({'cameras': CAMERAS, 'frames': [{'name': 'a', 'file': 'a.png', 'camera': 'c'}]}, 'a.png cannot be read'),
    ({'cameras': CAMERAS, 'frames': [{'name': 'a', 'camera': 'c'}]}, "'file' is missing"),
    ({'cameras': {'c': {'K': [0] * 9, 'D': []}}, 'frames': []}, 'camera matrix K is')])
def test_what_is_wrong_with_a_folder(tmp_path, capsys, content, said):
    if content is not None:
        (tmp_path / 'frames.json').write_text(content if isinstance(content, str) else json.dumps(content))
    assert markers_cli.main([str(tmp_path), '--json', str(tmp_path / 'out.json')]) == 1
    error = capsys.readouterr().err
    assert error.startswith('./run markers: ') and said in error and str(tmp_path) in error


def test_results_that_cannot_be_written(tmp_path, capsys):
    (tmp_path / 'frames.json').write_text(json.dumps({'cameras': CAMERAS, 'frames': []}))
    assert markers_cli.main([str(tmp_path), '--json', str(tmp_path / 'none' / 'out.json')]) == 1
    assert (f'./run markers: {tmp_path}/none/out.json cannot be written: No such file or directory. Type mkdir -p '
            f'{tmp_path}/none, or choose another place') in capsys.readouterr().err


def test_pictures_that_cannot_be_written(tmp_path, capsys):
    cv2.imwrite(str(tmp_path / 'a.png'), np.full((480, 640), 220, np.uint8))
    (tmp_path / 'file').write_text('')
    for folder, path, why in ((tmp_path / 'file' / 'in', tmp_path / 'file' / 'in', 'Not a directory'),
                              (tmp_path / 'full', tmp_path / 'full' / 'a.png.png', 'File too large. Make room on')):
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))  # a small limit of file sizes is a full disk
        try:
            assert markers_cli.main([str(tmp_path / 'a.png'), '--explain', str(folder)]) == 1
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert f'./run markers: {path} cannot be written: {why}' in capsys.readouterr().err
    assert list((tmp_path / 'full').iterdir()) == []


@pytest.mark.parametrize('arguments', [['--explain', '{0}'], ['--explain', '{0}/../{1}'], ['--json', '{0}/frames.json'],
                                       ['--json', '{0}/../{1}/frames.json']])
def test_what_is_read_is_not_replaced(tmp_path, capsys, arguments):
    image = np.full((480, 640), 220, np.uint8)
    cv2.imwrite(str(tmp_path / 'square.png'), image)
    frames = [{'name': 'square', 'file': 'square.png', 'camera': 'c'}]
    (tmp_path / 'frames.json').write_text(json.dumps({'cameras': CAMERAS, 'frames': frames}))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(SystemExit):
        markers_cli.main([str(tmp_path), *(text.format(tmp_path, tmp_path.name) for text in arguments)])
    assert 'would be replaced' in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_what_was_found_is_said(tmp_path, capsys):
    (tmp_path / 'frames.json').write_text(json.dumps({'cameras': CAMERAS, 'frames': []}))
    assert markers_cli.main([str(tmp_path), '--json', str(tmp_path / 'out.json')]) == 0
    assert capsys.readouterr().out == f'0 markers in 0 frames, 0.0 ms per frame (median): {tmp_path}/out.json\n'


def test_explain_says_and_draws_what_is_there(tmp_path, capsys):
    image = np.full((480, 640), 220, np.uint8)
    image[100:200, 100:200] = 20
    cv2.imwrite(str(tmp_path / 'a.png'), image)
    frames = [{'name': 'square', 'file': 'a.png', 'camera': 'c'}]
    (tmp_path / 'frames.json').write_text(json.dumps({'cameras': CAMERAS, 'frames': frames}))
    command = [str(tmp_path), '--json', str(tmp_path / 'out.json'), '--explain']
    assert markers_cli.main(command) == 0
    said = 'square:\n  1: its cells differ from every code word: the best fit is 0.00, more than 0.64 is needed ('
    assert capsys.readouterr().out.startswith(said)
    assert markers_cli.main([*command, str(tmp_path / 'pictures'), '--at', '600,400']) == 0
    out = capsys.readouterr().out
    assert out.startswith(said) and 'At 600, 400: there is no dark quadrilateral' in out
    assert cv2.imread(str(tmp_path / 'pictures' / 'square.png')).shape[0] > 480
    assert json.loads((tmp_path / 'out.json').read_text())['frames']['square']['detections'] == []


def test_images_without_a_description_are_those_of_a_webcam(tmp_path, capsys):
    image = np.full((480, 640), 220, np.uint8)
    image[100:226, 100:226] = drawing.marker_image(5, 126)
    for name in ('near.png', 'other.JPG'):
        cv2.imwrite(str(tmp_path / name), image)
    (tmp_path / 'notes.txt').write_text('no image')
    out = tmp_path / 'out.json'
    assert markers_cli.main([str(tmp_path), '--json', str(out)]) == 0
    found = {name: frame['detections'] for name, frame in json.loads(out.read_text())['frames'].items()}
    assert [(name, each['id']) for name, (each,) in sorted(found.items())] == [('near.png', 5), ('other.JPG', 5)]
    assert found['near.png'][0]['position'][2] == pytest.approx(525 / 126, rel=0.01)  # focal length [px] / width [px]
    capsys.readouterr()
    assert markers_cli.main([str(tmp_path / 'near.png'), '--explain']) == 0
    assert capsys.readouterr().out.startswith('near.png:\n  1: found as marker 5 (126 px wide')


def test_file_that_is_not_an_image(tmp_path, capsys):
    (tmp_path / 'a.png').write_text('text')
    assert markers_cli.main([str(tmp_path / 'a.png')]) == 1
    assert 'a.png cannot be read as an image' in capsys.readouterr().err


@pytest.mark.parametrize('point', ['5', 'x,y', '1,2,3'])
def test_wrong_point_is_refused(tmp_path, capsys, point):
    with pytest.raises(SystemExit):
        markers_cli.main([str(tmp_path), '--json', 'out.json', '--explain', '--at', point])
    assert f"argument --at: '{point}': two numbers are needed, such as 320,240" in capsys.readouterr().err
