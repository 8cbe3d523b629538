"""Draw the turtles in the image; the artwork is our own. Loads OpenCV: import it only when an image is needed.

A turtle's design depends only on its name, so that images are the same in each run. Images are numpy arrays
(height, width, 3), uint8, RGB; positions are in metres with y down, headings in rad, counter-clockwise from +x.
The functions may be called from any thread.
"""
import functools
import math
from typing import Callable, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.turtle_world import PIXELS_PER_METRE, Colour
from turtlesim.core.designs import design_of

SIZE = 45  # [px] of a sprite; its artwork stays inside a circle, so that rotated sprites fit into the same square
MIDDLE = SIZE // 2
TURNED_FROM = 2  # sprites are rotated from images this many times larger, which keeps them sharp
FINE = 8  # the artwork is drawn this many times larger
DEGREES = 360  # headings a sprite can have
KEPT = 256  # rotated sprites that are cached, 8 kB each

DARK = (24, 28, 38)
WHITE = (255, 255, 255)
SHELL = (20.4, 22.5, 14.4, 12.4)  # centre and half axes, in the units of the artwork: px of a sprite that faces +x
FLIPPERS = ((30.2, 10.5, 5.9, 3.5, -62), (30.2, 34.5, 5.9, 3.5, 62),  # centre, half axes, degrees clockwise
            (11.0, 12.0, 4.7, 3.2, 48), (11.0, 33.0, 4.7, 3.2, -48))
HEAD = (36.6, 22.5, 6.0, 5.8)

Point = Tuple[float, float]


class Artwork:
    """A transparent image to draw on, in the units of the artwork; drawn parts are opaque."""

    def __init__(self) -> None:
        self.pixels = np.zeros((SIZE * FINE, SIZE * FINE, 4), np.uint8)

    def ellipse(self, x: float, y: float, half_x: float, half_y: float, colour: Colour, degrees: float = 0) -> None:
        """Fill an ellipse, rotated clockwise by ``degrees``."""
        (middle,), axes = _fine([(x, y)]), (round(half_x * FINE * 16), round(half_y * FINE * 16))
        cv2.ellipse(self.pixels, middle.tolist(), axes, degrees, 0, 360, (*colour, 255), -1, 8, 4)

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        cv2.fillPoly(self.pixels, [_fine(points)], (*colour, 255), 8, 4)

    def line(self, points: Sequence[Point], colour: Colour, width: float) -> None:
        cv2.polylines(self.pixels, [_fine(points)], False, (*colour, 255), round(width * FINE), 8, 4)


def _fine(points: Sequence[Point]) -> np.ndarray:
    """Return points (N, 2) int32 for OpenCV, in 1/16 px of the fine image; pixels are centred on whole numbers."""
    fine: np.ndarray = np.round((np.asarray(points, float) * FINE - 0.5) * 16).astype(np.int32)
    return fine


def _ring(x: float, y: float, radius: float, corners: int, turn: float = 0.0,
          inner: Optional[float] = None) -> List[Point]:
    """Return the corners of a regular polygon, or of a star with that inner radius."""
    steps = corners if inner is None else 2 * corners
    radii = [radius if inner is None or step % 2 == 0 else inner for step in range(steps)]
    angles = [turn + step * 2 * math.pi / steps for step in range(steps)]
    return [(x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(radii, angles)]


def _scutes(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    art.polygon(_ring(x, y, 5.2, 6), colour)
    for centre_x, centre_y in _ring(x, y, 10.6, 6, math.pi / 6):
        art.polygon(_ring(centre_x, centre_y, 5.2, 6), colour)


def _rings(art: Artwork, colour: Colour) -> None:
    x, y, half_x, half_y = SHELL
    for scale, shade in ((0.78, colour), (0.56, (198, 66, 48)), (0.34, colour)):
        art.ellipse(x, y, half_x * scale, half_y * scale, shade)


def _stripes(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    for offset in (-10, -3.4, 3.4, 10):
        art.line([(x + offset + 1.5, y - 14), (x + offset - 1.5, y), (x + offset + 1.5, y + 14)], colour, 3)


def _dots(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    art.ellipse(x, y, 3.2, 3.2, colour)
    for centre_x, centre_y in _ring(x, y, 8.4, 6):
        art.ellipse(centre_x, centre_y, 2.3, 2.3, colour)


def _star(art: Artwork, colour: Colour) -> None:
    art.polygon(_ring(SHELL[0], SHELL[1], 11, 5, 0.0, 4.6), colour)


def _diamonds(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    for offset, size in ((-9, 4.2), (0, 6), (9, 4.2)):
        art.polygon([(x + offset - size, y), (x + offset, y - 1.3 * size), (x + offset + size, y),
                       (x + offset, y + 1.3 * size)], colour)


def _flower(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    for centre_x, centre_y in _ring(x, y, 6, 5):
        art.ellipse(centre_x, centre_y, 3.7, 3.7, colour)
    art.ellipse(x, y, 3.2, 3.2, (255, 206, 70))


def _checks(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    side = 5.0
    for column in range(-4, 4):
        for row in range(-4, 4):
            if (column + row) % 2:
                left, top = x + column * side, y + row * side
                art.polygon([(left, top), (left + side, top), (left + side, top + side), (left, top + side)], colour)


def _spiral(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    turns = np.linspace(0, 5.2 * math.pi, 120)
    art.line([(x + 0.68 * t * math.cos(t), y + 0.58 * t * math.sin(t)) for t in turns], colour, 2.2)


def _heart(art: Artwork, colour: Colour) -> None:
    x, y = SHELL[:2]
    turns = np.linspace(0, 2 * math.pi, 60)
    art.polygon([(x - 1 + 0.6 * (13 * math.cos(t) - 5 * math.cos(2 * t) - 2 * math.cos(3 * t) - math.cos(4 * t)),
                    y + 0.6 * 16 * math.sin(t) ** 3) for t in turns], colour)


class Design(NamedTuple):
    """The colours of a turtle's skin and shell, and the shell's pattern with its colour."""

    skin: Colour
    shell: Colour
    pattern: Callable[[Artwork, Colour], None]
    pattern_colour: Colour


DESIGNS = (
    Design((255, 210, 140), (222, 84, 58), _rings, (255, 190, 96)),
    Design((196, 230, 140), (250, 216, 70), _stripes, (222, 140, 34)),
    Design((216, 188, 136), (116, 74, 46), _diamonds, (232, 188, 120)),
    Design((166, 214, 98), (58, 140, 66), _scutes, (128, 196, 88)),  # turtle1's
    Design((255, 196, 208), (182, 48, 112), _dots, (255, 172, 206)),
    Design((190, 222, 230), (246, 247, 250), _flower, (238, 110, 136)),
    Design((236, 158, 74), (46, 48, 58), _checks, (240, 176, 66)),
    Design((170, 232, 206), (122, 78, 186), _spiral, (226, 200, 255)),
    Design((238, 226, 168), (178, 54, 42), _heart, (255, 214, 206)),
    Design((252, 234, 190), (60, 178, 160), _star, (255, 250, 214)),
)

@functools.lru_cache(maxsize=len(DESIGNS))
def _artwork(design: int) -> np.ndarray:
    """Return a design facing +x, RGBA with premultiplied alpha, TURNED_FROM times as large as a sprite."""
    skin, shell = DESIGNS[design].skin, DESIGNS[design].shell
    art = Artwork()
    _limbs(art, DARK, 1.3)
    _limbs(art, skin, 0.0)
    for y in (19.4, 25.6):
        art.ellipse(38.5, y, 2.5, 2.2, WHITE)
        art.ellipse(39.2, y, 1.5, 1.5, DARK)
    x, y, half_x, half_y = SHELL
    red, green, blue = (value * 6 // 10 for value in shell)
    art.ellipse(x, y, half_x + 0.5, half_y + 0.5, DARK)
    art.ellipse(x, y, half_x - 0.7, half_y - 0.7, (red, green, blue))
    _shell(art, DESIGNS[design])
    side = SIZE * TURNED_FROM
    return cv2.resize(art.pixels, (side, side), interpolation=cv2.INTER_AREA)


def _limbs(art: Artwork, colour: Colour, outline: float) -> None:
    art.polygon([(8 - outline, 19.6 - outline), (8 - outline, 25.4 + outline), (2.8 - outline, 22.5)], colour)
    for x, y, half_x, half_y, degrees in FLIPPERS:
        art.ellipse(x, y, half_x + outline, half_y + outline, colour, degrees)
    x, y, half_x, half_y = HEAD
    art.ellipse(x, y, half_x + outline, half_y + outline, colour)


def _shell(art: Artwork, design: Design) -> None:
    """Draw the shell inside its rim, with its pattern clipped there."""
    x, y, half_x, half_y = SHELL
    inside = Artwork()
    inside.ellipse(x, y, half_x - 2.0, half_y - 2.0, design.shell)
    patterned = Artwork()
    patterned.pixels[:] = inside.pixels
    design.pattern(patterned, design.pattern_colour)
    mask = inside.pixels[:, :, 3] > 0
    art.pixels[mask] = patterned.pixels[mask]


@functools.lru_cache(maxsize=KEPT)
def _turned(design: int, degrees: int) -> Tuple[np.ndarray, np.ndarray]:
    """Return a rotated sprite: premultiplied RGB, and the share of the background that shows through, 0..255.

    Both are (SIZE, SIZE, 3) uint8.
    """
    scale = 1.0 / TURNED_FROM
    artwork_middle = (SIZE * TURNED_FROM - 1) / 2
    matrix: np.ndarray = cv2.getRotationMatrix2D((artwork_middle, artwork_middle), degrees * 360.0 / DEGREES, scale)
    matrix[:, 2] += MIDDLE - artwork_middle
    sprite = cv2.warpAffine(_artwork(design), matrix, (SIZE, SIZE), flags=cv2.INTER_LINEAR)
    return np.ascontiguousarray(sprite[:, :, :3]), cv2.cvtColor(255 - sprite[:, :, 3], cv2.COLOR_GRAY2RGB)


def render(canvas: np.ndarray, turtles: Iterable[Tuple[str, float, float, float]]) -> np.ndarray:
    """Return a new image: the canvas (height, width, 3), uint8, RGB, with turtles over it in the order of their names.

    ``turtles``: (name, x [m], y_down [m], theta [rad]), all finite; those outside the image are cut off.
    """
    frame = canvas.copy()
    for name, x, y_down, theta in sorted(turtles, key=lambda turtle: turtle[0]):
        degrees = round(theta * DEGREES / (2 * math.pi)) % DEGREES
        left = round(x * PIXELS_PER_METRE) - MIDDLE
        top = round(y_down * PIXELS_PER_METRE) - MIDDLE
        _paste(frame, left, top, *_turned(design_of(name), degrees))
    return frame


def _paste(frame: np.ndarray, left: int, top: int, colours: np.ndarray, background_share: np.ndarray) -> None:
    height, width = frame.shape[:2]
    right, bottom = min(left + SIZE, width), min(top + SIZE, height)
    if right <= max(left, 0) or bottom <= max(top, 0):
        return
    part = np.s_[max(-top, 0):bottom - top, max(-left, 0):right - left]
    covered = frame[max(top, 0):bottom, max(left, 0):right]
    background = cv2.multiply(covered, background_share[part], scale=1 / 255)
    covered[:] = cv2.add(background, colours[part])


def picture(design: int) -> np.ndarray:
    """Return a design that faces up, as in turtlesim/images: (SIZE, SIZE, 4) uint8, RGBA."""
    colours, background_share = _turned(design, DEGREES // 4)
    alpha = 255 - background_share[:, :, :1]
    plain = np.minimum(255, np.rint(colours * (255.0 / np.maximum(alpha, 1)))).astype(np.uint8)
    return np.concatenate([plain, alpha], axis=2)


def encode_png(frame: np.ndarray) -> bytes:
    """Return an image (RGB or RGBA) as the bytes of a PNG file."""
    swap = cv2.COLOR_RGBA2BGRA if frame.shape[2:] == (4,) else cv2.COLOR_RGB2BGR
    done, data = cv2.imencode('.png', cv2.cvtColor(frame, swap))
    if not done:
        raise ValueError(f'OpenCV cannot encode an image of shape {frame.shape} as PNG')
    return data.tobytes()
