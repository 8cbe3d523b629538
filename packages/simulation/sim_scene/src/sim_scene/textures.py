"""Textures of walls, panels and the floor: our own patterns, computed in all sizes that are needed.

Images are tones, uint8 arrays (rows, columns): 255 is the full colour of a wall, a panel or the floor. In the image of
a face, row 0 is at the top, and column 0 is on the left of a viewer in front of it.
"""
import functools
import math
from typing import Any, Dict, NamedTuple, Tuple

import cv2
import numpy as np

from alvar_core import code
from sim_scene.native import Image
from sim_scene.response import Response

FloatOrArray = Any  # a float or an array of floats

WALL_RESOLUTION = 256  # [px/m]
WALL_LENGTH, WALL_HEIGHT = 4.0, 2.0  # [m] of an image at that resolution; larger walls get coarser ones
PLAIN_FROM = 5  # halvings from which on bricks are too small to be drawn
SHADES = 32  # steps from black to a wall's own colour
BRICK_LENGTH, COURSE, MORTAR = 0.25, 0.125, 0.010  # [m] pitch of the bricks along and up, and the joint between them
DARKEST_AT_FLOOR, SHADOW_HEIGHT = 0.80, 0.10  # a wall's brightness at the floor, and the height [m] of that shadow
TONES = np.random.default_rng(4).uniform(0.90, 1.0, (64, 64))  # of bricks
MORTAR_TONE = 0.74
PANEL_PIXELS = 1024  # across a panel
PANEL_STEPS = 2  # images of a panel per halving, because markers have to be accurate
PAPER, INK = 250, 14  # grey levels of panels
MARGIN_CELLS = 2  # of a marker's black border
PAD = 4  # [px] by which an image is extended beyond its edges
TILE, GROUT, TILE_TONES = 0.5, 0.012, (1.0, 0.93)  # [m] of the floor's tiles and the joints between them
GROUT_TONE = 0.82
PERIOD = 2 * TILE  # [m] after which the floor repeats
FLOOR_RESOLUTION = 256  # [px/m] of the finest floor image


class PaddedImage(NamedTuple):
    """An image with PAD px around, the same for the compiled steps, and its resolution along and up [px/m]."""

    tones: np.ndarray
    image: Image
    along: float
    up: float


class Mipmap:
    """A face's image in smaller and smaller sizes, in both directions independently; each is made when first needed.

    ``image`` (rows, columns); ``length``, ``height`` [m] are those of the face. ``steps`` levels halve the size.
    """

    def __init__(self, image: np.ndarray, response: Response, length: float, height: float, steps: int = 1) -> None:
        self.length, self.height, self._response, self._steps = length, height, response, steps
        self._images: Dict[Tuple[int, int], np.ndarray] = {(0, 0): image}
        self._padded: Dict[Tuple[int, int], PaddedImage] = {}

    def at(self, along: int, up: int) -> PaddedImage:
        """Return the image at these two levels; a side of one pixel is not reduced further."""
        found = self._padded.get((along, up))
        if found is None:
            image = self._image(along, up)
            padded = cv2.copyMakeBorder(image, PAD, PAD, PAD, PAD, cv2.BORDER_REPLICATE)
            found = PaddedImage(padded, self._response.image(padded), image.shape[1] / self.length,
                                image.shape[0] / self.height)
            self._padded[along, up] = found
        return found

    def _image(self, along: int, up: int) -> np.ndarray:
        found = self._images.get((along, up))
        if found is None:
            back = min(self._steps, along or up)
            finer = self._image(along - back, up) if along else self._image(along, up - back)
            height, width = finer.shape[:2]
            scale = 0.5 ** (back / self._steps)
            size = (max(1, int(width * scale)), height) if along else (width, max(1, int(height * scale)))
            found = self._response.smaller(finer, size)
            self._images[along, up] = found
        return found


def rounded(values: np.ndarray) -> np.ndarray:
    """Return floats as uint8, clipped to 0..255."""
    whole: np.ndarray = np.clip(np.round(values), 0, 255).astype(np.uint8)
    return whole


def coarser_for(length: float, height: float) -> int:
    """Return how often the resolution of walls is halved until ``length`` x ``height`` [m] fit into an image."""
    return max(0, math.ceil(math.log2(max(length / WALL_LENGTH, height / WALL_HEIGHT))))


@functools.lru_cache(maxsize=16)
def wall(coarser: int, on_floor: bool, response: Response) -> Mipmap:
    """Return the Mipmap of a brick wall of WALL_LENGTH x WALL_HEIGHT, doubled ``coarser`` times, from its foot upwards.

    on_floor: darker towards its lower edge.
    """
    resolution = WALL_RESOLUTION / 2 ** coarser
    columns, rows = round(WALL_LENGTH * WALL_RESOLUTION), round(WALL_HEIGHT * WALL_RESOLUTION)
    up = (np.arange(rows, 0, -1) - 0.5) / resolution
    tone = np.full((rows, columns), TONES.mean())
    if coarser < PLAIN_FROM:
        tone = _bricks((np.arange(columns) + 0.5) / resolution, up)
    if on_floor:
        tone = tone * (DARKEST_AT_FLOOR + (1.0 - DARKEST_AT_FLOOR) * np.minimum(up / SHADOW_HEIGHT, 1.0))[:, None]
    return Mipmap(rounded(tone * 255), response, WALL_LENGTH * 2 ** coarser, WALL_HEIGHT * 2 ** coarser)


def _bricks(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the tone 0..1 (rows, columns) of each point: along (columns,), up (rows,) [m]."""
    course = np.floor(up / COURSE)
    shifted = along + 0.5 * BRICK_LENGTH * (course % 2)[:, None]
    brick = np.floor(shifted / BRICK_LENGTH)
    tone = TONES[(course % 64).astype(int)[:, None], (brick % 64).astype(int)]
    joint = (up - course * COURSE < MORTAR)[:, None] | (shifted - brick * BRICK_LENGTH < MORTAR)
    return np.where(joint, MORTAR_TONE, tone)


@functools.lru_cache(maxsize=64)
def panel(marker_id: int, size: float, marker_size: float, response: Response) -> Mipmap:
    """Return the Mipmap of a panel's face: an ALVAR marker, marker_size [m] wide, in a white square, size [m] wide.

    Edges of cells have subpixel accuracy. Raises alvar_core's CodeError for an impossible id.
    """
    cells = code.encode(marker_id)
    count = len(cells) + 2 * MARGIN_CELLS
    black = np.pad(~cells, MARGIN_CELLS, constant_values=True).astype(float)
    edges = (0.5 * (size - marker_size) + np.arange(count + 1) * marker_size / count) * PANEL_PIXELS / size
    before = np.clip(np.arange(PANEL_PIXELS + 1)[:, None] - edges[:-1], 0.0, np.diff(edges))
    share = np.diff(before, axis=0)  # (px, cells): how much of a pixel lies in a cell
    paper, ink = response.light(PAPER), response.light(INK)
    tones = response.values(paper + (ink - paper) * (share @ black @ share.T))
    return Mipmap(rounded(tones), response, size, size, PANEL_STEPS)


@functools.lru_cache(maxsize=8)
def floor(halved: int, response: Response) -> np.ndarray:
    """Return one period of the floor's tones, and then its first row and column once more.

    FLOOR_RESOLUTION / 2**halved px/m; column 0 at the smallest x, row 0 at the smallest y.
    """
    resolution = FLOOR_RESOLUTION / 2 ** halved
    fine: int = 2 ** min(halved, 3)  # parts of a pixel that are averaged
    position = (np.arange(round(PERIOD * resolution) * fine) + 0.5) / (resolution * fine)
    joint = np.abs((position + 0.5 * TILE) % TILE - 0.5 * TILE) < 0.5 * GROUT
    grout, odd = _averaged(joint, fine), _averaged(np.floor(position / TILE).astype(int) % 2, fine)
    grout = 1.0 - (1.0 - grout[:, None]) * (1.0 - grout)
    return np.pad(rounded(_tiles(np.abs(odd[:, None] - odd), grout, response)), (0, 1), mode='wrap')


def _averaged(values: np.ndarray, fine: int) -> np.ndarray:
    means: np.ndarray = values.reshape(-1, fine).mean(1)
    return means


def floor_mean(colour: np.ndarray, response: Response) -> np.ndarray:
    """Return the mean colour (3,), floats 0..255, of the pattern of a floor of this colour."""
    mean: np.ndarray = colour * _tiles(0.5, 1.0 - (1.0 - GROUT / TILE) ** 2, response) / 255
    return mean


def _tiles(odd: FloatOrArray, grout: FloatOrArray, response: Response) -> FloatOrArray:
    """Return the tone 0..255 of a place of the floor with these shares of the second kind of tile, and of joints."""
    first, second, joint = (response.light(255 * tone) for tone in (*TILE_TONES, GROUT_TONE))
    light = first + (second - first) * odd
    return response.values(light + (joint - light) * grout)
