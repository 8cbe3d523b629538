"""Make sheets of markers to print (PDF): true sizes, a label below each marker, cut lines, and a ruler.

Lengths on a page are in millimetres, x to the right and y down from the top left corner.
"""
from __future__ import annotations

import io
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence, Tuple

from alvar_core import bundles
from alvar_core.printing import marker_files
from alvar_core.printing.marker_files import PAGES, CreateError, File, Marker

if TYPE_CHECKING:
    import cairo

Box = Tuple[float, float, float, float]  # left, top, right, bottom, mm

EDGE, FOOT = 12.0, 22.0  # [mm] edge that printers leave white, space for the ruler at the bottom
LABEL, GAP = 4.0, 4.0  # [mm] height of a label, gap between markers
RULER = 100  # [mm]
TICKS = (10, 5.0), (5, 3.5), (1, 2.0)  # [mm] distance and length of the ruler's ticks
POINTS = 72 / 25.4  # points, the unit of PDF, per mm
GREY = 0.55


@dataclass(frozen=True)
class Spot:
    """A marker on a page; ``x``, ``y`` [mm]: top left corner of its black square; ``labelled``: it has a label."""

    marker: Marker
    x: float
    y: float
    labelled: bool = True

    @property
    def side(self) -> float:
        """Return the side [mm] of the black square."""
        return 1e3 * self.marker.side

    @property
    def white(self) -> float:
        """Return the width [mm] of the paper that must stay white around it: one cell."""
        return white_of(self.marker)

    @property
    def box(self) -> Box:
        """Return the box of its paper, including the label."""
        return (self.x - self.white, self.y - self.white, self.x + self.side + self.white,
                self.y + self.side + self.white + LABEL)


def white_of(marker: Marker) -> float:
    """Return the width [mm] of one cell of a marker."""
    return 1e3 * marker.side / marker.count


def room_of(page: str) -> tuple[float, float]:
    """Return the usable width and height [mm] of a page."""
    return PAGES[page][0] - 2 * EDGE, PAGES[page][1] - EDGE - FOOT - EDGE


def spread(markers: Sequence[Marker], page: str) -> list[list[Spot]]:
    """Return the pages with the markers in rows, in their order; raise CreateError."""
    width, height = room_of(page)
    pages: list[list[Spot]] = [[]]
    x, y, row = 0.0, 0.0, 0.0
    for marker in markers:
        white = white_of(marker)
        wide = 1e3 * marker.side + 2 * white
        high = wide + LABEL
        if wide > width or high > height:
            side = 1e3 * marker.side
            most = int(min(width, height - LABEL) * side / wide)
            raise CreateError(f'marker {marker.value}: its {side:.4g} mm with the white margin are too large for page '
                              f'{page}; up to {most} mm are possible')
        if x + wide > width:
            x, y, row = 0.0, y + row + GAP, 0.0
        if y + high > height:
            pages.append([])
            x, y, row = 0.0, 0.0, 0.0
        pages[-1].append(Spot(marker, EDGE + x + white, EDGE + y + white))
        x, row = x + wide + GAP, max(row, high)
    return pages


def arranged(markers: Sequence[Marker], page: str) -> list[Spot]:
    """Return the page of a bundle, with the markers at their positions; raise CreateError."""
    spots = [Spot(m, 1e3 * (m.centre[0] - m.side / 2), 1e3 * (-m.centre[1] - m.side / 2)) for m in markers]
    left, top = (min(spot.box[k] for spot in spots) for k in (0, 1))
    wide, high = max(spot.box[2] for spot in spots) - left, max(spot.box[3] for spot in spots) - top
    width, height = room_of(page)
    if wide > width or high > height:
        raise CreateError(f'the bundle is {wide:.4g} x {high:.4g} mm with the white margin, more than the {width:.4g} '
                          f'x {height:.4g} mm of page {page}; make it smaller (-s, -xy), or print its markers one by '
                          'one')
    move_x, move_y = EDGE + (width - wide) / 2 - left, EDGE + (height - high) / 2 - top
    return [Spot(spot.marker, spot.x + move_x, spot.y + move_y, not any(_in_the_way(spot, o) for o in spots))
            for spot in spots]


def _in_the_way(spot: Spot, other: Spot) -> bool:
    """Return whether a marker's label would cover the white edge of another marker."""
    left, _, right, bottom = spot.box
    return (other is not spot and other.box[0] < right and other.box[2] > left
            and other.box[1] < bottom and other.box[3] - LABEL > bottom - LABEL)


def files(markers: Sequence[Marker], path: str, page: str) -> list[File]:
    """Return the PDF file and, for a bundle, its XML file; raise CreateError."""
    if not marker_files.is_bundle(markers):
        return [(path, pdf(spread(markers, page), page))]
    markers = marker_files.placed(markers)
    marker_files.check_places(markers)
    made = [(path, pdf([arranged(markers, page)], page, cut_each=False))]
    corners = marker_files.bundle_corners(markers)
    if len(corners) > 1:
        made.append((f'{os.path.splitext(path)[0]}.xml', bundles.xml(corners).encode()))
    return made


def pdf(pages: Sequence[Sequence[Spot]], page: str, cut_each: bool = True) -> bytes:
    """Return the bytes of a PDF; ``cut_each``: draw cut lines around each marker, else around all of them."""
    try:
        import cairo
    except ImportError:
        raise CreateError('a PDF needs the Python package cairo; on Debian and Ubuntu: sudo apt-get install '
                          'python3-cairo') from None
    data = io.BytesIO()
    with cairo.PDFSurface(data, *(POINTS * length for length in PAGES[page])) as surface:
        surface.set_metadata(cairo.PDFMetadata.TITLE, 'ALVAR markers')
        for number, spots in enumerate(pages, 1):
            context = cairo.Context(surface)
            context.scale(POINTS, POINTS)
            for box in [spot.box for spot in spots] if cut_each else [_around(spots)]:
                _cut_line(context, box)
            for spot in spots:
                _marker(context, spot)
            _ruler(context, page, f'page {number} of {len(pages)}' if len(pages) > 1 else '')
            context.show_page()
    return data.getvalue()


def _around(spots: Sequence[Spot]) -> Box:
    return (min(s.box[0] for s in spots), min(s.box[1] for s in spots), max(s.box[2] for s in spots),
            max(s.box[3] for s in spots))


def _cut_line(context: cairo.Context, box: Box) -> None:
    left, top, right, bottom = box
    context.set_source_rgb(GREY, GREY, GREY)
    context.set_line_width(0.15)
    context.set_dash([1.5, 1.5])
    context.rectangle(left, top, right - left, bottom - top)
    context.stroke()
    context.set_dash([])


def _marker(context: cairo.Context, spot: Spot) -> None:
    """Draw the black square, then all white cells as one path, so that there are no seams between them."""
    context.set_source_rgb(0, 0, 0)
    context.rectangle(spot.x, spot.y, spot.side, spot.side)
    context.fill()
    context.set_source_rgb(1, 1, 1)
    cell = spot.side / spot.marker.count
    for row, cells in enumerate(spot.marker.black):
        for column in (~cells).nonzero()[0]:
            context.rectangle(spot.x + column * cell, spot.y + row * cell, cell, cell)
    context.fill()
    if spot.labelled:
        value = spot.marker.value
        text = f'{"" if isinstance(value, str) else "id "}{value}   {spot.side:.4g} mm'
        context.set_source_rgb(0, 0, 0)
        _text(context, text, spot.x, spot.y + spot.side + spot.white + LABEL - 1.2, 2.8, spot.side)


def _text(context: cairo.Context, text: str, x: float, y: float, size: float, room: float = 1e3) -> None:
    """Draw text from (x, y) on, scaled down if it is wider than ``room``."""
    context.select_font_face('sans-serif')
    context.set_font_size(size)
    wide = context.text_extents(text).x_advance
    context.set_font_size(size * min(1.0, room / max(wide, 1e-6)))
    context.move_to(x, y)
    context.show_text(text)


def _ruler(context: cairo.Context, page: str, note: str) -> None:
    left, line = EDGE, PAGES[page][1] - EDGE - 8.0
    context.set_source_rgb(0, 0, 0)
    context.set_line_width(0.2)
    for millimetre in range(RULER + 1):
        length = next(length for step, length in TICKS if millimetre % step == 0)
        context.move_to(left + millimetre, line)
        context.line_to(left + millimetre, line - length)
    context.move_to(left, line)
    context.line_to(left + RULER, line)
    context.stroke()
    for millimetre in range(0, RULER + 1, 10):
        _text(context, str(millimetre), left + millimetre - 0.8, line + 3.2, 2.4)
    _text(context, f'This ruler is {RULER} mm long. If it is not on your paper, print again at 100 % ("actual size").',
          left, line + 7.4, 2.8, 2 * RULER)
    _text(context, note, left + RULER + 10, line + 3.2, 2.8)
