"""course_grader.rules.exercise: the repository's exercise files are read; wrong ones are named with the key."""
import copy
import math
import pathlib

import pytest

from course_grader.rules import exercise, registry

FOLDER = pathlib.Path(__file__).resolve().parents[3] / 'exercises'
GOOD = {'title': 'T', 'time': '10 s', 'start': {'x': '3 to 5 m'}, 'allows': ['teleport'],
        'stimuli': [{'do': 'drive', 'for': '3 s'}],
        'checks': [{'check': 'moves', 'points': 60, 'length': '2 m'}, {'check': 'runs', 'points': 40, 'must': True}]}


@pytest.mark.parametrize('path', sorted(FOLDER.glob('*.yaml')), ids=lambda path: path.stem)
def test_exercise_files_are_right(path):
    loaded = exercise.load(path)
    assert loaded.name == path.stem and loaded.asks and loaded.title
    assert any(scored.must for scored in loaded.rules)


def test_values_are_converted():
    loaded = exercise.parse(GOOD, 'good')
    assert (loaded.time, loaded.pass_score, loaded.simulator) == (10.0, 80.0, 'turtlesim')
    assert loaded.start == {'x': (3.0, 5.0), 'theta': (0.0, 0.0)}
    assert loaded.rules[0] == exercise.ScoredRule('moves', {'length': 2.0}, 60.0, False)
    assert loaded.rules[1].parameters == {'until': 'the end'} and loaded.rules[1].must
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
    (changed('time', value='1000 s'), "time is '1000 s'; it must be above 0 and at most 120 s"),
    (changed('pass', value='high'), "the exercise: pass: 'high' must be a number"),
    (changed('pass', value=0), 'pass is 0; it must be above 0'),
    (changed('simulator', value='gazebo'), "the exercise: simulator: 'gazebo' must be one of turtlesim, robotont"),
    (changed('allows', value=['magic']), "allows has 'magic'; it may have teleport, reset, kill"),
    (changed('start', value={'z': '1 m'}), "start has an unknown key 'z'; it may have x, y, theta"),
    (changed('start', value={'x': '5 to 3 m'}), "start: x: '5 to 3 m' starts above its end"),
    (changed('start', value={'y': '9 to 12 m'}), 'start: y is 9 to 12 m; the arena allows 0 to 11.0889 m'),
    (changed('checks', value='all'), "the exercise: checks: 'all' must be a list"),
    (changed('checks', 0, 'check', value='flies'), "check 1 is 'flies'; it must be one of answers, commands"),
    (changed('checks', 0, 'length'), 'check 1 (moves) lacks the key length'),
    (changed('checks', 0, 'length', value='2 s'),
     "check 1 (moves): length: the unit 's' in '2 s' does not measure a length"),
    (changed('checks', 0, 'points'), 'check 1 (moves) lacks the key points'),
    (changed('checks', 0, 'points', value=-1), 'check 1 (moves): points is -1; it must be above 0'),
    (changed('checks', 0, 'points', value=50), 'the points of the checks add up to 90; they must add up to 100'),
    (changed('checks', 1, 'must', value='yes please'), "check 2 (runs): must: 'yes please' must be true or false"),
    (changed('checks', 1, 'until', value='noon'), "check 2 (runs): until: 'noon' must be one of the end, it is done"),
    (changed('stimuli', 0, 'do', value='dance'), "stimulus 1: do is 'dance'; it must be one of drive, call, markers"),
    (changed('stimuli', 0, 'for'), 'stimulus 1 (drive) lacks the key for'),
])
def test_wrong_files_are_named_with_the_key(content, said):
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse(content)
    assert str(error.value).startswith(said)


@pytest.mark.parametrize('parameters, said', [
    ({'check': 'prints', 'pattern': '('}, 'check 1 (prints): pattern: missing ), unterminated subpattern'),
    ({'check': 'pen', 'colour': [0, 0, 256]}, 'check 1 (pen): colour: [0, 0, 256] must be three whole numbers'),
    ({'check': 'draws', 'shape': 'heart'}, "check 1 (draws): shape: 'heart' must be one of circle, square, triangle"),
    ({'check': 'positions', 'count': 'four'}, "check 1 (positions): count: 'four' must be a whole number"),
])
def test_wrong_parameters_of_checks(parameters, said):
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse({'title': 'T', 'time': '1 s', 'checks': [{'points': 100, **parameters}]})
    assert str(error.value).startswith(said)


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
    assert all(registered.judge.__doc__ for registered in registry.RULES.values()) and len(registry.RULES) >= 11
