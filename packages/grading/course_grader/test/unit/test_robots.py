"""Exercises with several robots: what their files may say, where robots start, what counts for which one."""

import pytest

from course_grader.attempt.recording_reader import RecordingReader
from course_grader.formats import path_picture
from course_grader.rules import exercise, judging, random_stimuli, scoring, symptoms
from course_grader.rules.observation import Command, Observed, Sample
from unit_support.course_files import EXERCISES

TWO_ROBOTS = EXERCISES['two_robots']
STOP = {'check': 'stops', 'points': 100, 'x': '1 m'}
GOOD = {'title': 'T', 'time': '10 s', 'simulator': 'robotont', 'checks': [{**STOP, 'robot': 'b'}],
        'robots': {'a': {'x': '0 to 1 m', 'y': '0 m'}, 'b': {'x': '3 m', 'y': '-1 to 1 m', 'theta': '180 deg'}}}
DT = 0.01


@pytest.mark.parametrize('changes, said', [
    ({'robots': {'a b': {'x': 0, 'y': 0}}, 'checks': [STOP]},
     "robots has the name 'a b'; it must be a letter, then letters, digits or _, such as robot1"),
    ({'robots': {'a': {'x': 0}}, 'checks': [STOP]}, 'robots: a lacks the key y: where it starts'),
    ({'robots': {'a': None}, 'checks': [STOP]}, "robots: 'a' is empty; it must be a mapping (keys with values)"),
    ({'robots': ['a', 'b'], 'checks': [STOP]}, "the exercise: robots: ['a', 'b'] must be a mapping"),
    ({'robots': {'a': {'x': '1 kg', 'y': 0}}, 'checks': [STOP]}, "robots: 'a': x: the unit 'kg'"),
    ({'robots': {'a': {'x': 0, 'y': 0, 'z': 0}}, 'checks': [STOP]},
     "robots: 'a' has an unknown key 'z'; it may have x, y, theta"),
    ({'robots': {f'r{number}': {'x': f'{number} m', 'y': 0} for number in range(5)}, 'checks': [STOP]},
     'robots has 5 robots; it may have up to 4'),
    ({'robots': {'a': {'x': '0 to 1 m', 'y': 0}, 'b': {'x': '1.2 to 2 m', 'y': '-0.2 to 0.2 m'}}},
     'robots: a and b may start closer than 0.36 m, and then touch'),
    ({'simulator': 'turtlesim'}, 'robots needs simulator: robotont'),
    ({'start': {'x': '1 m'}}, 'robots and start cannot be combined'),
    ({'beside': ['amcl']}, 'robots and beside cannot be combined'),
    ({'stimuli': [{'do': 'tracker', 'for': '5 s'}]},
     'stimulus 1 (tracker) needs one robot, and the exercise has robots'),
    ({'checks': [{**STOP, 'robot': 'robot2'}]}, "check 1 (stops) has robot: 'robot2'; it must be one of robots: a, b"),
    ({'checks': [{**STOP, 'robot': 'b'}], 'robots': {}},
     "check 1 (stops) has robot: 'b'; it must be one of robots: none"),
    ({'checks': [{'check': 'runs', 'points': 100, 'robot': 'b'}]},
     'check 1 (runs) judges no single robot; robot may stand in commands, draws, moves, passes, stops'),
    ({'checks': [{'check': 'apart', 'points': 100}], 'robots': {'a': {'x': 0, 'y': 0}}},
     'check 1 (apart) needs two or more robots'),
])
def test_what_is_wrong_is_said(changes, said):
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse({**GOOD, **changes})
    assert str(error.value).startswith(said)


def test_each_robot_starts_where_the_file_says_and_elsewhere_with_each_seed():
    made = exercise.parse(GOOD)
    starts = [random_stimuli.robots(made, seed) for seed in range(20)]
    assert all(list(one) == ['a', 'b'] and 0.0 <= one['a']['x'] <= 1.0 and -1.0 <= one['b']['y'] <= 1.0
               and one['b']['x'] == 3.0 for one in starts)
    assert starts[3] == random_stimuli.robots(made, 3) and len({one['b']['y'] for one in starts}) == 20


def observed_of(**paths):
    """Return the Observed of robots that drive from one point to another in 2 s, and stand there for 4 s."""
    observed = Observed()
    observed.add_robots(paths)
    for name, ((x, y), (to_x, to_y)) in paths.items():
        for tick in range(600):
            part = min(1.0, tick / 200.0)
            observed.robots[name].track.append(Sample(tick * DT, x + part * (to_x - x), y + part * (to_y - y), 0.0))
    return observed


CROSSING = {'robot1': ((0.0, 0.0), (2.0, 2.0)), 'robot2': ((2.0, 0.0), (0.0, 2.0))}


@pytest.mark.parametrize('paths, points', [
    (CROSSING, (30, 30, 0)),
    ({**CROSSING, 'robot2': ((2.0, 0.0), (2.0, 1.0))}, (30, 0, 40)),
    ({**CROSSING, 'robot1': ((0.0, 0.0), (0.0, 0.0))}, (0, 30, 40)),
])
def test_a_check_counts_for_the_robot_that_it_names(paths, points):
    verdict = scoring.decide(exercise.load(TWO_ROBOTS), observed_of(**paths))
    full = [reason.points if reason.points == reason.of else 0 for reason in verdict.reasons]
    assert tuple(full) == points and verdict.outcome == scoring.FAILED
    assert verdict.reasons[1].asked.startswith('robot2: a stop at x = 0 and y = 2')


def test_the_distance_is_that_at_the_same_time():
    made = exercise.load(TWO_ROBOTS)
    observed = observed_of(**CROSSING)
    later = [sample._replace(t=sample.t + 3.0) for sample in observed.robots['robot2'].track]
    observed.robots['robot2'].track[:] = [Sample(tick * DT, 2.0, 0.0, 0.0) for tick in range(300)] + later
    verdict = scoring.decide(made, observed)
    assert verdict.score == 100.0 and 'robot1 and robot2 come as near as 1.41 m' in verdict.reasons[2].seen
    assert symptoms.advise(made, observed, verdict).hints == ()


def test_robots_that_touch_get_the_hint_of_the_file():
    made, observed = exercise.load(TWO_ROBOTS), observed_of(**CROSSING)
    hints = symptoms.advise(made, observed, scoring.decide(made, observed)).hints
    assert hints == (made.symptoms[0]['hint'],)


def test_all_robots_have_to_stand_until_a_verdict_is_final():
    observed = observed_of(**CROSSING)
    assert observed.all_stand() == pytest.approx(4.0, abs=0.1)
    observed.robots['robot2'].track.append(Sample(6.0, 0.5, 2.0, 0.0))
    assert observed.all_stand() == 0.0 and observed.standstill() > 3.9


def test_commands_and_changes_of_the_world_are_read_by_robot(tmp_path):
    path, observed = tmp_path / 'record.csv', Observed()
    observed.add_robots(['robot1', 'robot2'])
    path.write_text(
        'tick,event,x,y,theta,callers\n0,,5,5,0,\n1,robot1/cmd 1.0 0.0 0.0;robot2/cmd 2.0 0.0 0.0,5,5,0,/own;/own\n'
        '2,other/cmd 3.0 0.0 0.0;robot2/teleport_absolute 1.0 2.0 0.0,5,5,0,/own;/own\n'
        '3,robot2/delete_model;box/spawn_model 1.0 1.0 0.0;reset,5,5,0,/own;/own;/own\n')
    RecordingReader(str(path), DT, observed).read()
    assert observed.commands == observed.of_robot('robot1').commands == [Command(DT, 1.0, 0.0, 0.0, '/own')]
    assert observed.of_robot('robot2').commands == [Command(DT, 2.0, 0.0, 0.0, '/own')]
    assert len(observed.of_robot('').track) == 4 and observed.of_robot('robot2').track == []
    assert judging.shortcuts(observed, ()) == [
        'the program teleported to (1.00, 2.00) instead of driving', 'the program removed robot2 from the world',
        'the program put a model into the world, at (1.00, 1.00)', 'the program reset the simulator']


def test_the_picture_has_the_paths_of_all_robots():
    drawn = path_picture.drawing(exercise.load(TWO_ROBOTS), observed_of(**CROSSING))
    styles = [line.style for line in drawn.lines]
    assert [styles.count(style) for style in ('path', 'start', 'end', 'counted')] == [2, 2, 2, 2]
