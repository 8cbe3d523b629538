"""Follow a page of the documentation as a reader would, and check that the results are those on the page.

usage: check_page.py PAGE [PAGE ...] FOLDER [--browser]     such as README.md; FOLDER takes what the terminals showed

Terminals are shells behind pseudo-terminals, opened as the page says: in the repository's folder, or by ./run shell in
the home folder, which is empty and where they stay. Everything runs in a network namespace of its own, so that
`roscore` finds its port free; where none is allowed, no roscore of this workspace may run. Commands in LEFT_OUT are
not typed. With --browser, all is done in one tab of a browser: the terminals and the editor are those of ./run view
--terminal, and its page has to show what would be in windows; a screenshot follows each output. page.py tells how a
page is written. Exit code 0 when all is as the page says, else a text says which line is not.

Pages of the course are followed as by somebody who has done the steps before: the package topic_demo is there, with the
programs that the earlier pages print. Several pages are followed one after the other in the same terminals; what a page
wants to run, and what runs already, is not typed again.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import page
import pictures
from terminal import Terminal, TerminalError

from plain_support import course
from rostest_support.node_pages import REPOSITORY

COURSE = REPOSITORY / 'course'
LEFT_OUT = re.compile(r'git clone |cd turtle_robotont$|\./run test\b')
LOOKS = re.compile(r'rostopic echo -n ?1 |rosservice call /turtlesim/snapshot')  # may be typed again: changes nothing
SNAPSHOT = re.compile(r'message: "(/\S+\.png)"')
TROUBLE = re.compile(r'^Traceback \(most|^\S+: error: |^ERROR|\[(?:ERROR|FATAL)\]|command not found|No such file',
                     re.MULTILINE)
READY = {'roscore': 'started core service', 'rosrun turtlesim turtlesim_node': 'Spawning turtle'}  # on a loaded machine
SILENCE = 200.0  # [s] without a new line, on a loaded machine, after which the output of a program is complete
PRINTING = 600.0  # [s] after which a program that prints forever has printed enough
LOOKING = 60.0  # [s] for repeated commands to print the lines on the page
CLOSING = 30.0  # [s] in which all programs end by Ctrl-C
KEY_PAUSE = 0.3  # [s] between two keys, as fingers need
POLL = 0.1  # [s]
KEPT = ('PATH', 'LANG', 'http_proxy', 'https_proxy', 'TURTLE_ROBOTONT_ROS', 'TURTLE_ROBOTONT_CASE')  # of environment
APART = 'TURTLE_ROBOTONT_PAGE_APART'  # set in the network namespace


class WrongError(Exception):
    """Something is not as the page says."""


class Desk:
    """What a reader has in front of them: terminals and an editor."""

    def __init__(self, environment):
        self._environment = environment

    def terminal(self, folder, in_workspace):
        """Return a new terminal in ``folder``, a ./run shell if it is to be ``in_workspace``."""
        terminal = Terminal(folder, self._environment)
        if in_workspace:
            terminal.type(f'{REPOSITORY}/run shell', SILENCE)
            terminal.wait_free(SILENCE)
        return terminal

    def write(self, path, text):
        """Write a file."""
        path.write_text(text, encoding='utf-8')

    def look(self, commands):
        """Note that an output has come, while ``commands`` run."""

    def compare(self, drawn):
        """Compare the file of a picture on the page with what is on the screen."""

    def unseen(self):
        """Return what should have been seen on the screen, and was not."""
        return []

    def close(self):
        """End it, after the terminals."""


class Reader:
    """A reader who follows pages at a Desk, in a ``home``; ``terminals`` {number: Terminal}.

    ``shown``: the lines of all output on the pages, without their numbers.
    """

    def __init__(self, home, desk, shown):
        self.terminals, self.folder, self._commands, self._last = {}, None, {}, None
        self._home, self._desk, self._shown = home, desk, shown
        self._ways = {page.Command: self._type, page.Keys: self._press, page.Output: self._expect,
                      page.File: self._write, page.Picture: self._compare}

    def do(self, action):
        """Do one action of the page; raise WrongError or TerminalError when it does not come out as it says."""
        self._ways[type(action)](action)
        wrong = self._trouble()
        if wrong:
            raise WrongError(wrong[0])

    def _trouble(self):
        """Return the errors in the terminals that the page does not mention."""
        found = [(number, terminal.transcript.split('\n')) for number, terminal in self.terminals.items()]
        troubles = [(number, '\n'.join(lines[place:])[:1000]) for number, lines in found
                    for place, line in enumerate(lines) if TROUBLE.search(line)
                    and _without_numbers(line) not in self._shown]
        return [f'terminal {number} shows trouble:\n{text}' for number, text in troubles]

    def _terminal(self, number):
        """Return the terminal with a number, opened if it is a new one."""
        if number not in self.terminals:
            of_repository = number == page.REPOSITORY_TERMINAL
            self.terminals[number] = self._desk.terminal(REPOSITORY if of_repository else self._home, not of_repository)
        return self.terminals[number]

    def _turn_to(self, number):
        """Return the terminal with a number; wait until the commands in the others have started."""
        terminal = self._terminal(number)
        if self._last not in (None, number):
            self.terminals[self._last].wait_started()
            self._wait_ready(self._last)
        self._last = number
        return terminal

    def _wait_ready(self, number):
        """Wait until the command in a terminal prints that others can use it, as a reader sees before typing on."""
        ready = next((line for start, line in READY.items() if self._commands.get(number, '').startswith(start)), '')
        end, terminal = time.monotonic() + LOOKING, self.terminals[number]
        while not terminal.free() and ready not in terminal.transcript and time.monotonic() < end:
            time.sleep(POLL)

    def _type(self, command):
        runs = self._commands.get(command.terminal) == command.text and not self.terminals[command.terminal].free()
        if not LEFT_OUT.match(command.text) and not runs:
            self._turn_to(command.terminal).type(command.text, SILENCE)
            self._commands[command.terminal] = command.text

    def _press(self, keys):
        terminal = self._turn_to(keys.terminal)
        terminal.wait_started()
        for key in keys.keys:
            terminal.send(key)
            time.sleep(KEY_PAUSE)

    def _write(self, file):
        if file.name.startswith('~/'):
            self._turn_to(file.terminal).wait_started()  # an earlier command may make the folder
            path = self._home / file.name[2:]
        else:
            terminal = self._turn_to(file.terminal)
            terminal.type('pwd', SILENCE)
            terminal.wait_free(SILENCE)
            path = Path(terminal.printed()[0]) / file.name
        self._desk.write(path, file.text)

    def _look_again(self, number):
        """Type the last command again if it only looks and has ended; return whether it was."""
        command = self._commands.get(number, '')
        looks = LOOKS.match(command) is not None and self.terminals[number].free()
        if looks:
            self.terminals[number].type(command, SILENCE)
        return looks

    def _expect(self, output):
        terminal, end = self._terminal(output.terminal), time.monotonic() + LOOKING
        while True:
            over = (terminal.free() or terminal.silent_for() > SILENCE  # then the output is complete
                    or time.monotonic() > end + PRINTING)
            line = page.missing(output.lines, terminal.printed())
            if line is None:
                self._desk.look([text for number, text in self._commands.items() if not self.terminals[number].free()])
                return
            if over and (time.monotonic() > end or not self._look_again(output.terminal)):
                raise WrongError(f'terminal {output.terminal} does not print\n  {line}\nbut\n{terminal.tail()}')
            time.sleep(POLL)

    def _compare(self, picture):
        saved, end = self._saved(), time.monotonic() + LOOKING
        while saved:
            drawn = self.folder / picture.path
            if not drawn.exists():
                shutil.move(saved, drawn)
                raise WrongError(f'there was no {picture.path}; now there is what was saved: look at it')
            wrong = pictures.differences(cv2.imread(str(drawn)), cv2.imread(saved))
            os.remove(saved)
            if not wrong:
                self._desk.compare(drawn)
                return
            if time.monotonic() > end or not self._look_again(self._last):
                raise WrongError(f'the saved picture is not {picture.path}: {wrong}')
            saved = self._saved()

    def _saved(self):
        """Return the path of the picture that the last command saved, or None."""
        if self._last is None or 'snapshot' not in self._commands.get(self._last, ''):
            return None
        self.terminals[self._last].wait_free(SILENCE)
        found = SNAPSHOT.search('\n'.join(self.terminals[self._last].printed()))
        return found.group(1) if found and os.path.exists(found.group(1)) else None

    def close(self):
        """End everything; return the errors: programs that do not end on Ctrl-C, or only with errors."""
        wrong = []
        for number, terminal in sorted(self.terminals.items(), reverse=True):  # roscore at last
            wrong += [f'terminal {number} {text}' for text in terminal.close(CLOSING)]
        return wrong + self._trouble()


def _without_numbers(line):
    """Return a line of a terminal without its numbers, and without the ^C that a terminal shows for Ctrl-C."""
    return page.NUMBER.sub('', line.rstrip()).replace('^C', '')


def pages_before(path):
    """Return the folders of the steps of the course before the page ``path``; none for another page, and for step 1."""
    steps = [step.folder for step in course.steps(COURSE)]
    return steps[:steps.index(path.parent)] if path.parent in steps else []


def prepare(before, home, desk):
    """Make what a reader has after the steps in the folders ``before``: a workspace, and the programs of the steps."""
    text = (before[1] / 'README.md').read_text(encoding='utf-8')
    block = next(block for block in page.BLOCK.findall(text) if 'catkin_create_pkg' in block[1])
    terminal = desk.terminal(home, True)
    for command in page.commands(block[1]):
        terminal.type(command.text, SILENCE)
    terminal.wait_free(SILENCE)
    terminal.close(CLOSING)
    package = home / 'ros_ws' / 'src' / 'topic_demo'
    for folder in before:
        for kind, place in (('.py', 'scripts'), ('.launch', 'launch')):
            for program in folder.glob(f'*{kind}'):
                (package / place).mkdir(exist_ok=True)
                copied = package / place / program.name
                copied.write_text(course.printed(program.read_text(encoding='utf-8')), encoding='utf-8')
                copied.chmod(0o755)


def follow(paths, workspace, folder, in_browser):
    """Follow pages; return the differences from them."""
    return act([(path.parent, action) for path in paths for action in page.actions(path.read_text(encoding='utf-8'))],
               pages_before(paths[0]), workspace, folder, in_browser)


def act(actions, before, workspace, folder, in_browser=False):
    """Do ``actions``, (folder of the page, action), after the steps in the folders ``before``; return what is wrong."""
    home = Path(tempfile.mkdtemp(prefix='page_'))
    environment = {'LANG': 'C.UTF-8', **{name: os.environ[name] for name in KEPT if name in os.environ},
                   'HOME': str(home), 'TURTLE_ROBOTONT_WS': str(workspace)}
    if in_browser:
        from lab import Lab  # it needs selenium
        desk = Lab(REPOSITORY, home, environment, folder)
    else:
        desk = Desk(environment)
    shown = {_without_numbers(line) for _, action in actions if isinstance(action, page.Output)
             for line in action.lines}
    reader, wrong, action = Reader(home, desk, shown), [], 'the start'
    try:
        if len(before) > 1:
            prepare(before, home, desk)
        for place, action in actions:
            print(f'{time.monotonic() - BEGIN:6.1f} s  {action}', flush=True)
            reader.folder = place
            reader.do(action)
        wrong += [f'the page of the browser was not looked at: {what}' for what in desk.unseen()]
    except (WrongError, TerminalError) as error:
        wrong.append(f'{error}\nat {action}')
    finally:
        wrong += reader.close()
        for number, terminal in reader.terminals.items():
            (folder / f'terminal_{number}.txt').write_text(terminal.transcript, encoding='utf-8')
        desk.close()
        shutil.rmtree(home, ignore_errors=True)
    return wrong


def enter_own_network():
    """Go on in a network namespace with a loopback interface alone, if that is allowed; else return."""
    if APART in os.environ:
        return
    unshare = ['unshare', '-n'] if os.getuid() == 0 else ['unshare', '-rn']
    tried = subprocess.run([*unshare, 'ip', 'link', 'set', 'lo', 'up'], stderr=subprocess.DEVNULL, check=False)
    if tried.returncode == 0:
        os.environ[APART] = '1'
        os.execvp(unshare[0], [*unshare, 'sh', '-c', 'ip link set lo up && exec "$@"', 'sh', sys.executable, *sys.argv])


def main(arguments):
    """Follow a page; return the exit code."""
    in_browser = '--browser' in arguments
    arguments = [argument for argument in arguments if argument != '--browser']
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    enter_own_network()
    folder = Path(arguments.pop())
    folder.mkdir(parents=True, exist_ok=True)
    wrong = follow([(REPOSITORY / name).resolve() for name in arguments], os.environ['ws'], folder, in_browser)
    for text in wrong:
        print(f'WRONG: {text}')
    return 1 if wrong else 0


BEGIN = time.monotonic()
if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
