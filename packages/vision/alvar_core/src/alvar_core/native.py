"""The compiled steps of the detector (native/ of this package; documented in _native.pyi), and their thresholds.

They are built by catkin and by pip. On a processor with AVX2 and FMA, those that use them are loaded.
"""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import cv2

from alvar_core.detection import thresholds

__all__ = ['limit', 'steps']

AVX2, FMA3 = 11, 12  # of cv2.checkHardwareSupport; OpenCV 5 has no names for them


def _load() -> Any:
    names = ['alvar_core._native']
    if cv2.checkHardwareSupport(AVX2) and cv2.checkHardwareSupport(FMA3):
        names.insert(0, 'alvar_core._native_avx2')
    errors = []
    for name in names:
        try:
            return importlib.import_module(name)
        except ImportError as error:
            errors.append(str(error))
    raise ImportError('alvar_core needs its compiled steps, and they are missing or belong to another Python: '
                      f'{"; ".join(errors)}. In the course, type: ./run build. '
                      'Without it, type: python3 -m pip install packages/vision/alvar_core')


if TYPE_CHECKING:
    from alvar_core import _native as steps
else:
    steps = _load()
limit = steps.Thresholds(thresholds)
