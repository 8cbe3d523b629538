"""The code of ALVAR's markers: numbers and short texts as black and white cells.

A marker of resolution n (odd, 5 or more) has n x n data cells; in arrays of cells, 1 (True) is white. The middle row
alternates white and black, starting with white; it shows the resolution. In the middle column, the two cells above the
middle are black and the two below are white; they show which side is up. Every other cell contains, row by row from
the top left, one bit (black is 1) of a code word:

* resolution 5: the number, 8 bits, as two extended Hamming(8,4) blocks;
* larger resolutions: four flags as one Hamming(8,4) block (one bit for long blocks, three bits for the kind), then the
  payload in blocks of 8 cells, or of 16 if the first flag is set.

In a block of n cells, the positions 1, 2, 4, 8 ... are parity bits; the last cell of a complete block is the parity of
all others. The last block of a marker may be shorter. Texts are stored with six bits per letter.

The behaviour is that of ALVAR 2.0 as used by ar_track_alvar, with resolutions up to MAX_RESOLUTION instead of 127.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass
from numbers import Real
from typing import Iterable, Sequence, Tuple, Union

import numpy as np

from alvar_core.arrays import ArrayLike, Bools
from plain_support import LARGEST_MARKER_ID

NUMBER, STRING, FILE, HTTP = range(4)
KINDS = ('number', 'string', 'file', 'http')
MIN_RESOLUTION, MAX_RESOLUTION = 5, 31
MARGIN, MAX_MARGIN = 2, 10  # [cells] width of the black border: ALVAR's default, and the largest
LETTERS = ":abcdefghijklmnopqrstuvwxyz0123456789+-*/()$= ,.#[]%\"_!&'?<>@\\^;"
HEADER_BITS = 8

Value = Union[int, str]
Word = Tuple[int, int, Sequence[int]]  # resolution, block size, bits


class CodeError(ValueError):
    """A number, text or resolution that no marker can have, or cells that are not a marker."""


@dataclass(frozen=True)
class Content:
    """The content of a marker.

    ``kind`` is an index of KINDS, ``value`` the number or text, ``corrected`` the number of corrected cells, ``turns``
    the number of quarter turns, counter-clockwise as in numpy.rot90, that make the given cells upright.
    """

    kind: int
    value: Value
    corrected: int
    turns: int = 0


def check_resolution(resolution: float) -> int:
    """Return the resolution as int; raise CodeError if no marker can have it."""
    if isinstance(resolution, bool) or not isinstance(resolution, Real) \
            or resolution not in range(MIN_RESOLUTION, MAX_RESOLUTION + 1, 2):
        raise CodeError(f'marker resolution {resolution!r}: an odd number from {MIN_RESOLUTION} to {MAX_RESOLUTION} '
                        'is needed (createMarker draws 5 for ids up to 255)')
    return int(resolution)


def fixed_cells(resolution: int) -> tuple[Bools, Bools]:
    """Return (mask, white), each (n, n) bool: the cells that are equal in all markers, and which of them are white."""
    n, mid = check_resolution(resolution), resolution // 2
    mask, white = np.zeros((n, n), bool), np.zeros((n, n), bool)
    mask[mid] = True
    white[mid, ::2] = True
    mask[mid - 2:mid + 3, mid] = True
    white[mid + 1:mid + 3, mid] = True
    return mask, white


def payload_cells(resolution: int, block: int) -> int:
    """Return the number of cells for payload, including parity, with blocks of ``block`` cells."""
    cells = resolution * resolution - resolution - 4 - (HEADER_BITS if resolution > 5 else 0)
    tail = cells % block
    return cells - tail if tail < 3 else cells


def _is_parity(position: int) -> bool:
    return position & (position - 1) == 0


def _block_sizes(cells: int, block: int) -> list[int]:
    return [min(block, cells - start) for start in range(0, cells, block)]


def data_bits(cells: int, block: int) -> int:
    """Return the number of data bits that fit in ``cells`` cells."""
    return sum(sum(not _is_parity(i) for i in range(1, size + 1)) for size in _block_sizes(cells, block))


def _encode_block(bits: Iterable[int], size: int) -> list[int]:
    word = [0] * (size + 1)
    source = iter(bits)
    syndrome = 0
    for position in range(1, size + 1):
        if not _is_parity(position):
            word[position] = next(source)
            syndrome ^= position * word[position]
    for position in range(1, size + 1):
        if _is_parity(position):
            word[position] = 1 if syndrome & position else 0
    if _is_parity(size):
        word[size] = sum(word[1:size]) & 1
    return word[1:]


def _encode(bits: Sequence[int], cells: int, block: int) -> list[int]:
    out: list[int] = []
    start = 0
    for size in _block_sizes(cells, block):
        count = data_bits(size, block)
        out += _encode_block(bits[start:start + count], size)
        start += count
    return out


def _decode_block(word: Sequence[int]) -> tuple[list[int], int] | None:
    """Return (data bits, corrected), or None if two cells are wrong."""
    size = len(word)
    word = [0] + list(word)
    syndrome = 0
    whole = _is_parity(size)
    for position in range(1, size if whole else size + 1):
        syndrome ^= position * word[position]
    odd = sum(word) & 1
    corrected = 0
    if whole and (odd or syndrome):
        if not odd or syndrome >= size:
            return None
        word[syndrome or size] ^= 1
        corrected = 1
    elif syndrome:
        if syndrome > size:
            return None
        word[syndrome] ^= 1
        corrected = 1
    return [word[i] for i in range(1, size + 1) if not _is_parity(i)], corrected


def _decode(word: Sequence[int], block: int) -> tuple[list[int], int] | None:
    data: list[int] = []
    corrected = 0
    for start in range(0, len(word), block):
        found = _decode_block(word[start:start + block])
        if found is None:
            return None
        data += found[0]
        corrected += found[1]
    return data, corrected


def _smallest(length: int, first: int, strong: bool, resolution: int | None) -> tuple[int, int]:
    """Return (resolution, block) of the smallest marker that holds ``length`` data bits."""
    wanted = range(first, MAX_RESOLUTION + 1, 2) if resolution is None else [check_resolution(resolution)]
    for n in wanted:
        for block in (8,) if n == 5 or strong else (8, 16):
            if data_bits(payload_cells(n, block), block) >= length:
                return n, block
    if resolution is None:
        raise CodeError(f'{length} bits do not fit in a marker of resolution {MAX_RESOLUTION}, the largest: a shorter '
                        'text is needed')
    enough = _smallest(length, first, strong, None)[0]
    raise CodeError(f'{length} bits do not fit in a marker of resolution {resolution}; resolution {enough} is enough')


def _to_bits(value: int, count: int) -> list[int]:
    return [(value >> shift) & 1 for shift in range(count - 1, -1, -1)]


def _from_bits(bits: Iterable[int]) -> int:
    value = 0
    for bit in bits:
        value = value * 2 + int(bit)
    return value


def _number_word(number: float, strong: bool, resolution: int | None) -> Word:
    if isinstance(number, bool) or int(number) != number or not 0 <= number <= LARGEST_MARKER_ID:
        raise CodeError(f'marker id {number!r}: a whole number from 0 to {LARGEST_MARKER_ID} is needed')
    number = int(number)
    n, block = _smallest(max(1, number.bit_length()), 5, strong, resolution)
    cells = payload_cells(n, block)
    return n, block, _encode(_to_bits(number, data_bits(cells, block)), cells, block)


def _text_word(text: str, strong: bool, resolution: int | None) -> Word:
    text = text.lower()
    unknown = ''.join(sorted(set(text) - set(LETTERS)))
    if not text or unknown:
        raise CodeError(f"marker text {text!r}: {f'it holds {unknown!r}' if unknown else 'it is empty'}; at least one "
                        f'letter is needed, and only these are allowed: {LETTERS}')
    bits = [bit for letter in text for bit in _to_bits(LETTERS.index(letter), 6)]
    if resolution == 5:
        enough = _smallest(len(bits), 7, strong, None)[0]
        raise CodeError(f'a marker of resolution 5 holds only a number; resolution {enough} is enough for {text!r}')
    n, block = _smallest(len(bits), 7, strong, resolution)
    cells = payload_cells(n, block)
    room = data_bits(cells, block)
    while len(bits) < room // 6 * 6:
        bits += _to_bits(LETTERS.index(' '), 6)
    return n, block, _encode(bits + [0] * (room - len(bits)), cells, block)


def encode(value: Value, kind: int | None = None, strong: bool = False, resolution: int | None = None) -> Bools:
    """Return the data cells, (n, n) bool, True is white, of a number (int) or a text (str).

    Use the smallest resolution that is enough, as ALVAR does, unless ``resolution`` is given. ``strong`` forbids blocks
    of 16. ``kind`` is an index of KINDS, by default NUMBER for an int, STRING for a str. Raise CodeError.
    """
    kind = (STRING if isinstance(value, str) else NUMBER) if kind is None else kind
    if (kind == NUMBER) == isinstance(value, str):
        raise CodeError(f'a marker of kind {KINDS[kind]} cannot hold {value!r}')
    if isinstance(value, str):
        n, block, bits = _text_word(value, strong, resolution)
    else:
        n, block, bits = _number_word(value, strong, resolution)
    if n > 5:
        bits = [*_encode_block([int(block == 16), *_to_bits(kind, 3)], 8), *bits]
    mask, cells = fixed_cells(n)
    free = np.flatnonzero(~mask.ravel())
    flat = cells.ravel()
    flat[free] = True
    flat[free[:len(bits)]] = ~np.array(bits, bool)
    return flat.reshape(n, n)


@functools.lru_cache(maxsize=1)
def mirrored_numbers() -> tuple[int, ...]:
    """Return as which number each of resolution 5 is read in a mirror."""
    contents = [decode(np.fliplr(encode(number)), max_wrong=0) for number in range(256)]
    return tuple(int(content.value) for content in contents if content is not None)


def decode_upright(cells: ArrayLike, max_fixed_errors: int = 0) -> Content | None:
    """Return the Content of upright cells (n, n), True is white; None if they are not a marker."""
    cells = np.asarray(cells, bool)
    n = check_resolution(len(cells))
    mask, white = fixed_cells(n)
    wrong = int((cells[mask] != white[mask]).sum())
    if wrong > max_fixed_errors:
        return None
    word = [int(not c) for c in cells[~mask]]
    kind, block = NUMBER, 8
    if n > 5:
        header = _decode_block(word[:HEADER_BITS])
        if header is None or _from_bits(header[0][1:]) >= len(KINDS):
            return None
        block, kind = (16 if header[0][0] else 8), _from_bits(header[0][1:])
        wrong += header[1]
        word = word[HEADER_BITS:]
    found = _decode(word[:payload_cells(n, block)], block)
    if found is None:
        return None
    data, corrected = found
    if kind != NUMBER:
        letters = [LETTERS[_from_bits(data[start:start + 6])] for start in range(0, len(data) - 5, 6)]
        return Content(kind, ''.join(letters).rstrip(' '), wrong + corrected)
    number = _from_bits(data)
    return Content(kind, number, wrong + corrected) if number <= LARGEST_MARKER_ID else None


def decode(cells: ArrayLike, max_wrong: int = 1) -> Content | None:
    """Return the Content of cells in any of the four orientations, or None.

    At most ``max_wrong`` cells may be wrong. The orientation with the fewest wrong cells wins; None if two tie.
    """
    best: list[Content] = []
    for turns in range(4):
        found = decode_upright(np.rot90(np.asarray(cells, bool), turns), max_wrong)
        if found and found.corrected <= max_wrong:
            best.append(Content(found.kind, found.value, found.corrected, turns))
    best.sort(key=lambda content: content.corrected)
    if not best or len(best) > 1 and best[0].corrected == best[1].corrected:
        return None
    return best[0]
