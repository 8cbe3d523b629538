"""Array types for type hints; the docstrings state shapes, units and number types.

``Floats`` are float32 or float64, an ``Image`` is an array of OpenCV, uint8 unless stated otherwise.
"""
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from cv2.typing import MatLike as Image
    from numpy.typing import ArrayLike, NDArray

    Complexes = NDArray[np.complexfloating[Any, Any]]
    Floats = NDArray[np.floating[Any]]
    Bools = NDArray[np.bool_]
    Integers = NDArray[np.integer[Any]]
else:  # numpy before 1.21 has no NDArray, OpenCV before 4.8 no typing
    ArrayLike = Complexes = Floats = Bools = Integers = Image = np.ndarray

__all__ = ['ArrayLike', 'Bools', 'Complexes', 'Floats', 'Image', 'Integers']
