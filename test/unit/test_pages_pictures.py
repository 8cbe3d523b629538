"""test/pages/pictures.py tells drawn paths apart, and forgives what turtles do to a picture."""
import cv2
import numpy as np
import pytest

from pages import pictures

GROUND, PEN, BLUE, GREEN = (255, 86, 69), (255, 184, 179), (255, 0, 0), (60, 180, 90)  # BGR


def picture(corners=((100, 100), (300, 100), (300, 300)), colour=PEN, turtle=(300, 300), size=500):
    """Return a canvas with a path through the corners [px] and a turtle."""
    canvas = np.full((size, size, 3), GROUND, np.uint8)
    cv2.polylines(canvas, [np.array(corners)], False, colour, 3)
    cv2.circle(canvas, turtle, 20, GREEN, -1)
    return canvas


@pytest.mark.parametrize('saved, message', [
    (picture(), ''),
    (picture(corners=((102, 101), (301, 102), (302, 298))), ''),  # within REACH
    (picture(turtle=(100, 100)), ''),  # covers another part of the path
    (picture(corners=((100, 100), (300, 100))), 'it lacks 45 %'),
    (picture(corners=((100, 100), (300, 100), (300, 300), (100, 300))), 'has beyond the page 32 %'),
    (picture(corners=((100, 110), (300, 110), (310, 300))), 'it lacks 69 %'),
    (picture(colour=BLUE), 'of the path in the colour #0000ff'),
    (picture(size=400), 'its size is 400 x 400 px'),
    (np.full((500, 500, 3), 255, np.uint8), 'the background is another one'),
])
def test_differences_from_the_page(saved, message):
    found = pictures.differences(picture(), saved)
    assert message in found and bool(found) == bool(message)


@pytest.mark.parametrize('drawn, message', [
    ((), ''),  # the same path
    (((100, 100), (300, 100)), 'it lacks 4'),  # the rest is covered by no turtle
    (((100, 100), (300, 100), (300, 300), (100, 300)), 'has beyond the page 32 %'),
    (((0, 0),), 'nothing is drawn'),
])
def test_differences_of_a_canvas_without_turtles(drawn, message):
    canvas = picture(*([drawn] if drawn else []))
    canvas[(canvas == GREEN).all(axis=2)] = GROUND
    if not drawn:
        cv2.polylines(canvas, [np.array([[300, 280], [300, 300]])], False, PEN, 3)  # what the turtle hides
    found = pictures.differences_of_canvas(picture(), canvas)
    assert message in found and bool(found) == bool(message)


def test_a_canvas_that_is_not_there_differs():
    assert 'its size is' in pictures.differences_of_canvas(picture(), np.zeros((1, 1, 3), np.uint8))
