"""The look of the faces of solids: bricks and markers in perspective, plain colours, shaded cylinders."""
import math
from functools import partial
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel
from sim_scene import textures
from sim_scene.native import Light, Pattern, Solid
from sim_scene.response import Response

UPRIGHT, TOP_SHADE, UNDER_SHADE = 0.81, 1.0, 0.55  # brightness of upright faces on average, upper and lower ends
LIGHT = (0.16, 0.10)  # additional brightness of faces towards +x and +y
SHARPER = 0.4  # halvings by which a wall's image has a higher resolution than the camera's
FRONT = 0  # the face of a panel that shows its marker, the -x one; faces are numbered -x, +x, -y, +y of the box


class _Face(NamedTuple):
    """A patterned face: the function that returns its Mipmap, the colour of full tones, and z [m] of its lower edge."""

    mipmap: Callable[[], textures.Mipmap]
    colour: np.ndarray
    bottom: float


def shade(normal_x: textures.FloatOrArray, normal_y: textures.FloatOrArray) -> textures.FloatOrArray:
    """Return the brightness 0..1 of an upright face with this unit normal in the world; floats or arrays."""
    return UPRIGHT + LIGHT[0] * normal_x + LIGHT[1] * normal_y


def light() -> Light:
    """Return ``shade`` for the compiled scene."""
    return Light(upright=UPRIGHT, x=LIGHT[0], y=LIGHT[1])


class Faces:
    """The solids of a FloorPlan with the look of their faces; ``patterns``: False for plain colours only.

    solids: for the compiled scene, in the order of plan.solids(). Raises alvar_core's CodeError for a panel with an
    impossible marker_id.
    """

    def __init__(self, plan: FloorPlan, response: Response, patterns: bool) -> None:
        self._patterned: Dict[Tuple[int, int], _Face] = {}
        self._response, self._patterns = response, patterns
        self.solids: List[Solid] = []
        shapes = plan.solids()
        panels: List[Optional[Panel]] = [*[None] * (len(shapes) - len(plan.panels)), *plan.panels]
        for shape, panel, rank in zip(shapes, panels, _ranks(plan)):
            self.solids.append(_cylinder(shape, rank) if isinstance(shape, Cylinder) else self._box(shape, panel, rank))

    def pattern(self, solid: int, face: int, along: int, up: int) -> Pattern:
        """Return the Pattern of a face at the levels ``along`` and ``up`` of its Mipmap."""
        patterned = self._patterned[solid, face]
        mipmap = patterned.mipmap()
        _, image, per_metre_along, per_metre_up = mipmap.at(along, up)
        return Pattern(image=image, along=per_metre_along, up=per_metre_up, top=patterned.bottom + mipmap.height,
                       pad=textures.PAD, colour=patterned.colour)

    def _box(self, box: Box, panel: Optional[Panel], rank: float) -> Solid:
        cos, sin = math.cos(box.yaw), math.sin(box.yaw)
        brightness = [shade(*normal) for normal in ((-cos, -sin), (cos, sin), (sin, -cos), (-sin, cos))]
        resolution = [math.nan] * 4
        if self._patterns and panel:
            resolution[FRONT] = self._add_marker(panel)
        elif self._patterns and box.height >= textures.COURSE:
            resolution = self._add_bricks(box, brightness)
        return Solid.box(x=box.x, y=box.y, yaw=box.yaw, length=box.length, width=box.width, bottom=box.bottom,
                         height=box.height, rank=rank, sides=_shaded(box.colour, brightness), ends=_ends(box.colour),
                         resolution=resolution, steps=textures.PANEL_STEPS if panel else 1,
                         sharper=0.0 if panel else SHARPER)

    def _add_marker(self, panel: Panel) -> float:
        """Return the resolution [px/m] of a panel's pattern."""
        what = panel.marker_id, panel.size, panel.marker_size, self._response
        textures.panel(*what)  # refuses an impossible id
        self._patterned[len(self.solids), FRONT] = _Face(partial(textures.panel, *what), np.full(3, 255.0),
                                                         panel.bottom)
        return textures.PANEL_PIXELS / panel.size

    def _add_bricks(self, box: Box, brightness: Sequence[float]) -> List[float]:
        """Return the resolutions [px/m] of the patterns of a wall's four faces."""
        resolutions = []
        for face, (length, share) in enumerate(zip((box.width, box.width, box.length, box.length), brightness)):
            coarser = textures.coarser_for(length, box.height)
            tone = round(share * textures.SHADES) / textures.SHADES
            self._patterned[len(self.solids), face] = _Face(partial(textures.wall, coarser, box.bottom <= 0.0,
                                                                    self._response),
                                                            np.array(box.colour, float) * tone, box.bottom)
            resolutions.append(textures.WALL_RESOLUTION / 2 ** coarser)
        return resolutions


def _ranks(plan: FloorPlan) -> List[float]:
    """Return which of two faces in one plane is seen: that of the higher solid, and every panel."""
    solids = plan.solids()
    ranks = [0.0] * len(solids)
    for rank, index in enumerate(sorted(range(len(solids)), key=lambda k: solids[k].bottom + solids[k].height)):
        ranks[index] = rank + (len(solids) if index >= len(solids) - len(plan.panels) else 0)
    return ranks


def _cylinder(shape: Cylinder, rank: float) -> Solid:
    return Solid.cylinder(x=shape.x, y=shape.y, radius=shape.radius, bottom=shape.bottom, height=shape.height,
                          rank=rank, colour=shape.colour, ends=_ends(shape.colour))


def _ends(colour: Sequence[int]) -> np.ndarray:
    return _shaded(colour, (TOP_SHADE, UNDER_SHADE))


def _shaded(colour: Sequence[int], brightness: Sequence[float]) -> np.ndarray:
    """Return the colour with each brightness, (N, 3) uint8."""
    return textures.rounded(np.outer(brightness, colour))
