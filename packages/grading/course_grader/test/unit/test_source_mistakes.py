"""course_grader.rules.source_mistakes: what stands in a program's source, whatever it did."""
import pytest

from course_grader.rules import source_mistakes
from unit_support.course_files import programs

HEAD = '''import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose
from turtlesim.srv import SetPen, TeleportAbsolute, TeleportAbsoluteResponse
rospy.init_node('a')
'''


def found(text):
    """Return all advice on a program."""
    return source_mistakes.found(source_mistakes.program(HEAD + text))


@pytest.mark.parametrize('text, advice', [
    ("if __name__ == 'main':\n    rospy.spin()\n", "if __name__ == '__main__':"),
    ("pub = rospy.Publisher('/turtle1/cmd_vel', Twist)\npub.publish\n", 'parentheses call it, as in pub.publish()'),
    ("rospy.spin\n", 'only names rospy.spin'),
    ("while not rospy.is_shutdown:\n    rospy.sleep(1)\n", 'only names is_shutdown'),
    ("def main():\n    rospy.spin()\nmain\n", 'only names main'),
    ("def show(pose):\n    print(pose)\nrospy.Subscriber('/turtle1/pose', Pose, show())\n", '`show`, not `show()`'),
    ("def tick():\n    pass\nrospy.Timer(rospy.Duration(1), tick())\n", '`tick`, not `tick()`'),
    ("rospy.Subscriber('/turtle1/pose', Pose)\n", 'has no callback'),
    ("def go(q):\n    return TeleportAbsoluteResponse()\nrospy.ServiceProxy('/a', TeleportAbsolute, go)\n",
     'rospy.Service(NAME, TYPE, function)'),
    ("def main():\n    rospy.Subscriber('/turtle1/pose', Pose, print)\n", 'nothing calls main'),
    ("class A:\n    def __init__(self):\n        pass\n    def run(self):\n        rospy.spin()\nA()\n",
     'nothing calls run'),
    ("class A:\n    def __init__(self):\n        rospy.spin()\n", 'nothing uses the class A'),
    ("def show():\n    print(Pose.x)\nshow()\n", '`message = Pose()`'),
    ("def go(q):\n    return TeleportAbsoluteResponse\ngo(1)\n", '`return TeleportAbsoluteResponse()`'),
    ("def go(q):\n    print(q)\nrospy.Service('/a', TeleportAbsolute, go)\n", 'must return a response'),
    ("while not rospy.is_shutdown():\n    rospy.sleep(1)\npub.publish(1)\n", 'stands after the loop in line 6'),
    ("euler_from_quaternion([q.w, q.x, q.y, q.z])\n", 'in the order x, y, z, w'),
    ("def talk():\n    while not rospy.is_shutdown():\n        pub.publish(1)\ndef serve():\n    "
     "rospy.Service('/a', SetPen, print)\ntalk()\nserve()\n", 'talk() in line 11 returns only when the program ends'),
    ("while not rospy.is_shutdown():\n    pub.publish(1)\nrospy.Service('/a', SetPen, print)\n",
     'the loop in line 6 returns only when the program ends'),
    ("pub = rospy.Publisher('/turtle1/cmd_vel', Twist)\ndef store(pose):\n    global x\n    x = pose.x\n"
     "while not rospy.is_shutdown():\n    pub.publish(x)\n", 'nothing calls store'),
    ("for name in ('a', 'b'):\n    rospy.Subscriber(name, Pose, lambda pose: show(name, pose))\n",
     'the lambda in line 7 looks at name when it is called, and finds its last value'),
    ("rospy.spin()\nrospy.Publisher('/turtle1/cmd_vel', Twist).publish(Twist())\n", 'comes too late'),
    ("pub = rospy.Publisher('/turtle1/cmd_vel', Twist)\n", 'publish(message)'),
    ("pen = rospy.ServiceProxy('/turtle1/set_pen', SetPen)\npen.wait_for_service()\n", 'never called'),
    ("x = 0\ndef show(pose):\n    x = pose.x\nprint(x)\n", '`global x`'),
    ("while rospy.is_shutdown():\n    rate.sleep()\n", 'line 6 never runs: it has to be `while not rospy'),
    ("while not rospy.is_shutdown():\n    p.publish(1)\n    rospy.spin()\n", 'so that the loop does not go on'),
    ("def go(m):\n    rospy.spin()\nrospy.Subscriber('a', Twist, go)\n", 'so that go does not go on'),
    ("def far(x):\n    x + 1\nd = far(2)\n", 'far is used as a value in line 8, but returns none'),
    ("def far(x):\n    print(x)\nwhile far(2) > 1:\n    pass\n", 'far is used as a value in line 8'),
    ("x = None\ndef show(pose):\n    x = pose.x\n    print(x)\nrospy.Subscriber('a', Pose, show)\nprint(x)\n",
     '`global x`'),
    ("def go():\n    x = 0\n    def show(pose):\n        x = pose.x\n    rospy.Subscriber('a', Pose, show)\n"
     '    print(x)\ngo()\n', '`nonlocal x`'),
    ("def go(q):\n    print(q)\n    return\nrospy.Service('/a', Trigger, go)\n", '`return TriggerResponse()`'),
    ("class A:\n    def show(self, pose):\n        x = pose.x\n    def x_of(self):\n        return self.x\nA()\n",
     'self.x = ...'),
    ("class A:\n    def show(message):\n        print(message)\nA().show()\n", 'def show(self, message)'),
    ("clear = rospy.ServiceProxy('/clear', Empty)\nclear\n", 'only names clear: parentheses call it, as in clear()'),
    ("def go(q):\n    print(q)\nrospy.Service('/a', Trigger, go)\n", '`return TriggerResponse()`'),
    ("def go(q):\n    print(q)\nrospy.Service('/a', Trigger, handler=go)\n", '`return TriggerResponse()`'),
    ("s = SimpleActionServer('a', FibonacciAction, go, False)\nrospy.spin()\n", 'call its start()'),
    ("s = SimpleActionServer('a', FibonacciAction, execute_cb=go, auto_start=False)\n", 'call its start()'),
    ("if x >= 6:\n    pass\nelif x >= 8:\n    pass\n", 'line 8 never holds, because that in line 6'),
    ("if p.x < 10:\n    pass\nelif y < 3:\n    pass\nelif p.x < 8:\n    pass\n", 'line 10 never holds'),
    ("rospy.Subscriber('/turtle1/pose', Twist, print)\n", '/turtle1/pose has the type Pose'),
    ("from geometry_msgs.msg import Pose\nrospy.Subscriber('turtle1/pose', Pose, print)\n",
     'from turtlesim.msg import Pose'),
    ("pen = rospy.ServiceProxy('/turtle1/set_pen', TeleportAbsolute)\npen(1)\n",
     '/turtle1/set_pen has the type SetPen'),
])
def test_mistakes(text, advice):
    assert advice in '\n'.join(found(text))


@pytest.mark.parametrize('text', [
    "if x >= 8:\n    pass\nelif x >= 6:\n    pass\n", "if x < 6:\n    pass\nelif x > 8:\n    pass\n",
    "if x >= 6:\n    pass\nelif y >= 8:\n    pass\n", "if x >= 6:\n    pass\nif x >= 8:\n    pass\n",
    "if read() > 6:\n    pass\nelif read() > 8:\n    pass\n", "if x > a:\n    pass\nelif x > b:\n    pass\n",
    "x = 2.0\ndef show(pose):\n    x = pose.x\n    print(x)\nrospy.Subscriber('a', Pose, show)\nprint(x)\n",
    "while not rospy.is_shutdown():\n    rate.sleep()\nrospy.spin()\n",
    "while not rospy.is_shutdown():\n    rospy.spin()\n",
    "def far(x):\n    return x\nd = far(2)\n", "def far(x):\n    print(x)\nfar(2)\nd = other.far(2)\n",
    "x = 0\ndef show(pose):\n    x = pose.x\n", "x = 0\ndef add(x):\n    x = x + 1\n    return x\nprint(add(x))\n",
    "def stop():\n    p.publish(0)\np = rospy.Publisher('a', Twist)\np.publish(1)\n",
    "p = rospy.Publisher('a', Twist)\np.publish(1)\nrospy.spin()\np.publish(0)\n",
    "p = rospy.Publisher('a', Twist)\nwhile not rospy.is_shutdown():\n    p.publish(1)\np.publish(0)\n",
    "euler_from_quaternion([q.x, q.y, q.z, q.w])\n",
    "s = SimpleActionServer('a', FibonacciAction, go)\n", "m = Pose()\nm.x\n",
    "s = SimpleActionServer('a', FibonacciAction, go, False)\ns.start()\n"])
def test_what_may_be_right_is_none(text):
    assert found(text) == []


@pytest.mark.parametrize('text', [
    "for name in ('a', 'b'):\n    rospy.Subscriber(name, Pose, lambda pose, name=name: show(name, pose))\n",
    "for name in ('a', 'b'):\n    rospy.Subscriber(name, Pose, show, name)\n",
    "def talk():\n    while not rospy.is_shutdown():\n        pub.publish(1)\n        return\ntalk()\n"
    "rospy.Service('/a', SetPen, print)\n",
    "def talk():\n    while not rospy.is_shutdown():\n        pub.publish(1)\nrospy.Service('/a', SetPen, print)\n"
    "Thread(target=talk).start()\nrospy.Subscriber('/b', Pose, print)\n"])
def test_loops_and_lambdas_that_are_right(text):
    assert not any('comes too late' in hint or 'lambda' in hint for hint in found(text))


def test_a_program_that_is_no_node():
    source = "import rospy\nrospy.Publisher('a', Twist).publish(Twist())\n"
    assert 'rospy.init_node' in source_mistakes.found(source_mistakes.program(source))[0]


@pytest.mark.parametrize('path', programs('right', '*.py'),
                         ids=lambda path: f'{path.parent.name}_{path.stem}')
def test_right_programs_have_none(path):
    program = source_mistakes.program(path.read_text(encoding='utf-8'))
    assert source_mistakes.found(program) == []


@pytest.mark.parametrize('text, names', [
    ("rospy.Publisher('cmd_vel', Twist)\n", ['/cmd_vel']), ("NAME = '/turtle1/pose'\n", ['/turtle1/pose']),
    ("print('m/s of it', 'a / b')\n", []), ("f'/{turtle}/pose'\n'/' + turtle + '/pose'\n", []),
    ("def broken(:\n", None)])
def test_names(text, names):
    program = source_mistakes.program(text)
    assert (source_mistakes.names(program) if program else None) == names
