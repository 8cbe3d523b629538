"""Follow a public course text that is not part of the repository, from a new terminal to its last line.

usage: check_seed.py NUMBER FOLDER     0, 1 or 2, see course_texts.py; FOLDER takes what the terminals showed

The functions of SEEDS list what a student does, in the order of the text, as actions of page.py: each command of the
text is typed or left out, which Seed checks; what is typed besides says why. check_page.py does the actions: each
terminal is a ./run shell in a home folder that is empty at first. Exit code 0 when all comes out as the text says.
"""
import os
import re
import sys
from pathlib import Path

import check_page
import page

from rostest_support import course_texts

EDITOR = 'no editor of windows is here: the file is written instead'
TIME = '[1234567890.0]'  # of a log line
INFO = f'[INFO] {TIME}: '
POSE = 'rostopic echo -n 1 /turtle1/pose'
COLOR = 'rostopic echo -n 1 /turtle1/color_sensor'
STOP_AT_10 = '''if turtle_pose_.x < 10:
{indent}    cmd_vel_.linear.x = 1.0
{indent}else:
{indent}    cmd_vel_.linear.x = 0.0
{indent}    rospy.loginfo(f'stopped at {{turtle_pose_.x}}')
'''
SQUARE = '''for x, y in [(8.0, 5.5), (8.0, 8.0), (5.5, 8.0), (5.5, 5.5)]:
{indent}    while math.hypot(x - turtle_pose_.x, y - turtle_pose_.y) > 0.05 and not rospy.is_shutdown():
{indent}        turn = math.atan2(y - turtle_pose_.y, x - turtle_pose_.x) - turtle_pose_.theta
{indent}        cmd_vel_.angular.z = 4.0 * math.remainder(turn, 2.0 * math.pi)
{indent}        cmd_vel_.linear.x = 0.5 if abs(cmd_vel_.angular.z) < 0.4 else 0.0
{indent}        cmd_vel_pub_.publish(cmd_vel_)
{indent}        rate.sleep()
{indent}    rospy.loginfo(f'corner {{x}} {{y}}')
{indent}cmd_vel_pub_.publish(Twist())
{indent}rospy.spin()
'''
GO_TO_FOUR = '''
rospy.init_node('goto_pose')
turtleSetPen(0, 0, 0, 5, 0)
for x, y in [(2.0, 2.0), (8.0, 2.0), (8.0, 8.0), (2.0, 8.0)]:
    turtleGotoPose(x, y, 0.0)
'''


class Seed:
    """A text that is followed: ``actions`` [(folder, action)] so far, and the commands that are still to come."""

    def __init__(self, number):
        self.course = course_texts.text(number)
        self.programs = course_texts.programs(self.course)
        self.actions = []
        self._commands = course_texts.commands(self.course)
        self._below = []

    def _next(self, beginning):
        command, self._below = self._commands.pop(0) if self._commands else ('its end', [])
        if not command.startswith(beginning):
            raise ValueError(f'the text goes on with {command}, not with {beginning}')
        return command

    def _add(self, action):
        self.actions.append((None, action))

    def type(self, terminal, *beginnings):
        """Type the next commands of the text, which begin like this."""
        for beginning in beginnings:
            self._add(page.Command(terminal, self._next(beginning)))

    def leave_out(self, beginning, why):
        """Leave out the next command of the text."""
        print(f'left out: {self._next(beginning)}: {why}')

    def also(self, terminal, *commands):
        """Type what the text says in words, or takes for granted, or what a student does after an error."""
        for command in commands:
            self._add(page.Command(terminal, command))

    def write(self, terminal, name, source):
        """Write a file with an editor, in the folder of the terminal."""
        self._add(page.File(terminal, name, source))

    def press(self, terminal, *keys):
        """Press the keys of these names in a terminal."""
        self._add(page.Keys(terminal, tuple(page.KEYS[key] for key in keys)))

    def stop(self, *terminals):
        """End the programs of terminals."""
        for terminal in terminals:
            self.press(terminal, 'Ctrl+C')

    def see(self, terminal, *lines):
        """Expect lines in a terminal."""
        self._add(page.Output(terminal, lines))

    def look(self, terminal, command, *lines):
        """Type a command that shows what the window of a simulator would, until it prints these lines."""
        self.also(terminal, command)
        self.see(terminal, *lines)

    def printed(self, count):
        """Return this many lines that the text prints below the last command."""
        return self._below[:count]

    def end(self):
        """Raise ValueError if the text has commands that were neither typed nor left out."""
        if self._commands:
            raise ValueError(f'these commands of the text are not typed: {[command for command, _ in self._commands]}')


def publisher_and_subscriber(seed):
    """Text 0. Nothing is left out but its figures."""
    folder = course_texts.folder(seed.course)
    workspace = os.path.dirname(folder)
    seed.also(3, f'mkdir -p {folder}', f'cd {folder}')  # it stands in the prompt
    seed.type(3, 'catkin_create_pkg topic_demo rospy std_msgs geometry_msgs')
    seed.see(3, *course_texts.output(seed.course, 'Created', 'Successfully'))
    seed.also(3, 'mkdir topic_demo/scripts', 'cd topic_demo/scripts')  # said in words
    seed.write(3, 'publisher.py', seed.programs[0])
    seed.type(3, 'chmod +x publisher.py')
    seed.type(1, 'roscore')
    seed.type(2, 'rosrun turtlesim turtlesim_node')
    seed.type(4, 'rosrun topic_demo publisher.py')
    # The text forgets to build the workspace, and to source it
    seed.see(4, "[rospack] Error: package 'topic_demo' not found")
    seed.also(4, f'cd {workspace}', 'catkin_make', 'source devel/setup.bash', 'rosrun topic_demo publisher.py')
    seed.see(4, *4 * [f'{INFO}...[0.50 m/s, 0.20 rad/s]'])
    seed.look(5, POSE, 'linear_velocity: 0.5', 'angular_velocity: 0.2')
    seed.stop(4)
    seed.also(3, 'chmod -x publisher.py')  # the error of somebody who forgot chmod
    seed.type(4, 'rosrun topic_demo publisher.py')
    seed.see(4, *course_texts.output(seed.course, '[rosrun]'))
    seed.also(3, 'chmod +x publisher.py')
    seed.stop(2, 1)

    seed.also(3, 'cd ../src')  # where the text stores the subscriber
    seed.write(3, 'pose_subscriber.py', seed.programs[1])
    seed.also(3, 'chmod +x pose_subscriber.py')  # "same as before"
    seed.type(11, 'roscore')
    seed.type(12, 'rosrun turtlesim turtlesim_node')
    seed.type(13, 'rosrun turtlesim turtle_teleop_key')
    seed.also(14, f'source {workspace}/devel/setup.bash')
    seed.type(14, 'rosrun topic_demo pose_subscriber.py')
    seed.see(14, f'{INFO}Turtle pose: x:5.544445, y:5.544445')
    seed.press(13, '↑')
    seed.see(14, f'{INFO}Turtle pose: x:7.56, y:5.54')
    seed.press(13, '↓')
    seed.see(14, *(f'{INFO}Turtle pose: x:{x}, y:5.54' for x in (7.56, 5.54)))
    seed.press(13, '←')
    seed.look(15, POSE, 'theta: 2.02', 'angular_velocity: 0.0')
    seed.press(13, '→')
    seed.look(15, POSE, 'x: 5.54', 'y: 5.54', 'theta: 0.0', 'angular_velocity: 0.0')
    seed.stop(14)

    seed.also(3, 'mv ../scripts/publisher.py publisher_demo.py')  # into src, with another name
    seed.type(14, 'rosrun topic_demo publisher_demo.py')
    seed.see(14, *4 * [f'{INFO}...[0.50 m/s, 0.20 rad/s]'])
    seed.look(15, POSE, 'linear_velocity: 0.5', 'angular_velocity: 0.2')


def logistics(seed):
    """Text 1. Screenshots are left out: what they would show is looked at with rostopic."""
    pub, service = seed.programs
    seed.type(3, 'mkdir -p', 'cd', 'catkin_create_pkg turtle_training roscpp rospy std_msgs', 'cd', 'catkin_make',
              'source', 'echo', 'source ~/.bashrc')
    seed.type(3, 'roscd', 'mkdir scripts', 'cd scripts', 'touch pub.py', 'chmod +x pub.py')
    seed.leave_out('code pub.py', EDITOR)
    seed.write(3, 'pub.py', pub)
    seed.type(3, 'rosrun turtle_training pub.py')
    seed.see(3, f'[WARN] {TIME}: There is no ROS master at ... Waiting for it: type roscore in another terminal.')
    seed.also(1, 'roscore')  # an earlier chapter explains both
    seed.also(2, 'rosrun turtlesim turtlesim_node')
    seed.see(3, *(f'{INFO}x: {x} y: 5.544' for x in (5.544, 8.0, 11.09)))  # to the wall, in an old terminal
    seed.stop(3)

    # Challenge 1. 62 lines of log a second are too many for a loaded machine: the turtle would be seen too late
    quiet = re.sub(r' *rospy\.loginfo\(f.*\n', '', pub)
    seed.write(3, 'pub.py', _instead_of(quiet, 'cmd_vel_.linear.x = 1.0', STOP_AT_10))
    seed.also(4, 'rosservice call /reset', 'rosrun turtle_training pub.py')  # a new terminal knows the package
    seed.see(4, f'{INFO}stopped at 10.0')
    seed.look(5, POSE, 'x: 10.0', 'y: 5.544', 'theta: 0.0', 'linear_velocity: 0.0')
    seed.stop(4)

    square = _instead_of(quiet, 'while not rospy.is_shutdown():', SQUARE)
    square = square.replace('import rospy\n', 'import math\nimport rospy\n', 1)
    seed.also(3, 'cp pub.py square.py')  # special challenge
    seed.write(3, 'square.py', square)
    seed.also(4, 'rosservice call /reset', 'rosrun turtle_training square.py')
    seed.see(4, *(f'{INFO}corner {x} {y}' for x, y in ((8.0, 5.5), (8.0, 8.0), (5.5, 8.0), (5.5, 5.5))))
    seed.look(5, POSE, 'x: 5.5', 'y: 5.5', 'linear_velocity: 0.0')
    seed.stop(4, 2, 1)

    seed.type(11, 'roscore')
    seed.type(12, 'rosrun turtlesim turtlesim_node')
    seed.type(13, 'rosservice list')
    seed.see(13, '/clear', '/kill', '/reset', '/spawn', '/turtle1/set_pen', '/turtle1/teleport_absolute',
             '/turtle1/teleport_relative', '/turtlesim/get_loggers', '/turtlesim/set_logger_level')
    seed.type(13, 'rosservice type /clear')
    seed.see(13, *seed.printed(1))
    seed.type(13, 'rosservice call /clear')
    seed.see(12, f'{INFO}Clearing turtlesim.')
    seed.type(13, 'rosservice type /spawn | rossrv show')
    seed.see(13, *seed.printed(6))
    seed.type(13, 'rosservice call /spawn')
    seed.see(13, *seed.printed(1))
    seed.look(13, 'rostopic echo -n 1 /LLCROS/pose', 'x: 3.0', 'y: 3.0', 'theta: 1.57')

    seed.type(14, 'roscd turtle_training/scripts', 'touch service.py', 'chmod +x service.py')
    seed.leave_out('code service.py', EDITOR)
    seed.write(14, 'service.py', service)
    seed.type(11, 'roscore')  # they run already
    seed.type(12, 'rosrun turtlesim turtlesim_node')
    seed.type(15, 'rosrun turtle_training service.py')
    seed.see(15, f'{INFO}... gotoPose ...')
    # As printed, the program ends here, with any turtlesim, so that nobody answers the call: it needs rospy.spin()
    seed.type(13, 'rosservice call /turtle1/gotoPose 1.5 2.5 3.14')
    seed.see(13, 'ERROR: Service [/turtle1/gotoPose] is not available.')
    seed.write(14, 'service.py', course_texts.with_spin(service))
    seed.also(15, 'rosrun turtle_training service.py')
    seed.see(15, f'{INFO}... gotoPose ...')
    seed.also(13, 'rosservice call /turtle1/gotoPose 1.5 2.5 3.14')
    seed.see(15, f'{INFO}... x: 1.5 y: 2.5 theta: 3.14')
    seed.type(16, 'rosrun turtlesim turtle_teleop_key')
    seed.press(16, '↑')
    seed.look(17, POSE, 'x: 7.56', 'y: 5.54')
    seed.look(17, COLOR, 'r: 0', 'g: 0', 'b: 255')

    seed.look(13, 'rosservice type /turtle1/teleport_absolute', 'turtlesim/TeleportAbsolute')  # challenge 1
    for x, y in (2.0, 2.0), (6.0, 2.0), (6.0, 6.0), (2.0, 6.0), (2.0, 2.0):
        seed.also(13, f'rosservice call /turtle1/teleport_absolute {x} {y} 0.0')
        seed.look(17, POSE, f'x: {x}', f'y: {y}')

    functions = service[:service.index('def main')] + course_texts.function(seed.course, 'turtleGotoPose')
    seed.also(14, 'cp service.py goto_pose.py')  # special challenge
    seed.write(14, 'goto_pose.py', functions + GO_TO_FOUR)
    seed.also(13, 'rosrun turtle_training goto_pose.py')
    seed.see(13, *(f'{INFO}Goto => x: {x} y: {y} theta: 0.0'
                   for x, y in ((2.0, 2.0), (8.0, 2.0), (8.0, 8.0), (2.0, 8.0))))
    seed.look(17, POSE, 'x: 2.0', 'y: 8.0')
    seed.look(17, COLOR, 'r: 0', 'g: 0', 'b: 0')


def _instead_of(source, beginning, lines):
    """Return a program with lines in place of that which begins so, and of its block."""
    before, found, after = source.partition(beginning)
    if not found:
        raise ValueError(f'the program has no line {beginning}')
    indent = before.rpartition('\n')[2]
    rest = after.splitlines(keepends=True)[1:]
    while rest and rest[0].startswith(indent + ' '):
        rest.pop(0)
    return before + lines.format(indent=indent) + ''.join(rest)


def robotont(seed):
    """Text 2. Left out: the videos, a real Robotont and its network, a webcam, and what is shown to an instructor.

    The text takes a package of an earlier section for granted, with a node and a launch file that starts camera and
    tracker. A circle is driven in the simulation.
    """
    node = course_texts.ar_control_node
    forward = [f'{INFO}linear:', '  x: 0.2', '  y: 0.0', '  z: 0.0', 'angular:', '  x: 0.0', '  y: 0.0', '  z: 0.0']
    seed.also(3, 'mkdir -p ~/catkin_ws/src', 'cd ~/catkin_ws/src',
              'catkin_create_pkg ar_control_robotont rospy geometry_msgs ar_track_alvar_msgs',
              'cd ~/catkin_ws', 'catkin_make', 'echo "source ~/catkin_ws/devel/setup.bash" >> ~/.bashrc',
              'source ~/.bashrc', 'roscd ar_control_robotont', 'mkdir scripts launch',
              'touch scripts/ar_control_node.py', 'chmod +x scripts/ar_control_node.py')
    seed.write(3, 'launch/ar_control.launch',
               '<launch>\n  <include file="$(find turtle_robotont)/launch/camera_ar_track.launch"/>\n</launch>\n')
    seed.write(3, 'scripts/ar_control_node.py', node(markers=False))
    seed.type(1, 'roscore')
    seed.type(4, 'rosrun ar_control_robotont ar_control_node.py')
    seed.see(4, *2 * forward)
    seed.type(5, 'rostopic echo /cmd_vel')
    seed.see(5, *2 * ['linear:', *forward[1:]])
    seed.look(6, 'rostopic hz /cmd_vel', 'average rate: 1.0')
    seed.stop(6, 4)

    seed.type(2, 'roslaunch robotont_gazebo world_minimaze.launch')
    seed.also(6, 'rostopic echo /odom/pose/pose/position/x')
    seed.see(6, '-2.0')
    seed.also(4, 'rosrun ar_control_robotont ar_control_node.py')
    seed.see(6, '-2.0', '-1.8', '-1.6')
    seed.stop(6, 4)
    seed.write(3, 'scripts/ar_control_node.py', node(markers=False, turn=0.5))
    seed.also(6, "rosservice call /robotont_gazebo/set_pose '{x: -2.0, y: 0.0, yaw: 0.0}'",
              'rostopic echo /odom/pose/pose/orientation/z')
    seed.also(4, 'rosrun ar_control_robotont ar_control_node.py')
    seed.see(5, 'angular:', '  x: 0.0', '  y: 0.0', '  z: 0.5')
    seed.see(6, '0.0', '0.5', '1.0', '-0.5', '0.0')  # a circle: the sine of half of its direction
    seed.stop(6, 5, 4, 2)

    seed.type(2, 'roslaunch ar_control_robotont ar_control.launch')
    seed.write(3, 'scripts/ar_control_node.py', node())
    seed.also(4, 'rosrun ar_control_robotont ar_control_node.py')
    for marker in range(1, 6):
        seed.see(4, f'{INFO}Detected marker with ID {marker}')
    seed.type(7, 'rostopic echo /ar_pose_marker')
    seed.see(7, 'markers:', '    id: 3', '          x: 0.22', '          y: -0.13', '          z: 0.7')
    seed.stop(4)
    seed.write(3, 'scripts/ar_control_node.py', node(print_x=True))
    seed.also(4, 'rosrun ar_control_robotont ar_control_node.py')
    seed.see(4, f'{INFO}x of marker 3: 0.22 m')
    seed.stop(2)
    seed.also(8, "rostopic pub -1 /ar_pose_marker ar_track_alvar_msgs/AlvarMarkers '{}'")  # an image without markers
    seed.see(4, f'{INFO}No AR markers detected.')


SEEDS = publisher_and_subscriber, logistics, robotont


def main(arguments):
    """Follow a text; return the exit code."""
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    check_page.enter_own_network()
    number, folder = int(arguments[0]), Path(arguments[1])
    folder.mkdir(parents=True, exist_ok=True)
    seed = Seed(number)
    SEEDS[number](seed)
    seed.end()
    wrong = check_page.act(seed.actions, [], os.environ['ws'], folder)
    for text in wrong:
        print(f'WRONG: {text}')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
