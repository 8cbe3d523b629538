"""An image prepared for the search: grey, lightly smoothed, in three sizes."""
from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Image
from alvar_core.camera import Camera, CameraError
from alvar_core.detection.light import LINEAR, Light
from alvar_core.detection.pyramid import Pyramid

if TYPE_CHECKING:
    from alvar_core.detection.detection import Detection

MIN_IMAGE_SIDE = 16  # px


class ImageError(ValueError):
    """An image cannot be searched."""


def grey_image(image: Image) -> Image:
    """Return the grey image, uint8, of a uint8 or uint16 image in grey, BGR or BGRA; raise ImageError for others."""
    if not isinstance(image, np.ndarray) or image.ndim not in (2, 3) or min(image.shape[:2]) < MIN_IMAGE_SIDE:
        got = getattr(image, 'shape', type(image).__name__)
        raise ImageError(f'an image of at least {MIN_IMAGE_SIDE}x{MIN_IMAGE_SIDE} pixels is needed, got {got}')
    if image.dtype == np.uint16:
        image = np.right_shift(image, 8).astype(np.uint8)
    if image.dtype != np.uint8:
        raise ImageError(f'an image of type uint8 or uint16 is needed, got {image.dtype}')
    if image.ndim == 2:
        return np.ascontiguousarray(image)
    if image.shape[2] == 1:
        return np.ascontiguousarray(image[:, :, 0])
    if image.shape[2] not in (3, 4):
        raise ImageError(f'an image with 1, 3 or 4 channels is needed, got {image.shape[2]}')
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY if image.shape[2] == 3 else cv2.COLOR_BGRA2GRAY)


class ImageBuffers:
    """Images that are reused in every frame, because allocating them would take longer than filling them."""

    MOST = 24

    def __init__(self) -> None:
        self._kept: dict[tuple[str, int, int], Image] = {}

    def get(self, name: str, height: int, width: int) -> Image:
        """Return a uint8 image (height, width) with arbitrary content; the same one for the same name and size."""
        key = name, height, width
        if key not in self._kept:
            if len(self._kept) > self.MOST:
                self._kept.clear()
            self._kept[key] = np.empty((height, width), np.uint8)
        return self._kept[key]


class PreparedImage:
    """An image prepared for the search: ``grey`` and ``smooth`` (height, width) uint8, and its ``camera``.

    ``light``: the Light of its greys. ``stripes`` [rad]: angle of the stripes of light on it, if it is known;
    ``before``: the Detections of the image before it that are tracked. A PreparedImage is valid until the buffers are
    used for the next image. The constructor raises ImageError or CameraError.
    """

    stripes: float | None = None
    before: Sequence[Detection] = ()

    def __init__(self, image: Image, camera: Camera, buffers: ImageBuffers | None = None,
                 light: Light = LINEAR) -> None:
        if not isinstance(camera, Camera):
            raise CameraError(f'a Camera is needed to search an image, got {type(camera).__name__}')
        self.grey, self.camera, self.light = grey_image(image), camera, light
        height, width = self.grey.shape
        if camera.size and camera.size != (width, height):
            raise ImageError('the image has {}x{} pixels, but the camera is calibrated for {}x{}: calibrate it for '
                             'this size, or switch it to that one'.format(width, height, *camera.size))
        self.buffers = buffers or ImageBuffers()
        self.smooth = cv2.GaussianBlur(self.grey, (3, 3), 0, dst=self.buffers.get('smooth', height, width))

    @cached_property
    def noise(self) -> float:
        """Return the standard deviation of the image's noise [greys]."""
        return noise_of(self.grey)

    def relight(self, light: Light) -> None:
        """Use another Light for the greys."""
        self.light = light
        self.__dict__.pop('pyramid', None)

    @cached_property
    def pyramid(self) -> Pyramid:
        """Return the image in three sizes; it is computed when first needed."""
        height, width = self.grey.shape
        return Pyramid(self.grey, self.buffers.get('atlas', height + height // 2, width), self.light)


def noise_of(grey: Image) -> float:
    """Return the standard deviation of a grey image's noise, from second differences along some rows."""
    return float(native.steps.noise_of(grey))
