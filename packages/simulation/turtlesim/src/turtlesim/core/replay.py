"""Replay recordings of turtlesim with our own world and canvas, and count the differences.

recording.py describes the format. A PNG file with the same name is the canvas at the end, without the turtle.

A recorder sees from the pose in which tick a command or teleport took effect. It cannot see this for the pen and for
clear, and may record them one tick too early. If the readings of the colour sensor right after such an event fit better
with the event one tick later, the replay moves it, reports that, and gives the share of equal colours for both.
"""
import argparse
import csv
import io
import math
import os
import struct
import sys
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

from kinematic_core.worlds.turtle_world import CANVAS_SIZE, WATCHDOG_STEPS, Colour, TurtlePose
from turtlesim.core.canvas import Canvas
from turtlesim.core.drawn_world import DrawnWorld
from turtlesim.core.recording import COLUMNS, EMPTY, EVENTS, TURTLE

MAX_GAP = 100_000  # [ticks] between two rows: 27 minutes
UNSEEN = ('pen', 'clear')  # events that leave no trace in the pose


class RecordingError(ValueError):
    """A file is not a recording; the text says which, where and why."""


class Event(NamedTuple):
    """An event that took effect in a tick; ``name`` is one of EVENTS, after `TURTLE/` if it is another turtle's."""

    name: str
    values: Tuple[float, ...]


class Row(NamedTuple):
    """A row of a recording. Pose and colour are None if there is no turtle1."""

    tick: int
    events: List[Event]
    pose: Optional[TurtlePose]
    colour: Optional[Colour]


class Comparison:
    """The result of replaying one recording."""

    def __init__(self) -> None:
        self.ticks = 0
        self.different_poses = 0
        self.first_difference: Optional[str] = None
        self.different_colours: List[int] = []  # ticks
        self.booked_different_colours = 0  # their number if every event stays in its recorded tick
        self.moved_events = 0
        self.equal_pixels: Optional[float] = None  # share, 0..1, or None without a picture


def replay(path: str) -> Comparison:
    """Replay a recording; return its Comparison. Raise RecordingError or OSError if it cannot be read."""
    rows = _read(path)
    result, canvas = _run(rows, path)
    booked, moved = len(result.different_colours), 0
    for number, row in enumerate(rows[:-1]):
        near = range(row.tick, row.tick + 3)
        if any(event.name in UNSEEN for event in row.events) and any(t in near for t in result.different_colours):
            later = _one_tick_later(rows, number)
            other, other_canvas = _run(later, path)
            if len(other.different_colours) < len(result.different_colours):
                rows, result, canvas, moved = later, other, other_canvas, moved + 1
    result.booked_different_colours, result.moved_events = booked, moved
    image = os.path.splitext(path)[0] + '.png'
    if os.path.exists(image):
        result.equal_pixels = _equal_pixels(canvas, image)
    return result


def _one_tick_later(rows: List[Row], number: int) -> List[Row]:
    """Return the rows with the UNSEEN events of row ``number`` moved to the next row."""
    row, after = rows[number:number + 2]
    kept = [event for event in row.events if event.name not in UNSEEN]
    moved = [event for event in row.events if event.name in UNSEEN]
    return [*rows[:number], row._replace(events=kept), after._replace(events=moved + after.events), *rows[number + 2:]]


def _run(rows: List[Row], path: str) -> Tuple[Comparison, Canvas]:
    # a recording with watchdog events was made in wall time: use these events instead of our own watchdog
    timed = any(event.name == 'timeout' for row in rows for event in row.events)
    drawn = DrawnWorld(watchdog_steps=math.inf if timed else WATCHDOG_STEPS)
    result = Comparison()
    tick = rows[0].tick - 1
    for row in rows:
        if row.tick - tick > MAX_GAP:
            raise RecordingError(f'{path}: tick {row.tick} follows tick {tick}; a gap may have {MAX_GAP} ticks')
        for _ in range(tick + 1, row.tick):  # ticks without a row
            drawn.step()
        tick = row.tick
        _apply(drawn, row, path)
        reading = next((reading for reading in drawn.step() if reading.turtle.name == TURTLE), None)
        _compare(result, row, reading and reading.turtle.pose(), reading and reading.colour)
    return result, drawn.canvas


def _read(path: str) -> List[Row]:
    with open(path, 'rb') as file:
        content, end, cut = file.read().rpartition(b'\n')
    try:
        reader = csv.DictReader(io.StringIO((content + end).decode('utf-8'), newline=''))
    except UnicodeDecodeError:
        raise RecordingError(f'{path}: not a text file') from None
    try:
        rows = [_parse(row) for row in reader]
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError, csv.Error) as error:
        raise RecordingError(f'{path}: line {reader.line_num}: not a row of a recording of turtlesim: {error!r}; '
                             f'the columns are {", ".join(("tick", "event", *COLUMNS))}') from None
    if not rows:
        raise RecordingError(f'{path}: contains no ticks')
    if cut:
        print(f'{path}: the last row is incomplete (no end of line); left out', file=sys.stderr)
    return rows


def _parse(row: Dict[str, str]) -> Row:
    events = [event.split() for event in row['event'].split(';') if event.strip()]
    fields = [row[field] for field in COLUMNS]
    pose, colour = None, None  # there is no turtle1
    if tuple(fields) != EMPTY:
        pose = TurtlePose(*map(float, fields[:len(TurtlePose._fields)]))
        _bits(pose)  # raises an error if a value is not a float32
        r, g, b = map(int, fields[len(TurtlePose._fields):])
        colour = r, g, b
    return Row(int(row['tick']), [Event(name, tuple(map(float, values))) for name, *values in events], pose, colour)


def _apply(drawn: DrawnWorld, row: Row, path: str) -> None:
    for called, values in row.events:
        turtle, _, name = called.rpartition('/')
        try:
            EVENTS[name](drawn, turtle or TURTLE, *values)
        except KeyError:
            raise RecordingError(f'{path}: tick {row.tick}: unknown event {name!r}; known are: '
                                 f'{", ".join(EVENTS)}') from None
        except (TypeError, ValueError, OverflowError) as error:  # InvalidInput is a ValueError
            raise RecordingError(f'{path}: tick {row.tick}: event {name} {list(values)}: {error}') from None


def _bits(pose: Optional[TurtlePose]) -> Optional[bytes]:
    return None if pose is None else struct.pack('<5f', *pose)


def _text(pose: Optional[TurtlePose]) -> str:
    return 'no turtle1' if pose is None else ', '.join(f'{name}={value!r}' for name, value in pose._asdict().items())


def _compare(result: Comparison, row: Row, pose: Optional[TurtlePose], colour: Optional[Colour]) -> None:
    result.ticks += 1
    bits = _bits(pose)
    if bits != _bits(row.pose):
        result.different_poses += 1
        if result.first_difference is None:
            ours = None if bits is None else TurtlePose(*struct.unpack('<5f', bits))
            result.first_difference = f'tick {row.tick}: recorded {_text(row.pose)}; here {_text(ours)}'
    if colour != row.colour:
        result.different_colours.append(row.tick)


def _equal_pixels(canvas: Canvas, path: str) -> float:
    import cv2
    image = cv2.imread(path, cv2.IMREAD_COLOR)
    if image is None or image.shape != (CANVAS_SIZE, CANVAS_SIZE, 3):
        raise RecordingError(f'{path}: not an image of {CANVAS_SIZE} x {CANVAS_SIZE} pixels')
    return float((image[:, :, ::-1] == canvas.array()).all(axis=2).mean())


def _report(path: str, result: Comparison) -> None:
    def share(different: int) -> str:
        return f'{100.0 * (1.0 - different / result.ticks):.2f} %'
    moved = '' if not result.moved_events else (f' (with {result.moved_events} pen or clear events one tick later than '
                                                f'recorded; {share(result.booked_different_colours)} as recorded)')
    canvas = 'no picture' if result.equal_pixels is None else f'{100.0 * result.equal_pixels:.4f} % of the pixels equal'
    print(f'{path}: {result.ticks} ticks, {result.different_poses} with a different pose, '
          f'{share(len(result.different_colours))} of the colours equal{moved}, {canvas}')
    if result.first_difference:
        print(f'  first difference: {result.first_difference}')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Replay the files of the command line; return 1 if a pose differs, 2 if a file cannot be replayed."""
    parser = argparse.ArgumentParser(prog='./run replay', description='Replay recordings of the real turtlesim.')
    parser.add_argument('files', nargs='+', metavar='FILE.csv',
                        help='recordings (CSV), each with or without a PNG file beside it')
    status = 0
    for path in parser.parse_args(arguments).files:
        try:
            result = replay(path)
        except (RecordingError, OSError) as error:
            print(error, file=sys.stderr)
            status = 2
            continue
        _report(path, result)
        if result.different_poses:
            status = status or 1
    return status


if __name__ == '__main__':
    sys.exit(main())
