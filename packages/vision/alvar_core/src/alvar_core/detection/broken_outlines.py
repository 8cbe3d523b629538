"""Find squares whose outline is broken, for instance by the edge of a shadow, from straight parts of outlines.

An outline that leaves a side of the square where the shadow begins still follows the rest of that side. Two straight
parts that meet at a right turn are a corner, and two corners that face each other are a square.
"""
from __future__ import annotations

import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats, Image


def distinct_parts(smooth: Image, parts: Floats) -> Floats:
    """Return those straight parts (N, 2, 2) that are dark on their right, compared with their left."""
    found: Floats = native.steps.distinct_parts(smooth=smooth, parts=parts, limit=native.limit)
    return found


def squares(parts: Floats) -> Floats:
    """Return the quads (N, 4, 2), clockwise, that straight parts (K, 2, 2) form, those with most of their rim first."""
    if len(parts) < 3:
        return np.zeros((0, 4, 2))
    quads: Floats = native.steps.squares(parts=parts, limit=native.limit)
    return quads
