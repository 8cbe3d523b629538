"""Copies this repository without the solutions of its exercises: ./run link --without-solutions FOLDER.

usage: student_copy.py TARGET

What shows how an exercise is solved stays behind: the programs of this package, samples, tests, measurements, the
demo. So does the history of Git. In the programs that the course prints, ``# your code`` stands for the lines that an
exercise asks for, on the pages, too. Links of the pages to what is missing become plain text.
"""
import os
import pathlib
import re
import shutil
import sys
import tempfile

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / 'packages' / 'support' / 'plain_support' / 'src'))
from plain_support import course  # noqa: E402

COPIED = (  # files, and folders with all that is in them
    'run', 'package.xml', 'CMakeLists.txt', 'setup.py', 'requirements.txt', 'requirements.lock', 'LICENSE',
    'tools/environment.bash', 'tools/workspace.bash', 'tools/pip.lock', 'test/package_tests.cmake', 'msg', 'srv',
    'packages',
    'launch/browser.launch', 'launch/camera_ar_track.launch', 'launch/turtlesim.launch', 'launch/view.launch',
    'scripts/browser.py', 'scripts/grade.py', 'scripts/marker_sequence.py',
    'src/turtle_robotont/__init__.py', 'src/turtle_robotont/elsewhere.py',
    'course', 'docs/browser.md', 'docs/exercise_files.md', 'docs/grading.md',
    'docs/grading_security.md', 'docs/images/browser.png', 'docs/installation.md', 'docs/programs.md',
    'docs/simulated_time.md', 'docs/troubleshooting.md', 'docs/two_machines.md')
PATROL = 'packages/navigation/robotont_navigation/scripts/patrol.py'  # the program of step 28
LEFT_BEHIND = shutil.ignore_patterns('test', 'samples', '__pycache__', '.*')  # folders in them
MARK = 'WITHOUT_SOLUTIONS'  # a file that says what a copy is; ./run reads it, too
README = '''\
# turtle_robotont, without solutions

A beginners' course for ROS 1 and Python that runs on a plain Debian. This copy has everything that you need to write
and grade your programs, and no solutions.

* [The course](course/README.md) has a page for each step. Where a program says `# your code`, you write it. `./run
  grade --sheet` prints all tasks.
* `./run shell` opens a terminal with ROS; the first `./run` command installs it. `./run view --turtlesim` shows the
  turtle [in a browser](docs/browser.md).
* `./run doctor` says what is wrong on your machine. [Messages that you may see](docs/troubleshooting.md),
  [what you need](docs/installation.md), [how programs are graded](docs/grading.md).

Licence: [BSD-3-Clause](LICENSE).
'''
LINK = re.compile(r'(?P<line>^)?(?P<picture>!?)\[(?P<text>[^]]*)\]\((?P<path>[^)#\s]+)(#[^)]*)?\)'
                  r'(?(line)(?P<end>\n\n)?)', re.MULTILINE)  # with the end of a paragraph that is nothing else
EXPLAINED = re.compile(r'^```(python|xml)\n(.*?)^```\n', re.MULTILINE | re.DOTALL)
MARKED = re.compile(r'<!-- file: \S+ -->\n\Z')
PROGRAM = re.compile(r'^ *scripts/(\w+\.py)\n', re.MULTILINE)  # of a list in CMakeLists.txt


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.split('\n\n')[1])
    target = pathlib.Path(sys.argv[1])
    try:
        copy(target)
    except FileExistsError:
        sys.exit(f'./run link: {target} exists already, perhaps with programs of yours in it. Move it out of the '
                 f'workspace (mv {target} ~), or choose another workspace')
    except OSError as error:
        why = error.strerror or error.args[0][0][2]  # of shutil.copytree, which lists all its errors
        sys.exit(f'./run link: {target} cannot be written: {why}. Nothing of it was left there. Make room on the disk '
                 f'(df -h {target.parent} says how much is left), or choose another workspace')


def copy(target):
    """Copy the repository, completely or not at all; raise FileExistsError if the target exists, or OSError."""
    if os.path.lexists(target):
        raise FileExistsError(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.turtle_robotont_', dir=target.parent) as folder:
        new = pathlib.Path(folder, target.name)
        _fill(new)
        new.rename(target)


def _fill(target):
    """Copy the repository into a new folder."""
    target.mkdir()
    for name in COPIED:
        source, copied = REPOSITORY / name, target / name
        copied.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, copied, symlinks=True, ignore=LEFT_BEHIND)
        else:
            shutil.copy2(source, copied)
    (target / 'README.md').write_text(README, encoding='utf-8')
    (target / MARK).write_text('This is a copy of turtle_robotont without the solutions of its exercises, made by '
                               './run link --without-solutions.\n', encoding='utf-8')
    build, there = target / 'CMakeLists.txt', {path.name for path in target.glob('scripts/*.py')}
    build.write_text(PROGRAM.sub(lambda match: match[0] if match[1] in there else '',
                                 build.read_text(encoding='utf-8')), encoding='utf-8')
    for step in course.steps(REPOSITORY / 'course'):
        _take_solutions_out(step.folder, target / 'course' / step.folder.name)
    shutil.copy(target / 'course' / '28_patrol' / 'patrol.py', target / PATROL)
    for page in target.rglob('*.md'):
        page.write_text(_without_dead_links(page.read_text(encoding='utf-8'), page.parent), encoding='utf-8')


def _take_solutions_out(folder, copied):
    """Write the programs and the page of a step without the solutions."""
    text = (folder / 'README.md').read_text(encoding='utf-8')
    for path in (*folder.glob('*.py'), *folder.glob('*.launch')):
        program = path.read_text(encoding='utf-8')
        (copied / path.name).write_text(course.without_solution(program), encoding='utf-8')
        text = text.replace(course.printed(program), course.without_solution(program))
        solution = {line for line in course.solution_lines(program) if line.strip()}
        text = EXPLAINED.sub(lambda block, solution=solution: _without(block, solution), text)
    (copied / 'README.md').write_text(text, encoding='utf-8')


def _without(block, solution):
    """Return a block that explains a program, with YOUR_CODE in the place of the lines of its solution."""
    if MARKED.search(block.string[:block.start()]):
        return block[0]  # the program itself
    kept = ['' if line in solution else line for line in block[2].splitlines(True)]
    if all(kept):
        return block[0]
    sign = course.YOUR_CODE['<' if block[1] == 'xml' else '#']
    return f'```{block[1]}\n{"".join(kept).rstrip() or sign}\n```\n'


def _without_dead_links(text, folder):
    """Return a page of a folder with the text alone of each link that leads nowhere, nothing of a paragraph of its own.
    """
    def link(match):
        path = match['path']
        if '://' in path or path.startswith('mailto:') or (folder / path).exists():
            return match[0]
        return '' if match['picture'] or match['end'] else match['text']
    return LINK.sub(link, text)


if __name__ == '__main__':
    main()
