"""Array types for type hints: those of plain_support.arrays, complex numbers and images.

Docstrings state shapes, units and number types; an ``Image`` is an array of OpenCV, uint8 unless stated otherwise.
"""
from typing import TYPE_CHECKING, Any

import numpy as np

from plain_support.arrays import ArrayLike, Bools, Floats, Integers

if TYPE_CHECKING:
    from cv2.typing import MatLike as Image
    from numpy.typing import NDArray

    Complexes = NDArray[np.complexfloating[Any, Any]]
else:  # OpenCV before 4.8 has no typing
    Complexes = Image = np.ndarray

__all__ = ['ArrayLike', 'Bools', 'Complexes', 'Floats', 'Image', 'Integers']
