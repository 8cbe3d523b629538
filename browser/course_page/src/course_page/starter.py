"""The programs that the page starts and stops: a fixed list of launch files, without arguments from outside, and bags.

Threading contract: the loop's thread calls all methods; processes are ended in threads of the loop's executor.
"""
import asyncio
import functools
import itertools
import json
import os
import pathlib
import re
import signal
import tempfile
from typing import NamedTuple, Tuple

from plain_support.processes import BackgroundProcess, end_with_parent
from rosbridge_core import web

LAST_LINES = 12  # of a program's output
LARGEST = 200  # [characters] of a line
TAIL = 16384  # [bytes] of the output that are searched for them, once a second for each page
MAX_BAGS = 20  # of the folder: the newest ones
CONTROL = re.compile(r'\x1b\[[0-9;]*[A-Za-z]|\x1b\][^\x07]*\x07')  # colours and the title of the terminal


class Startable(NamedTuple):
    """A program of the list; ``command`` is also what a user can type."""

    name: str
    title: str
    about: str
    command: Tuple[str, ...]


def _launch(*arguments):
    return ('roslaunch', *arguments)


STARTABLES = (
    Startable('turtlesim', 'Turtlesim', 'A turtle that draws. The panel Turtle shows it.',
              _launch('turtle_robotont', 'turtlesim.launch', 'window:=false')),
    Startable('minimaze', 'Robotont in a maze', 'With camera and odometry. The panel Robotont shows it.',
              _launch('robotont_gazebo', 'world_minimaze.launch')),
    Startable('minimaze_lidar', 'Robotont in a maze, with a lidar', 'The same maze, and a full laser scan.',
              _launch('robotont_gazebo', 'world_minimaze.launch', 'model:=robotont_gazebo_lidar')),
    Startable('minimaze_ar', 'Robotont in a maze with AR markers', 'Start the tracker, too, to see the markers.',
              _launch('robotont_gazebo', 'world_minimaze_ar.launch')),
    Startable('between', 'Robotont between two posts', 'The world of the lessons about the laser scan.',
              _launch('robotont_gazebo', 'world_between.launch')),
    Startable('bangbang', 'Robotont before a wall', 'The world of the lessons about keeping a distance.',
              _launch('robotont_gazebo', 'world_bangbang.launch')),
    Startable('tracker', 'Tracker for the Robotont\'s camera', 'Finds the AR markers that the Robotont sees.',
              _launch('turtle_robotont', 'camera_ar_track.launch', 'source:=simulator')),
    Startable('demo_camera', 'Camera and tracker without a camera', 'Plays pictures of AR markers.',
              _launch('turtle_robotont', 'camera_ar_track.launch')),
    Startable('record', 'Record a bag', 'Records all topics, for 10 minutes at most, into the folder of the programs.',
              ('rosbag', 'record', '--all', '--duration=10m', '--output-prefix=page')),
)


def last_lines(output):
    """Return the last lines of what a program has printed, without colours."""
    lines = CONTROL.sub('', output).strip().splitlines()
    return '\n'.join(line[:LARGEST] for line in lines[-LAST_LINES:])


def bags(folder):
    """Return a Startable that plays a bag for each of the newest ones in a folder."""
    found = sorted(pathlib.Path(folder).glob('*.bag'), key=os.path.getmtime, reverse=True)[:MAX_BAGS]
    return [Startable(f'play {path.name}', f'Play {path.name}', 'Publishes the messages in this bag.',
                      ('rosbag', 'play', f'./{path.name}')) for path in found]


class Starter:
    """The programs that this server has started: STARTABLES, and the bags of the folder that it runs in.

    Their output is kept in a temporary folder.
    """

    def __init__(self, startables=STARTABLES, folder='.'):
        self._fixed, self._place, self._startables = startables, folder, {}
        self._processes, self._ending, self._numbers = {}, set(), itertools.count()
        self._look_for_bags()
        self._folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_page_')

    def state(self):
        """Return a dict of each program, for JSON; ``state`` is stopped, running, stopping or failed."""
        self._look_for_bags()
        return [{'name': one.name, 'title': one.title, 'about': one.about, 'command': ' '.join(one.command),
                 'state': self._state(one.name), 'output': self._output(one.name)}
                for one in self._startables.values()]

    def _look_for_bags(self):
        running = [one for name, one in self._startables.items() if name in self._processes]
        self._startables = {one.name: one for one in (*self._fixed, *running, *bags(self._place))}

    def _state(self, name):
        process = self._processes.get(name)
        if name in self._ending:
            return 'stopping'
        if process is None:
            return 'stopped'
        return 'running' if process.runs() else 'failed' if process.process.returncode else 'stopped'

    def _output(self, name):
        process = self._processes.get(name)
        return last_lines(process.output(TAIL) if process else '')

    def start(self, name):
        """Start a program unless it runs; raise KeyError for an unknown name, or OSError."""
        command = self._startables[name].command
        if self._state(name) in ('running', 'stopping'):
            return
        self._processes[name] = BackgroundProcess(
            command, os.path.join(self._folder.name, str(next(self._numbers))), cwd=self._place,
            preexec_fn=functools.partial(end_with_parent, signal.SIGINT, os.getpid()))

    async def stop(self, name):
        """End a program, as Ctrl-C does; raise KeyError for an unknown name."""
        self._startables[name]
        process = self._processes.get(name)
        if process is None or name in self._ending:
            return
        self._ending.add(name)
        try:
            await asyncio.get_event_loop().run_in_executor(None, process.stop)
            del self._processes[name]
        finally:
            self._ending.discard(name)

    def end(self):
        """End all programs; the loop has ended."""
        for process in self._processes.values():
            process.signal(signal.SIGINT)
        for process in self._processes.values():
            process.stop()
        self._folder.cleanup()


class Programs(web.Guarded):
    """GET: the state of all programs as JSON. POST ``{"name": ..., "action": "start" or "stop"}``."""

    def get(self):
        self.answer_json(json.dumps(self.settings['starter'].state()))

    async def post(self):
        """Start or stop a program; answer with the state, or with 400 and what is allowed."""
        starter = self.settings['starter']
        try:
            asked = json.loads(self.request.body)
            name, action = asked['name'], asked['action']
            if action not in ('start', 'stop'):
                raise ValueError(f'action is {action!r:.40}; it must be "start" or "stop"')
            if action == 'start':
                starter.start(name)
            else:
                await starter.stop(name)
        except OSError as error:
            self.refuse(500, f'{name} cannot be started: {error.strerror or error}')
        except (KeyError, TypeError, ValueError) as error:
            text = error if isinstance(error, ValueError) and 'must be' in str(error) else \
                'the request must be {"name": NAME, "action": "start" or "stop"}, with a NAME from the list'
            self.refuse(400, str(text))
        else:
            self.get()
