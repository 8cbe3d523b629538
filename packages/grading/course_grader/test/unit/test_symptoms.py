"""course_grader.rules.symptoms: a program that lost points gets advice on the likely mistake."""
import math

import pytest

from course_grader.rules import exercise, path_mistakes, scoring, symptoms
from course_grader.rules.observation import Command, Observed, Problem
from unit_support import course_files
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle

OTHERS = {('/turtle1/cmd_vel', 'subscribes'), ('/turtle1/pose', 'publishes'), ('/turtle1/set_pen', 'serves'),
          ('/turtle1/teleport_absolute', 'serves'), ('/turtle1/teleport_relative', 'serves'), ('/rosout', 'publishes')}


def advised(name, act=None, source='', trouble='', connections=()):
    """Return the Verdict for the motion of a turtle in an exercise."""
    turtle = GradedTurtle(4.0, 3.0)
    if act:
        act(turtle)
    observed = turtle.observed
    observed.others, observed.source = OTHERS, source
    observed.problem = Problem(trouble) if trouble else None
    observed.connections |= set(connections)
    one = exercise.load(EXERCISES[name])
    return symptoms.advise(one, observed, scoring.decide(one, observed))


def hints(*values, **named):
    return advised(*values, **named).hints


@pytest.mark.parametrize('told, source, trouble', [
    ('Mistake', "rospy.Subscriber('/turtle1/pose', Pose, show)\nrospy.spin\n", ''), ('Hint', '', ''),
    ('Mistake', '', "exit code 1: NameError: name 'rospy' is not defined"),
    ('Hint', '', 'exit code 1: BufferError: full')])
def test_only_what_is_certain_is_told_as_the_mistake(told, source, trouble):
    assert advised('stop_at_x', lambda turtle: turtle.drive(2.0, 0.0), source, trouble).advice()[0].startswith(told)


def circle(turtle, angular=0.2, rate=10.0):
    turtle.drive(33.0, 0.5, angular, rate, say=lambda pose: '0.5 0.2')


@pytest.mark.parametrize('connection, said', [
    (('/turtle/cmd_vel', 'publishes'), 'publishes /turtle/cmd_vel, which nobody reads: did you mean /turtle1/cmd_vel?'),
    (('/cmd_vel', 'publishes'), 'publishes /cmd_vel, which nobody reads: did you mean /turtle1/cmd_vel?'),
    (('/turtle1/Pose', 'subscribes'),
     'subscribes to /turtle1/Pose, which nobody publishes: did you mean /turtle1/pose?'),
    (('/turtle1/setpen', 'serves'), 'offers /turtle1/setpen, which nobody calls: did you mean /turtle1/set_pen?'),
])
def test_names_that_nobody_else_uses(connection, said):
    assert hints('publish_circle', connections=[connection])[0] == f'the program {said}'


def test_a_name_that_the_program_uses_already_is_not_meant():
    used = [('/cmd_vel', 'publishes'), ('/turtle2/cmd_vel', 'publishes')]
    assert 'did you mean /turtle1/cmd_vel?' in hints('launch_two_turtles', connections=used)[0]


def test_a_name_with_a_slash_ignores_the_namespace_of_its_node():
    used = [('/cmd_vel', 'publishes'), ('/rosout', 'publishes'), ('/turtle1/drive/get_loggers', 'serves')]
    assert hints('launch_two_turtles', connections=used) == (
        "/cmd_vel begins with a slash, so that the namespace of its node changes nothing: write 'cmd_vel'",)


@pytest.mark.parametrize('connection', [('/rosout', 'publishes'), ('/turtle1/cmd_vel', 'publishes'),
                                        ('/my_node/get_loggers', 'serves'), ('/something/else', 'publishes')])
def test_other_names_are_not_suspected(connection):
    assert not any('did you mean' in hint for hint in hints('publish_circle', connections=[connection]))


@pytest.mark.parametrize('source', [
    't' + '.a' * 2000 + '.linear.x += 1\n',
    'm = wait_for_message(t' + '.a' * 2000 + ', P)\nwhile True:\n    print(m)\n',
    'while True:\n    publish(a)\n' * 50_000])
def test_a_source_that_cannot_be_searched_costs_no_verdict(source):
    assert hints('publish_circle', lambda turtle: circle(turtle, angular=0.3), source) is not None


def test_names_in_the_source_are_compared_with_the_task_first():
    source = "call = rospy.ServiceProxy('/turtle1/teleport', Teleport)  # of turtlesim/Teleport\n"
    assert hints('square_by_teleport', source=source)[0] == (
        'the program uses /turtle1/teleport, which does not exist: did you mean /turtle1/teleport_absolute?')


def test_a_relative_name_that_a_launch_file_puts_into_a_namespace_is_no_misspelling():
    source = "publisher = rospy.Publisher('cmd_vel', Twist, queue_size=10)\n"
    assert 'did you mean' in hints('publish_circle', source=source)[0]
    assert not any('did you mean' in hint for hint in hints('publish_circle', source=source, connections=[
        ('/turtle1/cmd_vel', 'publishes')]))


def test_a_service_that_returns_nothing():
    def act(turtle):
        turtle.print("[ERROR] Error processing request: service handler returned None")
    assert 'must return a response' in hints('set_pen_and_goto_pose', act)[0]


def test_each_of_several_checks_of_one_name_counts():
    def act(turtle):  # blue is 255 by default, so that the reason of the last of three checks says little
        turtle.observed.parameters = {f'/turtlesim/background_{part}': value for part, value in (
            ('r', 69), ('g', 86), ('b', 255))}
    assert 'its full name, which begins with that of the node' in hints('background_by_parameters', act)[0]


def test_a_missing_spin():
    def act(turtle):
        turtle.observed.exit_code, turtle.observed.ended_at = 0, 5.0
    assert 'rospy.spin()' in hints('print_poses', act, source="rospy.Subscriber('/turtle1/pose', Pose, show)\n")[0]
    assert not any('ended by itself' in hint for hint in hints(
        'print_poses', act, source="rospy.Subscriber('/turtle1/pose', Pose, show)\nrospy.spin()\n"))


def test_a_program_that_has_to_end_needs_no_spin():
    def act(turtle):
        turtle.observed.exit_code, turtle.observed.ended_at = 0, 5.0
    source = "rospy.Subscriber('/turtle1/pose', Pose, show)\nrospy.sleep(5)\n"
    assert not any('rospy.spin() in' in hint for hint in hints('background_by_parameters', act, source=source))
    assert 'rospy.spin()' in hints('print_poses', act, source=source)[0]


def speeds_up(turtle):
    turtle.drive(1.0, 0.5).drive(1.0, 1.0).drive(1.0, 1.5)


def floods(turtle):
    turtle.drive(1.0, 0.5)
    turtle.observed.commands = sorted(2 * turtle.observed.commands)


@pytest.mark.parametrize('act, source, said', [
    (speeds_up, 'def show(pose):\n    while pose.x < 10:\n        pub.publish(go)\n'
                "Subscriber('/turtle1/pose', Pose, show)\n", 'write `if` instead of `while`'),
    (floods, 'while not rospy.is_shutdown():\n    pub.publish(go)\n', 'the loop in line 1 sends its commands without'),
    (floods, 'for corner in range(4):\n    pub.publish(go)\n', 'the loop in line 1 sends its commands without'),
    (speeds_up, 'while True:\n    go.linear.x += 0.5\n    rate.sleep()\n', 'line 2 changes the velocity each time'),
    (speeds_up, 'go.linear.x = error // 2\n', '// in line 1 rounds down'),
])
def test_what_the_source_shows_where_it_drives_wrong(act, source, said):
    found = hints('stop_at_x', act, source=source + "rospy.init_node('a')\n")
    assert said in found[0]


@pytest.mark.parametrize('source', [
    'def send():\n    pub.publish(go)\n    rate.sleep()\nwhile True:\n    send()\n',
    'for marker in message.markers:\n    pub.publish(marker)\n',
    "def show(pose):\n    while queue:\n        queue.pop()\nrospy.Subscriber('/turtle1/pose', Pose, show)\n",
    'total.x += 1\n',
])
def test_other_loops_are_not_suspected(source):
    found = hints('stop_at_x', lambda turtle: turtle.drive(2.0, 0.5), source=source + "rospy.init_node('a')\n")
    assert not any(word in hint for hint in found for word in ('pause', 'instead of `while`', 'grows'))


def test_a_value_that_is_none_because_it_stays_in_a_function():
    source = ('x = None\ndef callback(pose):\n    x = pose\nrospy.init_node("a")\n'
              "rospy.Subscriber('/turtle1/pose', Pose, callback)\nprint(x.y)\n")
    trouble = "AttributeError: 'NoneType' object has no attribute 'y'"
    assert 'write `global x`' in hints('stop_at_x', source=source, trouble=f'exit code 1: {trouble}')[0]
    assert 'still None' in hints('stop_at_x', source=source.replace('    x', '    global x; x'), trouble=trouble)[0]


def test_what_no_cause_is_sure_for_is_told_in_numbers():
    assert ('it sent 12 velocities in 1.1 s, with linear.x 0.2 m/s and angular.z 1.5 rad/s' in
            hints('spiral', lambda turtle: turtle.drive(1.2, 0.2, 1.5))[0])
    assert ('it turns by 35 degrees in all; a whole circle' in
            hints('robot_circle', lambda turtle: turtle.drive(1.0, 1.0, 0.6))[0])


@pytest.mark.parametrize('own, end', [
    ((1.0, 1.0, 0.5), 'its own is 0.99 m long, turns by 28 degrees and takes 1.0 s: sleep between two poses for the '
                      'difference of their times'),
    ((4.0, 0.73, -0.5), 'and takes 4.0 s'),  # of the same length: it needs no pauses
    ((2.9, 1.0, -0.5), ': it turns to the other side, so check the sign of angular.z')])
def test_a_path_that_is_repeated_is_told_in_numbers(own, end):
    turtle = GradedTurtle(3.0, 3.0)
    turtle.drive(2.0, 1.0, 0.5)
    shown = len(turtle.observed.commands)
    turtle.wait(1.0).drive(*own)
    del turtle.observed.commands[:shown]  # the grader drove
    turtle.observed.connections.add(('/turtle1/pose', 'subscribes'))
    hint, = path_mistakes.measured(exercise.load(EXERCISES['record_and_play']), turtle.observed, ['repeats'])
    assert hint.endswith(end)


@pytest.mark.parametrize('timed_out, said', [(True, 'it was in part 2 of 4'), (False, 'straight parts, of')])
def test_a_square_that_is_not_finished_in_time(timed_out, said):
    turtle = GradedTurtle(3.0, 3.0).drive(2.0, 0.5).drive(1.0, 0.0, math.pi / 2.0).drive(2.0, 0.5)
    turtle.observed.timed_out = timed_out
    hint, = path_mistakes.measured(exercise.load(EXERCISES['robot_square']), turtle.observed, ['draws'])
    assert said in hint


def test_a_circle_that_is_too_large():
    found = hints('robot_circle', lambda turtle: turtle.drive(13.0, 1.0, 0.5))  # of 4 m, and at most 3 m are asked
    assert found[0].startswith('the circle has a diameter of 4.0 m, and not of 0.5 to 3 m')


def test_a_program_that_publishes_an_empty_message():
    said = hints('stop_at_x', lambda turtle: turtle.drive(2.0, 0.0), 'while moves():\n    pub.publish(Twist())\n')
    assert said[0].startswith('line 2 publishes Twist(), a new message of zeros')
    said = hints('stop_at_x', lambda turtle: turtle.drive(2.0, 0.0), 'pub.publish(twist)\npub.publish(Twist())\n')
    assert said[0].startswith('all velocities that it sends are 0')


@pytest.mark.parametrize('name, topic, exit_code, told', [
    ('keep_distance', '/cmd_vel', None, 'or faster than 10 m/s'), ('keep_distance', '/cmd_vel', 1, None),
    ('stop_at_x', '/turtle1/cmd_vel', None, 'no velocity of it'), ('follow_turtle', '/turtle2/cmd_vel', None, None)])
def test_a_program_that_sends_no_velocity(name, topic, exit_code, told):
    one = exercise.load(EXERCISES[name])
    seen = Observed(connections={(topic, 'publishes')}, exit_code=exit_code)
    said = symptoms.advise(one, seen, scoring.decide(one, seen)).hints
    assert told in said[0] if told else 'no velocity of it' not in str(said)


def test_a_path_with_one_side():
    turtle = GradedTurtle(3.0, 3.0).drive(2.0, 0.5).drive(3.0, 0.0, 0.5)
    hint, = path_mistakes.measured(exercise.load(EXERCISES['robot_triangle']), turtle.observed, ['draws'])
    assert 'one straight part of 1.00 m' in hint and 'then it only turns; a triangle has 3 equal sides' in hint


def test_a_path_that_is_not_that_of_the_solution_gets_advice_on_motion():
    turtle = GradedTurtle(4.0, 3.0)
    turtle.drive(2.0, 0.0)
    turtle.observed.solution = [(4.0, 3.0), (6.0, 3.0)]
    one = exercise.parse({'title': 'T', 'asks': 'Drive.', 'time': '9 s', 'solution': 'pass',
                          'checks': [{'check': 'same_path', 'points': 100}]})
    advised = symptoms.advise(one, turtle.observed, scoring.decide(one, turtle.observed))
    assert advised.hints[0].startswith('all velocities that it sends are 0')


@pytest.mark.parametrize('solution, advice', [('pass', 1), ('twist.linear.x += 0.01', 0)])
def test_what_the_solution_does_too_is_no_mistake(solution, advice):
    turtle = GradedTurtle(4.0, 3.0)
    speeds_up(turtle)
    turtle.observed.solution = [(4.0, 3.0), (4.0, 5.0)]
    turtle.observed.source = 'for _ in range(3):\n    twist.linear.x += 0.1\n'
    one = exercise.parse({'title': 'T', 'asks': 'Drive.', 'time': '9 s', 'solution': solution,
                          'checks': [{'check': 'same_path', 'points': 100}]})
    advised = symptoms.advise(one, turtle.observed, scoring.decide(one, turtle.observed))
    assert sum('so that it grows' in hint for hint in advised.hints) == advice


@pytest.mark.parametrize('source, told', [
    ("goal.target_pose.header.frame_id = 'base_link'\n", "frame_id = 'map' instead of 'base_link'"),
    ("goal.target_pose.header.frame_id = 'map'\nturn(math.sin(90 / 2))\n", 'angles are in radians')])
def test_goals_that_are_written_wrong(source, told):
    one = exercise.load(EXERCISES['send_goals'])
    observed = Observed(source=source)
    assert told in symptoms.advise(one, observed, scoring.decide(one, observed)).hints[0]


@pytest.mark.parametrize('source, told', [
    ("spawn(2, 2, 0, 'Turtle2')\n", 'gets another name'),
    ("spawn(2, 2, 0, 'turtle2')\n", 'call /spawn with')])
def test_a_turtle_with_another_name(source, told):
    assert told in hints('spawn_turtle', source=source)[0]


def test_degrees_of_a_transform():
    source = 'send(quaternion_from_euler(0, 0, math.degrees(pose.theta)))\n'
    assert 'degrees in line 1 makes degrees' in hints('tf_broadcaster', source=source)[0]


@pytest.mark.parametrize('source, told', [
    ("rospy.logdebug('0.5')\n", True), ("rospy.logdebug('0.5')\nrospy.loginfo('on')\n", False),
    ("rospy.init_node('a', log_level=rospy.DEBUG)\nrospy.logdebug('0.5')\n", False)])
def test_messages_that_are_not_printed(source, told):
    assert any('logdebug are not printed' in hint for hint in hints('publish_circle', source=source)) == told


def test_the_wrong_turtle_drives():
    def act(turtle):
        turtle.drive(5.0, 1.0).observed.turtles['turtle2'] = [turtle.observed.track[-1]._replace(x=1.0)]
    assert 'publish on /turtle2/cmd_vel' in hints('follow_turtle', act, connections=[
        ('/turtle1/cmd_vel', 'publishes')])[0]


def test_the_namespace_of_an_action_is_no_misspelling():
    assert not any('did you mean' in hint for hint in hints(
        'fibonacci_server', source="actionlib.SimpleActionServer('/fibonacci', FibonacciAction, run, False)\n",
        connections=[('/fibonacci/goal', 'subscribes'), ('/fibonacci/result', 'publishes')]))


@pytest.mark.parametrize('trouble, said', [
    ('service [/clear] responded with an error: b"service cannot process request: parameter /turtlesim/background_r is '
     "'255'; it must be a whole number from 0 to 255\"", 'the parameter /turtlesim/background_r is a text'),
    ('service [/spawn] responded with an error: b"service cannot process request: there is a turtle2 already"',
     'the service refuses the request: there is a turtle2 already'),
    ('genpy.message.SerializationError: field x must be float type', 'in the order of `rossrv show TYPE`'),
])
def test_refused_calls_are_explained(trouble, said):
    assert said in hints('spawn_turtle', trouble=trouble)[0]


def test_a_variable_with_the_name_of_a_type():
    found = hints('publish_circle', source='from geometry_msgs.msg import Twist\ndef f():\n    Twist = Twist()\n',
                  trouble="UnboundLocalError: cannot access local variable 'Twist' where it is not associated")
    assert found[0].startswith('a variable has the name of the imported Twist')


def test_the_first_symptom_of_a_check_counts():
    found = hints('set_pen_and_goto_pose', lambda turtle: turtle.pen(0, 0, 255, 1, 0).drive(2.0, 1.0))
    assert [hint for hint in found if 'blue' in hint or 'width' in hint] == ['the width of the pen has to be 5']


@pytest.mark.parametrize('colour, told', [((255, 0, 0), True), ((0, 255, 0), False)])
def test_a_colour_of_the_pen_is_a_symptom(colour, told):
    made = exercise.parse({'title': 'T', 'time': '9 s', 'symptoms': [{'pen': [255, 0, 0], 'hint': 'red is first'}],
                           'checks': [{'check': 'pen', 'colour': [0, 0, 255], 'points': 100}]})
    observed = GradedTurtle().pen(*colour, 1, 0).drive(2.0, 1.0).observed
    decided = symptoms.advise(made, observed, scoring.decide(made, observed))
    assert ('red is first' in decided.hints) == told


def blue_corner(turtle, off=1):
    """Two sides in blue, and the way back with the pen lifted."""
    turtle.pen(0, 0, 255, 4, 0).drive(2.0, 1.0).drive(1.0, 0.0, math.pi / 2).drive(2.0, 1.0)
    return turtle.pen(0, 0, 255, 4, off).drive(1.0, 0.0, math.pi / 2).drive(2.0, 1.0)


@pytest.mark.parametrize('symptom', [
    {'lost': 'pen', 'pen': [0, 0, 255]}, {'lost': 'pen'}, {'lost': 'pen', 'seen': '^0%'}])
def test_a_pen_of_another_colour_that_is_lifted_at_the_end_is_not_called_off(symptom):
    """The hint was that the pen is off, and that of the exercise was not shown."""
    made = exercise.parse({'title': 'T', 'time': '20 s', 'symptoms': [{**symptom, 'hint': 'choose red'}], 'checks': [
        {'check': 'pen', 'colour': [255, 0, 0], 'points': 100}]})
    observed = blue_corner(GradedTurtle()).observed
    assert symptoms.advise(made, observed, scoring.decide(made, observed)).hints == ('choose red',)


def test_a_symptom_of_the_exercise_overrules_a_general_hint():
    content = {'title': 'T', 'time': '20 s', 'checks': [{'check': 'pen', 'colour': [255, 0, 0], 'points': 100}]}
    observed = GradedTurtle().pen(255, 0, 0, 1, 1).drive(2.0, 1.0).observed
    for own, first in (({'pen': [255, 0, 0], 'hint': 'lower it'}, 'lower it'),
                       ({'hint': 'choose red'}, 'the pen is off')):
        made = exercise.parse({**content, 'symptoms': [{'lost': 'pen', **own}]})
        found = symptoms.advise(made, observed, scoring.decide(made, observed)).hints
        assert found[0].startswith(first) and any(hint.startswith('the pen is off') for hint in found)


@pytest.mark.parametrize('connection, said', [
    (('/turtle1/pose', 'publishes'), 'rospy.Subscriber instead of rospy.Publisher'),
    (('/turtle1/cmd_vel', 'subscribes'), 'rospy.Publisher instead of rospy.Subscriber'),
    (('/turtle1/set_pen', 'serves'), 'rospy.ServiceProxy instead of rospy.Service'),
    (('/turtle1/set_pen', 'publishes'), '/turtle1/set_pen is a service, and no topic'),
])
def test_what_the_simulator_does_already(connection, said):
    assert said in hints('publish_circle', connections=[connection])[0]


def test_who_teleports_is_told_to_drive():
    assert 'here the turtle has to drive' in hints('square_by_topics', lambda turtle: turtle.teleport(1.0, 1.0))[0]


def test_a_program_that_crashed_gets_no_advice_on_what_it_did_not_come_to():
    found = hints('publish_circle', lambda turtle: turtle.wait(1.0),
                  trouble='the program ended with exit code 1: StrangeError: what')
    assert found == ('the program ended with a StrangeError: the last lines of its output say why, and in which line',)
    found = hints('publish_circle', lambda turtle: turtle.wait(1.0),
                  trouble="the program ended with exit code 1: NameError: name 'Twist' is not defined")
    assert found == ('Twist is used, but not imported: `from geometry_msgs.msg import Twist`',)


def test_a_sure_cause_stands_alone():
    found = hints('publish_circle', lambda turtle: turtle.wait(1.0), connections=[('/turtle/cmd_vel', 'publishes')])
    assert len(found) == 1 and 'did you mean' in found[0]


def test_another_turtle_of_the_task_is_no_misspelling():
    assert not any('did you mean' in hint for hint in hints('follow_turtle', connections=[
        ('/turtle2/cmd_vel', 'publishes')]))


def test_commands_that_come_too_early():
    def act(turtle):
        turtle.wait(1.0).observed.exit_code = 0
    assert 'no command arrived' in hints('square_by_topics', act, source='pub.publish(Twist())\n',
                                         connections=[('/turtle1/cmd_vel', 'publishes')])[0]


@pytest.mark.parametrize('source, told', [
    ('import rospy\n\n\ndef main():\n    rospy.init_node("a")\n    rospy.spin()\n', 'nothing calls main'),
    ('import rospy\n# rospy.init_node("a")\nrospy.spin()\n', 'call rospy.init_node')])
def test_who_never_calls_the_function_with_the_node_is_told_that(source, told):
    found = hints('command_server', source=source, trouble='the program never started a node; does it call '
                  'rospy.init_node?')
    assert len(found) == 1 and told in found[0]


def test_who_passes_with_less_than_all_points_gets_hints():
    assert 'print or log' in hints('publish_circle', lambda turtle: turtle.drive(33.0, 0.5, 0.2))[0]


def test_who_has_all_points_gets_no_hint():
    assert hints('publish_circle', circle, connections=[('/turtle/cmd_vel', 'publishes')]) == ()


def test_hints_are_few():
    assert len(hints('publish_circle', trouble='NameError: init_node', connections=[
        ('/turtle/cmd_vel', 'publishes'), ('/turtle1/cmdvel', 'publishes'), ('/turtle1/Pose', 'subscribes')])) == 2


@pytest.mark.parametrize('symptom, said', [
    ({'lost': 'moves'}, 'symptom 1 lacks the key hint'),
    ({'hint': 'a', 'lost': 'flies'}, "symptom 1: lost: 'flies' must be one of "),
    ({'hint': 'a', 'seen': '('}, 'symptom 1: seen: '),
    ({'hint': 'a', 'colour': 'red'}, "symptom 1 has an unknown key 'colour'"),
])
def test_wrong_symptoms_are_the_teachers_error(symptom, said):
    content = {'title': 'T', 'time': '10 s', 'checks': [{'check': 'moves', 'points': 100, 'length': '2 m'}]}
    assert exercise.parse({**content, 'symptoms': [{'hint': 'drive', 'lost': 'moves'}]}).symptoms[0]['hint'] == 'drive'
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse({**content, 'symptoms': [symptom]})
    assert str(error.value).startswith(said)


def test_every_predicate_is_known():
    assert set(symptoms.PREDICATES) == set(exercise.OF_A_SYMPTOM) - {'hint'}
    assert symptoms.advise(exercise.load(EXERCISES['stop_at_x']), Observed(),
                           scoring.Verdict('undecided', 0.0, [], [])).hints == ()


def test_each_mistake_of_the_regression_set_is_one():
    """A changed sample would no longer hold it; ``grading/hints`` grades them."""
    assert len(course_files.mistakes()) >= 150


def test_what_it_commands_explains_the_path_that_it_drives():
    """It turns into the wall; the first hint was that it is too slow."""
    found = hints('publish_circle', lambda turtle: circle(turtle, angular=-0.2))
    assert found[0] == ('angular.z is -0.2, which has the wrong sign: it is the turn speed, positive to the left')
    assert not any('too slow' in hint for hint in found)


@pytest.mark.parametrize('name, rate, told', [('robot_forward', 1.0, False), ('robot_square', 1.0, True)])
def test_pauses_that_the_task_asks_for_are_no_mistake(name, rate, told):
    one = exercise.load(EXERCISES[name])
    observed = Observed(commands=[Command(number / rate, -0.1, 0.0, 0.0) for number in range(10)], seconds=10.0)
    assert any('ten times per second' in hint for hint in path_mistakes.stops_in_between(one, observed)) is told
