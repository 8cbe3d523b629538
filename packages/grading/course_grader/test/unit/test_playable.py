"""course_grader.rules.playable: what an exercise file may say is accepted by what plays it, or refused when it is read.

hypothesis writes exercise files; the simulators' own tables of parameters and worlds then take what the grader draws.
"""
import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from course_grader import cli
from course_grader.attempt import service_types
from course_grader.attempt.simulation import Simulation
from course_grader.rules import exercise, random_stimuli
from course_grader.supervision.job import Job
from kinematic_core.worlds import world_format
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.robot_world import RobotWorld
from kinematic_core.worlds.turtle_world import ARENA_SIZE, TurtleWorld
from rospy_support.parameters import Parameter
from sim_scene import worlds

RUNS = [{'check': 'runs', 'points': 100}]
BASE = {'title': 'T', 'time': '60 s', 'checks': RUNS}
ROBOT = {**BASE, 'simulator': 'robotont'}
MAZE = {**ROBOT, 'world': {'like': 'minimaze'}}
NUMBERS = st.one_of(st.sampled_from([0, 1e-9, 0.5, 5.5, 11.0888, 11.0889, 11.089, 180, 270, 360, 400, 1000, 1001, 1e7,
                                     1e300]), st.floats(-400, 400, width=32))


def spans(unit):
    """Texts of an exercise file, also wrong ones."""
    def between(ends):
        return f'{min(ends):.7g} to {max(ends):.7g} {unit}'
    return st.one_of(st.tuples(NUMBERS, NUMBERS).map(between), NUMBERS.map(lambda value: f'{value:.7g} {unit}'),
                     NUMBERS.map(lambda value: f'at least {value:.7g} {unit}'),
                     st.sampled_from([f'1e999 {unit}', f'at most 2 {unit}', f'-1e400 to 0 {unit}']))


def read(content):
    """Return the Exercise, or None if its file is refused."""
    try:
        return exercise.parse(content)
    except exercise.ExerciseError:
        return None


def arguments(made, seed, folder='/tmp'):
    """Return {name: value} of the private parameters with which the grader starts the simulator."""
    simulation = Simulation(Job(made, (), '', '', seed), lockstep=True)
    given_ = [argument.partition(':=') for argument in simulation._arguments(folder) if argument.startswith('_')]
    return {f'~{name[1:]}': yaml.safe_load(text) for name, _, text in given_}


def accepted(values, table):
    """Let the simulator's own parameters convert the values, as from the command line."""
    return {name: table[name].convert(value) for name, value in values.items() if name not in ('~record', '~world')}


def turtle_starts(values):
    from turtlesim import node
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Parameter, 'read', lambda one, default=None, values_=None: one.convert(
            values.get(one.name, one.default)))
        patch.setattr(node.rospy, 'resolve_name', lambda name: name)
        return node._start()


LENGTHS = st.one_of(st.sampled_from(['0 to 11.0889 m', '11.0889 m', '0 m', '2.5 to 3 m']), spans('m'))  # mostly right
HEADINGS = st.one_of(st.sampled_from(['-190 deg', '180 deg', '270 deg', '0 to 360 deg', '300 to 800 deg']),
                     spans('deg'))
START = st.fixed_dictionaries({'theta': HEADINGS}, optional={'x': LENGTHS, 'y': LENGTHS})


@given(START, st.integers(1, 9999))
def test_where_a_turtle_starts(start, seed):
    from turtlesim import node
    made = read({**BASE, 'start': start})
    if made:
        values = arguments(made, seed)
        accepted(values, node.PARAMETERS)
        x, y, theta = turtle_starts(values)
        assert abs(math.remainder(theta - random_stimuli.start(made, seed)['theta'], math.tau)) < 1e-3
        assert 0.0 <= min(x, y) and max(x, y) <= ARENA_SIZE
        TurtleWorld(start=(x, y, theta))


@given(START, st.fixed_dictionaries({}, optional={'x': spans('m'), 'y': spans('m')}),
       st.fixed_dictionaries({}, optional={'noise': spans('cm'), 'slip': st.integers(0, 120).map('{} %'.format)}),
       st.integers(1, 9999))
def test_where_a_robot_starts(start, shift, odometry, seed):
    from robotont_gazebo import node
    made = read({**MAZE, 'start': start, 'shift': shift, 'odometry': odometry})
    if made:
        made = random_stimuli.shifted(made, seed)
        values = arguments(made._replace(world={}), seed)
        numbers = accepted(values, node.PARAMETERS)
        plan = world_format.parse(made.world)
        world = RobotWorld(plan, Pose2D(1000.0 * 9, 0.0, 0.0), slip=numbers.get('~odom_slip', 0.0))
        world.place(numbers['~x'], numbers['~y'], numbers['~yaw'])


def test_tiny_numbers_reach_the_simulator_as_numbers(tmp_path):
    """1e-09 is a text in YAML 1.1."""
    wall = {'name': 'a', 'x': 5.0, 'y': 0.0, 'yaw': 1e-9, 'length': 1.0, 'width': 1.0, 'height': 1.0}
    values = arguments(read({**ROBOT, 'world': {'boxes': [wall]}, 'odometry': {'noise': '1e-7 cm'}}), 1, tmp_path)
    assert values['~odom_noise'] == 1e-9
    assert worlds.read_yaml(values['~world']).boxes[0].yaw == 1e-9


@given(st.lists(st.tuples(spans('m'), spans('m'), spans('deg')), min_size=1, max_size=4), st.integers(1, 9999))
def test_where_several_robots_start(starts, seed):
    made = read({**ROBOT, 'robots': {f'robot{number}': dict(zip(('x', 'y', 'theta'), start))
                                     for number, start in enumerate(starts)}})
    for start in random_stimuli.robots(made, seed).values() if made else ():
        assert all(math.isfinite(value) for value in start.values()) and abs(start['theta']) <= math.pi
        RobotWorld(start=Pose2D(start['x'], start['y'], start['theta']))


@given(spans('m/s'), spans('deg/s'), st.integers(1, 9999))
def test_how_a_turtle_is_driven(linear, angular, seed):
    made = read({**BASE, 'stimuli': [{'do': 'drive', 'for': '10 s', 'linear': linear, 'angular': angular}]})
    world = TurtleWorld()
    for velocity in random_stimuli.stimuli(made, seed)[0] if made else ():
        world.command('turtle1', velocity[0], 0.0, velocity[1])


@given(spans('m'), spans('m'), spans('deg'), st.integers(1, 9999))
def test_where_a_robot_is_carried(x, y, theta, seed):
    made = read({**MAZE, 'stimuli': [{'do': 'carry', 'after': '5 s', 'x': x, 'y': y, 'theta': theta}]})
    if made:
        (at_x, at_y, yaw), = random_stimuli.stimuli(made, seed)[0]
        RobotWorld().carry(at_x, at_y, yaw)


@given(st.integers(-1, 10 ** 7), st.floats(-1.0, 1e4, width=32), st.integers(1, 9999))
def test_which_markers_are_shown(most, rate, seed):
    made = read({**BASE, 'stimuli': [{'do': 'markers', 'for': '20 s', 'most': most, 'rate': f'{rate:.7f} Hz'}]})
    shows = random_stimuli.stimuli(made, seed)[0] if made else [{}]
    assert all(len(show) <= most for show in shows if show) and len(shows) <= 8 * 20


@pytest.mark.parametrize('degrees', [-270, 0, 179.999, 180, 270, 360, 720])
def test_each_heading_is_a_start(degrees):
    """270 degrees left every submission undecided, and a heading between 180 and 360 half of them."""
    from turtlesim import node
    made = exercise.parse({**BASE, 'start': {'x': '11.0889 m', 'y': '0 m', 'theta': f'{degrees} deg'}})
    values = arguments(made, 7)
    accepted(values, node.PARAMETERS)
    assert math.cos(turtle_starts(values)[2]) == pytest.approx(math.cos(math.radians(degrees)), abs=1e-3)


def check(name, **keys):
    """Return the key of an exercise with one check."""
    return {'checks': [{'check': name, 'points': 100, **keys}]}


POST = {'cylinders': [{'name': 'post', 'x': 1.0, 'y': 0.0, 'radius': 0.1, 'height': 0.5}]}
BOARD = {'name': 'board', 'marker_id': 3, 'x': 1.0, 'y': 0.0, 'yaw': 0.0}


@pytest.mark.parametrize('changes, said', [
    ({'start': {'x': 'at least 3 m'}}, "start: x: 'at least 3 m' has no end, and a value is drawn from it"),
    ({'start': {'x': '1e999 m'}}, "start: x: '1e999 m' is too large"),
    ({**ROBOT, 'start': {'x': '2000 m'}}, 'start: x is 2000 m; it must be in -1000 to 1000 m'),
    ({**ROBOT, 'start': {'x': '0.5 to 1 m'}, 'world': POST}, 'start: the robot cannot be at x=0.75, y=0: post is'),
    ({**ROBOT, 'world': POST, 'shift': {'x': '-1 to 0 m'}}, 'start: the robot cannot be at x='),
    ({**ROBOT, 'world': POST, 'robots': {'post': {'x': '3 m', 'y': '0 m'}}},
     "robots has the name 'post', which something in the world has already"),
    ({**ROBOT, 'robots': {'ground_plane': {'x': '3 m', 'y': '0 m'}}}, "robots has the name 'ground_plane'"),
    ({**ROBOT, 'odometry': {'slip': '95 %'}}, 'odometry: slip is 0.95; it must be 0 to 0.9'),
    ({**ROBOT, 'odometry': {'noise': '2 m'}}, 'odometry: noise is 2 m; it must be 0 to 1 m'),
    ({'stimuli': [{'do': 'drive', 'for': '3 s', 'linear': 'at least 1 m/s'}]}, 'stimulus 1 (drive): linear: '),
    ({'stimuli': [{'do': 'markers', 'for': '3 s', 'most': 21}]}, 'stimulus 1 (markers): most is 21; it must'),
    ({'stimuli': [{'do': 'markers', 'for': '3 s', 'rate': '9 Hz'}]}, 'stimulus 1 (markers): rate is 9 Hz'),
    ({'stimuli': [{'do': 'markers', 'for': '3 s', 'topic': '/tf'}]}, 'stimulus 1 (markers): topic is /tf'),
    ({'stimuli': [{'do': 'markers', 'for': '3 s', 'topic': '/tür'}]}, 'stimulus 1 (markers): topic: '),
    ({'stimuli': [{'do': 'turns', 'for': '1 s'}]}, 'stimulus 1 (turns): for is 1 s; it must be at least 2 s'),
    ({'stimuli': [{'do': 'call', 'service': '/s', 'type': 'a/B', 'request': ['at most 2 m']}]},
     'stimulus 1 (call): request: number 1 has no end'),
    ({'stimuli': [{'do': 'call', 'service': '/s', 'type': 'a/B', 'request': [], 'times': 10 ** 9}]},
     'stimulus 1 (call): times is 1e+09; it must be 1 to 50'),
    ({**ROBOT, 'beside': ['move_base'], 'stimuli': [{'do': 'destinations', 'goals': []}]},
     'stimulus 1 (destinations): goals is empty'),
    ({**ROBOT, 'world': {'panels': [{**BOARD, 'path': [[0, 1, 0, 0], [5, 2, 0, 0]]}]},
      'stimuli': [{'do': 'move', 'after': '3 s', 'panel': 'board', 'to': ['1 m', '2 m', '0 deg']}]},
     'stimulus 1 (move): the panel board moves by itself'),
    (check('stops', x='12 m'), 'check 1 (stops): x is 12 m; the window of turtlesim has 0 to 11.0889 m'),
    (check('passes', through=[['1 m', '2 m'], ['-1 m', '2 m']]), 'check 1 (passes): x is -1 m; the window'),
    (check('draws', shape='square', size='at least 12 m'), 'check 1 (draws): size is at least 12 m; the window'),
    (check('commands', rate='at least 100 Hz'),
     'check 1 (commands): rate is at least 100 Hz; the simulator counts one in each of its steps, at most 62.5 Hz'),
    ({**ROBOT, **check('commands', linear='at least 11 m/s')},
     'check 1 (commands): linear is at least 11 m/s; the simulator takes -10 to 10 m/s'),
    (check('follows', turtle='my turtle'), "check 1 (follows): turtle is 'my turtle'; a name starts with a letter"),
    (check('spawns', turtle='turtle1', x='2 m', y='2 m'),
     'check 1 (spawns): turtle is turtle1, which is there from the beginning'),
    ({'vary': {'goal': '8 to 13 m'}, **check('stops', x='$goal')},
     'for students who get goal = 13 m: check 1 (stops): x is 13 m'),
    ({'vary': {'goal': '0.001 to 0.004 m'}, **check('moves', length='$goal')},
     "vary: goal: '0.001 to 0.004 m' has only one value with 2 decimals; use a smaller unit"),
])
def test_what_nothing_could_play_is_refused_when_it_is_read(changes, said):
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse({**BASE, **changes}, student='Nobody 1')
    assert str(error.value).startswith(said), str(error.value)


AMCL = {**MAZE, 'beside': ['amcl', 'move_base']}
PEN = {'do': 'call', 'service': '/s', 'type': 'turtlesim/SetPen'}


@pytest.mark.parametrize('content, said', [
    ({**AMCL, 'parameters': {'/amcl/max_particles': 0}}, 'parameters: /amcl/max_particles is 0; it must be'),
    ({**AMCL, 'parameters': {'/move_base/controller_frequency': 'fast'}}, 'controller_frequency is'),
    ({**AMCL, 'parameters': {'/amcl/max_particles': 2 ** 31}}, 'it must be true, false, a whole number of 32 bits'),
    ({**AMCL, 'parameters': {'/amcl/tf_broadcast': None}}, 'it must be true, false'),
    ({**BASE, 'stimuli': [{**PEN, 'request': ['0 to 300 px'] * 5}]},
     'request: r of turtlesim/SetPen is a uint8, from 0 to 255'),
    ({**BASE, 'stimuli': [{**PEN, 'request': ['-1 to 5 px'] * 5}]}, 'request: r of turtlesim/SetPen is a uint8'),
    ({**BASE, 'stimuli': [{**PEN, 'request': ['0 to 255 px'] * 4}]},
     'request has 4 numbers, but turtlesim/SetPen takes 5'),
])
def test_what_nodes_and_services_would_refuse_is_refused_when_it_is_read(tmp_path, content, said):
    (tmp_path / 'mine.yaml').write_text(yaml.safe_dump(content))
    with pytest.raises(exercise.ExerciseError) as error:
        cli.load(tmp_path / 'mine.yaml')
    assert said in str(error.value)


def test_whole_numbers_are_called_where_a_service_has_them():
    """The call failed, and the program was told that it did not answer."""
    import io

    from turtlesim.srv import SetPen, TeleportAbsolute
    made = exercise.parse({**BASE, 'stimuli': [{**PEN, 'request': ['0 to 255 px'] * 5}]})
    for numbers in random_stimuli.stimuli(made, 7)[0]:
        request = SetPen._request_class(*service_types.request(SetPen, numbers))
        request.serialize(io.BytesIO())
    assert service_types.request(TeleportAbsolute, (1.25, 2.5, 3.0)) == (1.25, 2.5, 3.0)


@given(st.text('abcdef', min_size=1), st.floats(0.1, 5.0), st.floats(0.0, 3.0))
def test_a_value_of_a_student_lies_in_its_span(student, low, width):
    content = {**BASE, 'vary': {'goal': f'{low:.3f} to {low + width:.3f} m'},
               **check('moves', length='$goal')}
    try:
        value = exercise.parse(content, student=student).rules[0].rule.length
    except exercise.ExerciseError as error:
        assert 'has only one value' in str(error)
    else:
        assert float(f'{low:.3f}') <= value <= float(f'{low + width:.3f}')
