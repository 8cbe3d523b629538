"""The exercise sheet: the tasks of the course for students, step by step, with the line that grades each. Markdown."""
import textwrap
from pathlib import Path
from typing import Iterable, Mapping

from course_grader.rules.exercise import Exercise
from plain_support.course import Step, exercises_of

WIDTH = 118  # characters of a line of Markdown
TERMINAL_WIDTH = 80
HEAD = '''\
# Exercise sheet

The exercises of the course, for students. Hand in one file for each exercise, with the name of the exercise: a Python
program `NAME.py`, a launch file `NAME.launch`, an executable script of commands `NAME.bash`, or one command
`NAME.cmd`. Other files that it needs lie beside it, or in the same package.

Grade your program before you hand it in: type the command in the folder of this repository. It starts everything that
is needed, and says how many of 100 points you get, and why. Each grading starts elsewhere and uses other numbers, so a
program that only fits one run fails. `docs/grading.md` says more.
'''


def markdown(steps: Iterable[Step], loaded: Mapping[Path, Exercise]) -> str:
    """Return the sheet; ``loaded``: {file: exercise}; the sheet shows these."""
    return HEAD + ''.join(_section(step, loaded) for step in steps)


def of_student(student: str, tasks: Iterable[Exercise]) -> str:
    """Return the tasks of a student as text."""
    return '\n\n'.join([student, *('\n'.join([f'{task.name}: {task.title}', *textwrap.wrap(task.asks, TERMINAL_WIDTH)])
                                   for task in tasks)])


def _section(step: Step, loaded: Mapping[Path, Exercise]) -> str:
    tasks = [loaded[path] for path in exercises_of(step.folder) if path in loaded]
    if not tasks:
        return ''
    head = f'\n## {step.number}. {step.title}\n\nThe page of this step: `course/{step.folder.name}/README.md`\n'
    return head + ''.join(map(_task, tasks))


def _task(task: Exercise) -> str:
    text = '\n'.join(textwrap.wrap(task.asks, WIDTH, break_on_hyphens=False, break_long_words=False))
    files = [f'{task.name}.{ending}' for ending in ('launch', 'cmd', 'yaml', 'py')]
    file = next((file for file in files if file in task.asks), files[-1])
    return (f'\n### {task.title}\n\n{text}\n\nHand in **{file}**. To grade it:\n\n'
            f'```\n./run grade {task.name} -- FOLDER/{file}\n```\n')
