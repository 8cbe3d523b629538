"""Exercise files: what a student is asked to do, how long it is observed, and what counts. YAML, without ROS.

KEYS, STIMULI and registry.RULES say what a file may contain. The points of all checks add up to 100. A check that
``must`` hold fails the exercise below half of its share.

All errors are reported together, so parsers collect them instead of raising: they append to a list of problems, and
return the values that they could read.
"""
import itertools
import math
import re
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from course_grader.rules import playable, variants
from course_grader.rules.fits import LINE
from course_grader.rules.judging import ALWAYS, ANY, VISIBLE, Parameter, Parameters, Rule, Span
from course_grader.rules.registry import RULES
from course_grader.rules.rules_driving import Apart, Draws, Passes, Pen, Positions, Repeats, SamePath, Stops
from course_grader.rules.rules_navigation import Maps, Navigates
from course_grader.rules.rules_output import Answers, PrintsMarkers, PrintsNoMarker, Reaches
from course_grader.rules.rules_state import Background, Keeps, Steers
from course_grader.rules.values import QuantityError, convert, meant
from kinematic_core.worlds import world_format
from kinematic_core.worlds.robot_world import ROBOT_RADIUS
from plain_support import InvalidInput, documents, packages, shown

SIMULATORS = ('turtlesim', 'robotont')
MOST_ROBOTS = 4
OF_ONE_ROBOT = 'commands', 'draws', 'moves', 'passes', 'stops'  # checks that may name one of several robots
NOT_WITH_ROBOTS = 'start', 'beside', 'odometry', 'localised', 'unmapped'  # keys
MAX_TIME = 240.0  # [s] of simulated time
MAX_STARTS = 5
ALLOWED = ('teleport', 'reset', 'kill')
BESIDE = ('map_server', 'amcl', 'slam_gmapping', 'move_base')
START: Parameters = {
    'x': Parameter('drawn length', None, 'position'), 'y': Parameter('drawn length', None, 'position'),
    'theta': Parameter('drawn angle', (0.0, 0.0), 'heading, counter-clockwise from the x axis')}
ODOMETRY: Parameters = {
    'noise': Parameter('length', 0.0, 'of each wheel after one metre'),
    'slip': Parameter('share', 0.0, 'by which the wheels turn in vain')}
SHIFT: Parameters = {axis: Parameter('drawn length', (0.0, 0.0), 'along this axis') for axis in 'xy'}


class StimulusKind(NamedTuple):
    """What the grader can do: one sentence, and its keys."""

    meaning: str
    parameters: Parameters


STIMULI: Dict[str, StimulusKind] = {  # what the grader can do
    'drive': StimulusKind('The grader drives the turtle with velocities that change every 2 s.', {
        'for': Parameter('time', ..., 'how long'),
        'after': Parameter('time or 0', 0.0, 'when it starts'),
        'linear': Parameter('drawn speed', (0.5, 1.5), 'drawn from this span'),
        'angular': Parameter('drawn turn speed', (-0.8, 0.8), 'drawn from this span')}),
    'call': StimulusKind('The grader calls a service and waits up to 5 s for each answer.', {
        'service': Parameter('name', ..., 'its name'),
        'type': Parameter('service type', ..., 'its type, such as `turtlesim/TeleportAbsolute`'),
        'request': Parameter('spans', ..., 'one number of each request is drawn from each span'),
        'times': Parameter('integer', 3, 'how many calls'),
        'after': Parameter('time or 0', 0.0, 'when they start')}),
    'markers': StimulusKind(
        'The grader shows markers with different ids, and every other time none, in 8 messages a second with a '
        'pause before each change.', {
        'for': Parameter('time', ..., 'how long'),
        'topic': Parameter('name', '/ar_pose_marker', 'where'),
        'rate': Parameter('rate', 2.0, 'how often they change'),
        'most': Parameter('integer', 3, 'the highest number of markers at once; each number up to it is shown')}),
    'turns': StimulusKind(
        'The grader shows a marker and turns it: another roll, pitch and yaw every 2 s, every fourth time no '
        'marker, in 8 messages a second.', {
        'for': Parameter('time', ..., 'how long'),
        'topic': Parameter('name', '/ar_pose_marker', 'where')}),
    'goals': StimulusKind(
        'The grader sends goals of actionlib_tutorials/FibonacciAction, waits up to 10 s for each result, and '
        'cancels the last goal after 1 s.', {
        'action': Parameter('name', ..., 'its name'),
        'times': Parameter(tuple(range(1, 6)), 2, 'how many goals, besides the one that is cancelled'),
        'after': Parameter('time or 0', 0.0, 'when they start')}),
    'carry': StimulusKind('The grader carries the robot away, as somebody does who lifts it: its wheels do not turn.', {
        'after': Parameter('time', ..., 'when'),
        'x': Parameter('drawn length', ..., 'where to'), 'y': Parameter('drawn length', ..., 'where to'),
        'theta': Parameter('drawn angle', (0.0, 0.0), 'heading there')}),
    'move': StimulusKind(
        'The grader moves a panel of the world, which is an obstacle; if the robot stands there, as soon as it '
        'has left.', {
        'after': Parameter('time', ..., 'when'),
        'panel': Parameter('text', ..., 'the name of a panel of the world'),
        'to': Parameter('pose', ..., 'where to, `[x, y, heading]`')}),
    'destinations': StimulusKind(
        'The grader sends these goals to move_base, each after the result of the one before it.', {
        'goals': Parameter('poses', ..., '`[[x, y, heading], ...]`, such as `[-2 m, 0.5 m, 90 deg]`'),
        'after': Parameter('time or 0', 0.0, 'when they start')}),
    'distances': StimulusKind(
        'The grader publishes what is left, ahead and right of the camera of the robot, 10 messages a second, as '
        'LaserScanSplit of robotont_laserscan_to_distance or robotont_sensors, as the program asks.', {
        'for': Parameter('time', ..., 'how long the program is watched at least'),
        'topic': Parameter('name', '/scan_to_distance', 'where')}),
    'tracker': StimulusKind(
        'The grader publishes the markers of the world that the camera of the robot sees, 7.5 messages a second: '
        'x ahead, y to the left.', {
        'for': Parameter('time', ..., 'how long the program is watched at least'),
        'topic': Parameter('name', '/ar_pose_marker', 'where')}),
}
KEYS: Parameters = {
    'title': Parameter('text', ..., 'one line'),
    'asks': Parameter('text', '', 'the task, for the report'),
    'simulator': Parameter(SIMULATORS, 'turtlesim', 'which simulator runs'),
    'time': Parameter('time', ..., 'the longest time for which the program is observed, in simulated time'),
    'pass': Parameter('number', 80.0, 'the score that passes, 0 to 100'),
    'vary': Parameter('mapping', {}, 'values that differ from student to student, drawn by their names; `$NAME` stands '
                      'for one in all texts'),
    'starts': Parameter('integer', 1, f'how often a program is graded, each time with other drawn values, 1 to '
                        f'{MAX_STARTS}; all have to pass'),
    'start': Parameter('mapping', {}, 'where the turtle or robot starts, drawn by the seed'),
    'robots': Parameter('mapping', {}, f'names of up to {MOST_ROBOTS} Robotonts, each with its start; they have laser '
                        'scanners, and their topics and frames lie in namespaces of these names'),
    'world': Parameter('mapping', {}, 'what stands around the robot, with the keys of a world file of robotont_gazebo; '
                       '`like` names one whose shapes stand there, too'),
    'beside': Parameter('list', [], f'which of {", ".join(BESIDE)} run, too; the robot then has a laser scanner'),
    'odometry': Parameter('mapping', {}, 'errors of the odometry'),
    'parameters': Parameter('mapping', {}, 'parameters of the nodes in `beside`, instead of those in their launch '
                            'files: full name and value'),
    'localised': Parameter('boolean', False, 'whether amcl knows where the robot starts'),
    'unmapped': Parameter('list', [], 'names of what stands in the world, and not on the map of map_server'),
    'shift': Parameter('mapping', {}, 'by how much the world, and the points of `stops` and `passes`, are shifted, '
                       'drawn by the seed'),
    'allows': Parameter('list', [], f'which of {", ".join(ALLOWED)} are allowed; the others are shortcuts'),
    'solution': Parameter('text', '', 'a Python program that does what is asked, for the check `same_path`'),
    'stimuli': Parameter('list', [], 'what the grader does meanwhile'),
    'checks': Parameter('list', ..., 'what counts'),
    'symptoms': Parameter('list', [], 'advice for mistakes, to a program that lost points')}
OF_A_CHECK: Parameters = {
    'points': Parameter('number', ..., 'how many of the 100 points it gives'),
    'must': Parameter('boolean', False, 'whether the exercise fails below half of its points'),
    'robot': Parameter('text', '', 'which one of several robots it judges; the first, if empty'),
    'visible': Parameter(VISIBLE, ALWAYS, 'when students see it in their results')}

OF_A_SYMPTOM: Parameters = {
    'hint': Parameter('text', ..., 'the advice, one sentence'),
    'lost': Parameter('check', None, 'the check that lost points'),
    'kept': Parameter('check', None, 'the check that lost no points'),
    'seen': Parameter('pattern', None, 'found in what the report says of a check that lost points'),
    'prints': Parameter('pattern', None, 'found in what the program printed, or in why it failed'),
    'source': Parameter('pattern', None, 'found in the Python source of the program'),
    'publishes': Parameter('pattern', None, 'found in the name of a topic that it publishes'),
    'subscribes': Parameter('pattern', None, 'found in the name of a topic that it subscribes to'),
    'serves': Parameter('pattern', None, 'found in the name of a service that it offers'),
    'pen': Parameter('colour', None, 'a colour to which it sets the pen, `[red, green, blue]`'),
    'linear': Parameter('span speed', ANY, 'the median of linear.x of its commands'),
    'sideways': Parameter('span speed', ANY, 'the same of linear.y'),
    'angular': Parameter('span turn speed', ANY, 'the same of angular.z'),
    'end x': Parameter('span length', ANY, 'where the turtle or robot is at the end'),
    'end y': Parameter('span length', ANY, 'the same for y'),
}


NEEDS = {'turtlesim': ('drive',), 'robotont': ('distances', 'tracker', 'carry', 'move')}  # simulator: stimuli


class ExerciseError(ValueError):
    """An exercise file is wrong; the text has a line for each mistake: where, what and what is allowed."""


class ScoredRule(NamedTuple):
    """One of the ``checks`` of an exercise: name, rule, points, whether it must hold, when it is visible.

    ``robot``: which one of several robots it judges; '': the first.
    """

    name: str
    rule: Rule
    points: float
    must: bool
    visible: str = ALWAYS
    robot: str = ''


Stimulus = Tuple[str, Dict[str, Any]]  # what, {parameter: value}


class Exercise(NamedTuple):
    """An exercise as its file describes it; times in s, angles in rad, ``start`` as {axis: (low, high)}."""

    name: str
    title: str
    asks: str
    simulator: str
    time: float
    pass_score: float
    start: Dict[str, Span]
    allows: Tuple[str, ...]
    stimuli: List[Stimulus]
    rules: List[ScoredRule]
    symptoms: List[Dict[str, Any]] = []  # {'hint': advice, predicate: value or None}, see symptoms.py
    world: Dict[str, Any] = {}  # what stands around the robot, as in a world file
    shift: Dict[str, Span] = {}  # {axis: (low, high)} by which it is shifted
    beside: Tuple[str, ...] = ()  # nodes that run beside the simulator
    odometry: Dict[str, float] = {}  # noise [m], slip
    parameters: Dict[str, Any] = {}  # {full name: value} of the nodes in beside
    localised: bool = False  # whether amcl knows the start
    unmapped: Tuple[str, ...] = ()  # names of shapes that are not on the map
    varies: bool = False  # whether it has values that differ from student to student
    starts: int = 1  # how often a program is graded, each time with other drawn values
    robots: Dict[str, Dict[str, Span]] = {}  # several ones, by name, each with its start as in ``start``
    solution: str = ''  # a Python program whose path is compared with that of students

    @property
    def of_map(self) -> bool:
        """Whether a map file is handed in, and no program."""
        return any(_is_of_map(scored.rule) for scored in self.rules)


def load(path: documents.Path, student: str = '') -> Exercise:
    """Return the Exercise of a file, for a student if it varies.

    Raise ExerciseError, or OSError when it cannot be read.
    """
    try:
        content = documents.read_yaml(path)
    except documents.DocumentError as error:
        raise ExerciseError(f'{path}: {error}') from None
    name = re.sub(r'\.ya?ml$', '', str(path).rsplit('/', 1)[-1])
    try:
        return parse(content, name, student)
    except ExerciseError as error:
        lines = str(error).split('\n')
        head = '' if len(lines) == 1 else f'{len(lines)} mistakes\n  '
        raise ExerciseError(f'{path}: {head}' + '\n  '.join(lines)) from None


def parse(content: Any, name: str = 'exercise', student: str = '') -> Exercise:
    """Return the Exercise in what a YAML file holds, with the values of a student."""
    problems: List[str] = []
    content_of_all, content = content, variants.content_for(content, name, student, problems)
    values = _fields(content, KEYS, 'the exercise', problems)
    start, robots = _start(values, problems), _robots(values, problems)
    shift = _fields(values['shift'], SHIFT, 'shift', problems) if values.get('shift') else {}
    values['world'] = _whole_world(values.get('world', {}), problems)
    problems += _wrong_world(values)
    odometry = _fields(values['odometry'], ODOMETRY, 'odometry', problems) if values.get('odometry') else {}
    rules = list(filter(None, (_rule(entry, number, problems)
                               for number, entry in enumerate(values.get('checks', ()), 1))))
    points = sum(scored.points for scored in rules)
    if 'checks' in values and len(rules) == len(values['checks']) and abs(points - 100.0) > 1e-6:
        problems.append(f'the points of the checks add up to {points:g}; they must add up to 100')
    stimuli = list(filter(None, (_stimulus(entry, number, problems)
                                 for number, entry in enumerate(values.get('stimuli', ()), 1))))
    symptoms = [_fields(entry, OF_A_SYMPTOM, f'symptom {number}', problems)
                for number, entry in enumerate(values.get('symptoms', ()), 1)]
    problems += _out_of_limits(values, content)
    problems += _wrong_navigation(values)
    if not problems:
        values.update({key: tuple(values[key]) for key in ('allows', 'beside', 'unmapped')},
                      asks=values['asks'].strip(), start=start, robots=robots, shift=shift, odometry=odometry,
                      stimuli=stimuli, symptoms=symptoms)
        del values['checks']
        made = Exercise(name=name, pass_score=values.pop('pass'), varies=bool(values.pop('vary')), rules=rules,
                        **values)
        problems = [*_contradictions(made), *playable.problems(made)]
        if not problems:
            problems = list(_of_others(content_of_all, name))
        if not problems:
            return made
    raise ExerciseError('\n'.join(problems))


def _out_of_limits(values: Dict[str, Any], content: Any) -> Iterator[str]:
    """Yield texts about numbers beyond their limits, and shortcuts that do not exist; ``content``: as typed."""
    if not 0.0 < values.get('time', MAX_TIME) <= MAX_TIME:
        yield f'time is {shown(content["time"])}; it must be above 0 and at most {MAX_TIME:g} s'
    if values.get('starts', 1) > MAX_STARTS:
        yield f'starts is {values["starts"]}; it must be 1 to {MAX_STARTS}'
    if not 0.0 < values.get('pass', 100.0) <= 100.0:
        yield f'pass is {values["pass"]:g}; it must be above 0 and at most 100'
    yield from (f'allows has {shown(kind)}; it may have {", ".join(ALLOWED)}{meant(kind, ALLOWED)}'
                for kind in values.get('allows', ()) if kind not in ALLOWED)


def _of_others(content: Any, name: str) -> Iterator[str]:
    """Yield the problems with the values of other students, at the ends of what is drawn."""
    for values, filled in variants.ends(content):
        try:
            parse(filled, name)
        except ExerciseError as error:
            yield from (f'for students who get {values}: {line}' for line in str(error).split('\n'))


def _start(values: Dict[str, Any], problems: List[str]) -> Dict[str, Span]:
    limits = {axis: found for axis, found in _fields(values.get('start', {}), START, 'start', problems).items()
              if found is not None}
    for axis in 'xy' if values.get('simulator') == 'turtlesim' else '':
        low, high = limits.get(axis, playable.ARENA)
        if not playable.ARENA[0] <= low <= high <= playable.ARENA[1]:
            problems.append(f'start: {axis} is {values["start"][axis]}; the arena allows 0 to '
                            f'{playable.ARENA[1]:.4f} m')
    return limits


def _robots(values: Dict[str, Any], problems: List[str]) -> Dict[str, Dict[str, Span]]:
    """Return {name: start} of several robots."""
    given, before = values.get('robots', {}), len(problems)
    robots = {name: _fields(start, START, f'robots: {shown(name)}', problems) for name, start in given.items()}
    problems += [f'robots has the name {shown(name)}; it must be a letter, then letters, digits or _, such as robot1'
                 for name in robots if not re.fullmatch(r'[A-Za-z]\w*', str(name), re.ASCII)]
    problems += [f'robots: {name} lacks the key {axis}: where it starts' for name, start in robots.items()
                 for axis in 'xy' if axis in start and start[axis] is None]
    if len(robots) > MOST_ROBOTS:
        problems.append(f'robots has {len(robots)} robots; it may have up to {MOST_ROBOTS}')
    if robots and values.get('simulator') != 'robotont':
        problems.append('robots needs simulator: robotont')
    problems += [f'robots and {key} cannot be combined' for key in NOT_WITH_ROBOTS if robots and values.get(key)]
    if len(problems) == before:
        problems += [f'robots: {one} and {other} may start closer than {2.0 * ROBOT_RADIUS:g} m, and then touch'
                     for one, other in itertools.combinations(robots, 2)
                     if math.hypot(*(_gap(robots[one][axis], robots[other][axis]) for axis in 'xy'))
                     < 2.0 * ROBOT_RADIUS]
    return robots


def _gap(one: Span, other: Span) -> float:
    """Return the distance between two spans, 0 if they overlap."""
    return max(one[0] - other[1], other[0] - one[1], 0.0)


def _whole_world(world: Dict[str, Any], problems: List[str]) -> Dict[str, Any]:
    """Return a world with the shapes of the one that it is ``like``."""
    if 'like' not in world:
        return world
    worlds = packages.folder('robotont_gazebo') / 'worlds'
    names = sorted(path.stem for path in worlds.glob('*.yaml'))
    if world['like'] not in names:
        problems.append(f'world: like is {shown(world["like"])}; it must be one of {", ".join(names)}'
                        f'{meant(world["like"], names)}')
        return {}
    known = documents.read_yaml(worlds / f'{world["like"]}.yaml')
    return {**known, **{key: [*known.get(key, ()), *value] if key in world_format.KINDS and isinstance(value, list)
                        else value for key, value in world.items() if key != 'like'}}


def _wrong_navigation(values: Dict[str, Any]) -> Iterator[str]:
    """Yield texts about the nodes that run beside the simulator, and what they need."""
    beside = values.get('beside', ())
    yield from (f'beside has {shown(name)}; it may have {", ".join(BESIDE)}{meant(name, BESIDE)}'
                for name in beside if name not in BESIDE)
    if beside and values.get('simulator') != 'robotont':
        yield 'beside needs simulator: robotont'
    if {'map_server', 'slam_gmapping'} <= set(beside):
        yield 'beside has map_server and slam_gmapping; only one of them can publish the map'
    if 'map_server' in beside and not values.get('world'):
        yield 'map_server needs a world, of which it publishes the map'
    nodes = tuple(f'/{name}/' for name in beside)
    example = nodes[0] if nodes else '/move_base/'
    yield from (f'parameters has {shown(name)}; it must begin with the name of a node in beside, such as {example}'
                for name in values.get('parameters', ()) if not str(name).startswith(nodes))
    world = values.get('world')
    lists = [world.get(kind) for kind in world_format.KINDS] if isinstance(world, dict) else []
    shapes = [str(shape.get('name')) for shapes in lists if isinstance(shapes, list) for shape in shapes
              if isinstance(shape, dict)]
    yield from (f'unmapped has {shown(name)}; nothing in the world has that name{meant(name, shapes)}'
                for name in values.get('unmapped', ()) if name not in shapes)


def _wrong_world(values: Dict[str, Any]) -> List[str]:
    """Return the problems of the world, as texts."""
    if not values.get('world'):
        return ['shift needs a world'] if values.get('shift') else []
    if values.get('simulator') != 'robotont':
        return ['world needs simulator: robotont']
    try:
        world_format.parse(values['world'])
    except InvalidInput as error:
        return [f'world: {error}']
    return []


def _rule(entry: Any, number: int, problems: List[str]) -> Optional[ScoredRule]:
    """Return a check, or None if it is wrong."""
    before, where = len(problems), f'check {number}'
    name, entry = _named(entry, 'check', where, RULES, problems)
    if name is None:
        return None
    where = f'{where} ({name})'
    common = _fields({key: entry.pop(key) for key in OF_A_CHECK if key in entry}, OF_A_CHECK, where, problems)
    if common.get('points', 1.0) <= 0.0:
        problems.append(f'{where}: points is {common["points"]:g}; it must be above 0')
    values = _fields(entry, RULES[name].parameters(), where, problems)
    return ScoredRule(name, RULES[name](**values), **common) if len(problems) == before else None


def _stimulus(entry: Any, number: int, problems: List[str]) -> Optional[Stimulus]:
    """Return a stimulus, or None if it is wrong."""
    before, where = len(problems), f'stimulus {number}'
    what, entry = _named(entry, 'do', where, STIMULI, problems)
    values = _fields(entry, STIMULI[what].parameters, f'{where} ({what})', problems) if what else {}
    return (what, values) if what and len(problems) == before else None


def _named(entry: Any, key: str, where: str, allowed: Iterable[str], problems: List[str]
           ) -> Tuple[Optional[str], Dict[Any, Any]]:
    """Return the name that an entry has for a key, or None if it is wrong, and the other keys of the entry."""
    if not _is_mapping(entry, where, problems):
        return None, {}
    others = {name: value for name, value in entry.items() if name != key}
    name = entry.get(key)
    if isinstance(name, str) and name in allowed:
        return name, others
    problems.append(f'{where}: {key} is {shown(name)}; it must be one of {", ".join(allowed)}{meant(name, allowed)}')
    return None, others


def _contradictions(made: Exercise) -> Iterator[str]:
    """Yield texts about requirements that no program can fulfil."""
    yield from (f'{key} needs a program, and a check maps with of: file has none'
                for key in ('beside', 'stimuli', 'robots') if made.of_map and getattr(made, key))
    for number, scored in enumerate(made.rules, 1):
        yield from (f'check {number} ({scored.name}) {text}' for text in _missing(scored, made))
    if made.solution and not any(isinstance(scored.rule, SamePath) for scored in made.rules):
        yield 'solution is for the check same_path, and checks has none'
    for number, (what, values) in enumerate(made.stimuli, 1):
        where, end = f'stimulus {number} ({what})', values.get('after', 0.0) + values.get('for', 0.0)
        if end > made.time or (what == 'call' and end >= made.time):
            yield f'{where} lasts until {end:g} s, longer than the time of the exercise, {made.time:g} s'
        if what == 'move' and values['panel'] not in (names := [one['name'] for one in made.world.get('panels', ())]):
            yield f'{where}: there is no panel {shown(values["panel"])} in the world{meant(values["panel"], names)}'
        if what == 'destinations' and 'move_base' not in made.beside:
            yield f'{where} needs move_base in beside'
        for simulator, kinds in NEEDS.items():
            if what in kinds and made.simulator != simulator:
                yield f'{where} needs simulator: {simulator}'
            elif what in kinds and made.robots:
                yield f'{where} needs one robot, and the exercise has robots: {", ".join(made.robots)}'


def _missing(scored: ScoredRule, made: Exercise) -> Iterator[str]:
    """Yield texts about what a check needs and the exercise lacks."""
    rule = scored.rule
    yield from _missing_keys(rule)
    if made.of_map and not _is_of_map(rule):
        yield 'needs a program, and a check maps with of: file has none: give it an exercise of its own'
    yield from _missing_robot(scored, made)
    yield from _missing_stimulus(rule, made)
    if isinstance(rule, (Maps, Navigates)) and not made.world:
        yield 'needs a world: there are no walls'
    if isinstance(rule, (PrintsMarkers, PrintsNoMarker)):
        most = max((int(show['for'] * show['rate']) for what, show in made.stimuli if what == 'markers'), default=0)
        if most < (2 if isinstance(rule, PrintsNoMarker) else 1):  # the second message is the first without markers
            yield 'needs a stimulus {do: markers, ...} of two messages: the first shows markers, the second none'
    by_teleports = isinstance(rule, Positions) and rule.by == 'teleports'
    if by_teleports and 'teleport' not in made.allows:
        yield 'needs the line: allows: [teleport]'
    if (by_teleports or isinstance(rule, (Pen, Background))) and made.simulator != 'turtlesim':
        yield 'needs simulator: turtlesim'


def _missing_keys(rule: Rule) -> Iterator[str]:
    """Yield texts about keys of a check that belong together."""
    if isinstance(rule, Stops) and rule.x is None and rule.y is None:
        yield 'lacks the key x or y: where to stop'
    if isinstance(rule, Draws) and (rule.shape == LINE) != (len(rule.through) > 1):
        yield 'needs the key through with two or more points for the shape line, and no such key for others'
    if isinstance(rule, Passes) and bool(rule.through) == (None not in (rule.x, rule.y)):
        yield 'needs either x and y, or through'


def _is_of_map(rule: Rule) -> bool:
    return isinstance(rule, Maps) and rule.of == 'file'


def _missing_robot(scored: ScoredRule, made: Exercise) -> Iterator[str]:
    """Yield texts about robots that a check names, or needs, and the exercise lacks."""
    if scored.robot and scored.robot not in made.robots:
        yield (f'has robot: {shown(scored.robot)}; it must be one of robots: {", ".join(made.robots) or "none"}'
               f'{meant(scored.robot, made.robots)}')
    elif scored.robot and scored.name not in OF_ONE_ROBOT:
        yield f'judges no single robot; robot may stand in {", ".join(OF_ONE_ROBOT)}'
    if isinstance(scored.rule, Apart) and len(made.robots) < 2:
        yield 'needs two or more robots'


def _missing_stimulus(rule: Rule, made: Exercise) -> Iterator[str]:
    """Yield the stimulus or program that a check needs and the exercise lacks, as a text."""
    done = dict(made.stimuli)
    if isinstance(rule, Answers) and rule.service not in {
            values['service'] for what, values in made.stimuli if what == 'call'}:
        yield f'needs a stimulus {{do: call, service: {rule.service}, ...}}: nobody calls that service'
    if isinstance(rule, Reaches) and rule.action not in {
            values['action'] for what, values in made.stimuli if what == 'goals'}:
        yield f'needs a stimulus {{do: goals, action: {rule.action}, ...}}: nobody sends goals to that action'
    if isinstance(rule, SamePath) and not made.solution:
        yield 'needs the key solution: a program to compare with'
    if isinstance(rule, Repeats) and 'drive' not in done:
        yield 'needs a stimulus {do: drive, ...}: there is nothing to repeat'
    if isinstance(rule, Steers) and 'turns' not in done:
        yield 'needs a stimulus {do: turns, ...}: nothing shows the program an angle'
    if isinstance(rule, Keeps):
        needed = 'distances' if rule.what == 'ahead' else 'tracker'
        if needed not in done:
            yield f'needs a stimulus {{do: {needed}, ...}}: nothing tells the program how far it is'


def _is_mapping(value: Any, where: str, problems: List[str]) -> bool:
    """Return whether a value is a mapping."""
    if not isinstance(value, dict):
        what = 'empty' if value is None else shown(value)
        problems.append(f'{where} is {what}; it must be a mapping (keys with values)')
    return isinstance(value, dict)


def _fields(entry: Any, kinds: Parameters, where: str, problems: List[str]) -> Dict[str, Any]:
    """Return {key: value} of all ``kinds``, converted, without those that are wrong."""
    if not _is_mapping(entry, where, problems):
        return {}
    allowed = ', '.join(kinds) or 'none'
    problems += [f'{where} has an unknown key {shown(key)}; it may have {allowed}{meant(key, kinds)}'
                 for key in entry if key not in kinds]
    values = {}
    for key, (kind, default, _) in kinds.items():
        try:
            if key in entry:
                values[key] = convert(entry[key], tuple(RULES) if kind == 'check' else kind)
            elif default is ...:
                problems.append(f'{where} lacks the key {key}')
            else:
                values[key] = default
        except (QuantityError, re.error, OverflowError, RecursionError) as error:
            problems.append(f'{where}: {key}: {error}')
    return values
