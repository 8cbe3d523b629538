#!/usr/bin/env python3
"""Prints docs/exercise_sheet.md: the exercises of the course, with step, text, what to hand in, and the command.

usage: ./run shell -c "python3 $PWD/tools/exercise_sheet.py"

The texts are those of the exercise files; the pages of the course say which step an exercise belongs to.
"""
import pathlib
import re
import textwrap

from course_grader.rules import exercise

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
PAGES = 'course.md', 'course_next.md', 'course_markers.md', 'course_navigation.md'
WIDTH = 118  # characters of a line
HEAD = '''\
# Exercise sheet

The exercises of [the course](course.md), for students. Hand in one file for each exercise, with the name of the
exercise: a Python program `NAME.py`, a launch file `NAME.launch`, an executable script of commands `NAME.bash`, or
one command `NAME.cmd`. Other files that it needs lie beside it, or in the same package.

Grade your program before you hand it in: type the command in the folder of this repository. It starts everything that
is needed, and says how many of 100 points you get, and why. Each grading starts elsewhere and uses other numbers, so a
program that only fits one run fails. [grading.md](grading.md) says more.
'''


def main():
    """Print the page."""
    print(page(), end='')


def page():
    """Return the page."""
    return HEAD + ''.join(map(_section, steps()))


def steps():
    """Return [(page, heading, names of the exercises)] of the steps that have exercises."""
    found = []
    for page_name in PAGES:
        text = (REPOSITORY / 'docs' / page_name).read_text(encoding='utf-8')
        for part in re.split(r'^## ', text, flags=re.MULTILINE)[1:]:
            names = exercises(part)
            if names:
                found.append((page_name, part.split('\n', 1)[0], names))
    return found


def exercises(section):
    """Return the names of the exercises that a step of a page names."""
    line = re.search(r'^\* \*\*Exercises?:\*\* (.*)', section, re.MULTILINE)
    graded = re.findall(r'run grade (\w+) --', section)
    return list(dict.fromkeys(re.findall(r'`(\w+)`', line.group(1)) if line else graded))


def _section(step):
    page_name, heading, names = step
    anchor = re.sub(r'[^\w -]', '', heading.lower()).replace(' ', '-')
    parts = [f'\n## {heading}\n\n[This step in the course]({page_name}#{anchor})\n']
    for name in names:
        loaded = exercise.load(REPOSITORY / 'grading' / 'course_grader' / 'exercises' / f'{name}.yaml')
        text = '\n'.join(textwrap.wrap(loaded.asks, WIDTH, break_on_hyphens=False, break_long_words=False))
        files = [f'{name}.{ending}' for ending in ('launch', 'cmd', 'yaml', 'py')]
        file = next((file for file in files if file in loaded.asks), files[-1])
        parts.append(f'\n### {loaded.title}\n\n{text}\n\nHand in **{file}**. To grade it:\n\n'
                     f'```\n./run grade {name} -- FOLDER/{file}\n```\n')
    return ''.join(parts)


if __name__ == '__main__':
    main()
