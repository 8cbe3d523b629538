"""createMarker: pictures of the right size, names and files of the original, bundles, questions, wrong input."""
import io
import struct

import cv2
import numpy as np
import pytest

from alvar_core import bundles, code, drawing
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.printing import create_marker

MILLIMETRE = 0.05e-3  # half a tenth


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def made(folder):
    return sorted(path.name for path in folder.iterdir())


def read_png(path):
    """(picture, its printed width in metres)."""
    data = path.read_bytes()
    at = data.index(b'pHYs')
    per_metre, also, unit = struct.unpack('>IIB', data[at + 4:at + 13])
    assert per_metre == also and unit == 1 and at < data.index(b'IDAT')
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    return picture, picture.shape[1] / per_metre


def detected(picture, resolution=5, margin=2, scale=1.0):
    """{id: Detection} in a picture with white around, as a camera sees it."""
    picture = cv2.copyMakeBorder(picture, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)
    picture = cv2.GaussianBlur(cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), (0, 0), 0.8)
    height, width = picture.shape
    camera = Camera([800, 0, width / 2, 0, 800, height / 2, 0, 0, 1])
    return {d.id: d for d in Detector(0.09, resolution, margin).detect(picture, camera)}


@pytest.mark.parametrize('arguments, pixels, metres', [
    (['5'], 340, 0.09),  # 9 cm * 96 / 2.54 = 340.16
    (['-s', '4.4', '5'], 166, 0.044),
    (['-uin', '-s', '2', '5'], 192, 0.0508),
    (['-u', '192', '-s', '1', '5'], 192, 0.0508),
    (['-s', '3', '-ucm', '5'], 113, 0.03),
])
def test_a_picture_prints_at_its_size(folder, arguments, pixels, metres):
    assert create_marker.main(arguments) == 0
    picture, width = read_png(folder / 'MarkerData_5.png')
    assert picture.shape == (pixels, pixels)
    assert width == pytest.approx(metres, abs=MILLIMETRE)
    assert set(detected(picture)) == {5}


def test_several_numbers_make_several_files(folder):
    assert create_marker.main(['0', '1', '255', '300']) == 0
    assert made(folder) == [f'MarkerData_{n}.png' for n in (0, 1, 255, 300)]
    for number in (0, 1, 255):
        assert set(detected(read_png(folder / f'MarkerData_{number}.png')[0])) == {number}
    assert set(detected(read_png(folder / 'MarkerData_300.png')[0], 7)) == {300}


@pytest.mark.parametrize('option, kind, text, name', [
    ('-1', code.STRING, 'Hello World', 'hello_wor'), ('-2', code.FILE, 'catalog.xml', 'catalog_x'),
    ('-3', code.HTTP, 'www.vtt.fi', 'www_vtt_f'), ('-1', code.STRING, '-+', '__')])
def test_texts_read_back(folder, option, kind, text, name):
    assert create_marker.main([option, text]) == 0
    picture, _ = read_png(folder / f'MarkerData_{name}.png')
    assert set(detected(picture, len(code.encode(text, kind)), scale=0.5)) == {text.lower()}


@pytest.mark.parametrize('text', [code.LETTERS[i:i + 22] for i in range(0, len(code.LETTERS), 22)])
def test_every_letter_reads_back_by_the_detector(text):
    cells = code.encode(text)
    picture = drawing.image_of_cells(cells, 8 * (len(cells) + 4))
    assert set(detected(picture, len(cells))) == {text.rstrip()}


def test_texts_of_one_beginning_get_files_of_their_own(folder):
    assert create_marker.main(['-1', 'turtle one', 'turtle one b']) == 0
    assert made(folder) == ['MarkerData_turtle_on.png', 'MarkerData_turtle_on_2.png']


@pytest.mark.parametrize('options, cells, margin', [
    (['-r', '9'], 9, 2), (['-m', '1'], 5, 1), (['-m', '3.0', '-r', '7'], 7, 3), (['-m', '0', '-r', '0'], 5, 2)])
def test_resolution_and_margin_are_used(folder, options, cells, margin):
    assert create_marker.main([*options, '-s', '10', '3']) == 0
    picture, _ = read_png(folder / 'MarkerData_3.png')
    assert set(detected(picture, cells, margin)) == {3}


def test_the_stronger_code(folder):
    assert create_marker.main(['-f', '70000']) == 0  # 17 bits fit into 7x7 cells in blocks of 16 only
    assert set(detected(read_png(folder / 'MarkerData_70000.png')[0], len(code.encode(70000, strong=True)))) == {70000}
    assert len(code.encode(70000, strong=True)) > len(code.encode(70000))


def test_a_bundle_is_one_picture_and_its_description(folder):
    assert create_marker.main(['-s', '4.4', '-xy', '0', '0', '8', '-xy', '9', '0', '9', '-xy', '0', '9', '10']) == 0
    assert made(folder) == ['MarkerData_8_9_10.png', 'MarkerData_8_9_10.xml']
    picture, width = read_png(folder / 'MarkerData_8_9_10.png')
    assert width == pytest.approx(0.134, abs=3 * MILLIMETRE)  # 4.4 / 2 + 9 + 4.4 / 2 cm; whole pixels
    found = detected(picture, scale=0.3)
    assert set(found) == {8, 9, 10}
    right, down = (found[n].corners.mean(0) - found[8].corners.mean(0) for n in (9, 10))
    pitch = 9 * create_marker.CM * 0.3
    assert right == pytest.approx([pitch, 0], abs=0.5) and down == pytest.approx([0, pitch], abs=0.5)
    bundle = bundles.read(folder / 'MarkerData_8_9_10.xml')
    assert (bundle.master, bundle.ids, bundle.notes) == (8, (8, 9, 10), ())
    assert bundle.corners[9].mean(0) == pytest.approx([0.09, 0, 0], abs=1e-8)
    assert bundle.corners[10].mean(0) == pytest.approx([0, -0.09, 0], abs=1e-8)  # y is up there
    assert bundle.corners[8][0] == pytest.approx([-0.022, 0.022, 0], abs=1e-8)  # top left


def test_a_bundle_file_is_in_centimetres_whatever_the_units(folder):
    assert create_marker.main(['-uin', '-s', '1', '1', '-xy', '3', '0', '2']) == 0
    bundle = bundles.read(folder / 'MarkerData_1_2.xml')
    assert bundle.sizes == pytest.approx({1: 0.0254, 2: 0.0254})
    assert bundle.corners[2].mean(0) == pytest.approx([0.0762, 0, 0], abs=1e-7)


def answer(monkeypatch, *lines):
    monkeypatch.setattr('sys.stdin', io.StringIO('\n'.join(lines) + '\n'))


def test_questions(folder, monkeypatch, capsys):
    answer(monkeypatch, '8', '', '', '', 'left', '14', '0', '', '', '', '-1')
    assert create_marker.main(['-p', '-s', '4.4']) == 0
    assert made(folder) == ['MarkerData_8_9_10.png', 'MarkerData_8_9_10.xml']
    bundle = bundles.read(folder / 'MarkerData_8_9_10.xml')
    assert bundle.corners[9].mean(0) == pytest.approx([0.14, 0, 0], abs=1e-8)
    assert bundle.corners[10].mean(0) == pytest.approx([0.088, -0.088, 0], abs=1e-8)  # the place that was offered
    assert "position 'left': a number from" in capsys.readouterr().out


def test_the_end_of_the_input_ends_the_questions(folder, monkeypatch):
    answer(monkeypatch, '4', '0', '0')
    assert create_marker.main([]) == 0
    assert made(folder) == ['MarkerData_4.png']


def test_an_array(folder, monkeypatch):
    answer(monkeypatch, '2', '3', '10', '12', '0', '20')
    assert create_marker.main(['-ar', '-s', '5']) == 0
    bundle = bundles.read(folder / 'MarkerData_20_21_22_23_24_25.xml')
    assert {n: tuple(np.round(c.mean(0)[:2] * 100, 6) + 0.0) for n, c in bundle.corners.items()} == {
        20: (0, 0), 21: (12, 0), 22: (24, 0), 23: (0, -10), 24: (12, -10), 25: (24, -10)}


@pytest.mark.parametrize('arguments, said', [
    (['-r', '5', '256'], 'marker 256: 9 bits do not fit in a marker of resolution 5; resolution 7 is enough'),
    (['-r', '5', '-1', 'a'], "resolution 5 holds only a number; resolution 7 is enough for 'a'"),
    (['-r', '7', '-1', 'a longer text'], 'resolution 7; resolution 13 is enough'),
    (['-1', 'grün'], "it holds 'ü'; at least one letter is needed, and only these are allowed: :abc"),
    (['-1', ''], 'it is empty'),
    (['4294967296'], 'a whole number from 0 to 4294967295 is needed'),
    (['-5'], 'marker id -5: a whole number from 0'),
    (['five'], "marker 'five': a whole number is needed; for a text, put -1 before it"),
    (['--size', '5'], 'unknown option --size; createMarker --help lists them'),
    (['-s'], '-s needs a length in units after it'),
    (['-s', 'big', '5'], "-s: marker size 'big': a number from 0.001 to 100000 is needed"),
    (['-s', 'nan', '5'], "-s: marker size 'nan'"),
    (['-s', '0', '5'], "-s: marker size '0'"),
    (['-s', '0.1', '5'], '9 x 9 cells on 4 pixels (1 mm); 9 to 20000 pixels are possible'),
    (['-s', '1000', '5'], 'on 37795 pixels'),
    (['-m', '1.5', '5'], '-m: margin 1.5: a whole number of cells'),
    (['-m', '11', '5'], "-m: margin '11': a number from 0 to 10"),
    (['-r', '6', '5'], '-r: marker resolution 6.0: an odd number from 5 to 31'),
    (['-a', '5'], 'draws no ARToolKit markers'),
    (['-s', '5'], 'the id is missing'),
    (['-xy', '0', '0', '1', '2'], 'markers 1 and 2 overlap'),
    (['-xy', '0', '0', '1', '-xy', '20', '0', '1'], 'marker 1 appears twice'),
    (['-xy', '0', '0', '1', '-xy', '900', '0', '2'], 'is too large; up to 20000 x 20000'),
    (['--page', 'a3', '5'], '--page a3: it must be one of a4, letter'),
])
def test_what_cannot_be_done(folder, capsys, arguments, said):
    assert create_marker.main(arguments) == 2
    said_there = capsys.readouterr().err
    assert said_there.startswith('createMarker: ') and said in said_there
    assert made(folder) == []


def test_a_file_that_cannot_be_written(folder, capsys):
    (folder / 'MarkerData_5.png').mkdir()
    assert create_marker.main(['5']) == 2
    assert f'{folder}/MarkerData_5.png cannot be written: Is a directory' in capsys.readouterr().err


def test_a_picture_and_its_description_are_both_new_or_both_old(folder, capsys):
    assert create_marker.main(['5', '-xy', '20', '0', '6']) == 0
    (xml, ), (png, ) = folder.glob('*.xml'), folder.glob('*.png')
    before = png.read_bytes()
    xml.unlink()
    xml.mkdir()
    assert create_marker.main(['-s', '3', '5', '-xy', '20', '0', '6']) == 2
    assert f'{xml} cannot be written: Is a directory. Change to another folder with cd' in capsys.readouterr().err
    assert png.read_bytes() == before and len(list(folder.iterdir())) == 2


def test_help_names_every_option(capsys):
    assert create_marker.main(['--help']) == 0
    text = capsys.readouterr().out
    options = {*create_marker._SETTINGS, *create_marker._READERS}
    assert len(options) > 15 and {option for option in options if f'{option}' not in text} == set()
