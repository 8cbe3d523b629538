"""The compiled steps of the detector (vision/alvar_core/native), where they were built.

Each step has a twin in numpy beside its caller, which is used without them: where the package was not built by catkin,
with a camera that is not a plain Camera, and where the environment variable ALVAR_CORE_PLAIN is set. Both find the same
markers; greys between pixels, and thus corners, differ by the rounding of cv2.remap.
"""
from __future__ import annotations

import ctypes
import os
from typing import Any, Tuple

import numpy as np

from alvar_core.arrays import Floats, Image
from alvar_core.camera import Camera

NAME, FOR_AVX2 = 'libalvar_core_native.so', 'libalvar_core_native_avx2.so'  # found as others: by LD_LIBRARY_PATH
INTERFACE = 3  # to be raised with each change of what a step is given or returns: a library built before is left out
RETURN_NUMBERS = 'alvar_noise', 'alvar_coarse_fit'  # the others return whole ones or nothing
ImageArguments = Tuple[ctypes.c_void_p, ctypes.c_int64, int, int]


def _load() -> ctypes.CDLL | None:
    if os.environ.get('ALVAR_CORE_PLAIN'):
        return None
    try:
        plain = ctypes.CDLL(NAME)
        if plain.alvar_interface() != INTERFACE:
            return None
        library = ctypes.CDLL(FOR_AVX2) if plain.alvar_processor_has_avx2() else plain
        for name in RETURN_NUMBERS:
            getattr(library, name).restype = ctypes.c_double
        return library
    except (OSError, AttributeError):  # it is not there, or so old that it cannot say what it is
        return None


library = _load()


def address(array: np.ndarray[Any, Any]) -> ctypes.c_void_p:
    """Return where a C-contiguous array begins; the caller keeps the array for as long as it is used."""
    return ctypes.c_void_p(array.__array_interface__['data'][0])


def image(grey: Image) -> ImageArguments:
    """Return a grey image (height, width), uint8, as arguments: address, bytes from row to row, width, height."""
    height, width = grey.shape
    return address(grey), ctypes.c_int64(grey.strides[0]), width, height


def library_for(camera: Camera) -> tuple[ctypes.CDLL, Floats] | None:
    """Return the compiled steps and the twelve numbers of a camera's lens; None if they are not to be used for it."""
    if library is None or type(camera) is not Camera:  # a fisheye has another lens
        return None
    return library, np.concatenate([[camera.fx, camera.fy, camera.cx, camera.cy], camera.distortion])
