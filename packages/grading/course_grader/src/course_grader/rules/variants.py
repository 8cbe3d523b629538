"""Values that differ from student to student: ``vary: {stop: 8 to 10 m}`` in an exercise file, ``$stop`` in its texts.

The name of the student is the seed, so the sheet that tells a student the task, the student's own gradings and that of
the class agree. Without ROS.
"""
import random
import re
import unicodedata
from typing import Any, Dict, Iterator, List, Tuple

from course_grader.rules.values import NUMBER, UNIT, UNITS, QuantityError, span
from plain_support import shown

VARY = 'vary'
NAME = re.compile(r'[A-Za-z]\w*')
REFERENCE = re.compile(r'\$(\w+)')
DRAWN = re.compile(rf'\s*({NUMBER})\s+to\s+({NUMBER})\s*({UNIT})\s*')
FINE, COARSE = 2, 1  # decimals of a value whose span is narrower than WIDE, and of others
WIDE = 1.0


def content_for(content: Any, exercise: str, student: str, problems: List[str]) -> Any:
    """Return what an exercise file holds with the values of a student in place of each ``$NAME``."""
    if not isinstance(content, dict) or VARY not in content:
        return content
    entries = content[VARY]
    if not isinstance(entries, dict) or not entries:
        problems.append(f'{VARY} is {shown(entries)}; it must be a mapping, such as {{stop: 8 to 10 m}}')
        return content
    values: Dict[str, str] = {}
    for name, text in entries.items():
        try:
            values[str(name)] = _drawn(str(name), text, f'{exercise}/{_plain(student)}')
        except QuantityError as error:
            problems.append(f'{VARY}: {name}: {error}')
            values[str(name)] = '$' + str(name)
    used = set(REFERENCE.findall(str({key: value for key, value in content.items() if key != VARY})))
    problems += [f'${name} stands in the exercise, but not in {VARY}' for name in sorted(used - set(values))]
    problems += [f'{VARY} has {name}, but ${name} stands nowhere' for name in values if name not in used]
    return {key: value if key == VARY else _filled(value, values) for key, value in content.items()}


def ends(content: Any) -> Iterator[Tuple[str, Any]]:
    """Yield (values, content) of a right exercise file for the lowest and for the highest values that can be drawn."""
    if not isinstance(content, dict) or VARY not in content:
        return
    others = {key: value for key, value in content.items() if key != VARY}
    for end in (1, 2):
        matches = {name: DRAWN.fullmatch(text) for name, text in content[VARY].items()}
        values = {str(name): f'{float(match[end]):g} {match[3]}' for name, match in matches.items() if match}
        yield ', '.join(f'{name} = {value}' for name, value in values.items()), _filled(others, values)


def _plain(student: str) -> str:
    return ' '.join(unicodedata.normalize('NFC', student).casefold().split())


def _drawn(name: str, text: Any, seed: str) -> str:
    """Return a value as a text with its unit; raise QuantityError."""
    parts = DRAWN.fullmatch(text) if isinstance(text, str) else None
    if not NAME.fullmatch(name) or parts is None or parts[3] not in UNITS:
        raise QuantityError(f'{shown(text)} must be a span with a unit, such as "8 to 10 m", of a name of letters')
    span(text, UNITS[parts[3]][0])
    low, high = float(parts[1]), float(parts[2])
    decimals = COARSE if high - low >= WIDE else FINE
    if low < high and round(low, decimals) == round(high, decimals):
        raise QuantityError(f'{shown(text)} has only one value with {decimals} decimals; use a smaller unit')
    value = round(random.Random(f'{seed}/{name}').uniform(low, high), decimals)
    return f'{min(max(value, low), high):g} {parts[3]}'


def _filled(value: Any, values: Dict[str, str]) -> Any:
    """Return a value with the texts in it filled in."""
    if isinstance(value, str):
        return REFERENCE.sub(lambda match: values.get(match[1], match[0]), value)
    if isinstance(value, list):
        return [_filled(entry, values) for entry in value]
    if isinstance(value, dict):
        return {key: _filled(entry, values) for key, entry in value.items()}
    return value
