"""Why a marker is not found: the explanation agrees with the detector, and names the stage where a candidate ended."""
import json
import pathlib
import re

import cv2
import numpy as np
import pytest

from alvar_core import drawing
from alvar_core.camera import default_camera
from alvar_core.detection import explanation
from alvar_core.detection.detector import Detector
from alvar_core.detection.explanation import FOUND, RANKS, Candidate, Explanation, explain
from unit_support import REPOSITORY, marker_score

HERE = pathlib.Path(__file__).resolve()
FRAMES = REPOSITORY / 'test' / 'data' / 'alvar'
CORE = HERE.parents[3]
BLACK, PAPER, GROUND = 20, 230, 110
CAMERA = default_camera()
PLACE = 250, 180  # of the marker's left top corner


def picture(value=42, side=90, margin=2, white=20, blur=0.7, ground=GROUND):
    """Return an image of a marker on paper; ``white``: width of the white margin [px]."""
    image = np.full((480, 640), ground, np.uint8)
    x, y = PLACE
    image[y - white:y + side + white, x - white:x + side + white] = PAPER
    image[y:y + side, x:x + side] = np.where(drawing.marker_image(value, side, margin) > 0, PAPER, BLACK)
    return cv2.GaussianBlur(image, (0, 0), blur)


def tiny():
    """Return an image of a marker of 8.5 px on paper."""
    image, (x, y) = picture(white=0, side=9), PLACE
    drawn = np.where(drawing.marker_image(42, 34, 2) > 0, PAPER, BLACK).astype(np.uint8)
    paper = np.pad(drawn, 23, constant_values=PAPER)
    image[y - 6:y + 14, x - 6:x + 14] = cv2.resize(paper, (20, 20), interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(image, (0, 0), 0.7)


def covered(cover, grey=120):
    """Return the image of a marker with something grey over rows and columns."""
    image = picture()
    image[cover] = grey
    return image


BAR = np.s_[170:215, 240:300]
MADE = {  # image, resolution and margin of the detector: the threshold it misses, a part of the text
    'too small': (tiny(), (5, 2), 'MIN_MARKER_AREA', 'square pixels, more than 80 are needed'),
    'blurred': (picture(side=18, blur=2.4), (5, 2), 'MAX_BLUR', 'it is blurred over'),
    'blurred and large': (picture(blur=15), (5, 2), 'MIN_COARSE_FIT', 'its cells differ from every code word'),
    'covered border': (covered(BAR), (5, 2), 'UNLIKE.margin_ratio',
                       'perhaps marker 42, but the best code word is hardly'),
    'no white margin': (picture(white=0, ground=25), (5, 2), 'MIN_SEEN_EDGES', 'of the edges of its cells are seen'),
    'wider border': (picture(side=60, margin=3), (5, 2), 'WIDER_MARGIN', 'its black border is wider'),
    'narrower border': (picture(margin=1), (5, 2), 'UNLIKE.fit', 'With marker_margin 1 it is marker 42'),
    'more cells': (picture(1000), (5, 2), 'CHANGED_FIT', 'With marker_resolution 7 it is marker 1000'),
    'fewer cells': (picture(), (7, 2), 'MIN_COARSE_FIT', 'With marker_resolution 5 it is marker 42'),
    'a black square': (covered(np.s_[180:270, 250:340], grey=BLACK), (5, 2), 'MIN_COARSE_FIT', 'the best fit is 0.0'),
}


def explained(image, detector, camera=CAMERA):
    """Return the Explanation of an image, after a check that it finds the markers of the detector."""
    found = detector.detect(image, camera)
    result = explain(detector, image, camera)
    named = [each for each in result.candidates if each.stage == FOUND]
    assert [each.id for each in named] == [each.id for each in found]
    assert all((one.corners == other.corners).all() for one, other in zip(named, found))
    return result


@pytest.mark.parametrize('name', MADE)
def test_why_a_marker_is_not_found(name):
    image, layout, threshold, said = MADE[name]
    result = explained(image, Detector(0.1, *layout))
    assert result.candidates[0].threshold == threshold
    assert said in result.lines[0]
    assert result.lines[0].split(': ', 1)[1] in result.at((PLACE[0] + 5, PLACE[1] + 5))


def test_stages_of_glare_are_named():
    """A lamp lies across the marker so broadly that it hides the cells; without it, glare is not mentioned."""
    x = np.arange(640)
    lamp = 300 * np.exp(-0.5 * ((x - 295) / 18) ** 2)
    shiny = np.clip(picture() + lamp, 0, 255).astype(np.uint8)
    _, ended = Detector(0.1).explain(shiny, CAMERA)
    missed = {threshold for _, threshold, *_ in ended}
    assert missed & {'MIN_GLARE', 'MIN_GLARE_WHITE', 'MAX_GLARE_ERROR', 'MIN_GLARE_SCORE_GAP', 'MAX_GLARE_MISFIT'}
    said = [each.sentence for each in explain(Detector(0.1), shiny, CAMERA).candidates]
    assert any('glare' in each or 'saturated' in each for each in said), said
    _, ended = Detector(0.1).explain(np.minimum(shiny, 200), CAMERA)
    assert not any('GLARE' in threshold for _, threshold, *_ in ended)


def test_found_marker_and_what_is_beside_it():
    result = explained(picture(), Detector(0.1))
    assert result.lines[0].startswith('1: found as marker 42 (90 px wide, 10.0 px per cell, at 295, 22')
    assert result.at((295, 225)).startswith('At 295, 225: 1: found as marker 42')
    assert 'there is no dark quadrilateral' in result.at((600, 400))


def square(side, stage):
    corners = np.array([[0, 0], [side, 0], [side, side], [0, side]], float) - side / 2
    return Candidate(corners, stage, f'{stage} of {side} px', (0, 0, 0))


@pytest.mark.parametrize('stages, said', [  # of squares of 90, 50 and 30 px in each other
    (('margin', 'code', 'sides'), '1: margin of 90 px'),  # white cells of a marker
    (('border', 'code', 'sides'), '3: sides of 30 px')])
def test_point_on_several_candidates_is_on_the_marker_or_the_smallest(stages, said):
    candidates = [square(side, stage) for side, stage in zip((90, 50, 30), stages)]
    assert said in Explanation(9, candidates[:2], candidates[2:]).at((0, 0))


def test_image_without_anything():
    result = explained(np.full((480, 640), 128, np.uint8), Detector(0.1))
    assert not result.candidates and 'There is no dark quadrilateral' in result.lines[0]
    assert 'nor anywhere else' in result.at((10, 10))


@pytest.mark.nightly
def test_frames_are_explained_as_they_are_detected():
    truth = json.loads((FRAMES / 'frames.json').read_text())
    cameras, detector, stages = marker_score.cameras_of(truth), Detector(1.0), set()
    for frame in truth['frames']:
        image = cv2.imread(str(FRAMES / frame['file']), cv2.IMREAD_GRAYSCALE)
        result = explained(image, detector, cameras[frame['camera']])
        stages |= {each.stage for each in result.candidates + result.others}
    assert {FOUND, 'sides', 'border', 'code', 'alignment', 'reading', 'acceptance'} <= stages
    assert detector.detect(image, cameras[frame['camera']]) is not None and detector._ended is None


def test_other_resolutions_are_explained():
    assert explained(picture(1000), Detector(0.1, 7)).candidates[0].id == 1000


def test_picture_has_outlines_and_lines():
    result = explained(picture(), Detector(0.1))
    drawn = result.draw(picture())
    assert drawn.shape[0] > 480 and drawn.shape[1:] == (640, 3)
    assert (drawn[:480] == explanation.FOUND_COLOUR).all(2).sum() > 300  # four sides of 90 px
    assert drawn[480:].any()
    assert result.draw(picture()[:200, :100]).shape[1] == explanation.PANEL_WIDTH


def test_every_threshold_has_a_sentence():
    named = set()
    for path in CORE.glob('native/*.cpp'):
        named |= set(re.findall(r'"([A-Z]+(?:_[A-Z]+)*(?:_[A-Z]+|\.[a-z]+))"', path.read_text()))
    for path in CORE.glob('src/alvar_core/detection/*_light.py'), \
            [CORE / f'src/alvar_core/detection/{name}.py' for name in ('detector', 'glare')]:
        for each in path:
            named |= set(re.findall(r"\('([A-Z]+(?:_[A-Z]+)+)'", each.read_text()))
    assert named - set(RANKS) == set() and len(named) > 25
