"""packages/simulation/turtlesim/images: a picture of each design, for notebook widgets that look for them in turtlesim.

A picture that is missing is saved, and its test fails once: look at the new one before you commit it.
"""

import cv2
import numpy as np
import pytest

from turtlesim.core import sprites
from turtlesim.core.designs import FILES
from unit_support.packages import PACKAGES

IMAGES = PACKAGES['turtlesim'].folder / 'images'
ROUNDING = 3  # of 255 [levels] premultiplied, between versions of OpenCV


@pytest.mark.parametrize('design, name', list(enumerate(FILES)), ids=FILES)
def test_file_shows_the_design(design, name):
    path = IMAGES / f'{name}.png'
    if not path.exists():
        path.write_bytes(sprites.encode_png(sprites.picture(design)))
        pytest.fail(f'{path} was missing and has been saved; look at it')
    saved = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA).astype(float)
    wanted = sprites.picture(design).astype(float)
    assert saved.shape == (sprites.SIZE, sprites.SIZE, 4)
    assert np.abs(saved[:, :, 3] - wanted[:, :, 3]).max() <= ROUNDING
    opacity = wanted[:, :, 3:] / 255.0
    assert np.abs((saved - wanted)[:, :, :3] * opacity).max() <= ROUNDING


def test_each_design_has_one_file():
    assert len(FILES) == len(sprites.DESIGNS)
    assert {path.name for path in IMAGES.iterdir()} == {f'{name}.png' for name in FILES}


def test_picture_faces_up_with_a_transparent_background():
    image = sprites.picture(sprites.design_of('turtle1'))
    assert image[0, 0, 3] == 0 and image[sprites.MIDDLE, sprites.MIDDLE, 3] == 255
    opaque = image[:, :, 3] > 128
    # the head, 36.6 to the right in the artwork that faces +x, is at row 44 - 36.6 = 7.4; the tail, 2.8, at row 41
    assert opaque[8, sprites.MIDDLE] and not opaque[2, 10] and opaque[40, sprites.MIDDLE]
    skin = np.array(sprites.DESIGNS[sprites.design_of('turtle1')].skin, float)
    assert np.abs(image[7, sprites.MIDDLE, :3] - skin).max() < 10.0
