"""The steps of the course: folders ``NN_NAME`` with a page, programs, exercises, samples, and what step.yaml says.

    README.md      the page of the step
    *.py *.launch  the programs that the page prints; one with the name of an exercise is a right answer to it
    NAME.yaml      an exercise
    samples/NAME/  programs right_* and wrong_* for it
    step.yaml      see Step

Folders below ``more`` hold exercises that belong to no step.

In a program, the lines ``# solution`` and ``# end of solution`` enclose what an exercise asks for. The page prints the
program without these two lines; a copy for students has ``# your code`` in the place of all of it.
"""
import functools
import pathlib
import re
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

from plain_support import documents, packages

STEP_FILE = 'step.yaml'
BEGIN, END = re.compile(r'\s*(?:#|<!--) solution(?: -->)?'), re.compile(r'\s*(?:#|<!--) end of solution(?: -->)?')
YOUR_CODE = {'#': '# your code', '<': '<!-- your code -->'}
MORE = 'more'
FOLDER = re.compile(r'(\d\d)([a-z]?)_\w+')


class Demo(NamedTuple):
    """What ``./run demo`` plays: its title, what it is about, the command that it stands for, and who plays it."""

    title: str
    asks: str
    types: str
    plays: str


class Step(NamedTuple):
    """A step of the course. ``number``: as on its page, such as 3 or 3b; all else but the folder is in step.yaml.

    ``minutes``: how long a beginner takes; ``new``: the ideas that its program brings; ``needs``: what has to run;
    ``panels``: those of the page that show what happens.
    """

    number: str
    folder: pathlib.Path
    title: str
    minutes: int
    new: Tuple[str, ...]
    needs: str
    panels: Tuple[str, ...]
    demo: Tuple[Demo, ...]

    @property
    def page(self) -> pathlib.Path:
        return self.folder / 'README.md'


@functools.lru_cache(maxsize=None)
def repository() -> pathlib.Path:
    """Return the folder of this repository: that of the package turtle_robotont. Raise rospkg.ResourceNotFound."""
    return packages.folder('turtle_robotont').resolve()


@functools.lru_cache(maxsize=None)
def installed() -> pathlib.Path:
    """Return the folder of the course. Raise rospkg.ResourceNotFound."""
    return packages.folder('turtle_robotont') / 'course'


def steps(course: pathlib.Path) -> List[Step]:
    """Return the steps in a folder, in their order. Raise OSError, DocumentError, or TypeError for a wrong key."""
    found = []
    for folder in sorted(course.iterdir()):
        match = FOLDER.fullmatch(folder.name)
        if match and (folder / STEP_FILE).is_file():
            says: Dict[str, Any] = documents.read_yaml(folder / STEP_FILE)
            new, panels, demo = (says.pop(key, ()) for key in ('new', 'panels', 'demo'))
            found.append(Step(f'{int(match.group(1))}{match.group(2)}', folder, new=tuple(new), panels=tuple(panels),
                              demo=tuple(Demo(**entry) for entry in demo), **says))
    return found


def exercises_of(folder: pathlib.Path) -> List[pathlib.Path]:
    """Return the files of the exercises of a step, or of a folder below ``more``; the one with its name first."""
    files = [path for path in folder.glob('*.yaml') if path.name != STEP_FILE]
    return sorted(files, key=lambda path: (not folder.name.endswith(path.stem), path.name))


def exercises(course: pathlib.Path) -> Dict[str, pathlib.Path]:
    """Return {name: file} of all exercises, in the order of the steps."""
    more = course / MORE
    folders = [*sorted(path for path in course.iterdir() if FOLDER.fullmatch(path.name)),
               *(sorted(more.iterdir()) if more.is_dir() else [])]
    return {path.stem: path for folder in folders if folder.is_dir() for path in exercises_of(folder)}


def printed_answer(exercise: pathlib.Path) -> Optional[pathlib.Path]:
    """Return the program that the page of a step prints, if it is an answer to the exercise in this file."""
    answers = exercise.with_suffix('.py'), exercise.with_suffix('.launch')
    return next((path for path in answers if path.is_file()), None)


def samples(exercise: pathlib.Path) -> List[pathlib.Path]:
    """Return the sample programs right_* and wrong_* for the exercise in this file."""
    return sorted(path for path in (exercise.parent / 'samples' / exercise.stem).glob('*_*')
                  if path.name.startswith(('right_', 'wrong_')))


def answers(exercise: pathlib.Path) -> List[pathlib.Path]:
    """Return the printed answer to the exercise in this file, if there is one, and then its samples."""
    return [*filter(None, [printed_answer(exercise)]), *samples(exercise)]


def printed(program: str) -> str:
    """Return a program as its page prints it."""
    return ''.join(line for line in program.splitlines(True) if not _is(BEGIN, line) and not _is(END, line))


def solution_lines(program: str) -> List[str]:
    """Return the lines of a program that belong to its solution."""
    return [line for inside, line in _lines(program) if inside and not _is(BEGIN, line) and not _is(END, line)]


def without_solution(program: str) -> str:
    """Return a program with ``# your code`` in the place of each solution."""
    kept = []
    for inside, line in _lines(program):
        if _is(BEGIN, line):
            sign = line.lstrip()[0]
            kept.append(f'{line[:line.index(sign)]}{YOUR_CODE[sign]}\n')
        elif not inside:
            kept.append(line)
    return ''.join(kept)


def _is(mark: 're.Pattern[str]', line: str) -> bool:
    return mark.fullmatch(line.rstrip()) is not None


def _lines(program: str) -> Iterator[Tuple[bool, str]]:
    """Yield (whether it is in a solution, line); the lines that enclose a solution are in it."""
    inside = False
    for line in program.splitlines(True):
        inside = inside or _is(BEGIN, line)
        yield inside, line
        inside = inside and not _is(END, line)
