"""Array types for type hints; the docstrings state shapes, units and number types. ``Floats``: float32 or float64."""
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[Any]
    Floats = NDArray[np.floating[Any]]
    Bools = NDArray[np.bool_]
    Integers = NDArray[np.integer[Any]]
else:  # numpy before 1.21 has no NDArray
    Array = ArrayLike = Floats = Bools = Integers = np.ndarray

__all__ = ['Array', 'ArrayLike', 'Bools', 'Floats', 'Integers']
