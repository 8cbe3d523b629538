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
from typing import Any, Callable, Collection, Dict, Iterable, List, NamedTuple, Optional, Sequence, Set, Tuple

from browser_servers.core import web
from course_page import recordings, running
from course_page.reasons import died, last_lines, reason
from course_page.recordings import Refused
from plain_support.processes import BackgroundProcess, end_with_parent

TAIL = 16384  # [bytes] of the output that are searched for its last lines, once a second for each page
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


def _launch(*arguments: str) -> Tuple[str, ...]:
    return ('roslaunch', *arguments)


def _robot(name: str, title: str, about: str, world: str, file: str, model: str = 'robotont_gazebo_nuc') -> Startable:
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


def bags(folder: str) -> List[Startable]:
    """Return a Startable that plays a bag for each of the newest ones in a folder."""
    times = {path: os.path.getmtime(path) for path in pathlib.Path(folder).glob('*.bag') if path.is_file()}
    return [Startable(f'play {path.name}', f'Play {path.name}', 'Publishes the messages in this bag.',
                      ('rosbag', 'play', f'./{path.name}'))
            for path in sorted(times, key=times.__getitem__, reverse=True)[:MAX_BAGS]]


def indexers(paths: Iterable[pathlib.Path]) -> List[Startable]:
    """Return a Startable that indexes a recording for each of those that were cut off."""
    return [Startable(f'index {path.name}', f'Index {path.name}',
                      'This recording was not closed. With an index it can be played.',
                      ('rosrun', 'course_page', 'index_bag', f'./{path.name}')) for path in paths]


class Starter:
    """The programs that this server has started: STARTABLES, and the bags of the folder that it runs in.

    Their output is kept in a temporary folder. ``outlives``: this server runs on without the other nodes of its launch
    file.
    """

    def __init__(self, startables: Sequence[Startable] = STARTABLES, folder: str = '.',
                 outlives: bool = False) -> None:
        self._fixed, self._work, self._outlives = startables, os.path.realpath(folder), outlives
        self._startables = {startable.name: startable for startable in startables}
        self._lock: Optional[asyncio.Lock] = None
        self._processes: Dict[str, BackgroundProcess] = {}
        self._ending: Set[str] = set()
        self._numbers = itertools.count()
        self._reasons: Dict[str, str] = {}
        self._watches: Set[asyncio.Future[None]] = set()
        self._seen, self._looked = running.NOTHING, -LOOK_INTERVAL
        self._folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_page_')

    async def state(self) -> List[Dict[str, str]]:
        """Return a dict of each program, for JSON.

        ``state`` is stopped, running, elsewhere (another has started it), stopping or failed; ``reason`` tells of its
        end.
        """
        await self._look()
        await _in_thread(self._look_for_bags)
        return [{'name': name, 'title': program.title, 'about': self._about(program),
                 'command': shlex.join(program.command), 'state': self._state(name), 'reason': self._reason(name),
                 'output': self._output(name)} for name, program in self._startables.items()]

    async def _look(self, now: bool = False) -> None:
        """Ask the master what runs, unless it was asked just before."""
        if now or time.monotonic() - self._looked > LOOK_INTERVAL:
            self._looked = time.monotonic()
            names = {name for program in self._fixed for name in program.unique if name != RECORDING}
            parameters = {name for program in self._fixed for name, _ in program.parameters}
            self._seen = await _in_thread(running.look, sorted(names), sorted(parameters))

    def _look_for_bags(self) -> None:
        cut_off = recordings.cut_off(self._work)
        for indexer in indexers([path for path, at_rest in cut_off.items() if at_rest]):
            if indexer.name not in self._processes:  # once
                self._launch(indexer)
        kept = [program for name, program in self._startables.items() if name in self._processes and
                (name.startswith('index ') or self._runs(name))]
        self._startables = {program.name: program for program in
                            (*self._fixed, *indexers(cut_off), *bags(self._work), *kept)}

    def _about(self, program: Startable) -> str:
        if program.name not in RECORDERS:
            return program.about
        try:
            size = recordings.limit(self._work)
        except Refused as error:
            return f'{program.about}. Not now: {error}.'
        return f'{program.about} into {self._work}, for at most {recordings.LONGEST} minutes and {size} MB.'

    def _runs(self, name: str) -> bool:
        return name in self._processes and self._processes[name].runs()

    def _state(self, name: str) -> str:
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

    def _elsewhere(self) -> List[Startable]:
        """Return the programs of the list that others have started."""
        ours = {name for program in self._started() for name in program.unique}
        return [program for program in self._fixed
                if program.unique and program.unique[0] in self._seen.holders and program.unique[0] not in ours
                and all(self._seen.values.get(name) == value for name, value in program.parameters)]

    def _started(self) -> List[Startable]:
        return [program for name, program in self._startables.items() if self._runs(name)]

    def _reason(self, name: str) -> str:
        process = self._processes.get(name)
        if name in self._reasons:
            return self._reasons[name]
        return reason(process.output(REASON_TAIL)) if process and self._state(name) == 'failed' else ''

    def _output(self, name: str) -> str:
        process = self._processes.get(name)
        return last_lines(process.output(TAIL) if process else '')

    async def start(self, name: str, instead: bool = False) -> None:
        """Start a program unless it runs; with ``instead``, end those first that it would disturb.

        Raise KeyError for an unknown name, Question if others have to end first, Refused, or OSError.
        """
        if name not in self._startables:
            await self.state()
        program, self._lock = self._startables[name], self._lock or asyncio.Lock()
        async with self._lock:
            if self._state(name) in ('running', 'stopping'):
                return
            await self._look(now=True)
            await self._make_room(program, instead)
            if name in RECORDERS:
                await self._record(program)
            else:
                self._launch(program)

    async def _make_room(self, program: Startable, instead: bool) -> None:
        """End the programs that ``program`` would disturb; without ``instead``, raise Question."""
        ours = [other for other in self._started() if set(other.unique) & set(program.unique)]
        holders = self._foreign(program, ours)
        if not (ours or holders):
            return
        titles = {other.title: other for other in (*ours, *self._elsewhere())
                  if set(other.unique) & set(program.unique)}
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
        left = await _in_thread(running.end, lambda: self._foreign(program, (), running.look(program.unique)))
        if left:
            raise Refused(f'{", ".join(sorted(left))} did not end: end it in its terminal by Ctrl-C, then start this')

    def _foreign(self, program: Startable, ours: Collection[Startable],
                 seen: Optional[running.Seen] = None) -> Set[str]:
        """Return the nodes of others that ``program`` would disturb."""
        contested = set(program.unique) - {name for other in ours for name in other.unique}
        holders = (seen or self._seen).holders
        return {node for name, users in holders.items() if name in contested for node in users}

    def _launch(self, program: Startable, command: Sequence[str] = ()) -> None:
        self._reasons.pop(program.name, None)
        self._processes[program.name] = BackgroundProcess(
            command or program.command, os.path.join(self._folder.name, str(next(self._numbers))), cwd=self._work,
            preexec_fn=functools.partial(end_with_parent, signal.SIGINT, os.getpid()))

    async def _record(self, program: Startable) -> None:
        size = recordings.limit(self._work)
        with_images = RECORDERS[program.name]
        raw = await _in_thread(recordings.raw_topics)
        master = await _in_thread(recordings.master_id)
        before = recordings.names(self._work)
        self._launch(program, recordings.command(size, with_images, () if with_images else raw))
        watch = asyncio.ensure_future(self._watch(program.name, size, master, before))
        self._watches.add(watch)  # the loop itself keeps no reference
        watch.add_done_callback(self._watches.discard)

    async def _watch(self, name: str, size: int, master: Optional[int], before: Set[str]) -> None:
        """End a recording at its limits, and keep what has become of it as the reason of its end."""
        begun, process = time.monotonic(), self._processes[name]
        why: Optional[str] = None
        while why is None and await _in_thread(process.members):
            await asyncio.sleep(WATCH_INTERVAL)
            if name not in self._ending:
                why = await _in_thread(recordings.reason_to_end, self._work, begun, master)
        if why is not None:
            await self._end(name)
        self._reasons[name] = await _in_thread(recordings.outcome, self._work, before, size, why)

    async def stop(self, name: str) -> None:
        """End a program, as Ctrl-C does; raise KeyError for an unknown name."""
        self._startables[name]
        await self._end(name)

    async def _end(self, name: str) -> None:
        process = self._processes.get(name)
        if process is None or name in self._ending:
            return
        self._ending.add(name)
        try:
            await _in_thread(_end, name, process)
            del self._processes[name]
        finally:
            self._ending.discard(name)

    def end(self) -> None:
        """End all programs; the loop has ended."""
        for process in self._processes.values():
            process.signal(signal.SIGINT)
        for name, process in self._processes.items():
            _end(name, process)
        self._folder.cleanup()


def _end(name: str, process: BackgroundProcess) -> None:
    if name in RECORDERS:
        recordings.close(process, signal.SIGINT)
    else:
        process.stop()


async def _in_thread(function: Callable[..., Any], *arguments: Any) -> Any:
    return await asyncio.get_event_loop().run_in_executor(None, function, *arguments)


class Programs(web.Guarded):
    """GET: the state of all programs as JSON. POST ``{"name": ..., "action": "start" or "stop"}`` changes it."""

    async def get(self) -> None:
        self.answer_json(json.dumps(await self.settings['starter'].state()))

    async def post(self) -> None:
        """Start or stop a program; answer with the state, with 400 and what is allowed, or with 409 and why not.

        Or with ``{"question": TEXT}``, and nothing is done: ``"instead": true`` in the request ends what is in the way.
        """
        starter = self.settings['starter']
        try:
            request = json.loads(self.request.body)
            name, action = request['name'], request['action']
            if action not in ('start', 'stop'):
                raise ValueError(f'action is {action!r:.40}; it must be "start" or "stop"')
            if action == 'start':
                await starter.start(name, request.get('instead') is True)
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
