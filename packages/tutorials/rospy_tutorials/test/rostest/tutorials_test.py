#!/usr/bin/env python3
"""The lessons: a turtle that follows by tf, polygons and numbers by actions, two numbers by a service, and others."""
import math
import signal

import actionlib
import roslib.packages
import rospy
import tf
import tf2_ros
from actionlib_tutorials.msg import AveragingAction, AveragingGoal, FibonacciAction, FibonacciGoal
from geometry_msgs.msg import Twist
from std_msgs.msg import Float32, String
from turtle_actionlib.msg import ShapeAction, ShapeGoal

from rostest_support.common import DEADLINE, FLOAT32_TOLERANCE, MIDDLE, Collected, Process, nightly, run, until
from rostest_support.course import CourseCase, stands

ARRIVED = 0.05  # [m] between the turtle that follows and the one that it follows
MD5 = {  # of the originals, built from their sources
    FibonacciAction: 'f59df5767bf7634684781c92598b2406', AveragingAction: '628678f2b4fa6a5951746a4a2d39e716',
    ShapeAction: 'd73b17d6237a925511f5d7727a1dc903'}
SIDE = 0.3 * math.sqrt(3.0)  # [m] of a triangle with a radius of 0.3 m
BROADCAST = {  # frame: x, y, yaw [m, m, rad] in the frame world
    'turtle1': (4.0, 4.0, 0.0), 'turtle2': (4.0, 2.0, 0.0), 'carrot1': (7.0, 2.0, 0.0)}
TO_LEADER = 0.5 * 2.0, 4.0 * math.pi / 2.0  # [m/s, rad/s] to turtle1, 2 m to the left of turtle2
TO_CARROT = 0.5 * 3.0, 0.0  # 3 m ahead of it
LISTENERS = (  # package, program, velocity that it commands
    ('turtle_tf', 'turtle_tf_listener.py', TO_LEADER), ('turtle_tf', 'turtle_tf_listener', TO_LEADER),
    ('turtle_tf', 'turtle_tf_listener_wait.py', TO_CARROT), ('turtle_tf2', 'turtle_tf2_listener.py', TO_LEADER),
    ('turtle_tf2', 'turtle_tf2_listener', TO_LEADER), ('turtle_tf2', 'turtle_tf2_listener_wait.py', TO_LEADER))
WRONG_LESSONS = (  # package, program, part of its error
    ('turtle_tf', 'turtle_tf_broadcaster.py', 'Type: rosrun turtle_tf turtle_tf_broadcaster.py _turtle:=turtle1'),
    ('turtle_tf', 'turtle_tf_broadcaster', 'Type: rosrun turtle_tf turtle_tf_broadcaster turtle1'),
    ('turtle_tf2', 'turtle_tf2_broadcaster.py', 'Type: rosrun turtle_tf2 turtle_tf2_broadcaster.py _turtle:=turtle1'),
    ('turtle_tf2', 'turtle_tf2_broadcaster', 'Type: rosrun turtle_tf2 turtle_tf2_broadcaster turtle1'),
    ('rospy_tutorials', 'param_talker.py', "'/global_example' is not set. Type: roslaunch rospy_tutorials"),
    ('rospy_tutorials', 'add_two_ints_client', '3', 'Type: rosrun rospy_tutorials add_two_ints_client 3 4'),
    ('rospy_tutorials', 'add_two_ints_client', '3', '4.5', 'Two whole numbers are needed, or none'))
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

    def comes_to_turtle1(self, package, listener):
        *_, process = started = self.follow(package, listener)
        until(lambda: self.apart() < ARRIVED, lambda: f'arrived; {self.apart():.3f} m are left')
        self.call('turtle1/teleport_absolute', 9.0, 9.0, 0.0)
        self.follower.next(lambda pose: pose.linear_velocity > 0.5, 'turtle2 on its way')
        commands = self.commands('turtle2')
        commands.next(what='a velocity')
        process.stop()
        self.ends_with_a_stop(commands)
        self.assertEqual(0, process.process.returncode)
        for each in started:
            each.stop()
        self.call('reset')

    def test_turtle2_comes_to_turtle1(self):
        """By turtle_tf2's listener that waits for the present time; it ends with a stop."""
        self.comes_to_turtle1('turtle_tf2', 'turtle_tf2_listener_wait.py')

    @nightly
    def test_turtle2_comes_to_turtle1_by_turtle_tf(self):
        self.comes_to_turtle1('turtle_tf', 'turtle_tf_listener.py')

    def test_follower_that_waits_stands_while_tf_is_lost(self):
        """turtle1's broadcaster is killed, and started again."""
        first, _, listener = self.follow('turtle_tf2', 'turtle_tf2_listener_wait.py')
        self.call('turtle1/teleport_absolute', 1.0, 10.0, 0.0)
        first.process.kill()
        listener.wait_for_output('No transform from turtle2 to turtle1')
        self.follower.next(stands, 'turtle2 standing')
        self.broadcasters('turtle_tf2', 'turtle1')
        until(lambda: self.apart() < ARRIVED, lambda: f'arrived; {self.apart():.3f} m are left')

    def broadcast(self, frames):
        """Send frames below world, again and again until the test ends; ``frames``: {name: (x, y, yaw)}."""
        broadcaster = tf.TransformBroadcaster()

        def send(_):
            for name, (x, y, yaw) in frames.items():
                turned = tf.transformations.quaternion_from_euler(0.0, 0.0, yaw)
                broadcaster.sendTransform((x, y, 0.0), turned, rospy.Time.now(), name, 'world')
        timer = rospy.Timer(rospy.Duration(0.1), send)
        self.addCleanup(timer.shutdown)

    def test_velocity_leads_to_the_frame(self):
        """Every listener, as the frames of this test stand; a turtle2 that is there follows."""
        self.broadcast(BROADCAST)
        commands = self.commands('turtle2')
        for number, (package, name, (speed, turn)) in enumerate(LISTENERS):
            with self.subTest(name):
                listener = self.program(package, name)
                command = commands.next(lambda one: one != Twist(), 'a velocity')
                self.assertAlmostEqual(speed, command.linear.x, delta=1e-6)
                self.assertAlmostEqual(turn, command.angular.z, delta=1e-6)
                self.assertEqual(number > 0, 'the one that is there follows' in listener.output())
                listener.stop()
                self.ends_with_a_stop(commands)
        debug = self.program('turtle_tf', 'turtle_tf_listener_debug')
        debug.wait_for_output('turtle3')

    def test_frames(self):
        """Those of both packages: turtle1 where its pose is, carrot1 beside it, and carrot1 around it."""
        self.call('turtle1/teleport_absolute', 3.0, 4.0, 1.2)
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        self.addCleanup(listener.unregister)
        for word in ('tf', 'tf2'):
            with self.subTest(word):
                by_argument = self.program(f'turtle_{word}', f'turtle_{word}_broadcaster', 'turtle1')
                self.assert_placed(buffer, 'world', 'turtle1', lambda _: (3.0, 4.0), 1.2)
                carrot = self.program(f'turtle_{word}', f'fixed_{word}_broadcaster.py')
                self.assert_placed(buffer, 'turtle1', 'carrot1', lambda _: (0.0, 2.0))
                carrot.stop()
                carrot = self.program(f'turtle_{word}', f'dynamic_{word}_broadcaster.py')
                self.assert_placed(buffer, 'turtle1', 'carrot1', lambda time: (10.0 * math.sin(math.pi * time),
                                                                               10.0 * math.cos(math.pi * time)))
                carrot.stop()
                by_argument.stop()
                buffer.clear()

    def assert_placed(self, buffer, frame, child, place, yaw=0.0):
        """Wait until tf has a frame at ``place(time)``, (x, y) [m] of a time [s], turned by ``yaw`` [rad]."""
        def found():
            try:
                seen = buffer.lookup_transform(frame, child, rospy.Time())
            except tf2_ros.TransformException:
                return False
            x, y = place(seen.header.stamp.to_sec())
            shift, turn = seen.transform.translation, seen.transform.rotation
            return (math.hypot(shift.x - x, shift.y - y) < 1e-3
                    and abs(math.remainder(2.0 * math.atan2(turn.z, turn.w) - yaw, math.tau)) < 1e-3)
        until(found, f'{child} where it should be in {frame}')

    @nightly
    def test_wrong_parameters_are_named(self):
        """Each of these nodes ends, and names the allowed values, or the line to type."""
        started = [(self.program(package, name, f'__name:=wrong{number}', *arguments), said)
                   for number, (package, name, *arguments, said) in enumerate(WRONG_LESSONS)]
        for process, said in started:
            output = self.ended(process, code=1)
            self.assertIn(said, output)
            self.assertNotIn('Traceback', output)

    def test_points_of_turtle3_as_turtle1_sees_them(self):
        """turtle1 stands in the middle and looks along x: the difference of the positions."""
        for word in ('tf', 'tf2'):
            with self.subTest(word):
                started = [*self.broadcasters(f'turtle_{word}', 'turtle1'),
                           self.program(f'turtle_{word}', f'turtle_{word}_message_broadcaster.py')]
                printer = self.program(f'turtle_{word}', f'turtle_{word}_message_filter')
                found = printer.wait_for_output(r'Position\(x:(\S+) y:(\S+) z:0.000000\)')
                x, y = (float(text) + MIDDLE for text in found.groups())
                # a circle of 1 m from (4, 2), heading 0
                self.assertAlmostEqual(1.0, math.hypot(x - 4.0, y - 3.0), delta=0.05)
                for one in (*started, printer):
                    one.stop()

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

    @nightly
    def test_goals_that_are_cancelled_replaced_or_impossible(self):
        """The turtle stops when its goal is cancelled."""
        self.program('turtle_actionlib', 'shape_server')
        client, poses = self.client('turtle_shape', ShapeAction), self.poses()
        client.send_goal(ShapeGoal(2, 1.0))
        self.assertEqual('edges is 2; it must be 3 or more', self.ended_as(client, Status.ABORTED))
        client.send_goal(ShapeGoal(5, 4.0))
        poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle moving')
        commands = self.commands()
        commands.next(what='a velocity')
        client.cancel_goal()
        self.ended_as(client, Status.PREEMPTED)
        self.ends_with_a_stop(commands)
        client.send_goal(ShapeGoal(5, 4.0))
        until(lambda: client.get_state() == Status.ACTIVE, 'the goal active')
        other = self.client('turtle_shape', ShapeAction)
        other.send_goal(ShapeGoal(4, 0.2))
        self.ended_as(client, Status.PREEMPTED)
        self.ended_as(other, Status.SUCCEEDED)

    @nightly
    def test_turtle_of_a_server_that_is_ended_stops(self):
        server = self.program('turtle_actionlib', 'shape_server')
        client, commands = self.client('turtle_shape', ShapeAction), self.commands()
        client.send_goal(ShapeGoal(5, 4.0))
        commands.next(lambda command: command.linear.x > 0.0, 'the turtle moving')
        server.process.send_signal(signal.SIGINT)
        self.assertNotIn('Traceback', self.ended(server))
        self.ends_with_a_stop(commands)

    def test_server_that_is_ended_while_it_computes(self):
        server = self.program('actionlib_tutorials', 'fibonacci_server.py')
        self.client('fibonacci', FibonacciAction).send_goal(FibonacciGoal(40))
        server.wait_for_output('creating fibonacci sequence of order 40 with seeds 0, 1')
        server.process.send_signal(signal.SIGINT)
        output = self.ended(server)
        self.assertFalse([word for word in ('Traceback', 'Exception') if word in output], output)

    def test_clients(self):
        """Each sends its goal to a server, and says how that has ended."""
        servers = [self.program('actionlib_tutorials', 'fibonacci_server.py'),
                   self.program('actionlib_tutorials', 'averaging_server'),
                   self.program('actionlib_tutorials', 'gen_numbers.py'),
                   self.program('turtle_actionlib', 'shape_server')]
        for name, action in (('fibonacci', FibonacciAction), ('averaging', AveragingAction),
                             ('turtle_shape', ShapeAction)):
            self.client(name, action)  # each server is there
        rospy.set_param('/use_sim_time', False)  # for the clients: their patience must not begin at the time zero
        self.addCleanup(rospy.set_param, '/use_sim_time', True)
        started = [(self.program(package, name), said) for package, name, said in (
            ('actionlib_tutorials', 'averaging_client', 'Action finished: (SUCCEEDED|ABORTED)'),  # the mean is about 5
            ('turtle_actionlib', 'shape_client', 'Action finished: SUCCEEDED'))]
        for name, said in (('fibonacci_client.py', 'Result: 0, 1, 1, 2, 3, .*, 6765\n'),
                           ('fibonacci_client', 'Action result: 0 1 1 2 3 .* 6765\n'),
                           ('fibonacci_callback_client', 'length 21\n(.*\n)*.*Answer: 6765'),
                           ('fibonacci_class_client', r'Finished in state \[SUCCEEDED\]\n.*Answer: 55')):
            client = self.program('actionlib_tutorials', name)
            self.assertRegex(self.ended(client), said)
        for client, said in started:
            self.assertRegex(self.ended(client), said)
        self.assertFalse([server.output() for server in servers if not server.runs()])

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
        client.send_goal(FibonacciGoal(-1))
        self.ended_as(client, Status.SUCCEEDED)
        self.assertEqual((0, 1), client.get_result().sequence)
        self.cancelled_and_replaced('fibonacci', FibonacciAction, FibonacciGoal(40))

    def test_fibonacci_in_c_has_its_name_whatever_the_node_is_called(self):
        self.program('actionlib_tutorials', 'fibonacci_server', '__name:=fibonacci_server')
        client = self.client('fibonacci', FibonacciAction)
        client.send_goal(FibonacciGoal(1))
        self.ended_as(client, Status.SUCCEEDED)
        self.assertEqual((0, 1, 1), client.get_result().sequence)

    @nightly
    def test_averaging(self):
        """One number more than the goal says; a mean below 5 aborts."""
        self.program('actionlib_tutorials', 'averaging_server')
        client = self.client('averaging', AveragingAction)
        publisher, given = rospy.Publisher('random_number', Float32, queue_size=10), []
        for numbers, state, mean, deviation in (((4.0, 7.0, 10.0), Status.SUCCEEDED, 7.0, math.sqrt(6.0)),
                                                ((4.0, 5.0), Status.ABORTED, 4.5, 0.5)):
            client.send_goal(AveragingGoal(len(numbers) - 1), feedback_cb=lambda feedback: given.append(feedback.data))
            until(lambda: client.get_state() == Status.ACTIVE and publisher.get_num_connections(), 'the goal active')
            for number in numbers[:-1]:
                publisher.publish(number)
                until(lambda number=number: number in given[-1:], 'the feedback')
            publisher.publish(numbers[-1])
            self.ended_as(client, state)
            result = client.get_result()
            self.assertAlmostEqual(mean, result.mean, places=5)
            self.assertAlmostEqual(deviation, result.std_dev, places=5)
        early = [number for number in given if number not in (10.0, 5.0)]  # the result may overtake the last feedback
        self.assertEqual([4.0, 7.0, 4.0], early)
        self.cancelled_and_replaced('averaging', AveragingAction, AveragingGoal(100))

    def test_two_numbers_are_added(self):
        client = self.program('rospy_tutorials', 'add_two_ints_client', '3', '4')  # it waits for the service
        server = self.program('rospy_tutorials', 'add_two_ints_server')
        self.assertIn('3 + 4 = 7', self.ended(client))
        self.assertIn(' + ', self.ended(self.program('rospy_tutorials', 'add_two_ints_client')))  # random ones
        server.stop()
        self.assertEqual(0, server.process.returncode)

    def test_talker_and_listener(self):
        self.program('rospy_tutorials', 'talker.py')
        listener = self.program('rospy_tutorials', 'listener.py')
        listener.wait_for_output('I heard hello world [0-9.]+')

    def test_headers_of_connections(self):
        """A client and a publisher have them, the other side prints them."""
        server = self.program('rospy_tutorials', 'server_connection_header.py')
        client = self.program('rospy_tutorials', 'client_connection_header.py', '3', '4')
        self.assertIn('3 + 4 = 7', self.ended(client))
        self.assertIn('Request gave me peanut butter cookies', server.output())
        server.stop()
        self.program('rospy_tutorials', 'talker_connection_header.py')
        listener = self.program('rospy_tutorials', 'listener_connection_header.py')
        listener.wait_for_output('just offered me oreo cookies')

    def test_parameters(self):
        """param_talker.launch sets them; the program publishes one and deletes another."""
        launch = Process('roslaunch', 'rospy_tutorials', 'param_talker.launch')
        self.addCleanup(launch.stop)
        self.assertEqual('Hello World', Collected('/foo/chatter', String).next().data)
        self.assertIn('found global_example parameter under key: /global_example', launch.output())
        self.assertFalse(rospy.has_param('/foo/to_delete'))


if __name__ == '__main__':
    run(TutorialsTest)
