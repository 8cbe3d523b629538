"""Remove the shadows of blinds or a fence from an image: along each stripe, the light is the same.

Such shadows cut the outlines of markers to pieces and put their own edges across the cells. But they are parallel, and
dark pixels along a stripe are print, not shadow: the light at a pixel is that of the brighter ones before and after it
on the same stripe. Divided by the light, the image looks as if it had been lit evenly.
"""
from __future__ import annotations

import math

import cv2
import numpy as np

from alvar_core.arrays import Floats, Image
from alvar_core.detection import thresholds


def stripe_angle(parts: Floats, diagonal: float) -> float | None:
    """Return the angle [rad] of the stripes with edges at straight parts (N, 2, 2); None if most are no such edges.

    ``diagonal`` [px]: of the image.
    """
    step = parts[:, 1] - parts[:, 0]
    way = step[:, 0] + 1j * step[:, 1]
    length = np.abs(way)
    # of twice the angle both edges of a stripe have the same, and the sides of a square cancel each other
    double = way * way / np.maximum(length, 1e-9)
    total = double.sum()
    if abs(total) < max(thresholds.MIN_STRIPES * diagonal, thresholds.MIN_STRIPED * length.sum()):
        return None
    for similar in thresholds.SAME_STRIPES:
        near = (double * (total / abs(total)).conjugate()).real >= similar * length
        if not near.any():
            break
        total = double[near].sum()
    return math.atan2(total.imag, total.real) / 2


def without_stripes(grey: Image, angle: float) -> Image:
    """Return a grey image (height, width), uint8, as if its stripes at an angle [rad] were not there."""
    height, width = grey.shape
    longer = max(grey.shape)
    scale = min(1.0, thresholds.MAX_STRIPED_SIDE / longer)
    size = math.ceil(scale * math.hypot(height, width))
    turn = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), math.degrees(angle), scale)
    turn[:, 2] += (size - width) / 2, (size - height) / 2
    along = cv2.warpAffine(grey, turn, (size, size))  # with level stripes
    along = cv2.blur(along, (thresholds.STRIPE_BLUR, 1))
    # closing raises dark pixels to the darker one of their two sides
    reach = np.ones((1, 1 + 2 * round(thresholds.STRIPE_REACH * scale * longer)), np.uint8)
    light = cv2.morphologyEx(along, cv2.MORPH_CLOSE, reach)
    light = cv2.warpAffine(light, turn, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    return cv2.divide(grey, light, scale=thresholds.EVEN_WHITE)
