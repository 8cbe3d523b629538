"""The command line and the dialogue of ar_track_alvar's createMarker.

An option applies to the arguments after it; a unit of length is a number of pixels, at 96 pixels per inch.
"""
from __future__ import annotations

import math
import sys
from typing import Any, Callable, Iterator, Mapping, Sequence, TypeVar

from alvar_core import code
from alvar_core.printing import marker_files
from alvar_core.printing.marker_files import DPI, PAGES, CreateError, Marker
from plain_support import unwritten, write_together

CM, INCH = DPI / 2.54, DPI  # [px] per unit
SIDE = 9.0  # [units]
PAGE = 'a4'
INTERRUPTED = 130  # exit code after Ctrl-C, as a shell's
Answer = TypeVar('Answer')
Read = Callable[[str], str]  # returns the next argument; its parameter describes that in the error if it is missing

HELP = f"""usage: createMarker [OPTION ...] ID ...

Draws ALVAR markers for ar_track_alvar: for each ID, MarkerData_ID.png in the current folder.

  5                   the marker with the number 5 (5x5 cells hold 0 to 255; higher numbers need more cells)
  -1 "hello world"    a marker with a text (-2 catalog.xml: with a file name; -3 www.vtt.fi: with a URL)
  -s 5.0              width and height of the black square, in units (default {SIDE:g})
  -ucm, -uin, -u 96   unit: centimetres (default), inches, or a number of pixels ({DPI:g} pixels per inch)
  -m 2                width of the black border in cells (default {code.MARGIN})
  -r 7                data cells per row (odd, {code.MIN_RESOLUTION} to {code.MAX_RESOLUTION}; default: the fewest)
  -f                  the stronger code, Hamming(8,4), for markers with more than 5x5 cells
  -xy 14 0            position of the next markers, right of and below the origin; all markers go into one image
                      MarkerData_8_9.png with a bundle file MarkerData_8_9.xml (in cm) for findMarkerBundlesNoKinect;
                      the first marker is the master and should be at 0 0
  -p                  asks for ids and positions; createMarker without arguments does the same
  -ar                 asks for an array of markers
  --pdf OUT.pdf       a sheet to print instead of images, with true sizes, ids, cut lines, and a ruler
  --page a4|letter    paper of the sheet (default {PAGE})
  -h, --help          this text

An option applies to the ids after it: createMarker -s 4.4 -xy 0 0 8 -xy 14 0 9
A PNG file contains its size: print it without scaling. Set marker_size of the tracker to the side of the black
square in cm."""


class CommandLine:
    """Reads the arguments in turn; ``markers`` are those so far; the other fields are the settings of the next one.

    ``at``: its x and y, None without a position; ``unit`` [px]; ``side`` [units]; the others correspond to options.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        self.markers: list[Marker] = []
        self.pdf: str | None = None
        self.page = PAGE
        self.prompt, self.array, self.help = not arguments, False, False
        self.kind, self.strong, self.margin = code.NUMBER, False, code.MARGIN
        self.resolution: int | None = None
        self.at: tuple[float, float] | None = None
        self.unit, self.side = CM, SIDE
        rest = iter([a for a in arguments if not (a.startswith('__') and ':=' in a)])  # roslaunch adds those
        for argument in rest:
            self._take(argument, rest)

    def _take(self, argument: str, rest: Iterator[str]) -> None:
        if argument in _SETTINGS:
            for name, value in _SETTINGS[argument].items():
                setattr(self, name, value)
        elif argument in _READERS:
            _READERS[argument](self, lambda what: _next(rest, argument, what))
        elif argument == '-a':
            raise CreateError('-a: createMarker draws no ARToolKit markers, because ar_track_alvar cannot read them')
        elif self.kind == code.NUMBER and argument.startswith('-') and not argument[1:2].isdigit():
            raise CreateError(f'unknown option {argument}; createMarker --help lists them')
        else:
            self.add(argument)

    def set_side(self, read: Read) -> None:
        """-s"""
        self.side = number(read('a length in units'), '-s: marker size', 1e-3, 1e5)

    def set_unit(self, read: Read) -> None:
        """-u"""
        self.unit = number(read('pixels per unit'), '-u: pixels per unit', 1e-3, 1e5)

    def set_margin(self, read: Read) -> None:
        """-m"""
        value = number(read('a number of cells'), '-m: margin', 0, code.MAX_MARGIN)
        if value != int(value):
            raise CreateError(f'-m: margin {value:g}: a whole number of cells is needed')
        self.margin = int(value) or code.MARGIN

    def set_resolution(self, read: Read) -> None:
        """-r"""
        value = number(read('a number of cells'), '-r: marker resolution', 0, code.MAX_RESOLUTION)
        try:
            self.resolution = code.check_resolution(value) if value else None
        except code.CodeError as error:
            raise CreateError(f'-r: {error}') from None

    def set_place(self, read: Read) -> None:
        """-xy"""
        x = number(read('x and y in units'), '-xy: x', -1e5, 1e5)
        self.at = x, number(read('x and y in units'), '-xy: y', -1e5, 1e5)

    def set_pdf(self, read: Read) -> None:
        """--pdf"""
        self.pdf = read('the name of a PDF file')

    def set_page(self, read: Read) -> None:
        """--page"""
        self.page = read(' or '.join(PAGES)).lower()
        if self.page not in PAGES:
            raise CreateError(f'--page {self.page}: it must be one of {", ".join(PAGES)}')

    def add(self, text: str) -> None:
        """Add a marker with an id or a text."""
        value = whole(text, 'marker') if self.kind == code.NUMBER else text.lower()
        try:
            cells = code.encode(value, self.kind, self.strong, self.resolution)
        except code.CodeError as error:
            raise CreateError(f'marker {text}: {error}') from None
        metres = self.unit / DPI * 0.0254
        at = (self.at[0] * metres, -self.at[1] * metres) if self.at else None
        pixels = int(self.side * self.unit + 0.5)
        self.markers.append(Marker(value, cells, self.margin, self.side * metres, at, pixels))


_SETTINGS: dict[str, dict[str, Any]] = {
    '-f': {'strong': True}, '-1': {'kind': code.STRING}, '-2': {'kind': code.FILE}, '-3': {'kind': code.HTTP},
    '-uin': {'unit': INCH}, '-ucm': {'unit': CM}, '-p': {'prompt': True}, '-ar': {'array': True},
    '-h': {'help': True}, '--help': {'help': True},
}
_READERS: dict[str, Callable[[CommandLine, Read], None]] = {
    '-u': CommandLine.set_unit, '-s': CommandLine.set_side, '-r': CommandLine.set_resolution,
    '-m': CommandLine.set_margin, '-xy': CommandLine.set_place, '--pdf': CommandLine.set_pdf,
    '--page': CommandLine.set_page,
}


def _next(rest: Iterator[str], option: str, what: str) -> str:
    argument = next(rest, None)
    if argument is None:
        raise CreateError(f'{option} needs {what} after it')
    return argument


def number(text: str, what: str, low: float, high: float) -> float:
    """Return a text as a number from ``low`` to ``high``; raise CreateError if it is not one."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise CreateError(f'{what} {text!r}: a number from {low:g} to {high:g} is needed')
    return value


def whole(text: str, what: str) -> int:
    """Return a text as a whole number; raise CreateError if it is not one."""
    try:
        return int(text)
    except ValueError:
        raise CreateError(f'{what} {text!r}: a whole number is needed'
                          + ('; for a text, put -1 before it' if what == 'marker' else '')) from None


def ask(question: str, default: Answer, convert: Callable[[str], Answer]) -> Answer:
    """Ask until the answer is valid, and return it; an empty answer means the default."""
    shown = f'{default:g}' if isinstance(default, float) else default
    while True:
        text = input(f'{question} [{shown}]: ').strip()
        if not text:
            return default
        try:
            return convert(text)
        except CreateError as error:
            print(f'  {error}')


def ask_for_markers(line: CommandLine) -> None:
    """Ask for ids and positions until -1 or the end of the input; the default positions fill a growing square."""
    pitch, asked, marker_id = 2 * line.side, 0, 0
    while True:
        marker_id = ask('  marker id (use -1 to end)', marker_id, lambda text: whole(text, 'marker id'))
        if marker_id < 0:
            return
        ring = math.isqrt(asked)
        along = asked - ring * ring
        x, y = pitch * min(ring, 2 * ring - along), pitch * min(ring, along)
        line.at = (ask('  x position (in current units)', x, coordinate),
                   ask('  y position (in current units)', y, coordinate))
        try:
            line.add(str(marker_id))
            marker_files.check_places(line.markers)
        except CreateError as error:
            print(f'  {error}')
            del line.markers[asked:]
            continue
        asked, marker_id = asked + 1, marker_id + 1


def coordinate(text: str) -> float:
    """Return a text as a coordinate; raise CreateError if it is not one."""
    return number(text, 'position', -1e5, 1e5)


def ask_for_array(line: CommandLine) -> None:
    """Ask for rows and columns of markers with consecutive ids."""
    def count(text: str) -> int:
        return int(number(text, 'rows or columns', 1, 1000))

    rows, columns = ask('Array rows : ', 1, count), ask('Array cols : ', 1, count)
    down, right = ask('Rows distance : ', 2 * line.side, coordinate), ask('Cols distance : ', 2 * line.side, coordinate)
    by_column = ask('Column major (1 or 0) : ', 1, lambda text: whole(text, 'column major'))
    first = ask('First marker ID : ', 0, lambda text: whole(text, 'marker id'))
    for place in range(rows * columns):
        row, column = (place % rows, place // rows) if by_column else divmod(place, columns)
        line.at = (column * right, row * down)
        line.add(str(first + place))


def converse(line: CommandLine) -> None:
    """Ask the questions of -p or -ar; the end of the input ends them."""
    line.kind = code.NUMBER
    print(f'{HELP}\n\nPrompt marker placements interactively')
    print(f'  units: {line.unit / CM:g} cm {line.unit / INCH:g} inches\n  marker side: {line.side:g} units')
    try:
        if line.prompt:
            ask_for_markers(line)
        else:
            ask_for_array(line)
    except EOFError:
        print()


def save(files: Mapping[str, bytes]) -> None:
    """Write files {name: content}, all or none; raise CreateError if that fails."""
    for name in files:
        print(f'Saving: {name}')
    try:
        write_together(files)
    except OSError as error:
        raise CreateError(unwritten(error, 'change to another folder with cd')) from None


def run(arguments: Sequence[str]) -> None:
    """Execute the arguments; raise CreateError."""
    line = CommandLine(arguments)
    if line.help:
        print(HELP)
        return
    if line.prompt or line.array:
        converse(line)
    markers = line.markers
    if not markers:
        raise CreateError('the id is missing; createMarker 5 draws marker 5, and createMarker --help lists all options')
    if line.pdf is None:
        made = marker_files.files(markers)
    else:
        from alvar_core.printing import sheet  # needs cairo; images do not
        made = sheet.files(markers, line.pdf, line.page)
    save(dict(made))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return the exit status."""
    try:
        run(sys.argv[1:] if arguments is None else arguments)
    except CreateError as error:
        print(f'createMarker: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0
