"""course_grader.rules.suspicions: what may be a mistake where a vehicle does not move as it should."""
import math

import pytest

from course_grader.rules import source_mistakes, suspicions
from course_grader.rules.observation import Command, Observed, Sample
from unit_support import REPOSITORY
from unit_support.course_files import programs

PUBLISHER = 'pub = rospy.Publisher("/cmd_vel", Twist)\n'
LOOP = 'while not rospy.is_shutdown():\n    rate.sleep()\n'


def found(text, positions=True):
    """Return the advice on a program."""
    program = source_mistakes.program(text)
    return [*suspicions.found(program, positions), *(suspicions.unwrapped(program, Observed()) if positions else ())]


@pytest.mark.parametrize('wrong, right, advice', [
    ('twist.linear.x += 0.1\n', 'twist.linear.x = v + 0.1\n', 'so that it grows'),
    ('place = (pose.x, pose.x, 0)\n', 'place = (pose.x, pose.y, 0)\n', 'uses pose.x twice, and pose.y not at all'),
    ('dx, dy = x - pose.x, y - pose.x\n', 'dx, dy = x - pose.x, y - pose.y\n', 'uses pose.x twice'),
    ('speed = 1 // 2\n', 'speed = 1 / 2\nahead = ranges[len(ranges) // 2]\nmiddle = len(ranges) // 2\n',
     'a whole number'),
    ('twist.angular.z = math.degrees(math.atan2(y, x))\n', "print('%.1f' % math.degrees(yaw))\n"
     "rospy.loginfo(f'{math.degrees(yaw)}')\nturned = math.degrees(yaw)\nwhile turned < 90:\n    rate.sleep()\n",
     'line 1 makes degrees'),
    ('d = math.degrees(yaw)\nq = quaternion_from_euler(0, 0, d)\n', 'd = math.degrees(yaw)\nprint(d)\n',
     'line 1 makes degrees'),
    ('a = math.atan2(dx, dy)\n', 'a = math.atan2(dy, dx)\n', 'takes y first'),
    ('a = atan2(goal.x - pose.x, goal.y - pose.y)\n', 'a = atan2(goal.y - pose.y, goal.x - pose.x)\n', 'takes y first'),
    ('a = np.arctan2(goal_x - x, y_error)\n', 'a = np.arctan2(p.x, p.z)\na = atan2(sin(x), cos(y))\n'
     'a = math.atan2(x * x + y, y)\n', 'takes y first'),
    ('yaw = odom.pose.pose.orientation.z\n', 'q = odom.pose.pose.orientation\nyaw = 2 * math.atan2(q.z, q.w)\n',
     'part of a quaternion'),
    ('yaw = orientation.w\n', 'yaw = 2 * math.asin(msg.pose.pose.orientation.z)\n', 'part of a quaternion'),
    ('goal = pose.theta + math.pi / 2\n' + LOOP, 'goal = (pose.theta + math.pi) % (2 * math.pi)\n', 'from pi to -pi'),
    ('turn = self.yaw - wanted\n', 'turn = self.yaw - wanted\nif turn > math.pi:\n    turn -= 6.28\n',
     'from pi to -pi'),
    ('turn = goal_angle - now\n', 'd = goal_angle - now\nd = math.atan2(math.sin(d), math.cos(d))\n', 'from pi to -pi'),
    ("at = rospy.wait_for_message('/turtle1/pose', Pose)\nwhile True:\n    go(at.x)\n    rate.sleep()\n",
     "while True:\n    at = rospy.wait_for_message('/turtle1/pose', Pose)\n    go(at.x)\n    rate.sleep()\n",
     'at in line 1 is read only once'),
    ("start = rospy.wait_for_message('/odom', Odometry)\nwhile far(start):\n    rate.sleep()\n",
     "start = rospy.wait_for_message('/odom', Odometry)\nrospy.Subscriber('/odom', Odometry, seen)\n"
     'while far(start):\n    rate.sleep()\n', 'read only once'),
    ("bag.write('/turtle1/pose', pose)\nfor m in bag.read_messages(topics=['/turtle1/cmd_vel']):\n    pass\n",
     "bag.write('/turtle1/pose', pose)\nfor m in bag.read_messages(topics=['/turtle1/pose']):\n    pass\n"
     "file.write('x')\n", 'the topic /turtle1/cmd_vel is read from the bag, but /turtle1/pose'),
    ("def show(p):\n    rospy.sleep(1)\nrospy.Subscriber('/odom', Odometry, show)\n",
     "def show(p):\n    rospy.sleep(0.01)\nrospy.Subscriber('/odom', Odometry, show)\ndef go():\n    rospy.sleep(1)\n",
     'the callback show sleeps in line 2'),
    ("def show(p):\n    rate.sleep()\nrospy.Subscriber('/odom', Odometry, callback=show)\n",
     "def show(p):\n    pass\nrospy.Subscriber('/odom', Odometry, callback=show)\nrate.sleep()\n", 'sleeps in line 2'),
    ('while True:\n    pub.publish(twist)\n', 'while True:\n    pub.publish(twist)\n    rate.sleep()\n',
     'without a pause'),
    ('for pose in poses:\n    pub.publish(twist)\n', 'for pose in poses:\n    pub.publish(twist)\n    rate.sleep()\n',
     'without a pause'),
    ('for pose in poses:\n    pub.publish(twist)\n', "def show(message):\n    for one in message.markers:\n"
     "        pub.publish(twist)\nrospy.Subscriber('/m', M, show)\n", 'without a pause'),
    (f'{PUBLISHER}pub.publish(Twist())\nrospy.spin()\n', f'{PUBLISHER}rospy.sleep(1)\npub.publish(Twist())\n',
     'line 2 publishes as soon as the publisher is made'),
    (f'{PUBLISHER}for side in range(4):\n    pub.publish(side)\n    rospy.sleep(2)\n',
     f'{PUBLISHER}for step in range(40):\n    pub.publish(step)\n    rospy.sleep(0.1)\n', 'nobody is connected'),
    (f'{PUBLISHER}pub.publish(1)\n', f'{PUBLISHER}connect(pub)\npub.publish(1)\ndef connect(pub):\n    pass\n',
     'nobody is connected'),
    (f'{PUBLISHER}pub.publish(1)\n', f'{PUBLISHER}def show(pose):\n    pub.publish(1)\n', 'nobody is connected'),
    ('buffer.lookup_transform("a", "b", rospy.Time.now())\n',
     'buffer.lookup_transform("a", "b", rospy.Time.now(), rospy.Duration(1))\n', 'for this very moment'),
    ('now = rospy.Time.now()\nlistener.lookupTransform("a", "b", now)\n',
     'now = rospy.Time.now()\nlistener.waitForTransform("a", "b", now, rospy.Duration(1))\n'
     'listener.lookupTransform("a", "b", now)\n', 'rospy.Time(0) asks for the latest one'),
    ('rospy.Publisher("/turtle2/cmd_vel", Twist)\nbuffer.lookup_transform("turtle1", "turtle2", rospy.Time())\n',
     'rospy.Publisher("/turtle2/cmd_vel", Twist)\nbuffer.lookup_transform("turtle2", "turtle1", rospy.Time())\n',
     "comes first, 'turtle2', and then 'turtle1'"),
    ('t.linear.x = pose.angular_velocity\n', 't.linear.x = pose.linear_velocity\nt.angular.z = pose.angular_velocity\n',
     'line 1 sets linear.x to angular_velocity'),
    ('goal.pose.orientation.z = 1.57\n', 'goal.pose.orientation.z = 0.7071\n', 'is a part of a quaternion'),
    ('t.transform.rotation.z = pose.theta\n', 't.transform.rotation.z = math.sin(pose.theta / 2)\n',
     't.transform.rotation.z in line 1 is a part'),
    ('go = rospy.ServiceProxy("/a", TeleportAbsolute)\ngo(theta, x, y)\n',
     'go = rospy.ServiceProxy("/a", TeleportAbsolute)\ngo(x, y, theta)\ngo(2, 3, a)\n', 'in this order: x, y, theta'),
    ('import turtlesim.msg\na = math.atan2(dy, dx)\n', 'import turtlesim.msg\na = math.atan2(dy, dx)\nb = pose.theta\n',
     'subtract its own heading')])
def test_suspicions(wrong, right, advice):
    assert advice in '\n'.join(found(wrong))
    assert found(right) == []


def test_headings_and_comparisons_count_only_where_positions_do():
    assert found('goal = pose.theta + 1.57\nif x == 10:\n    pass\n', positions=False) == []


def test_programs_of_the_course_are_not_suspected():
    tutorials = REPOSITORY / 'packages' / 'tutorials'
    paths = [*(REPOSITORY / 'scripts').glob('*.py'), *tutorials.glob('turtle_tf*/scripts/*.py'),
             *(tutorials / 'rospy_tutorials').rglob('*.py')]
    programs = [(path, source_mistakes.program(path.read_text(encoding='utf-8'))) for path in paths]
    searched = [(path, program) for path, program in programs if program]  # others are too long
    assert len(searched) > 20
    for path, program in searched:
        assert [*source_mistakes.found(program), *suspicions.found(program, True)] == [], path


@pytest.mark.parametrize('path', [path for path in programs('right', '*.py') if path.stem != 'right_busy_loop'],
                         ids=lambda path: f'{path.parent.name}_{path.stem}')
def test_right_programs_are_not_suspected(path):
    assert found(path.read_text(encoding='utf-8')) == []


@pytest.mark.parametrize('text, advice', [
    ("if pose.x == 10:\n    pass\n", True), ("while x != goal.x:\n    pass\n", True),
    ("if pose.x >= 10:\n    pass\n", False), ("if pose is None or x == None:\n    pass\n", False),
    ("if name == 'x':\n    pass\n", False), ("if pose.x != last.x:\n    print(pose)\nlast = pose\n", False),
    ("if pose.x != goal.x:\n    pass\nlast = pose\n", True)])
def test_exact_comparisons(text, advice):
    assert bool(suspicions.compares_exactly(source_mistakes.program(text))) == advice


@pytest.mark.parametrize('text, advice', [
    ("twist.angular.z = 90\n", True), ("turn(pub, 120.0)\n", True), ("robot.corner(90)\n", True),
    ("turn(math.radians(90))\n", False),
    ("turn(90 * math.pi / 180)\n", False), ("for i in range(90):\n    pass\n", False), ("rospy.sleep(30)\n", False),
    ("goals = [(-2, 2, 0), (0, 2, -90)]\nq = quaternion_from_euler(0, 0, 0)\n", True),
    ("while steps < 90:\n    returned = 45\n", False), ("twist.angular.z = 0.9\n", False)])
def test_degrees(text, advice):
    assert bool(suspicions.degrees(source_mistakes.program(text))) == advice


def observed(velocities, seconds=1.0, **seen):
    """Return an Observed with these velocities at equal distances."""
    return Observed(commands=[Command(seconds * number / len(velocities), velocity, 0.0, 0.0)
                              for number, velocity in enumerate(velocities)], seconds=seconds, **seen)


SPINNING, TURNING = ([Sample(0.1 * number, 1.0, 1.0, math.remainder(0.1 * number, math.tau)) for number in range(count)]
                     for count in (200, 60))


@pytest.mark.parametrize('text, agrees, speaks_against_it', [
    ('go(0.0, 0.5, 120 / 0.5)\n', observed([], track=SPINNING), observed([], track=TURNING)),
    ('twist.linear.x += 0.1\n', observed([0.1, 0.2, 0.3]), observed([0.2, 0.2, 0.0])),
    ('while True:\n    pub.publish(twist)\n', observed([0.1] * 1000), observed([0.1] * 10)),
    (f'{PUBLISHER}pub.publish(1)\n', observed([]), observed([1.0])),
    ("def show(p):\n    rospy.sleep(1)\nrospy.Subscriber('/odom', Odometry, show)\n",
     observed([1.0] * 10, seconds=10.0), observed([1.0] * 100, seconds=10.0)),
    ('goal = pose.theta + 1.0\n', observed([], track=[Sample(0.0, 1.0, 1.0, 3.1)]),
     observed([], track=[Sample(0.0, 1.0, 1.0, 1.0)]))])
def test_a_suspicion_counts_only_if_what_was_observed_agrees(text, agrees, speaks_against_it):
    program = source_mistakes.program(text)

    def suspected(seen):
        return [*suspicions.found(program, True, seen), *suspicions.unwrapped(program, seen)]
    assert len(suspected(agrees)) == 1
    assert suspected(speaks_against_it) == []
