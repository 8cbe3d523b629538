"""Read a page of the documentation as a list of actions: the commands of a reader, and the results on the page.

The page stays plain Markdown, and nothing in it is hidden from the reader:

* A ```bash block holds commands, one a line. `# terminal 2` after one names the terminal; without a number anywhere in
  the block it is a terminal in the repository's folder.
* A ```text block has the output of a terminal: the one that the paragraph above names, else the one typed in last.
  `...` stands for anything. The other lines must come in this order; others may stand between them. Whole numbers
  must be equal, decimal ones within TOLERANCE or RELATIVE_TOLERANCE; the time stamps of log lines do not count.
* A ```python, ```xml or ```yaml block is a file if the paragraph above it says "as `NAME.py`"; `~/` is the home folder.
  A comment `<!-- file: PATH -->` above a block says that it is the file PATH, seen from the page (test_course.py
  compares both). Such a block needs a name, or in the paragraph above it a link to PATH: then it is only shown. Other
  blocks of these languages are parts of a file, to be explained.
* "In terminal 2 press" and <kbd>keys</kbd>: they are pressed there, in their order.
* A picture after a command that saved one must look like the saved one.
"""
import re
from typing import NamedTuple

REPOSITORY_TERMINAL = 0  # the number of the terminal in the repository's folder
TOLERANCE = 0.05  # of a decimal number; the error of a drive in metres and radians
RELATIVE_TOLERANCE = 0.02
FILES = {'python': 'py', 'xml': 'launch|xml', 'yaml': 'yaml'}  # language of a block: how the file's name ends
KEYS = {'↑': '\x1b[A', '↓': '\x1b[B', '→': '\x1b[C', '←': '\x1b[D', 'Ctrl+C': '\x03', 'Enter': '\n'}
COMMENT = re.compile(r'<!--.*?-->\n?')
FILE_COMMENT = re.compile(r'<!-- file: (\S+) -->\n\Z')
BLOCK = re.compile(r'^```(\w+)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r'!\[[^\]]*\]\(([^)]+\.png)\)')
PRESS = re.compile(r'\bin\s+terminal\s+(\d+)\s+press\b(.*?)(?=\bin\s+terminal\s+\d+\s+press\b|\Z)',
                   re.IGNORECASE | re.DOTALL)
KBD = re.compile(r'(?:<kbd>[^<]+</kbd>\+)?<kbd>[^<]+</kbd>')
NUMBER = re.compile(r'(?<![\w.])-?\d+\.\d+(?:e-?\d+)?(?![\w.]*\d)')
TIME_STAMP = re.compile(r'\[\d{9,}\.\d+\]')


class Command(NamedTuple):
    """A command line that the reader types."""

    terminal: int
    text: str


class Keys(NamedTuple):
    """Keys that the reader presses: the bytes that the terminal sends for each."""

    terminal: int
    keys: tuple


class Output(NamedTuple):
    """The output of a terminal: lines of the page, without those that are only `...`."""

    terminal: int
    lines: tuple


class File(NamedTuple):
    """A file that the reader writes: below the home folder if its name begins with ~/, else where a terminal is."""

    terminal: int
    name: str
    text: str


class Picture(NamedTuple):
    """The path of a picture, relative to the page."""

    path: str


class PageError(ValueError):
    """The page does not follow the rules of this module."""


def actions(text):
    """Return the actions of a page in their order; raise PageError where the page cannot be read."""
    found, end = [], 0
    for block in BLOCK.finditer(text):
        prose = text[end:block.start()]
        end = block.end()
        found += _of_prose(prose)
        last = next((action.terminal for action in reversed(found) if hasattr(action, 'terminal')), None)
        if block.group(1) in FILES:
            found += _of_file(block.group(1), block.group(2), prose, last)
        else:
            found += _of_block(block.group(1), block.group(2), _last_paragraph(prose), last)
    return found + _of_prose(text[end:])


def _last_paragraph(prose):
    return re.split(r'\n\s*\n', COMMENT.sub('', prose).strip())[-1]


def _of_prose(prose):
    found = []
    for paragraph in re.split(r'\n\s*\n', COMMENT.sub('', prose)):
        pressed = PRESS.findall(paragraph)
        if not pressed and KBD.search(paragraph):
            raise PageError(f'the page does not say "in terminal N press" before the keys: {paragraph.strip()}')
        found += [Keys(int(number), tuple(map(key_bytes, KBD.findall(rest)))) for number, rest in pressed]
        found += [Picture(path) for path in PICTURE.findall(paragraph)]
    return found


def key_bytes(markup):
    """Return the bytes that a terminal sends for `<kbd>x</kbd>` or `<kbd>Ctrl</kbd>+<kbd>C</kbd>`."""
    key = re.sub(r'</?kbd>', '', markup)
    if key not in KEYS and len(key) != 1:
        raise PageError(f'there is no key {key}; there are {", ".join(KEYS)} and single characters')
    return KEYS.get(key, key)


def _of_block(language, body, paragraph, last):
    if language == 'bash':
        return list(commands(body))
    if language == 'text':
        named = re.findall(r'terminal (\d+)', paragraph, re.IGNORECASE)
        terminal = int(named[-1]) if named else last
        if terminal is None:
            raise PageError(f'output before any command:\n{body}')
        return [Output(terminal, tuple(line for line in body.splitlines() if line.strip(' .')))]
    return []


def _of_file(language, body, prose, last):
    paragraph = _last_paragraph(prose)
    name = re.search(rf'as\s+`((?:~/)?[\w./]+\.(?:{FILES[language]}))`', paragraph)
    if name:
        return [File(last, name.group(1), body)]
    marked = FILE_COMMENT.search(prose)
    if marked and f']({marked.group(1)})' not in paragraph:
        raise PageError(f'the paragraph above a program does not say "as `NAME.py`", nor link it: {paragraph}')
    return []


def commands(body):
    """Yield the Commands of a block."""
    lines = body.replace('\\\n', '').splitlines()
    numbered = any(re.search(r'#\s*terminal \d', line) for line in lines)
    terminal = None if numbered else REPOSITORY_TERMINAL
    for line in lines:
        command, _, comment = line.partition(' #')
        named = re.search(r'terminal (\d+)', comment)
        terminal = int(named.group(1)) if named else terminal
        if not command.strip():
            continue
        if terminal is None:
            raise PageError(f'the first command of a block names no terminal: {line}')
        yield Command(terminal, re.sub(r'\s+', ' ', command).strip() if '"' not in command else command.strip())


def missing(expected, printed):
    """Return the first of the expected lines that is not among the printed ones in its order, or None."""
    rest = iter(printed)
    for line in expected:
        if not any(fits(line, candidate) for candidate in rest):
            return line
    return None


def fits(expected, printed):
    """Return whether a printed line matches the page, by the rules of this module."""
    pattern, numbers, end = '', [], 0
    expected, printed = (TIME_STAMP.sub('[TIME]', line.rstrip()) for line in (expected, printed))
    for part in re.finditer(rf'\.\.\.|{NUMBER.pattern}', expected):
        pattern += re.escape(expected[end:part.start()])
        end = part.end()
        if part.group() == '...':
            pattern += '.*?'
        else:
            pattern += r'(-?\d+(?:\.\d+)?(?:e-?\d+)?)'
            numbers.append(float(part.group()))
    found = re.fullmatch(pattern + re.escape(expected[end:]), printed)
    return found is not None and all(
        abs(float(text) - number) <= max(TOLERANCE, RELATIVE_TOLERANCE * abs(number))
        for text, number in zip(found.groups(), numbers))
