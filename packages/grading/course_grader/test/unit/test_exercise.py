"""course_grader.rules.exercise: the repository's exercise files are read; wrong ones are named with the key."""
import copy
import math

import pytest

from course_grader.rules import exercise, registry, rules_driving, rules_output
from unit_support.course_files import EXERCISES

GOOD = {'title': 'T', 'time': '10 s', 'start': {'x': '3 to 5 m'}, 'allows': ['teleport'],
        'stimuli': [{'do': 'drive', 'for': '3 s'}],
        'checks': [{'check': 'moves', 'points': 60, 'length': '2 m'}, {'check': 'runs', 'points': 40, 'must': True}]}


@pytest.mark.parametrize('path', EXERCISES.values(), ids=lambda path: path.stem)
def test_exercise_files_are_right(path):
    loaded = exercise.load(path)
    assert loaded.name == path.stem and loaded.asks and loaded.title
    assert any(scored.must for scored in loaded.rules)


@pytest.mark.parametrize('path', EXERCISES.values(), ids=lambda path: path.stem)
def test_the_task_says_what_counts(path):
    """The time, each name and each service that is checked, and what else is allowed stand in the task."""
    loaded = exercise.load(path)
    values = [(key, str(value)) for scored in loaded.rules for key, value in vars(scored.rule).items()]
    names = [value.lstrip('/') for key, value in values if key in ('topic', 'service')]
    names += [value for key, value in values if key == 'by' and value.startswith('teleport_')]
    counted = [*names, *([] if loaded.of_map else [f' {loaded.time:g} s']),
               *(['/reset'] if 'reset' in loaded.allows else [])]
    assert [text for text in counted if text not in loaded.asks] == []


def test_values_are_converted():
    loaded = exercise.parse(GOOD, 'good')
    assert (loaded.time, loaded.pass_score, loaded.simulator) == (10.0, 80.0, 'turtlesim')
    assert loaded.start == {'x': (3.0, 5.0), 'theta': (0.0, 0.0)}
    assert loaded.rules[0] == exercise.ScoredRule('moves', rules_driving.Moves(2.0), 60.0, False)
    assert loaded.rules[0].visible == 'always'
    assert loaded.rules[1].rule == rules_output.Runs('the end') and loaded.rules[1].must
    assert loaded.stimuli == [('drive', {'after': 0.0, 'linear': (0.5, 1.5), 'angular': (-0.8, 0.8), 'for': 3.0})]
    request = {'do': 'call', 'service': '/a', 'type': 'b/C', 'request': ['2 to 9 m', '90 deg']}
    assert exercise.parse({**GOOD, 'stimuli': [request]}).stimuli[0][1]['request'] == [
        (2.0, 9.0), pytest.approx((math.pi / 2.0,) * 2)]


def changed(*path, value=None):
    """GOOD with one value set, or without it where ``value`` is None."""
    content = copy.deepcopy(GOOD)
    inner = content
    for key in path[:-1]:
        inner = inner[key]
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return content


@pytest.mark.parametrize('content, said', [
    (None, 'the exercise is empty; it must be a mapping (keys with values)'),
    (changed('title'), 'the exercise lacks the key title'),
    (changed('colour', value=1), "the exercise has an unknown key 'colour'; it may have title, asks, simulator"),
    (changed('time', value='10 parsec'), "the exercise: time: the unit 'parsec'"),
    (changed('time', value='10'), "the exercise: time: '10' is not a number with one of the units s, ms, min"),
    (changed('time', value='1000 s'), "time is '1000 s'; it must be above 0 and at most 240 s"),
    (changed('pass', value='high'), "the exercise: pass: 'high' must be a number"),
    (changed('pass', value=0), 'pass is 0; it must be above 0'),
    (changed('simulator', value='gazebo'), "the exercise: simulator: 'gazebo' must be one of turtlesim, robotont"),
    (changed('allows', value=['magic']), "allows has 'magic'; it may have teleport, reset, kill"),
    (changed('start', value={'z': '1 m'}), "start has an unknown key 'z'; it may have x, y, theta"),
    (changed('start', value={'x': '5 to 3 m'}), "start: x: '5 to 3 m' starts above its end"),
    (changed('start', value={'y': '9 to 12 m'}), 'start: y is 9 to 12 m; the arena allows 0 to 11.0889 m'),
    (changed('checks', value='all'), "the exercise: checks: 'all' must be a list"),
    (changed('checks', 0, 'check', value='flies'), "check 1: check is 'flies'; it must be one of draws, commands"),
    (changed('checks', 0, 'length'), 'check 1 (moves) lacks the key length'),
    (changed('checks', 0, 'length', value='2 s'),
     "check 1 (moves): length: the unit 's' in '2 s' does not measure a length"),
    (changed('checks', 0, 'points'), 'check 1 (moves) lacks the key points'),
    (changed('checks', 0, 'points', value=-1), 'check 1 (moves): points is -1; it must be above 0'),
    (changed('checks', 0, 'points', value=50), 'the points of the checks add up to 90; they must add up to 100'),
    (changed('checks', 1, 'must', value='yes please'), "check 2 (runs): must: 'yes please' must be true or false"),
    (changed('checks', 1, 'until', value='noon'), "check 2 (runs): until: 'noon' must be one of the end, it is done"),
    (changed('checks', 0, value={'check': 'prints', 'points': 60, 'pattern': '('}),
     'check 1 (prints): pattern: missing ), unterminated subpattern'),
    (changed('checks', 0, value={'check': 'pen', 'points': 60, 'colour': [0, 0, 256]}),
     'check 1 (pen): colour: [0, 0, 256] must be three whole numbers'),
    (changed('checks', 0, value={'check': 'draws', 'points': 60, 'shape': 'heart'}),
     "check 1 (draws): shape: 'heart' must be one of circle, square, triangle"),
    (changed('checks', 0, 'visible', value='later'),
     "check 1 (moves): visible: 'later' must be one of always, after the deadline, never"),
    (changed('checks', 0, value={'check': 'positions', 'points': 60, 'count': 'four'}),
     "check 1 (positions): count: 'four' must be a whole number"),
    (changed('stimuli', 0, 'do', value='dance'), "stimulus 1: do is 'dance'; it must be one of drive, call, markers"),
    (changed('stimuli', 0, 'for'), 'stimulus 1 (drive) lacks the key for'),
])
def test_wrong_files_are_named_with_the_key(content, said):
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse(content)
    assert str(error.value).startswith(said)


CALL = {'do': 'call', 'service': '/s', 'type': 'std_srvs/Empty', 'request': []}
SHOW = {'do': 'markers', 'for': '3 s'}
MAZE = {'simulator': 'robotont', 'world': {'like': 'minimaze'}}
BOX = {'name': 'box', 'x': 2.0, 'y': 0.0, 'yaw': 0.0, 'length': 1.0, 'width': 1.0, 'height': 1.0}
DISTANCES = {'simulator': 'robotont', 'stimuli': [{'do': 'distances', 'for': '5 s'}]}


def check(name, **keys):
    """Return the key of an exercise with one check."""
    return {'checks': [{'check': name, 'points': 100, **keys}]}


@pytest.mark.parametrize('changes, said', [
    (check('stops'), 'check 1 (stops) lacks the key x or y: where to stop'),
    ({**check('answers', service='/t'), 'stimuli': [CALL]},
     'check 1 (answers) needs a stimulus {do: call, service: /t, ...}: nobody calls that service'),
    (check('prints_markers', what='id'), 'check 1 (prints_markers) needs a stimulus'),
    (check('repeats'), 'check 1 (repeats) needs a stimulus {do: drive'),
    (check('reaches', action='/fibonacci'), 'check 1 (reaches) needs a stimulus {do: goals, action: /fibonacci'),
    (check('steers', command='angular.z', by='roll'), 'check 1 (steers) needs a stimulus {do: turns'),
    (check('keeps', what='ahead', value='0.5 m'), 'check 1 (keeps) needs a stimulus {do: distances'),
    ({**DISTANCES, **check('keeps', what='marker left', value='0 m')}, 'check 1 (keeps) needs a stimulus {do: tracker'),
    ({**DISTANCES, 'simulator': 'turtlesim'}, 'stimulus 1 (distances) needs simulator: robotont'),
    ({**check('prints_no_marker'), 'stimuli': [{**SHOW, 'rate': '0.5 Hz'}]},
     'check 1 (prints_no_marker) needs a stimulus {do: markers, ...} of two messages'),  # 3 s * 0.5 Hz
    (check('positions', count=4), 'check 1 (positions) needs the line: allows: [teleport]'),
    ({**check('pen', colour=[0, 0, 0]), 'simulator': 'robotont'}, 'check 1 (pen) needs simulator: turtlesim'),
    (check('same_path'), 'check 1 (same_path) needs the key solution: a program to '
     'compare with'),
    ({'solution': 'pass'}, 'solution is for the check same_path, and checks has none'),
    (check('passes', x='5 m'), 'check 1 (passes) needs either x and y, or through'),
    (check('draws', shape='line'), 'check 1 (draws) needs the key through'),
    (check('passes', through=[['5 m']]),
     "check 1 (passes): through: ['5 m'] must be a point with x and y, such as [2 m, 3 m]"),
    ({'starts': 6}, 'starts is 6; it must be 1 to 5'), ({'starts': 0}, 'the exercise: starts: 0 must be above 0'),
    ({'stimuli': [{'do': 'drive', 'after': '8 s', 'for': '3 s'}]},
     'stimulus 1 (drive) lasts until 11 s, longer than the time of the exercise, 10 s'),
    ({'stimuli': [{**CALL, 'after': '10 s'}]}, 'stimulus 1 (call) lasts until 10 s'),
    ({'stimuli': [{'do': 'drive', 'for': '3 s'}], 'simulator': 'robotont'}, 'stimulus 1 (drive) needs simulator'),
    (check('connects', topic='turtle1/pose', role='publishes'),
     "check 1 (connects): topic: 'turtle1/pose' must be a full name, such as /turtle1/pose"),
    ({'stimuli': [{**CALL, 'type': 'turtlesim.srv.Go'}]}, "stimulus 1 (call): type: 'turtlesim.srv.Go' must be a"),
    (check('moves', length='-2 m'), "check 1 (moves): length: '-2 m' must be above 0"),
    (check('stops', x='5 m', rest='-1 s'), "check 1 (stops): rest: '-1 s' must be at least 0"),
    (check('prints_poses', share='120 %'), "check 1 (prints_poses): share: '120 %' must be at most 100 %"),
    (check('prints_poses', fields=4), 'check 1 (prints_poses): fields: 4 must be one of 2, 3'),
    (check('prints', pattern='x', times=0), 'check 1 (prints): times: 0 must be above 0'),
    (check('moves', lenght='2 m', length='2 m'),
     "check 1 (moves) has an unknown key 'lenght'; it may have length. Did you mean length?"),
    ({'simulator': 'robotont', 'beside': ['ampl']},
     "beside has 'ampl'; it may have map_server, amcl, slam_gmapping, move_base. Did you mean amcl?"),
    ({'beside': ['amcl']}, 'beside needs simulator: robotont'),
    ({**MAZE, 'beside': ['map_server', 'slam_gmapping']}, 'beside has map_server and slam_gmapping; only one'),
    ({'simulator': 'robotont', 'beside': ['map_server']}, 'map_server needs a world, of which it publishes the map'),
    ({**MAZE, 'unmapped': ['wall99']},
     "unmapped has 'wall99'; nothing in the world has that name. Did you mean wall9?"),
    ({**MAZE, 'odometry': {'noise': '2 s'}}, "odometry: noise: the unit 's' in '2 s' does not measure a length"),
    ({'simulator': 'robotont', 'world': {'like': 'minimase'}},
     "world: like is 'minimase'; it must be one of ar, bangbang"),
    ({**MAZE, 'world': {'like': 'minimaze', 'boxes': [{'name': 'wall1'}]}}, 'world: '),
    ({**MAZE, 'world': {'boxes': [{**BOX, 'length': -1}]}}, 'world: box: length is -1'),
    ({**MAZE, 'world': {'balls': []}}, 'world: '), ({'world': {'boxes': [BOX]}}, 'world needs simulator: robotont'),
    ({'simulator': 'robotont', **check('maps')}, 'check 1 (maps) needs a world'),
    ({**MAZE, 'checks': [{'check': 'maps', 'of': 'file', 'points': 50},
                         {'check': 'connects', 'topic': '/scan', 'role': 'subscribes', 'points': 50}]},
     'check 2 (connects) needs a program, and a check maps with of: file has none: give it an exercise of its own'),
    ({**MAZE, 'beside': ['amcl'], **check('maps', of='file')},
     'beside needs a program, and a check maps with of: file has none'),
    ({**MAZE, **check('navigates', goals=[['1 m', '2 m']])},
     "check 1 (navigates): goals: ['1 m', '2 m'] must be [x, y, heading], such as [-2 m, 0.5 m, 90 deg]"),
    ({**MAZE, 'beside': ['amcl'], 'parameters': {'/move_base/controller_frequency': 5.0}},
     "parameters has '/move_base/controller_frequency'; it must begin with the name of a node in beside, such as "
     "/amcl/"),
    ({**MAZE, 'stimuli': [{'do': 'move', 'after': '5 s', 'panel': 'wall1', 'to': ['1 m', '2 m', '0 deg']}]},
     "stimulus 1 (move): there is no panel 'wall1' in the world"),
    ({**MAZE, 'stimuli': [{'do': 'move', 'after': '5 s', 'panel': 'wall1', 'to': ['1 m', '2 m']}]},
     "stimulus 1 (move): to: ['1 m', '2 m'] must be [x, y, heading]"),
    ({**MAZE, 'beside': ['amcl'], 'stimuli': [{'do': 'destinations', 'goals': [['1 m', '2 m', '0 deg']]}]},
     'stimulus 1 (destinations) needs move_base in beside'),
    ({'simulator': 'turtlsim'},
     "the exercise: simulator: 'turtlsim' must be one of turtlesim, robotont. Did you mean turtlesim?"),
])
def test_what_no_program_could_fulfil_is_the_teachers_mistake(changes, said):
    content = {'title': 'T', 'time': '10 s', **check('runs'), **changes}
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse(content)
    assert str(error.value).startswith(said)


def test_a_world_has_the_shapes_of_the_one_that_it_is_like():
    post = {'name': 'post', 'x': 0.0, 'y': 2.0, 'radius': 0.1, 'height': 0.5}
    loaded = exercise.parse({'title': 'T', 'time': '10 s', **check('runs'), **MAZE,
                             'world': {'like': 'minimaze', 'cylinders': [post]}, 'unmapped': ['post']})
    assert loaded.world['cylinders'] == [post] and len(loaded.world['boxes']) == 16
    assert 'like' not in loaded.world and loaded.unmapped == ('post',)


def test_all_mistakes_are_said_at_once(tmp_path):
    (tmp_path / 'wrong.yaml').write_text("""
title: 7
time: 10 s
start: {x: 20 m}
stimuli:
  - {do: drive, fro: 3 s}
  - 5
checks:
  - {check: moves, points: 60}
  - {check: runs, points: 30, until: noon}
""", encoding='utf-8')
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.load(tmp_path / 'wrong.yaml')
    head, *lines = str(error.value).split('\n')
    assert head.endswith('wrong.yaml: 7 mistakes')
    assert [line.strip()[:24] for line in lines] == [
        'the exercise: title: 7 m', 'start: x is 20 m; the ar', 'check 1 (moves) lacks th', "check 2 (runs): until: '",
        'stimulus 1 (drive) has a', 'stimulus 1 (drive) lacks', 'stimulus 2 is 5; it must']


def test_files_that_are_no_yaml_or_not_there(tmp_path):
    (tmp_path / 'bad.yaml').write_text('title: [', encoding='utf-8')
    with pytest.raises(exercise.ExerciseError, match='bad.yaml: not YAML'):
        exercise.load(tmp_path / 'bad.yaml')
    (tmp_path / 'empty.yml').write_text('', encoding='utf-8')
    with pytest.raises(exercise.ExerciseError, match='empty.yml: the exercise is empty'):
        exercise.load(tmp_path / 'empty.yml')
    with pytest.raises(FileNotFoundError):
        exercise.load(tmp_path / 'none.yaml')


def test_every_check_says_what_it_looks_at():
    assert len(registry.RULES) >= 11
    for rule in registry.RULES.values():
        assert not rule.__doc__.startswith(f'{rule.__name__}('), 'written by dataclass'
