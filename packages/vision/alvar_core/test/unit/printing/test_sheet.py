"""Sheets to print: rendered by pdftoppm and measured with a ruler, as it were; read by the detector."""
import io
import shutil
import subprocess

import cv2
import numpy as np
import pytest

from alvar_core import bundles
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.printing import create_marker, marker_files, sheet

pytestmark = pytest.mark.slow

PRINT_DPI, LOOK_DPI = 300, 60
DOT = 25.4 / PRINT_DPI  # [mm] 0.085
HALF_A_PERCENT = 0.005


def sheet_of(arguments, page='a4'):
    """[(file name, bytes)] of the markers that arguments of createMarker name."""
    return sheet.files(create_marker.CommandLine(arguments).markers, 'sheet.pdf', page)


def printed(pdf, dpi, page=1):
    """The page as a grey picture, as a printer of this resolution would put it on paper."""
    if not shutil.which('pdftoppm'):
        pytest.skip('poppler-utils is not installed')
    out = subprocess.run(['pdftoppm', '-gray', '-r', str(dpi), '-f', str(page), '-l', str(page), '-'], input=pdf,
                         stdout=subprocess.PIPE, check=True, timeout=60).stdout
    return cv2.imdecode(np.frombuffer(out, np.uint8), cv2.IMREAD_GRAYSCALE)


def black_squares(picture):
    """Left, top, width, height in mm of the markers' black squares, in reading order."""
    outlines, _ = cv2.findContours((picture < 128).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    boxes = [np.array(cv2.boundingRect(outline)) * DOT for outline in outlines]
    boxes = [box for box in boxes if min(box[2:]) > 8]  # letters and the ruler are less
    return sorted(boxes, key=lambda box: (round(box[1]), box[0]))


def detections(picture, size=0.044):
    """{id: Detection} of a printed page by a camera at a distance of one metre."""
    share = LOOK_DPI / PRINT_DPI
    picture = cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    height, width = picture.shape
    focal = LOOK_DPI / 0.0254
    picture = cv2.GaussianBlur(picture, (0, 0), 1.0)  # as lenses do
    camera = Camera([focal, 0, width / 2 - 0.5, 0, focal, height / 2 - 0.5, 0, 0, 1])
    return {d.id: d for d in Detector(size).detect(picture, camera)}


@pytest.mark.parametrize('page, width, height', [('a4', 210, 297), ('letter', 215.9, 279.4)])
def test_page_has_its_size(page, width, height):
    picture = printed(sheet_of(['5'], page)[0][1], PRINT_DPI)
    assert picture.shape == (pytest.approx(height / DOT, abs=1), pytest.approx(width / DOT, abs=1))


@pytest.mark.parametrize('side', [10, 44, 90, 150])
def test_black_squares_measure_what_they_should(side):
    (name, pdf), = sheet_of(['-s', str(side / 10), '7'])
    (_, _, width, height), = black_squares(printed(pdf, PRINT_DPI))
    assert name == 'sheet.pdf' and (width, height) == (pytest.approx(side, abs=DOT), pytest.approx(side, abs=DOT))


def test_cells_are_where_they_should_be():
    marker, = create_marker.CommandLine(['-s', '9', '77']).markers
    picture = printed(sheet_of(['-s', '9', '77'])[0][1], PRINT_DPI)
    left, top, _, _ = black_squares(picture)[0]
    middles = (np.arange(9) + 0.5) * 10  # mm, nine cells of 10 mm
    seen = picture[np.ix_(((top + middles) / DOT).astype(int), ((left + middles) / DOT).astype(int))] < 128
    assert (seen == marker.black).all()


def test_no_seams_between_white_cells():
    picture = printed(sheet_of(['-s', '9', '0'])[0][1], PRINT_DPI)
    left, top, _, _ = black_squares(picture)[0]
    rows = slice(int((top + 52) / DOT), int((top + 68) / DOT))  # the sixth and seventh row of cells are white in 0
    assert picture[rows, int((left + 22) / DOT):int((left + 68) / DOT)].min() == 255


def test_the_ruler_is_a_ruler():
    picture = printed(sheet_of(['5'])[0][1], PRINT_DPI)
    height = picture.shape[0]
    dark = picture[int(height * 0.85):] < 128
    row = dark[dark.sum(1).argmax()]  # its line, the longest dark row
    ends = np.flatnonzero(row)[[0, -1]]
    assert row[ends[0]:ends[1]].all()
    assert (ends[1] - ends[0]) * DOT == pytest.approx(100, abs=0.3)
    above = dark[dark.sum(1).argmax() - int(4.2 / DOT)]
    assert np.diff(np.flatnonzero(np.diff(above.astype(int)) > 0)) * DOT == pytest.approx(np.full(10, 10), abs=2 * DOT)


def test_detector_finds_all_markers_at_their_size():
    pdf = sheet_of(['-s', '4.4', *(str(n) for n in range(8))])[0][1]
    found = detections(printed(pdf, PRINT_DPI))
    assert set(found) == set(range(8))
    distances = np.array([d.position[2] for d in found.values()])  # one metre if it has the size that it should
    assert np.abs(distances - 1).max() < HALF_A_PERCENT


def test_what_does_not_fit_goes_on_the_next_page():
    pdf = sheet_of(['-s', '9', '1', '2', '3'])[0][1]
    pages = sheet.spread(create_marker.CommandLine(['-s', '9', '1', '2', '3']).markers, 'a4')
    assert [[spot.marker.value for spot in page] for page in pages] == [[1, 2], [3]]
    assert [len(black_squares(printed(pdf, PRINT_DPI, page))) for page in (1, 2)] == [2, 1]


def test_pieces_of_paper_do_not_overlap_and_stay_on_the_page():
    line = ['-s', '2', '1', '2', '-s', '5', '3', '4', '-s', '3', *map(str, range(5, 30))]
    markers = create_marker.CommandLine(line).markers
    for page, (width, height) in sheet.PAGES.items():
        for spots in sheet.spread(markers, page):
            boxes = [spot.box for spot in spots]
            for number, (left, top, right, bottom) in enumerate(boxes):
                assert left >= sheet.EDGE and top >= sheet.EDGE and right <= width - sheet.EDGE
                assert bottom <= height - sheet.EDGE - sheet.FOOT
                assert all(left >= b[2] or right <= b[0] or top >= b[3] or bottom <= b[1] for b in boxes[:number])


def test_a_bundle_keeps_its_places():
    arguments = ['-s', '4.4', '-xy', '0', '0', '8', '-xy', '9', '0', '9', '-xy', '0', '9', '10']
    (_, pdf), (name, xml) = sheet_of(arguments)
    first, right, below = black_squares(printed(pdf, PRINT_DPI))
    assert right[:2] - first[:2] == pytest.approx([90, 0], abs=DOT)
    assert below[:2] - first[:2] == pytest.approx([0, 90], abs=DOT)
    assert name == 'sheet.xml' and xml.decode() == bundles.xml(
        marker_files.bundle_corners(create_marker.CommandLine(arguments).markers))


def test_a_label_in_the_way_of_another_marker_is_left_out():
    markers = create_marker.CommandLine(['-s', '4.4', '-xy', '0', '0', '1', '-xy', '0', '5', '2']).markers
    assert [spot.labelled for spot in sheet.arranged(markers, 'a4')] == [False, True]


@pytest.mark.parametrize('arguments, said', [
    (['-s', '30', '5'], 'marker 5: its 300 mm with the white margin are too large for page a4; up to 152 mm'),
    (['-s', '5', '-xy', '0', '0', '1', '-xy', '30', '0', '2'], 'the bundle is 361.1 x 65.11 mm with the white'),
])
def test_what_does_not_fit_on_a_page(arguments, said):
    with pytest.raises(marker_files.CreateError, match=said):
        sheet_of(arguments)


def test_the_largest_that_is_named_fits():
    assert len(sheet_of(['-s', '15.2', '5'])) == 1


def test_from_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', io.StringIO())
    out = tmp_path / 'out.pdf'
    assert create_marker.main(['--pdf', str(out), '--page', 'letter', '5', '6']) == 0
    assert out.read_bytes().startswith(b'%PDF')
    assert create_marker.main(['--pdf', str(tmp_path / 'nowhere' / 'out.pdf'), '5']) == 2
    assert 'nowhere/out.pdf cannot be written: No such file or directory' in capsys.readouterr().err


def test_without_cairo(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(__import__('sys').modules, 'cairo', None)
    assert create_marker.main(['--pdf', str(tmp_path / 'out.pdf'), '5']) == 2
    assert 'sudo apt-get install python3-cairo' in capsys.readouterr().err
