#!/usr/bin/env python3
"""The course's own programs and commands, as its texts print them, against the simulator."""
import os
import subprocess

import rospy

from rostest_support import course_texts
from rostest_support.common import DEADLINE, MIDDLE, Process, SimulatorCase, run, skip, until

BLUE = 0, 0, 255
LOGGED = 2e-6  # [m] error of a position that is printed with six decimals
STAY = 'import runpy, rospy, sys; runpy.run_path(sys.argv[1], run_name="__main__"); rospy.spin()'


class CourseTest(SimulatorCase):

    def package(self, name, **programs):
        """Make a package as the course does, with programs in scripts/; return the environment that knows it."""
        workspace = self.temporary_directory()
        subprocess.run(['catkin_create_pkg', name, 'rospy', 'std_msgs', 'geometry_msgs'], cwd=workspace, check=True,
                       stdout=subprocess.DEVNULL, timeout=DEADLINE)
        scripts = os.path.join(workspace, name, 'scripts')
        os.mkdir(scripts)
        for program, source in programs.items():
            path = os.path.join(scripts, f'{program}.py')
            with open(path, 'w', encoding='utf-8') as file:
                file.write(source)
            os.chmod(path, 0o755)
        return {'ROS_PACKAGE_PATH': f'{workspace}:{os.environ["ROS_PACKAGE_PATH"]}'}, scripts

    def start(self, *command, **environment):
        process = Process(*command, **environment)
        self.addCleanup(process.stop)
        return process

    def shell(self, command):
        """Type a command into bash; return its output."""
        done = subprocess.run(['bash', '-o', 'pipefail', '-c', command], stdout=subprocess.PIPE, timeout=2.0 * DEADLINE)
        self.assertEqual(0, done.returncode, command)
        return done.stdout.decode()

    def test_course_publisher(self):
        """rosrun topic_demo publisher.py: on and on at 0.5 m/s and 0.2 rad/s, ten times a second."""
        environment, _ = self.package('topic_demo', publisher=course_texts.programs(course_texts.text(0))[0])
        poses = self.poses()
        program = self.start('rosrun', 'topic_demo', 'publisher.py', **environment)
        first = poses.index(lambda pose: pose.linear_velocity == 0.5, 'a turtle that moves', deadline=2.0 * DEADLINE)
        driving = poses.some(first, 100)  # 1.6 s: longer than one command lasts
        self.assertEqual({(0.5, 0.2)}, {(pose.linear_velocity, round(pose.angular_velocity, 6)) for pose in driving})
        program.wait_for_output(r'(?s)(\[0\.50 m/s, 0\.20 rad/s\].*){10}')
        self.assertTrue(program.runs())

    def test_course_pose_subscriber(self):
        """rosrun topic_demo pose_subscriber.py: prints where the turtle is."""
        environment, _ = self.package('topic_demo', pose_subscriber=course_texts.programs(course_texts.text(0))[1])
        program = self.start('rosrun', 'topic_demo', 'pose_subscriber.py', **environment)
        program.wait_for_output(r'x:5\.54444[45], y:5\.54444[45]', 2.0 * DEADLINE)
        self.jump(2.0, 3.25)
        program.wait_for_output(r'x:2\.000000, y:3\.250000')

    def test_course_pub(self):
        """rosrun turtle_training pub.py: drives at 1 m/s and prints the positions that it hears of."""
        environment, _ = self.package('turtle_training', pub=course_texts.programs(course_texts.text(1))[0])
        poses = self.poses()
        program = self.start('rosrun', 'turtle_training', 'pub.py', **environment)
        poses.next(lambda pose: pose.x > MIDDLE + 1.5, 'a turtle that drove for longer than a second', 2.0 * DEADLINE)
        self.assertTrue({pose.linear_velocity for pose in poses.messages} <= {0.0, 1.0})
        printed = float(program.wait_for_output(r'x: (7\.\d+) y: 5\.54444')[1])
        self.assertTrue(any(abs(pose.x - printed) < LOGGED for pose in poses.messages))

    def test_course_service(self):
        """service.py: sets a blue pen, and answers rosservice call gotoPose with the numbers in its log.

        As printed, the program ends without waiting for calls, here as with any turtlesim; so it is kept running.
        """
        source = course_texts.programs(course_texts.text(1))[1]
        environment, scripts = self.package('turtle_training', service=source)
        program = self.start('python3', '-u', '-c', STAY, os.path.join(scripts, 'service.py'), **environment)
        rospy.wait_for_service('/turtle1/gotoPose', 2.0 * DEADLINE)
        self.call_goto_pose(program)
        before = self.pose()
        self.driver()(x=0.5)
        until(lambda: self.color() == BLUE, 'a blue path')
        self.assertEqual(before.y, self.pose().y)

    def call_goto_pose(self, program):
        command, = [command for command, _ in course_texts.commands(course_texts.text(1), 'rosservice')
                    if 'gotoPose' in command]
        x, y, theta = command.split()[-3:]
        self.shell(command)
        program.wait_for_output(f'x: {x}.* y: {y}.* theta: {theta}')

    def test_course_service_as_printed(self):
        """rosrun turtle_training service.py, exactly as printed: the pen is blue and the program ends well."""
        environment, _ = self.package('turtle_training', service=course_texts.programs(course_texts.text(1))[1])
        program = self.start('rosrun', 'turtle_training', 'service.py', **environment)
        self.assertEqual(0, program.process.wait(2.0 * DEADLINE), program.output())
        self.call('turtle1/teleport_absolute', 2.0, 2.0, 0.0)
        self.assertEqual(BLUE, self.color())

    def test_course_commands(self):
        """The course's rosservice commands that need only the simulator print the lines of the course."""
        commands = [entry for entry in course_texts.commands(course_texts.text(1), 'rosservice')
                    if 'gotoPose' not in entry[0]]
        self.assertEqual(5, len(commands))
        for command, below in commands:
            printed = self.shell(command).strip().splitlines()
            if command.endswith('list'):
                self.assertLessEqual({'/clear', '/kill', '/reset', '/spawn', '/turtle1/set_pen'}, set(printed))
            else:
                self.assertEqual(below[:len(printed)], printed, command)
        self.assert_pose(self.pose('LLCROS'), 3.0, 3.0, 1.57)


if __name__ == '__main__':
    if course_texts.FOLDER.is_dir():
        run(CourseTest)
    else:
        skip(course_texts.MISSING)
