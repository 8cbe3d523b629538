"""The compiled steps of the renderer: native/module.cpp.

Lengths in metres, angles in radians, colours 0 to 255 (red, green, blue). Raises ValueError for arrays of another shape
and TypeError for arguments of another type.
"""
from typing import Callable, Sequence

import numpy as np

class Camera:
    """A camera of width x height [px]; focal, cx, cy [px]; nothing nearer than ``near`` is seen."""
    def __init__(self, *, width: int, height: int, focal: float, cx: float, cy: float, near: float) -> None: ...

class Pose:
    """The camera's position, and the yaw of its level optical axis."""
    def __init__(self, x: float, y: float, z: float, yaw: float) -> None: ...

class Solid:
    """A box or a cylinder. Of faces in one plane, that of the highest ``rank`` is seen.

    ends (2, 3): colours of the upper and lower end. Of a box: sides (4, 3): colours of its own -x, +x, -y, +y faces;
    resolution [px/m] of their patterns, NaN: the plain colour; ``steps`` levels of a pattern halve its image, which is
    taken ``sharper`` halvings finer than the camera's pixels. Of a cylinder: colour: that of its side, without shade.
    """
    @staticmethod
    def box(*, x: float, y: float, yaw: float, length: float, width: float, bottom: float, height: float, rank: float,
            sides: np.ndarray, ends: np.ndarray, resolution: Sequence[float], steps: int, sharper: float) -> Solid: ...
    @staticmethod
    def cylinder(*, x: float, y: float, radius: float, bottom: float, height: float, rank: float,
                 colour: Sequence[float], ends: np.ndarray) -> Solid: ...

class Response:
    """The camera's response, in which tones and colours are blended.

    light (256,): that of each value of a picture, 0 for value 0, 65280 for 255, rising; 256 * value: linear.
    """
    def __init__(self, *, light: np.ndarray) -> None: ...

class Image:
    """An image of tones (rows, columns) uint8, seen by a camera with this response."""
    def __init__(self, *, tones: np.ndarray, response: Response) -> None: ...

class Pattern:
    """The image of a face: its tones are those of ``colour``; with ``pad`` px around.

    along, up: its resolution [px/m]; top: z of its upper edge; column 0 is on the left of a viewer in front of it.
    """
    def __init__(self, *, image: Image, along: float, up: float, top: float, pad: float,
                 colour: np.ndarray) -> None: ...

class Background:
    """Sky and floor: rows (height, 3): the colour of each row of the picture without the floor's pattern.

    floor: images of its tones, each half as fine as the previous one: one ``period`` of 2**n px, and one row and column
    more; sharpness: their pixels per pixel of the camera.
    """
    def __init__(self, *, rows: np.ndarray, floor: Sequence[Image], colour: np.ndarray, period: float,
                 sharpness: float) -> None: ...

class Light:
    """The brightness of an upright face: upright + x * normal_x + y * normal_y."""
    def __init__(self, *, upright: float, x: float, y: float) -> None: ...

class Scene:
    """The view of one camera in one world; only one thread at a time may use it.

    pattern(solid=, face=, along=, up=): returns the Pattern of a face, 0 to 3, at two levels of its image.
    """
    def __init__(self, *, camera: Camera, solids: Sequence[Solid], background: Background, light: Light,
                 response: Response, pattern: Callable[..., Pattern]) -> None: ...
    def picture(self, pose: Pose, *, bgr: bool) -> np.ndarray:
        """Return the picture (height, width, 3) uint8, RGB or BGR."""
    def depth(self, pose: Pose, *, near: float, far: float) -> np.ndarray:
        """Return the depths (height, width) float32 along the optical axis, NaN unless between near and far."""
