#!/usr/bin/env python3
"""The tutorials' nodes: a turtle that follows by tf, polygons and numbers by actions, two numbers by a service."""
import math
import os
import signal
import subprocess

import actionlib
import roslib.packages
import rospy
from actionlib_tutorials.msg import AveragingAction, AveragingGoal, FibonacciAction, FibonacciGoal
from geometry_msgs.msg import Twist
from std_msgs.msg import Float32
from turtle_actionlib.msg import ShapeAction, ShapeGoal

from rostest_support.common import DEADLINE, FLOAT32_TOLERANCE, MIDDLE, Collected, Process, run, until
from rostest_support.course import CourseCase, stands

ARRIVED = 0.05  # [m] between the turtle that follows and the one that it follows
MD5 = {  # of the originals, built from their sources
    FibonacciAction: 'f59df5767bf7634684781c92598b2406', AveragingAction: '628678f2b4fa6a5951746a4a2d39e716',
    ShapeAction: 'd73b17d6237a925511f5d7727a1dc903'}
SIDE = 0.3 * math.sqrt(3.0)  # [m] of a triangle with a radius of 0.3 m
WRONG = (  # package, program, arguments, part of what it says
    ('turtle_tf2', 'turtle_tf2_broadcaster.py', "the turtle is ''; it must be the name of one, such as turtle1"),
    ('turtle_tf', 'turtle_tf_broadcaster.py', '_turtle:=1a', 'Set it with _turtle:=turtle1'),
    ('turtle_tf2', 'turtle_tf2_listener.py', "parameter /turtle is 'a turtle'; it must be the name of another turtle"),
    ('rospy_tutorials', 'param_talker.py', '_topic_name:=5', 'topic_name is 5; it must be the name of a topic'),
    ('depthimage_to_laserscan', 'depthimage_to_laserscan', '_range_min:=5', '_range_max:=1',
     'range_min is 5; it must be below range_max, which is 1 m'),
    ('robotont_driver', 'fake_driver_node', "_odom_frame:=''", "odom_frame is ''; it must be a text that is not empty"))
Status = actionlib.GoalStatus


class TutorialsTest(CourseCase):

    def program(self, package, name, *arguments):
        """Start a program that ends with the test."""
        process = Process(roslib.packages.find_node(package, name)[0], *arguments)
        self.addCleanup(process.stop)
        return process

    def ends_with_a_stop(self, commands):
        """Wait until the last of these velocities is zero."""
        until(lambda: commands.messages[-1] == Twist(), 'a last Twist of zeros')

    def client(self, name, action):
        """Return a client of an action that is connected with its server."""
        client = actionlib.SimpleActionClient(name, action)
        self.assertTrue(client.wait_for_server(rospy.Duration(5 * DEADLINE)))
        return client

    def ended_as(self, client, state):
        """Wait for a goal's end in a state; return the text of the server."""
        self.assertTrue(client.wait_for_result(rospy.Duration(5 * DEADLINE)), 'the goal has not ended')
        self.assertEqual(Status.to_string(state), Status.to_string(client.get_state()), client.get_goal_status_text())
        return client.get_goal_status_text()

    def broadcasters(self, package, *turtles):
        """Start a broadcaster for each turtle; return the Processes."""
        script = f'{package}_broadcaster.py'
        return [self.program(package, script, f'__name:={turtle}_broadcaster', f'_turtle:={turtle}')
                for turtle in turtles]

    def apart(self):
        """Return the distance [m] between both turtles."""
        leader, follower = self.leader.messages[-1], self.follower.messages[-1]
        return math.hypot(leader.x - follower.x, leader.y - follower.y)

    def follow(self, package, listener):
        """Start a broadcaster for each turtle and a listener; return the Processes once turtle2 moves."""
        started = [*self.broadcasters(package, 'turtle1', 'turtle2'), self.program(package, listener)]
        self.leader, self.follower = self.poses('turtle1'), self.poses('turtle2')
        self.follower.next(lambda pose: not stands(pose), 'turtle2 moving')
        return started

    def test_turtle2_comes_to_turtle1(self):
        """turtle_tf and turtle_tf2, and the one that waits for the present time; they end with a stop."""
        for package, listener in (('turtle_tf', 'turtle_tf_listener.py'),
                                  ('turtle_tf2', 'turtle_tf2_listener_wait.py')):
            with self.subTest(listener):
                *_, process = started = self.follow(package, listener)
                until(lambda: self.apart() < ARRIVED, lambda: f'arrived; {self.apart():.3f} m are left')
                self.call('turtle1/teleport_absolute', 9.0, 9.0, 0.0)
                self.follower.next(lambda pose: pose.linear_velocity > 0.5, 'turtle2 on its way')
                commands = self.commands('turtle2')
                commands.next(what='a velocity')
                process.stop()
                self.ends_with_a_stop(commands)
                self.assertEqual(0, process.process.returncode)
                for one in started:
                    one.stop()
                self.call('reset')

    def test_follower_stands_while_tf_is_lost(self):
        """A broadcaster is killed; the one that waits for the present time gets no answer, the other one an old one."""
        for package, name, said in (
                ('turtle_tf2', 'turtle_tf2_listener.py', 'The transform from turtle2 to turtle1 is no longer sent'),
                ('turtle_tf', 'turtle_tf_listener.py', 'The transform from turtle2 to turtle1 is no longer sent'),
                ('turtle_tf2', 'turtle_tf2_listener_wait.py', 'No transform from turtle2 to turtle1')):
            with self.subTest(name):
                first, other, listener = self.follow(package, name)
                self.call('turtle1/teleport_absolute', 1.0, 10.0, 0.0)
                first.process.kill()
                listener.wait_for_output(said)
                self.follower.next(stands, 'turtle2 standing')
                again, = self.broadcasters(package, 'turtle1')
                until(lambda: self.apart() < ARRIVED, lambda: f'arrived; {self.apart():.3f} m are left')
                for one in (listener, again, other):
                    one.stop()
                self.call('reset')

    def test_wrong_parameters_are_named(self):
        """Each of these nodes ends, and says what is allowed."""
        rospy.set_param('/turtle', 'a turtle')
        self.addCleanup(rospy.delete_param, '/turtle')
        settings = {'global_example': 1, 'utterance': 'hello', 'gains': {'P': 1, 'I': 2, 'D': 3}}
        for name, value in settings.items():
            rospy.set_param(f'/{name}', value)
            self.addCleanup(rospy.delete_param, f'/{name}')
        started = [(self.program(package, name, f'__name:=wrong{number}', *arguments), said)
                   for number, (package, name, *arguments, said) in enumerate(WRONG)]
        for process, said in started:
            self.assertIn(said, self.ended(process, code=2))

    def test_points_of_turtle3_as_turtle1_sees_them(self):
        """turtle1 stands in the middle and looks along x: the difference of the positions."""
        self.broadcasters('turtle_tf', 'turtle1')
        self.broadcasters('turtle_tf', 'turtle3')
        self.program('turtle_tf', 'turtle_tf_message_broadcaster.py')
        printer = self.program('turtle_tf', 'turtle_tf_message_filter')
        found = printer.wait_for_output(r'Position\(x:(\S+) y:(\S+) z:0.000000\)')
        x, y = (float(text) + MIDDLE for text in found.groups())
        self.assertAlmostEqual(1.0, math.hypot(x - 4.0, y - 3.0), delta=0.05)  # from (4, 2), heading 0, radius 1 m

    def test_interfaces_are_those_of_the_originals(self):
        self.assertEqual(MD5, {action: action._md5sum for action in MD5})

    def test_triangle(self):
        self.program('turtle_actionlib', 'shape_server')
        client, poses = self.client('turtle_shape', ShapeAction), self.poses()
        client.send_goal(ShapeGoal(3, 0.3))
        self.ended_as(client, Status.SUCCEEDED)
        result = client.get_result()
        self.assertAlmostEqual(math.pi / 3.0, result.interior_angle, delta=FLOAT32_TOLERANCE)
        self.assertAlmostEqual(0.15, result.apothem, delta=FLOAT32_TOLERANCE)
        self.assert_at(poses.messages[-1], MIDDLE, MIDDLE, 0.0)
        corners = [(MIDDLE + SIDE, MIDDLE), (MIDDLE + SIDE / 2.0, MIDDLE + 0.45), (MIDDLE, MIDDLE)]
        self.assert_passes(poses.messages, corners)

    def test_goals_that_are_cancelled_replaced_or_impossible(self):
        """The turtle stops at once when its goal is cancelled; a goal at the wall is aborted."""
        self.program('turtle_actionlib', 'shape_server')
        client, poses = self.client('turtle_shape', ShapeAction), self.poses()
        client.send_goal(ShapeGoal(2, 1.0))
        self.assertEqual('edges is 2; it must be 3 to 100', self.ended_as(client, Status.ABORTED))
        client.send_goal(ShapeGoal(5, 4.0))
        poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle moving')
        commands = self.commands()
        commands.next(what='a velocity')
        client.cancel_goal()
        self.ended_as(client, Status.PREEMPTED)
        self.ends_with_a_stop(commands)
        client.send_goal(ShapeGoal(5, 4.0))
        poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle moving')
        other = self.client('turtle_shape', ShapeAction)
        other.send_goal(ShapeGoal(4, 11.0))
        self.ended_as(client, Status.PREEMPTED)
        self.assertIn('is there a wall?', self.ended_as(other, Status.ABORTED))

    def test_server_that_is_ended_aborts_its_goal(self):
        server = self.program('actionlib_tutorials', 'fibonacci_server.py')
        client = self.program('actionlib_tutorials', 'fibonacci_client.py')
        server.wait_for_output('creating fibonacci sequence of order 20')
        server.process.send_signal(signal.SIGINT)
        client.wait_for_output('Action finished: ABORTED .the server is being shut down')
        self.ended(client, code=1)

    def test_server_that_is_killed(self):
        """Each client says so and ends; the turtle stops, because nobody drives it any more."""
        poses, pairs = self.poses(), []
        for package, server, client, name in (('actionlib_tutorials', 'fibonacci_server.py', 'fibonacci_client.py',
                                               'fibonacci'),
                                              ('actionlib_tutorials', 'averaging_server', 'averaging_client',
                                               'averaging'),
                                              ('turtle_actionlib', 'shape_server', 'shape_client', 'turtle_shape')):
            pairs.append((self.program(package, server), self.program(package, client), name))
        poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle moving')
        for server, client, _ in pairs:
            client.wait_for_output('sending goal')
            server.process.kill()
        for _, client, name in pairs:
            self.assertIn(f'The server of the action /{name} has gone', self.ended(client, code=1))
        poses.next(stands, 'the turtle standing')

    def cancelled_and_replaced(self, name, action, goal):
        """Assert that a goal which never ends is preempted when it is cancelled, and when another one comes."""
        client, other = self.client(name, action), self.client(name, action)
        client.send_goal(goal)
        until(lambda: client.get_state() == Status.ACTIVE, 'the goal active')
        client.cancel_goal()
        self.ended_as(client, Status.PREEMPTED)
        client.send_goal(goal)
        until(lambda: client.get_state() == Status.ACTIVE, 'the goal active')
        other.send_goal(goal)
        self.ended_as(client, Status.PREEMPTED)
        until(lambda: other.get_state() == Status.ACTIVE, 'the other goal active')
        other.cancel_goal()
        self.ended_as(other, Status.PREEMPTED)

    def test_fibonacci(self):
        self.program('actionlib_tutorials', 'fibonacci_server.py')
        client, lengths = self.client('fibonacci', FibonacciAction), []
        every = actionlib.ActionClient('fibonacci', FibonacciAction)  # the simple one may drop the first feedback
        self.assertTrue(every.wait_for_server(rospy.Duration(5 * DEADLINE)))
        goal = every.send_goal(FibonacciGoal(5), feedback_cb=lambda _, feedback: lengths.append(len(feedback.sequence)))
        until(lambda: goal.get_comm_state() == actionlib.CommState.DONE, 'the result', 5 * DEADLINE)
        self.assertEqual((0, 1, 1, 2, 3, 5), goal.get_result().sequence)
        self.assertEqual([3, 4, 5, 6], lengths)
        client.send_goal(FibonacciGoal(47))
        self.assertIn('order is 47; it must be 0 to 46', self.ended_as(client, Status.ABORTED))
        client.send_goal(FibonacciGoal(-1))
        self.assertIn('order is -1; it must be 0 to 46', self.ended_as(client, Status.ABORTED))
        self.cancelled_and_replaced('fibonacci', FibonacciAction, FibonacciGoal(40))

    def test_fibonacci_in_c_has_its_name_whatever_the_node_is_called(self):
        self.program('actionlib_tutorials', 'fibonacci_server', '__name:=fibonacci_server')
        client = self.client('fibonacci', FibonacciAction)
        client.send_goal(FibonacciGoal(1))
        self.ended_as(client, Status.SUCCEEDED)
        self.assertEqual((0, 1, 1), client.get_result().sequence)

    def test_averaging(self):
        """One number more than the goal says; NaN is left out; a mean below 5 aborts."""
        server = self.program('actionlib_tutorials', 'averaging_server')
        client = self.client('averaging', AveragingAction)
        publisher, given = rospy.Publisher('random_number', Float32, queue_size=10), []
        for numbers, state in (((float('nan'), 4.0, 7.0, 10.0), Status.SUCCEEDED), ((4.0, 5.0), Status.ABORTED)):
            client.send_goal(AveragingGoal(len(numbers) - 2 if state == Status.SUCCEEDED else 1),
                             feedback_cb=lambda feedback: given.append(feedback.data))
            until(lambda: client.get_state() == Status.ACTIVE and publisher.get_num_connections(), 'the goal active')
            for number in numbers:
                publisher.publish(number)
            self.ended_as(client, state)
            self.assertAlmostEqual(7.0 if state == Status.SUCCEEDED else 4.5, client.get_result().mean, places=5)
        self.assertIn('it must be a finite number', server.output())
        self.assertEqual([4.0, 7.0, 10.0, 4.0, 5.0], given)
        client.send_goal(AveragingGoal(-1))
        self.assertEqual('samples is -1; it must be 0 or more', self.ended_as(client, Status.ABORTED))
        self.cancelled_and_replaced('averaging', AveragingAction, AveragingGoal(100))

    def test_two_numbers_are_added(self):
        client = self.program('rospy_tutorials', 'add_two_ints_client', '3', '4')  # it waits for the service
        server = self.program('rospy_tutorials', 'add_two_ints_server')
        self.assertIn('3 + 4 = 7', self.ended(client))
        client = self.program('rospy_tutorials', 'add_two_ints_client', str(2 ** 63 - 1), '1')
        self.assertIn('does not fit into an int64', self.ended(client, code=1))
        server.stop()
        self.assertEqual(0, server.process.returncode)

    def test_talker_and_listener(self):
        self.program('rospy_tutorials', 'talker.py')
        listener = self.program('rospy_tutorials', 'listener.py')
        listener.wait_for_output('I heard hello world [0-9.]+')

    def test_keyboard_drives(self):
        """Keys from a program: a velocity each, and zeros when it has gone; a wrong parameter is named."""
        wrong = self.program('teleop_twist_keyboard', 'teleop_twist_keyboard.py', '_speed:=fast')
        self.assertIn("/teleop_twist_keyboard/speed is 'fast'; it must be a number", self.ended(wrong, code=2))
        received = Collected('/robot/cmd_vel', Twist)
        script = roslib.packages.find_node('teleop_twist_keyboard', 'teleop_twist_keyboard.py')[0]
        process = Process(script, 'cmd_vel:=/robot/cmd_vel', '_speed:=0.25', stdin=subprocess.PIPE)
        self.addCleanup(process.stop)
        process.wait_for_output('currently:')
        os.write(process.process.stdin.fileno(), b'U')
        until(lambda: [one for one in received.messages if (one.linear.x, one.linear.y) == (0.25, 0.25)], 'a velocity')
        process.process.stdin.close()
        self.ended(process)
        self.ends_with_a_stop(received)


if __name__ == '__main__':
    run(TutorialsTest)
