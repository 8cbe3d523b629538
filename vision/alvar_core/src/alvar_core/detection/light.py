"""The light that greys stand for, and what a camera's response is.

Lenses blur light, not greys. Where greys are not proportional to light, a blurred edge lies beside the middle of its
greys: with the response of most cameras a third of a pixel on the dark side, so that squares look smaller and farther
away. Edges are therefore measured in light. The response is a power: light is grey ** gamma.

The markers themselves tell gamma: their cells are equally wide in light.
"""
from __future__ import annotations

import math
from numbers import Real
from typing import NamedTuple, Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats, Image

GAMMAS = (1.0, 4.0)  # of cameras
GAMMA_ERROR = 0.05  # of the logarithm of gamma: what one marker says is never known better
MAX_GAMMA_STEP = 1.2  # of gamma, in one image
GAMMA_MEMORY = 16 / GAMMA_ERROR ** 2  # information: what was learnt counts as 16 markers, ...
GAMMA_EVERY = 8  # ... and from then on, one of so many images is asked
LINEAR_GAMMA, LINEAR_ERRORS = 0.06, 3.0  # logarithm, standard deviations: of a smaller gamma, greys are light
SAME_GAMMA, AGAIN_GAMMA = 0.01, 0.04  # change of the logarithm: the light stays, the image is measured again
MOST_AGAIN = 3  # times


class Evidence(NamedTuple):
    """What markers say about the logarithm of gamma: ``information``, and that times the change they ask for."""

    information: float
    weighted: float


class Light:
    """What greys stand for: light is grey ** ``gamma``, from 0 to 255 as greys are."""

    def __init__(self, gamma: float) -> None:
        self.gamma, self.linear = gamma, gamma == 1
        self.steps = native.steps.Light(gamma=gamma)
        self._of_grey = self.steps.of_grey

    def of(self, grey: Image) -> Image | Floats:
        """Return the light of an image of greys."""
        if self.linear:
            return grey
        return cv2.LUT(grey, self._of_grey)

    def greys(self, light: Floats) -> Floats:
        """Return the greys that stand for light, of any shape."""
        return light if self.linear else np.interp(light, self._of_grey, np.arange(len(self._of_grey)))


LINEAR = Light(1.0)


class Response:
    """The Light of one camera: that of a known ``gamma``, or learnt from the markers in its images."""

    def __init__(self, gamma: float | None = None) -> None:
        self.light = LINEAR if gamma is None else Light(checked_gamma(gamma))
        self._known, self._gamma, self._information, self._images = gamma is not None, self.light.gamma, 0.0, 0

    @property
    def is_known(self) -> bool:
        """Return whether gamma is known, or markers have told it."""
        return self._known or self._information > 0

    def asks(self) -> bool:
        """Return whether the markers of the next image are to be asked: once much is known, those of some images."""
        self._images += 1
        settled = self._information >= GAMMA_MEMORY and self._images % GAMMA_EVERY
        return not (self._known or settled)

    def learn(self, evidence: Sequence[Evidence]) -> bool:
        """Learn from the markers of an image; return whether it is to be measured again in another Light."""
        most = GAMMA_ERROR ** -2
        shares = [(min(each.information, most), each.weighted / each.information)
                  for each in evidence if each.information > 0]
        seen = sum(information for information, _ in shares)
        if self._known or not seen:
            return False
        change = sum(information * change for information, change in shares) / seen
        # edges move by what gamma changes rather than by what its logarithm does
        asked = self.light.gamma * (1 + min(max(change, -MAX_GAMMA_STEP), MAX_GAMMA_STEP))
        low, high = GAMMAS
        total = self._information + seen
        self._gamma = min(max((self._information * self._gamma + seen * asked) / total, low), high)
        self._information = min(total, GAMMA_MEMORY)
        least = LINEAR_GAMMA + LINEAR_ERRORS / math.sqrt(total)
        gamma = self._gamma if math.log(self._gamma) > least else 1.0
        step = abs(math.log(gamma / self.light.gamma))
        if step < SAME_GAMMA:
            return False
        self.light = Light(gamma) if gamma != 1 else LINEAR
        if step < AGAIN_GAMMA:
            return False
        self._information = 0.0  # from so far away, gamma was a guess
        return True


def checked_gamma(gamma: float) -> float:
    """Return gamma as float; raise ValueError if no camera has it."""
    low, high = GAMMAS
    if isinstance(gamma, (bool, str)) or not isinstance(gamma, Real) or not low <= gamma <= high:
        raise ValueError(f'gamma {gamma!r}: a number from {low:g} to {high:g} is needed, 1 for greys that are light, '
                         'about 2.2 for most cameras')
    return float(gamma)
