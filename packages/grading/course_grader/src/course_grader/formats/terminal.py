"""Prints texts and tables for people, on any stream. Without ROS."""
import contextlib
import os
import sys
import textwrap
import unicodedata
from typing import List, Optional, Sequence, TextIO

from course_grader.formats import harmless
from course_grader.rules import scoring

GAP = '  '  # between two columns
SHORT = {scoring.UNDECIDED: '?'}
MIN_NAME = 8  # characters of a shortened name


def say(text: str, stream: Optional[TextIO] = None) -> None:
    """Print a text, by default to standard output; characters that the terminal cannot show become question marks."""
    stream = sys.stdout if stream is None else stream
    encoding = stream.encoding or 'utf-8'
    with contextlib.suppress(BrokenPipeError):  # flush() handles it
        stream.write(text.encode(encoding, 'replace').decode(encoding) + '\n')
    flush(stream)


def flush(stream: Optional[TextIO] = None) -> None:
    """Flush a stream.

    If nobody reads it any more (./run grade ... | head), all further output is discarded without an error.
    """
    stream = sys.stdout if stream is None else stream
    try:
        stream.flush()
    except BrokenPipeError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def columns() -> Optional[int]:
    """Return the width [characters] of the terminal, or None if standard output is not one."""
    try:
        return os.get_terminal_size(sys.stdout.fileno()).columns or None
    except (OSError, ValueError):
        return None


def table(rows: Sequence[Sequence[str]], width: Optional[int] = None) -> List[str]:
    """Return the lines of a table with headings; the first column is the names.

    If it is wider than ``width``, numbers replace the headings, and a legend follows. If even that is too wide, names
    are cut, and the columns are split into several tables.
    """
    rows = [[harmless.printed(cell) for cell in row] for row in rows]
    if width is None or _width(rows) <= width:
        return _lines(rows)
    name, *headings, last = rows[0]
    legend = ', '.join(f'{number} {heading}' for number, heading in enumerate(headings, 1))
    rows = [[name, *map(str, range(1, len(headings) + 1)), last],
            *([row[0], *(SHORT.get(cell, cell) for cell in row[1:])] for row in rows[1:])]
    room = max(MIN_NAME, width - _width([row[1:] for row in rows]) - len(GAP))
    rows = [[_shortened(row[0], room), *row[1:]] for row in rows]
    lines: List[str] = []
    for block in _blocks(rows, width):
        lines += [*([''] if lines else []), *_lines(block)]
    return [*lines, *textwrap.wrap(legend, width, break_on_hyphens=False)]


def _blocks(rows: Sequence[Sequence[str]], width: int) -> List[List[List[str]]]:
    """Return tables that are narrow enough: each has the names and at least one column."""
    blocks, first = [], 1
    while first < len(rows[0]):
        end = first + 1
        while end < len(rows[0]) and _width([[row[0], *row[first:end + 1]] for row in rows]) <= width:
            end += 1
        blocks.append([[row[0], *row[first:end]] for row in rows])
        first = end
    return blocks


def _lines(rows: Sequence[Sequence[str]]) -> List[str]:
    widths = [max(map(cells, column)) for column in zip(*rows)]
    lines = []
    for row in rows:
        padding = [' ' * (width - cells(cell)) for cell, width in zip(row, widths)]
        name, *numbers = row
        lines.append(GAP.join([name + padding[0], *(space + number for space, number in zip(padding[1:], numbers))]))
    return [line.rstrip() for line in lines]


def _width(rows: Sequence[Sequence[str]]) -> int:
    return sum(max(map(cells, column)) + len(GAP) for column in zip(*rows)) - len(GAP)


def cells(text: str) -> int:
    """Return the width of a text in cells of a terminal: an emoji takes two, a combining accent none."""
    return sum(0 if unicodedata.combining(sign) or unicodedata.category(sign) in ('Mn', 'Cf') else
               2 if unicodedata.east_asian_width(sign) in 'WF' else 1 for sign in text)


def _shortened(text: str, width: int) -> str:
    if cells(text) <= width:
        return text
    while cells(text) > width - 1:
        text = text[:-1]
    return text + '\u2026'
