"""The repository's exercises on what right and wrong nodes did, driven in the real core: scores and their reasons."""
import math

import pytest
import yaml

from course_grader.rules import exercise, scoring, symptoms
from course_grader.rules.observation import Call, Event, Problem, ShownMarkers
from plain_support import course
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle

SERVICE = '/turtle1/gotoPose'


def words(pose):
    return f'x: {pose.x:.4f} y: {pose.y:.4f}'


def logged(pose):
    return f'[INFO] [1668.25]: Turtle pose: x:{pose.x:.6f}, y:{pose.y:.6f}'


def marker_id(marker, _):
    return f'Detected marker with ID {marker}' if marker else 'No AR markers detected.'


def circle(turtle, **how):
    return turtle.drive(**{'seconds': 33.0, 'linear': 0.5, 'angular': 0.2, 'say': lambda pose: 'at 0.5 0.2', **how})


def polygon(turtle, sides=4, length=2.0, turn=None):
    for _ in range(sides):
        turtle.drive(length, linear=1.0).drive(0.1)
        turtle.drive(2.0 * math.pi / sides if turn is None else turn, angular=1.0).drive(0.1)
    return turtle


def square_of_teleports(turtle):
    for x, y in ((2.0, 2.0), (6.0, 2.0), (6.0, 6.0), (2.0, 6.0), (2.0, 2.0)):
        turtle.teleport(x, y)
    return turtle


def stop_at(turtle, x):
    while turtle.observed.track[-1].x < x - 0.02:
        turtle.drive(0.1, linear=1.0)
    return turtle.drive(2.0)


def serve(turtle, answered=True, printed=True, words='Service => x: {} y: {} theta: {}'):
    """Connect, be called with three requests, drive."""
    turtle.observed.connections.add((SERVICE, 'serves'))
    for number in range(3):
        request = (2.0 + number, 3.5, 0.5)
        turtle.observed.calls.append(Call(turtle.t, SERVICE, request, answered, '' if answered else 'no answer'))
        turtle.wait(0.2)
        if printed:
            turtle.print(words.format(*request))
    return turtle.drive(3.0, linear=0.6)


def start(turtle, early=False):
    """Offer a service that starts to drive, and be called after 3 s."""
    if early:
        turtle.drive(3.0, 0.5, 0.2)
    turtle.wait(0.0 if early else 3.0).observed.calls.append(Call(turtle.t, '/turtle_command', (), True))
    return turtle.drive(12.0, 0.5, 0.2)


def show(turtle, say):
    """Show markers and none in turn; ``say(id, x)`` and ``say(None, None)`` return the line that is printed."""
    turtle.observed.connections.add(('/ar_pose_marker', 'subscribes'))
    for markers in ({1: (0.31, 0.1, 2.0)}, {}, {7: (-0.42, 0.0, 1.5), 12: (1.27, 0.3, 3.0)}, {}):
        turtle.observed.shown.append(ShownMarkers(turtle.t, markers))
        turtle.wait(0.3)
        for marker, (x, _, _) in markers.items():
            turtle.print(say(marker, x))
        if not markers:
            turtle.print(say(None, None))
        turtle.wait(1.2)
    return turtle


def subscribed(turtle):
    turtle.observed.connections.add(('/turtle1/pose', 'subscribes'))
    return turtle


def robot(turtle, **how):
    return turtle.drive(**{'seconds': 11.0, 'linear': 0.2, 'rate': 1.0, 'say': lambda pose: 'forward 0.2', **how})


def cut_off(pose):
    return f'{int(pose.x)} {int(pose.y)}'


def rounded(pose):
    return f'{pose.x:.1f} {pose.y:.1f}'


def message(pose):
    """Return what rospy prints of a Pose."""
    return f'x: {pose.x}\ny: {pose.y}\ntheta: {pose.theta}\nlinear_velocity: 0.6\nangular_velocity: 0.5\n---'


def tells_again(turtle):
    """See markers, and tell twice a second what was seen last."""
    show(turtle, marker_id)
    for _ in range(10):
        turtle.print('No AR markers detected.').wait(0.5)
    return turtle


def pen_up_first(turtle):
    """Go to the first position with the pen up."""
    return square_of_teleports(turtle.pen(0, 0, 0, 3, 1).teleport(2.0, 2.0).pen(0, 0, 0, 3, 0))


def first_alone(shown):
    """Return a node that prints of each message the first marker alone."""
    told = set()

    def say(marker, _):
        here = next((number for number, one in enumerate(shown.observed.shown) if marker in one.markers), None)
        return '' if here in told else told.add(here) or marker_id(marker, None)
    return say


def squares_by_jumps(turtle):
    for _ in range(5):
        turtle.jump(3.0, math.pi / 2.0)
    return turtle


def table(pose):
    return f'{pose.y:8.2f} | {pose.x:8.2f} | {pose.theta:8.2f}'


def with_comma(pose):
    return f'x = {pose.x:.2f}, y = {pose.y:.2f}'.replace('.', ',')


RIGHT = {
    'command_server': [start],
    'publish_circle': [circle, lambda turtle: circle(turtle.drive(1.0, 1.0).reset())],
    'print_poses': [lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=words),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, rate=62.0, say=logged),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=message),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=lambda pose: f'{pose.x}\n{pose.y}'),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=rounded),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=lambda p: f'y: {p.y:.2f} x: {p.x:.2f}'),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=with_comma),
                    lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=lambda p: f'{p.x:.3f} {p.y:.3f}'
                                                            .replace('.', ',')),
                    lambda turtle: subscribed(turtle).print('y | x | theta').drive(10.0, 0.6, 0.5, say=table)],
    'stop_at_x': [lambda turtle: stop_at(turtle, 10.0)],
    'square_by_topics': [polygon, lambda turtle: polygon(turtle.drive(2.0, -1.0, 0.0)),
                         lambda turtle: polygon(turtle, sides=4, length=3.0)],
    'set_pen_and_goto_pose': [lambda turtle: serve(turtle.pen(0, 0, 255, 5, 0)),
                              lambda turtle: serve(turtle.pen(0, 0, 255, 5, 0), words='{:.1f}\n{:.1f}\n{:.1f}')],
    'square_by_teleport': [square_of_teleports, pen_up_first],
    'black_path': [lambda turtle: square_of_teleports(turtle.pen(0, 0, 0, 3, 0)), pen_up_first,
                   lambda turtle: square_of_teleports(turtle.drive(1.0, 1.0).reset().pen(0, 0, 0, 3, 0))],
    'robot_forward': [robot],
    'robot_turning': [lambda turtle: robot(turtle, angular=0.3),
                      lambda turtle: robot(turtle, linear=1.0, angular=-3.0)],
    'robot_square': [lambda turtle: polygon(turtle, 4, 1.2)],
    'robot_circle': [lambda turtle: turtle.drive(14.0, 0.25, 0.5)],
    'robot_triangle': [lambda turtle: polygon(turtle, 3, 1.2)],
    'print_marker_ids': [lambda turtle: show(turtle, marker_id), tells_again],
    'print_marker_x': [lambda turtle: show(turtle, lambda marker, x: f'{marker} is at x = {x}' if marker else 'none'),
                       lambda turtle: show(turtle, lambda marker, x: f'{x:.1f}' if marker else 'none')],
}
WRONG = [  # exercise, what is done, a part of the reasons or hints
    ('print_marker_ids', lambda turtle: show(turtle, first_alone(turtle)), '2 of 3'),
    ('print_marker_ids', lambda turtle: show(turtle, lambda marker, x: marker_id(marker, x) + '\nNo AR markers'),
     'printed 2 of 2 times, and 2 of 2 times with a marker shown'),
    ('print_marker_ids', lambda turtle: show(turtle, lambda marker, x: '\n'.join(map(str, range(147)))), '0 of 3'),
    ('black_path', lambda turtle: turtle.pen(0, 0, 0, 3, 0).teleport(2.0, 2.0).teleport(6.0, 2.0).teleport(6.0, 6.0),
     '3: (2.0, 2.0)'),
    ('black_path', lambda turtle: square_of_teleports(turtle.pen(0, 0, 0, 3, 0)).reset(), '0: none'),
    ('square_by_teleport', squares_by_jumps, '0: none; 5 teleports by another service'),
    ('stop_at_x', lambda turtle: stop_at(turtle, 9.7), 'within 0.15 m'),
    ('set_pen_and_goto_pose', lambda turtle: serve(turtle.pen(0, 0, 255, 5, 0), words='{}'), '0 requests printed'),
    ('publish_circle', lambda turtle: turtle.wait(30.0), '0 commands'),
    ('command_server', lambda turtle: start(turtle, early=True), 'commands before the call'),
    ('command_server', lambda turtle: turtle.drive(12.0, 0.5, 0.2), 'commands before the call'),
    ('publish_circle', lambda turtle: circle(turtle, angular=-0.2), 'angular.z -0.20 rad/s'),
    ('publish_circle', lambda turtle: circle(turtle, seconds=10.0), 'of the path lies on a circle'),
    ('publish_circle', lambda turtle: circle(turtle, rate=2.0), '2.0 Hz, 66 of 66 commands match'),
    ('print_poses', lambda turtle: subscribed(turtle).wait(10.0), 'none with 2 numbers'),
    ('print_poses', lambda turtle: turtle.drive(10.0, 0.6, 0.5, say=lambda pose: 'x: 5.54 y: 5.54'), '0 of 100 lines'),
    ('print_poses', lambda turtle: turtle.drive(10.0, 0.6, 0.5, say=lambda pose: f'x: {pose.y} y: {pose.x}'),
     'lines with'),
    ('stop_at_x', lambda turtle: turtle.drive(6.0, linear=0.5), 'still moving when the time was over, at x ='),
    ('stop_at_x', lambda turtle: turtle.teleport(10.0, 5.5).wait(3.0), 'the program teleported to (10.00, 5.50)'),
    ('square_by_topics', lambda turtle: polygon(turtle, sides=3), 'lies on a square'),
    ('square_by_topics', lambda turtle: polygon(turtle, sides=3, turn=math.pi / 2.0), 'of which 80%'),
    ('square_by_teleport', lambda turtle: square_of_teleports(turtle.pen(0, 0, 0, 3, 1)), 'that matches no square'),
    ('print_poses', lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=lambda pose: words(pose) + ' 1.0' * 11),
     '0 of 100 lines'),
    ('print_poses', lambda turtle: subscribed(turtle).drive(10.0, 0.6, 0.5, say=cut_off), 'lines with'),
    ('square_by_topics', square_of_teleports, 'the program teleported to (2.00, 2.00) instead of driving'),
    ('square_by_topics', lambda turtle: turtle.wait(5.0), 'it did not move'),
    ('set_pen_and_goto_pose', lambda turtle: turtle.pen(0, 0, 255, 5, 0).drive(3.0, 0.5), 'never offered it'),
    ('set_pen_and_goto_pose', lambda turtle: serve(turtle.pen(0, 0, 255, 5, 0), printed=False), '0 requests printed'),
    ('set_pen_and_goto_pose', lambda turtle: serve(turtle.pen(0, 0, 255, 5, 0), answered=False), 'no answer'),
    ('set_pen_and_goto_pose', lambda turtle: serve(turtle.pen(255, 0, 0, 5, 0)), 'pens: (255, 0, 0) width 5'),
    ('square_by_teleport', lambda turtle: turtle.teleport(2.0, 2.0).teleport(6.0, 2.0).teleport(2.0, 6.0),
     '3: (2.0, 2.0)'),
    ('square_by_teleport', lambda turtle: turtle.wait(3.0), '0: none'),
    ('black_path', square_of_teleports, 'the pen was not set'),
    ('black_path', lambda turtle: square_of_teleports(turtle.pen(0, 0, 0, 3, 1)), 'no path; pens'),
    ('black_path', lambda turtle: turtle.pen(0, 0, 0, 3, 0).teleport(2.0, 2.0).teleport(2.0, 2.1), '1: (2.0, 2.0)'),
    ('robot_forward', lambda turtle: robot(turtle, linear=-0.2), 'linear.x -0.20 m/s'),
    ('fibonacci_server', lambda turtle: turtle.wait(10.0), 'the program never offered it'),
    ('record_and_play', lambda turtle: turtle.wait(10.0), 'it sent no command'),
    ('bang_bang', lambda turtle: turtle.wait(10.0), 'the program subscribes to no sensor'),
    ('p_controller', lambda turtle: turtle.wait(10.0), '0 commands'),
    ('between_posts', lambda turtle: turtle.drive(10.0, 0.2), 'that comes as near as'),
    ('keep_distance', lambda turtle: turtle.drive(10.0, 0.2), 'the program subscribes to no sensor'),
    ('keep_centre', lambda turtle: turtle.drive(10.0, 0.0, 0.2), 'the program subscribes to no sensor'),
    ('ar_remote_control', lambda turtle: turtle.wait(10.0), 'subscribes to no marker'),
    ('ar_maze', lambda turtle: turtle.wait(10.0), 'it did not move'),
    ('log_levels', lambda turtle: turtle.drive(7.0, 1.0, say=words), 'info from 6 m on'),
    ('own_messages', lambda turtle: turtle.wait(3.0), 'the program serves nothing'),
    ('own_messages', lambda turtle: turtle.observed.connections.add(('/greet', 'serves')), 'publishes nothing'),
    ('own_messages', lambda turtle: turtle.observed.connections.add(('/person', 'publishes')), 'its type is unknown'),
    ('robot_turning', robot, '|angular.z| 0.00 rad/s'),
    ('robot_turning', lambda turtle: robot(turtle, linear=0.0, angular=0.3), 'linear.x 0.00 m/s'),
    ('robot_square', lambda turtle: polygon(turtle, 3, 1.2), 'lies on a square'),
    ('robot_square', lambda turtle: polygon(turtle, 4, 1.2, turn=2.0), 'a square'),
    ('robot_square', lambda turtle: turtle.drive(5.0, linear=0.3), 'a path of 1.50 m that matches no square'),
    ('robot_circle', lambda turtle: polygon(turtle, 4, 1.2), 'lies on a circle'),
    ('robot_circle', lambda turtle: turtle.drive(6.0, 0.25, 0.5), 'lies on a circle'),
    ('robot_triangle', lambda turtle: polygon(turtle, 4, 1.2), 'lies on a triangle'),
    ('robot_triangle', lambda turtle: turtle.drive(14.0, 0.25, 0.5), 'lies on a triangle'),
    ('robot_triangle', lambda turtle: polygon(turtle, 2, 1.2), 'a triangle'),
    ('print_marker_ids', lambda turtle: show(turtle, lambda marker, x: 'No AR markers detected.'), '0 of 3'),
    ('print_marker_ids', lambda turtle: show(turtle, lambda marker, x: f'ID {marker}' if marker else ''),
     'printed 0 of 2'),
    ('print_marker_x', lambda turtle: show(turtle, lambda marker, x: f'x: {-x}' if marker else ''), '0 of 3'),
    ('print_marker_x', lambda turtle: turtle.wait(3.0), '0 of 0'),
]


def graded(name, act):
    turtle = GradedTurtle(x=4.0, y=3.0)
    act(turtle)
    made = exercise.load(EXERCISES[name])
    return symptoms.advise(made, turtle.observed, scoring.decide(made, turtle.observed))


@pytest.mark.parametrize('name, act', [(name, act) for name, acts in RIGHT.items() for act in acts])
def test_right_nodes_score_100(name, act):
    decided = graded(name, act)
    assert (decided.outcome, decided.score, decided.objections) == ('passed', 100.0, []), decided.reasons


@pytest.mark.parametrize('name, act, said', WRONG)
def test_wrong_nodes_fail_with_the_reason_or_hint(name, act, said):
    decided = graded(name, act)
    assert decided.outcome == 'failed' and decided.score < 80.0
    texts = [f'{reason.asked}: {reason.seen}' for reason in decided.reasons]
    texts += [*decided.objections, *decided.hints]
    assert any(said in text for text in texts), texts


def test_every_exercise_has_a_right_sample_and_three_wrong_ones():
    """Samples are programs, which ``./run test samples/`` grades, or the simulated nodes of RIGHT and WRONG."""
    simulated = [name for name, _, _ in WRONG]
    for name, path in EXERCISES.items():
        kinds = [sample.name.partition('_')[0] for sample in course.samples(path)]
        assert kinds.count('wrong') + simulated.count(name) >= 3, name
        assert 'right' in kinds or course.printed_answer(path) or name in RIGHT, name


@pytest.mark.parametrize('event, said', [
    (Event(1.0, 'reset'), 'the program reset the simulator'),
    (Event(1.0, 'kill', ('turtle1',)), 'the program killed turtle1'),
    (Event(1.0, 'fake_pose', ('/turtle1/pose',)), 'the program published fake poses on /turtle1/pose'),
    (Event(1.0, 'fake_clock'), 'the program published /clock'),
])
def test_shortcuts_score_nothing(event, said):
    decided = graded('robot_forward', lambda turtle: robot(turtle).observed.events.append(event))
    assert (decided.outcome, decided.score, decided.objections) == ('failed', 0.0, [said])


def test_what_cannot_work_scores_nothing():
    def act(turtle):
        turtle.observed.problem = Problem('SyntaxError in line 3')
    decided = graded('publish_circle', act)
    assert (decided.outcome, decided.score, decided.objections) == ('failed', 0.0, ['SyntaxError in line 3'])


def test_a_run_that_could_not_keep_up_is_undecided_unless_all_is_right():
    def act(turtle, **how):
        circle(turtle, **how).observed.kept_up = False
    decided = graded('publish_circle', lambda turtle: act(turtle, angular=-0.2))
    assert decided.outcome == 'undecided' and 'too slow for the simulation' in decided.objections[0]
    decided = graded('publish_circle', act)
    assert (decided.outcome, decided.score) == ('passed', 100.0)


def test_a_rate_is_not_that_of_the_ticks():
    """Ten a second come every 6 or 7 ticks of 16 ms, whose median is 10.4 Hz; a pause is not part of the rate."""
    decided = graded('publish_circle', lambda turtle: circle(turtle.drive(3.0, 0.5, 0.2).wait(5.0)))
    assert ', 10.0 Hz,' in decided.reasons[0].seen


def test_what_is_hidden_counts_and_is_not_told():
    content = yaml.safe_load((EXERCISES['stop_at_x']).read_text())
    content['checks'][1]['visible'] = 'after the deadline'
    turtle = GradedTurtle(x=4.0, y=3.0)
    stop_at(turtle, 8.0)
    made = exercise.parse(content)
    decided = symptoms.advise(made, turtle.observed, scoring.decide(made, turtle.observed))
    assert (decided.outcome, decided.hints) == ('failed', ())
    assert decided.objections == ['a required check failed that is not shown yet']
    assert [reason.check for reason in decided.public().reasons] == ['moves']
    assert [reason.check for reason in decided.public(over=True).reasons] == ['moves', 'stops']
    assert decided.public()._replace(objections=[]).main_reason() == ''  # nothing is lost that may be told


def test_partly_right_is_worth_a_part():
    scores = [graded('stop_at_x', lambda turtle, x=x: stop_at(turtle, x)).score for x in (10.0, 9.7, 9.3, 8.0)]
    assert scores == sorted(scores, reverse=True) and scores[0] == 100.0 and 20.0 < scores[1] < 100.0
