"""What walls, panels and the floor look like: patterns of our own, made by rule, in all the sizes they are seen in.

Pictures are uint8 RGBA (the fourth channel only makes them faster to copy). A face's picture has its row 0 at the top
and its column 0 at the left of who stands before it.
"""
import functools
import math

import cv2
import numpy as np

from alvar_core import code

WALL_RESOLUTION = 256  # [px/m]
WALL_LENGTH, WALL_HEIGHT = 4.0, 2.0  # [m] of a picture at that resolution; for larger walls coarser ones are made
PLAIN_FROM = 5  # times halved, from which on bricks are too small to be drawn
SHADES = 32  # steps from black to a wall's own colour
BRICK_LENGTH, COURSE, MORTAR = 0.25, 0.125, 0.010  # [m] pitch of the bricks along and up, and the joint between them
DARKEST_AT_FLOOR, SHADOW_HEIGHT = 0.80, 0.10  # a wall's brightness where it meets the floor, and up to where [m]
TONES = np.random.default_rng(4).uniform(0.90, 1.0, (64, 64))  # of bricks
MORTAR_TONE = 0.74
PANEL_PIXELS = 1024  # across a panel
PANEL_STEPS = 2  # pictures of a panel until one is half as large: markers have to be exact
PAPER, INK = 250, 14  # greys of panels
MARGIN_CELLS = 2  # of a marker's black border
PAD = 4  # [px] that a picture goes on beyond its edges
TILE, GROUT, TILE_TONES = 0.5, 0.012, (1.0, 0.93)  # [m] of the floor's tiles and the joints between them
GROUT_TONE = 0.82
FLOOR_RESOLUTION = 256  # [px/m] of the finest floor picture


class Mipmap:
    """A face's picture in ever smaller sizes along and up apart, each made when first asked for.

    length, height [m] of what it shows. A picture is half as large `steps` levels on. at(along, up): (picture of these
    levels with PAD px around, px/m along, px/m up); what cannot be made smaller is left as it is.
    """

    def __init__(self, picture, length, height, steps=1):
        self.length, self.height, self._steps = length, height, steps
        self._pictures, self._padded = {(0, 0): picture}, {}

    def at(self, along, up):
        """Return the picture for these two levels, see the class."""
        found = self._padded.get((along, up))
        if found is None:
            picture = self._picture(along, up)
            padded = cv2.copyMakeBorder(picture, PAD, PAD, PAD, PAD, cv2.BORDER_REPLICATE)
            found = padded, picture.shape[1] / self.length, picture.shape[0] / self.height
            self._padded[along, up] = found
        return found

    def _picture(self, along, up):
        found = self._pictures.get((along, up))
        if found is None:
            back = min(self._steps, along or up)
            finer = self._picture(along - back, up) if along else self._picture(along, up - back)
            height, width = finer.shape[:2]
            scale = 0.5 ** (back / self._steps)
            size = (max(1, int(width * scale)), height) if along else (width, max(1, int(height * scale)))
            found = cv2.resize(finer, size, interpolation=cv2.INTER_AREA)
            self._pictures[along, up] = found
        return found


def rgba(rgb):
    """Return floats (..., 3) of 0 to 255 as uint8 RGBA."""
    out = np.full((*rgb.shape[:-1], 4), 255, np.uint8)
    out[..., :3] = np.clip(np.round(rgb), 0, 255)
    return out


def coarser_for(length, height):
    """Return how often the resolution of walls is halved so that a picture has room for length x height [m]."""
    return max(0, math.ceil(math.log2(max(length / WALL_LENGTH, height / WALL_HEIGHT))))


@functools.lru_cache(maxsize=64)
def wall(colour, shade, coarser, on_floor):
    """Return the Mipmap of a brick wall of WALL_LENGTH x WALL_HEIGHT, doubled `coarser` times; its foot is the wall's.

    colour (r, g, b) of its bricks, shade 0..1 of their brightness; on_floor: darker towards its lower edge.
    """
    tones = _tones(coarser, on_floor)
    steps = np.arange(256)[:, None] / 255.0 * shade * np.array(colour, float)
    return Mipmap(rgba(steps)[tones], WALL_LENGTH * 2 ** coarser, WALL_HEIGHT * 2 ** coarser)


@functools.lru_cache(maxsize=16)
def _tones(coarser, on_floor):
    """Return the brightness of a brick wall's picture, 0..255."""
    resolution = WALL_RESOLUTION / 2 ** coarser
    columns, rows = round(WALL_LENGTH * WALL_RESOLUTION), round(WALL_HEIGHT * WALL_RESOLUTION)
    up = (np.arange(rows, 0, -1) - 0.5) / resolution
    tone = np.full((rows, columns), TONES.mean())
    if coarser < PLAIN_FROM:
        tone = _bricks((np.arange(columns) + 0.5) / resolution, up)
    if on_floor:
        tone = tone * (DARKEST_AT_FLOOR + (1.0 - DARKEST_AT_FLOOR) * np.minimum(up / SHADOW_HEIGHT, 1.0))[:, None]
    return np.round(tone * 255).astype(np.uint8)


def _bricks(along, up):
    """Return the tone 0..1 of each point: along (columns,), up (rows,) [m]."""
    course = np.floor(up / COURSE)
    shifted = along + 0.5 * BRICK_LENGTH * (course % 2)[:, None]
    brick = np.floor(shifted / BRICK_LENGTH)
    tone = TONES[(course % 64).astype(int)[:, None], (brick % 64).astype(int)]
    joint = (up - course * COURSE < MORTAR)[:, None] | (shifted - brick * BRICK_LENGTH < MORTAR)
    return np.where(joint, MORTAR_TONE, tone)


@functools.lru_cache(maxsize=64)
def panel(marker_id, size, marker_size):
    """Return the Mipmap of a panel's face: the ALVAR marker, marker_size wide, in a white square, size wide [m].

    Edges of cells lie where they belong to a fraction of a pixel. Raises alvar_core's CodeError for an impossible id.
    """
    cells = code.encode(marker_id)
    count = len(cells) + 2 * MARGIN_CELLS
    black = np.pad(~cells, MARGIN_CELLS, constant_values=True).astype(float)
    edges = (0.5 * (size - marker_size) + np.arange(count + 1) * marker_size / count) * PANEL_PIXELS / size
    before = np.clip(np.arange(PANEL_PIXELS + 1)[:, None] - edges[:-1], 0.0, np.diff(edges))
    share = np.diff(before, axis=0)  # (px, cells): how much of a pixel lies in a cell
    grey = PAPER + (INK - PAPER) * (share @ black @ share.T)
    return Mipmap(rgba(np.repeat(grey[..., None], 3, axis=2)), size, size, PANEL_STEPS)


@functools.lru_cache(maxsize=32)
def floor(colour, halved, reach):
    """Return the RGBA picture of the floor around a crossing of its tiles' joints, `reach` [m] to each side.

    FLOOR_RESOLUTION / 2**halved px/m; column 0 at the smallest x, row 0 at the smallest y.
    """
    resolution = FLOOR_RESOLUTION / 2 ** halved
    fine = 2 ** min(halved, 3)  # parts of a pixel that are averaged
    place = (np.arange(2 * round(reach * resolution) * fine) + 0.5) / (resolution * fine) - reach
    joint = np.abs((place + 0.5 * TILE) % TILE - 0.5 * TILE) < 0.5 * GROUT
    odd = np.floor(place / TILE).astype(int) % 2
    grout = _averaged(joint, fine)
    odd = _averaged(odd, fine)
    tone = TILE_TONES[0] + (TILE_TONES[1] - TILE_TONES[0]) * np.abs(odd[:, None] - odd)
    grout = 1.0 - (1.0 - grout[:, None]) * (1.0 - grout)
    return rgba((tone + (GROUT_TONE - tone) * grout)[..., None] * np.array(colour, float))


def _averaged(values, fine):
    return values.reshape(-1, fine).mean(1)


def floor_mean(colour):
    """Return the mean colour (3,) of the floor's pattern."""
    share = 1.0 - (1.0 - GROUT / TILE) ** 2
    return np.array(colour, float) * (GROUT_TONE * share + (1.0 - share) * sum(TILE_TONES) / 2)
