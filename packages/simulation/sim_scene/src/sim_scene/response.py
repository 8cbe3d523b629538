"""The response of a camera: how much light the values of its pictures stand for.

Light is value ** gamma, both from 0 to 255. What is blended, such as the pattern of a far wall, is blended in light.
"""
import functools
from typing import Any, Tuple

import cv2
import numpy as np

from sim_scene import native

FloatOrArray = Any  # a float or an array
STEPS = 256  # of light, from 0 to 255, in the tables of the compiled steps


class Response:
    """The response of a camera with this ``gamma``; with 1, values are light, and stay as they are.

    compiled: its tables, for a Scene.
    """

    def __init__(self, gamma: float) -> None:
        self._gamma, values = gamma, np.arange(256)
        steps = np.round(self.light(values) * STEPS).astype(int)
        rising = np.maximum.accumulate(steps - values) + values  # so that no two values have the same light
        self._steps = rising.astype(np.uint16)
        self._nearest = np.round(np.interp(np.arange(rising[-1] + 1), rising, values)).astype(np.uint8)
        self.compiled = native.Response(light=rising)

    def light(self, values: FloatOrArray) -> FloatOrArray:
        """Return the light of values."""
        return values if self._gamma == 1.0 else 255.0 * (values / 255.0) ** self._gamma

    def values(self, light: FloatOrArray) -> FloatOrArray:
        """Return the values that show this light."""
        return light if self._gamma == 1.0 else 255.0 * (light / 255.0) ** (1.0 / self._gamma)

    def smaller(self, tones: np.ndarray, size: Tuple[int, int]) -> np.ndarray:
        """Return an image (rows, columns) uint8 in a smaller size (columns, rows)."""
        if self._gamma == 1.0:
            return cv2.resize(tones, size, interpolation=cv2.INTER_AREA)
        found: np.ndarray = self._nearest[cv2.resize(self._steps[tones], size, interpolation=cv2.INTER_AREA)]
        return found

    def image(self, tones: np.ndarray) -> native.Image:
        """Return an image (rows, columns) uint8 for the compiled steps."""
        return native.Image(tones=tones, response=self.compiled)


@functools.lru_cache(maxsize=4)
def response_of(gamma: float) -> Response:
    """Return the Response with this gamma: one for all renderers, so that they share the images of patterns."""
    return Response(gamma)
