"""The programs that the page starts and stops: a fixed list of launch files, without arguments from outside, and bags.

What others have started, in a terminal for example, is found at the ROS master: the page starts nothing that would take
the place of a running program, unless its user asks for that.

Threading contract: the loop's thread calls all methods; what waits for programs or the master runs in threads of the
loop's executor.
"""
import asyncio
import functools
import itertools
import json
import os
import pathlib
import shlex
import signal
import tempfile
import time
from typing import NamedTuple, Tuple

from browser_servers.core import web
from course_page import recordings, running
from course_page.reasons import died, plain, reason
from course_page.recordings import Refused
from plain_support.processes import BackgroundProcess, end_with_parent

LAST_LINES = 12  # of a program's output
LARGEST = 200  # [characters] of a line
TAIL = 16384  # [bytes] of the output that are searched for them, once a second for each page
REASON_TAIL = 1 << 18  # [bytes] of the output that are searched for the reason of its end
MAX_BAGS = 20  # of the folder: the newest ones
LOOK_INTERVAL = 1.0  # [s] between two questions to the master, for all pages together
WATCH_INTERVAL = 1.0  # [s] between two looks at a recording
RECORDING = 'recording'  # what only one program may do at a time, beside the names of nodes


class Startable(NamedTuple):
    """A program of the list; ``command`` is also what a user can type.

    ``unique``: nodes, topics that are published, and services that only one program may have; a program is the one
    that has the first of them, if it also has these ``parameters`` ((name, value), ...). ``loses``: what its end loses.
    """

    name: str
    title: str
    about: str
    command: Tuple[str, ...]
    unique: Tuple[str, ...] = ()
    parameters: Tuple[Tuple[str, str], ...] = ()
    loses: str = ''


class Question(Exception):
    """A program may only be started when others end, which its user has to say; the text asks for it."""


def _launch(*arguments):
    return ('roslaunch', *arguments)


def _robot(name, title, about, world, file, model='robotont_gazebo_nuc'):
    given = () if model == 'robotont_gazebo_nuc' else (f'model:={model}',)
    return Startable(name, title, about, _launch('robotont_gazebo', file, *given),
                     ('/robotont_gazebo', '/robotont_camera', '/robot_state_publisher', '/odom',
                      '/gazebo/get_world_properties'),
                     (('/robotont_gazebo/world', world), ('/robotont_gazebo/model', model)))


STARTABLES = (
    Startable('turtlesim', 'Turtlesim', 'A turtle that draws. The panel Turtle shows it.',
              _launch('turtle_robotont', 'turtlesim.launch', 'window:=false'), ('/turtlesim', '/spawn'),
              loses='the drawing'),
    _robot('minimaze', 'Robotont in a maze', 'With camera and odometry. The panel Robotont shows it.', 'minimaze',
           'world_minimaze.launch'),
    _robot('minimaze_lidar', 'Robotont in a maze, with a lidar', 'The same maze, and a full laser scan.', 'minimaze',
           'world_minimaze.launch', 'robotont_gazebo_lidar'),
    _robot('minimaze_ar', 'Robotont in a maze with AR markers', 'Start the tracker, too, to see the markers.',
           'minimaze_ar', 'world_minimaze_ar.launch'),
    _robot('between', 'Robotont between two posts', 'The world of the lessons about the laser scan.', 'between',
           'world_between.launch'),
    _robot('bangbang', 'Robotont before a wall', 'The world of the lessons about keeping a distance.', 'bangbang',
           'world_bangbang.launch'),
    Startable('tracker', 'Tracker for the Robotont\'s camera', 'Finds the AR markers that the Robotont sees.',
              _launch('turtle_robotont', 'camera_ar_track.launch', 'source:=simulator'),
              ('/ar_track_alvar', '/ar_pose_marker'), (('/ar_track_alvar/output_frame', 'camera_link'),)),
    Startable('demo_camera', 'Camera and tracker without a camera', 'Plays pictures of AR markers.',
              _launch('turtle_robotont', 'camera_ar_track.launch'),
              ('/ar_track_alvar', '/ar_pose_marker', '/usb_cam'),
              (('/ar_track_alvar/output_frame', 'camera_optical_frame'),)),
    Startable('record', 'Record a bag', 'Records all topics but raw images and point clouds',
              recordings.command(recordings.LARGEST, False), (RECORDING,)),
    Startable('record_images', 'Record a bag, with images',
              'Records all topics; a camera fills the size below in seconds. It records',
              recordings.command(recordings.LARGEST, True), (RECORDING,)),
)
RECORDERS = {'record': False, 'record_images': True}  # name: whether with images


def last_lines(output):
    """Return the last lines of what a program has printed, without colours."""
    return '\n'.join(line[:LARGEST] for line in plain(output)[-LAST_LINES:])


def bags(folder):
    """Return a Startable that plays a bag for each of the newest ones in a folder."""
    found = {path: os.path.getmtime(path) for path in pathlib.Path(folder).glob('*.bag') if path.is_file()}
    return [Startable(f'play {path.name}', f'Play {path.name}', 'Publishes the messages in this bag.',
                      ('rosbag', 'play', f'./{path.name}'))
            for path in sorted(found, key=found.get, reverse=True)[:MAX_BAGS]]


def indexers(paths):
    """Return a Startable that indexes a recording for each of those that were cut off."""
    return [Startable(f'index {path.name}', f'Index {path.name}',
                      'This recording was not closed. With an index it can be played.',
                      ('rosrun', 'course_page', 'index_bag', f'./{path.name}')) for path in paths]


class Starter:
    """The programs that this server has started: STARTABLES, and the bags of the folder that it runs in.

    Their output is kept in a temporary folder. ``outlives``: this server runs on without the other nodes of its launch
    file.
    """

    def __init__(self, startables=STARTABLES, folder='.', outlives=False):
        self._fixed, self._place, self._outlives = startables, os.path.realpath(folder), outlives
        self._startables, self._lock = {one.name: one for one in startables}, None
        self._processes, self._ending, self._numbers = {}, set(), itertools.count()
        self._reasons, self._watches = {}, set()
        self._seen, self._looked = running.NOTHING, -LOOK_INTERVAL
        self._folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_page_')

    async def state(self):
        """Return a dict of each program, for JSON.

        ``state`` is stopped, running, elsewhere (another has started it), stopping or failed; ``reason`` tells of its
        end.
        """
        await self._look()
        await _in_thread(self._look_for_bags)
        return [{'name': one.name, 'title': one.title, 'about': self._about(one), 'command': shlex.join(one.command),
                 'state': self._state(one.name), 'reason': self._reason(one.name), 'output': self._output(one.name)}
                for one in self._startables.values()]

    async def _look(self, now=False):
        """Ask the master what runs, unless it was asked just before."""
        if now or time.monotonic() - self._looked > LOOK_INTERVAL:
            self._looked = time.monotonic()
            names = {name for one in self._fixed for name in one.unique if name != RECORDING}
            parameters = {name for one in self._fixed for name, _ in one.parameters}
            self._seen = await _in_thread(running.look, sorted(names), sorted(parameters))

    def _look_for_bags(self):
        cut_off = recordings.cut_off(self._place)
        for one in indexers([path for path, at_rest in cut_off.items() if at_rest]):
            if one.name not in self._processes:  # once
                self._launch(one)
        kept = [one for name, one in self._startables.items() if name in self._processes and
                (name.startswith('index ') or self._runs(name))]
        self._startables = {one.name: one for one in
                            (*self._fixed, *indexers(cut_off), *bags(self._place), *kept)}

    def _about(self, one):
        if one.name not in RECORDERS:
            return one.about
        try:
            size = recordings.limit(self._place)
        except Refused as error:
            return f'{one.about}. Not now: {error}.'
        return f'{one.about} into {self._place}, for at most {recordings.LONGEST} minutes and {size} MB.'

    def _runs(self, name):
        return name in self._processes and self._processes[name].runs()

    def _state(self, name):
        process = self._processes.get(name)
        if name in self._ending:
            return 'stopping'
        if process is not None and process.runs():
            return 'running'
        if self._startables[name] in self._elsewhere():
            return 'elsewhere'
        if process is None:
            return 'stopped'
        return 'failed' if process.process.returncode or died(process.output(REASON_TAIL)) else 'stopped'

    def _elsewhere(self):
        """Return the programs of the list that others have started."""
        ours = {name for one in self._started() for name in one.unique}
        return [one for one in self._fixed if one.unique and one.unique[0] in self._seen.holders
                and one.unique[0] not in ours and all(self._seen.values.get(name) == value
                                                      for name, value in one.parameters)]

    def _started(self):
        return [one for name, one in self._startables.items() if self._runs(name)]

    def _reason(self, name):
        process = self._processes.get(name)
        if name in self._reasons:
            return self._reasons[name]
        return reason(process.output(REASON_TAIL)) if self._state(name) == 'failed' else ''

    def _output(self, name):
        process = self._processes.get(name)
        return last_lines(process.output(TAIL) if process else '')

    async def start(self, name, instead=False):
        """Start a program unless it runs; with ``instead``, end those first that it would disturb.

        Raise KeyError for an unknown name, Question if others have to end first, Refused, or OSError.
        """
        if name not in self._startables:
            await self.state()
        one, self._lock = self._startables[name], self._lock or asyncio.Lock()
        async with self._lock:
            if self._state(name) in ('running', 'stopping'):
                return
            await self._look(now=True)
            await self._make_room(one, instead)
            if name in RECORDERS:
                await self._record(one)
            else:
                self._launch(one)

    async def _make_room(self, one, instead):
        """End the programs that ``one`` would disturb; without ``instead``, raise Question."""
        ours = [other for other in self._started() if set(other.unique) & set(one.unique)]
        holders = self._foreign(one, ours)
        if not (ours or holders):
            return
        titles = {other.title: other for other in (*ours, *self._elsewhere()) if set(other.unique) & set(one.unique)}
        what = ' and '.join(f'"{title}"' for title in titles) or ', '.join(sorted(holders))
        where = '' if ours else ', started in a terminal'
        if holders and not self._outlives and await _in_thread(running.started_with_this_page, holders):
            raise Refused(f'{what} runs already. It was started together with this page: end both by Ctrl-C in their '
                          'terminal, then start this')
        if not instead:
            losses = ', '.join(filter(None, (other.loses for other in titles.values())))
            text = f'{what} runs already{where}. End it and start this?'
            raise Question(f'{text} It loses {losses}.' if losses else text)
        for other in ours:
            await self.stop(other.name)
        left = await _in_thread(running.end, lambda: self._foreign(one, (), running.look(one.unique)))
        if left:
            raise Refused(f'{", ".join(sorted(left))} did not end: end it in its terminal by Ctrl-C, then start this')

    def _foreign(self, one, ours, seen=None):
        """Return the nodes of others that ``one`` would disturb."""
        holders = (seen or self._seen).holders
        known = {name for other in ours for name in other.unique}
        return set().union(*(users for name, users in holders.items() if name in one.unique and name not in known))

    def _launch(self, one, command=None):
        self._reasons.pop(one.name, None)
        self._processes[one.name] = BackgroundProcess(
            command or one.command, os.path.join(self._folder.name, str(next(self._numbers))), cwd=self._place,
            preexec_fn=functools.partial(end_with_parent, signal.SIGINT, os.getpid()))

    async def _record(self, one):
        size = recordings.limit(self._place)
        with_images = RECORDERS[one.name]
        raw = await _in_thread(recordings.raw_topics)
        master = await _in_thread(recordings.master_id)
        before = recordings.names(self._place)
        self._launch(one, recordings.command(size, with_images, () if with_images else raw))
        watch = asyncio.ensure_future(self._watch(one.name, size, master, before))
        self._watches.add(watch)  # the loop itself keeps no reference
        watch.add_done_callback(self._watches.discard)

    async def _watch(self, name, size, master, before):
        """End a recording at its limits, and tell what has become of it."""
        begun, process, why = time.monotonic(), self._processes[name], ''
        while not why and await _in_thread(process.members):
            await asyncio.sleep(WATCH_INTERVAL)
            if name not in self._ending:
                why = await _in_thread(recordings.reason_to_end, self._place, begun, master)
        if why:
            await self._end(name)
        self._reasons[name] = await _in_thread(recordings.outcome, self._place, before, size, why)

    async def stop(self, name):
        """End a program, as Ctrl-C does; raise KeyError for an unknown name."""
        self._startables[name]
        await self._end(name)

    async def _end(self, name):
        process = self._processes.get(name)
        if process is None or name in self._ending:
            return
        self._ending.add(name)
        try:
            await _in_thread(_end, name, process)
            del self._processes[name]
        finally:
            self._ending.discard(name)

    def end(self):
        """End all programs; the loop has ended."""
        for process in self._processes.values():
            process.signal(signal.SIGINT)
        for name, process in self._processes.items():
            _end(name, process)
        self._folder.cleanup()


def _end(name, process):
    if name in RECORDERS:
        recordings.close(process, signal.SIGINT)
    else:
        process.stop()


async def _in_thread(function, *arguments):
    return await asyncio.get_event_loop().run_in_executor(None, function, *arguments)


class Programs(web.Guarded):
    """GET: the state of all programs as JSON. POST ``{"name": ..., "action": "start" or "stop"}`` changes it."""

    async def get(self):
        self.answer_json(json.dumps(await self.settings['starter'].state()))

    async def post(self):
        """Start or stop a program; answer with the state, with 400 and what is allowed, or with 409 and why not.

        Or with ``{"question": TEXT}``, and nothing is done: ``"instead": true`` in the request ends what is in the way.
        """
        starter = self.settings['starter']
        try:
            asked = json.loads(self.request.body)
            name, action = asked['name'], asked['action']
            if action not in ('start', 'stop'):
                raise ValueError(f'action is {action!r:.40}; it must be "start" or "stop"')
            if action == 'start':
                await starter.start(name, asked.get('instead') is True)
            else:
                await starter.stop(name)
        except Question as question:
            self.answer_json(json.dumps({'question': str(question)}))
        except Refused as error:
            self.refuse(409, str(error))
        except OSError as error:
            self.refuse(500, f'{name} cannot be started: {error.strerror or error}')
        except (KeyError, TypeError, ValueError) as error:
            text = error if isinstance(error, ValueError) and 'must be' in str(error) else \
                'the request must be {"name": NAME, "action": "start" or "stop"}, with a NAME from the list'
            self.refuse(400, str(text))
        else:
            await self.get()
