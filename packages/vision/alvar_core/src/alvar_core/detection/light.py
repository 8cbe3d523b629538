"""The response of a camera: how much light each grey stands for.

Lenses blur light, not greys. If greys are not proportional to light, the middle grey of a blurred edge is not at the
edge: with the response of most cameras, it lies a third of a pixel on the dark side, so that squares look smaller and
farther away. Edges are therefore measured in light. The response is a power: light is grey ** gamma.

Gamma is learnt from the markers: measured in light, all their cells are equally wide.
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
GAMMA_ERROR = 0.05  # of the logarithm of gamma: one marker never measures it better
MAX_GAMMA_STEP = 1.2  # of gamma, in one image
GAMMA_MEMORY = 16 / GAMMA_ERROR ** 2  # information: all markers so far count as 16, ...
GAMMA_EVERY = 8  # ... and from then on, only one of so many images is used
LINEAR_GAMMA, LINEAR_ERRORS = 0.06, 3.0  # logarithm, standard deviations: of a smaller gamma, greys are light
SAME_GAMMA, AGAIN_GAMMA = 0.01, 0.04  # change of the logarithm: keep the light up to here; measure again from here
MOST_AGAIN = 3  # times


class Evidence(NamedTuple):
    """A measurement of the logarithm of gamma by markers: ``information``, and information times the change."""

    information: float
    weighted: float


class Light:
    """The light that greys stand for: grey ** ``gamma``, scaled from 0 to 255 like greys."""

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
        """Return whether gamma is given, or learnt."""
        return self._known or self._information > 0

    def asks(self) -> bool:
        """Return whether to learn from the markers of the next image; once much is known, only some images are used."""
        self._images += 1
        settled = self._information >= GAMMA_MEMORY and self._images % GAMMA_EVERY
        return not (self._known or settled)

    def learn(self, evidence: Sequence[Evidence]) -> bool:
        """Learn from the markers of an image; return whether to measure the image again in another Light."""
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
    """Return gamma as float; raise ValueError if it is out of range."""
    low, high = GAMMAS
    if isinstance(gamma, (bool, str)) or not isinstance(gamma, Real) or not low <= gamma <= high:
        raise ValueError(f'gamma {gamma!r}: a number from {low:g} to {high:g} is needed, 1 for greys that are light, '
                         'about 2.2 for most cameras')
    return float(gamma)
