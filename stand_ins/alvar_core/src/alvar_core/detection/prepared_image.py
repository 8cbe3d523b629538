"""A picture prepared for search."""
from functools import cached_property

import cv2
import numpy as np

from alvar_core.camera import CameraError
from alvar_core.detection import alignment, candidates

SMALLEST = 16  # px


class PictureError(ValueError):
    """A picture that cannot be searched."""


def grey_picture(picture):
    """uint8 grey picture from uint8 or uint16, grey, BGR or BGRA; PictureError for anything else."""
    if not isinstance(picture, np.ndarray) or picture.ndim not in (2, 3) or min(picture.shape[:2]) < SMALLEST:
        got = getattr(picture, 'shape', type(picture).__name__)
        raise PictureError(f'a picture of at least {SMALLEST}x{SMALLEST} pixels is needed, got {got}')
    if picture.dtype == np.uint16:
        picture = (picture >> 8).astype(np.uint8)
    if picture.dtype != np.uint8:
        raise PictureError(f'a picture of type uint8 or uint16 is needed, got {picture.dtype}')
    if picture.ndim == 2:
        return np.ascontiguousarray(picture)
    if picture.shape[2] == 1:
        return np.ascontiguousarray(picture[:, :, 0])
    if picture.shape[2] not in (3, 4):
        raise PictureError(f'a picture with 1, 3 or 4 channels is needed, got {picture.shape[2]}')
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY if picture.shape[2] == 3 else cv2.COLOR_BGRA2GRAY)


class View:
    """A picture prepared for search: grey, lightly smoothed, camera; the pyramid is made when first needed.

    Raises PictureError, CameraError.
    """

    def __init__(self, picture, camera, workspace=None):
        if not hasattr(camera, 'to_real'):
            raise CameraError(f'a Camera is needed to search a picture, got {type(camera).__name__}')
        self.grey, self.camera = grey_picture(picture), camera
        size = getattr(camera, 'size', None)
        if size and size != self.grey.shape[::-1]:
            raise PictureError('the picture has {}x{} pixels, but the camera is calibrated for {}x{}: calibrate it for '
                               'this size, or switch it to that one'.format(*self.grey.shape[::-1], *size))
        self.workspace = workspace or candidates.Workspace()
        self.smooth = cv2.GaussianBlur(self.grey, (3, 3), 0, dst=self.workspace.picture('smooth', *self.grey.shape))

    @cached_property
    def noise(self):
        """Standard deviation of the picture's noise, grey levels."""
        return noise_of(self.grey)

    @cached_property
    def pyramid(self):
        """The picture in three sizes (alignment.Pyramid)."""
        height, width = self.grey.shape
        return alignment.Pyramid(self.grey, self.workspace.picture('atlas', height + height // 2, width))


def noise_of(grey):
    """Standard deviation of the noise of a grey picture, from its second differences along some rows."""
    rows = grey[4::max(1, len(grey) // 12)].astype(np.int16)
    second = np.abs(2 * rows[:, 1:-1] - rows[:, :-2] - rows[:, 2:]).ravel()
    share = np.bincount(second).cumsum() / second.size
    return np.interp(0.5, share, np.arange(len(share)) + 0.5) / (0.6745 * np.sqrt(6))
