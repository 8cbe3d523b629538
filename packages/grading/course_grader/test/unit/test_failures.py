"""course_grader.rules.failures: what Python says about a beginner's mistake leads to the right advice."""
import re
import subprocess
import sys
import time

import pytest

from course_grader.rules import failures

TWIST = '''
class Vector3:
    __slots__ = ['x', 'y', 'z']
class Twist:
    __slots__ = ['linear', 'angular']
    def __init__(self):
        self.linear = Vector3()
'''


def said_by(source):
    """Return the last line of the traceback of a program."""
    try:
        exec(compile(source, 'program.py', 'exec'), {'__name__': '__main__'})
    except Exception as error:
        return f'{type(error).__name__}: {error}'
    raise AssertionError('the program should fail')


@pytest.mark.parametrize('source, advice', [
    ("print 'hello'\n", 'this is Python 2'),
    ("name = raw_input()\n", 'this is Python 2'),
    ("import ConfigParser\n", 'this is Python 2'),
    ("def f():\n    a = 1\n  b = 2\n", 'four blanks'),
    ("if True:\n    a = 1\n\tb = 2\n", 'four blanks'),
    ("print((1, 2)\n", 'bracket'),
    ("a = [1, 2)\n", 'bracket'),
    ("print(‘hello’)\n", 'copied from a document'),
    ("if 1 = 2:\n    pass\n", '== compares'),
    ("a = 1 2\n", 'cannot read that line'),
    ("x = math.pi\n", '`import math`'),
    ("m = Twist()\n", '`from geometry_msgs.msg import Twist`'),
    ("p = Pose()\n", '`from turtlesim.msg import Pose`'),
    ("a = atan2(1, 2)\n", '`from math import atan2`'),
    ("while true:\n    pass\n", 'True instead of true'),
    ("class A:\n    def f():\n        self.x = 1\nA.f()\n", 'self as its first parameter'),
    ("speed = 1\nprint(sped)\n", 'the name sped is used'),
    ("import geometry_msg\n", 'there is no module geometry_msg'),
    ("from math import PI\n", 'from math import pi'),
    ("from math import tangent\n", 'math has no tangent'),
    ("def f(message):\n    pass\nf()\n", 'too few arguments'),
    ("def f():\n    pass\nf(1)\n", 'too many arguments'),
    ("class A:\n    def f(message):\n        pass\nA().f(1)\n", 'self as its first parameter'),
    ("class A:\n    def __init__(self, a):\n        pass\nA()\n", '__init__'),
    ("print(1.0 < '10')\n", 'text is used as a number'),
    ("print(1.0 - '10')\n", 'text is used as a number'),
    ("print('x = ' + 1.0)\n", 'cannot be joined by +'),
    ("print(None < 10)\n", 'still None'),
    ("a = None\nprint(a.x)\n", 'still None'),
    ("print(len < 10)\n", 'with parentheses'),
    ("def now():\n    pass\nnow.to_sec()\n", 'with parentheses'),
    (TWIST + "print(Twist() < 10)\n", 'whole message'),
    (TWIST + "Twist().linear < 1\n", 'whole message'),
    (TWIST.replace('Twist:', 'Twists:') + "class A:\n    pass\nfor a in A():\n    pass\n", 'A is not a list'),
    ("x = 1.0\nx()\n", 'as if it were a function'),
    ("import time\ntime()\n", 'a module cannot be called'),
    ("def f(a=None):\n    pass\n# rospy.Subscriber('a', Pose, f())\nNone()\n", 'hand over the function itself'),
    ("x = 0.5\nx.x = 1\n", 'message.linear.x = 0.5'),
    ("m = [1]\nm.id\n", 'for marker in message.markers'),
    ("(0.1).to_sec()\n", 'rospy.Duration'),
    ("float('1 2')\n", 'one number and nothing else'),
    ("[][0]\n", 'fewer elements'),
    ("{}['speed']\n", 'has the name speed'),
    ("def f():\n    f()\nf()\n", 'without end'),
    ("print('%d %d' % 1)\n", 'do not fit'),
    ("print('%d' % 'a')\n", 'do not fit'),
    ("print('{} {}'.format(1))\n", 'do not fit'),
    ("import struct\nstruct.pack('<d', 'a')\n", 'a number is needed'),
    ("class A:\n    def f(self):\n        print(self.x)\n        self.x = 1\nA().f()\n", 'before it has a value'),
    ("class A:\n    def f(self):\n        print(self.x)\nA().f()\n", 'give self.x a value'),
    ("class A:\n    def f(self):\n        self.g()\ndef g():\n    pass\nA().f()\n", 'outside of the class A'),
    ("open('/no/such/file')\n", 'no files but its own'),
    ("class A:\n    def f(self):\n        pass\nA.f()\n", 'make one with parentheses'),
    ("print('%f' % 'a')\n", 'a number is needed where a text'),
    ("import math\nmath.atan2(1)\n", 'atan2 takes 2 values, and gets 1'),
    ("a, b = 1\n", 'than names before it'), ("class A:\n    pass\nA(1)\n", 'A takes no values'),
    ("def f(a):\n    pass\nf(speed=1)\n", 'f has no argument speed'), ("(1, 2)[3]\n", 'fewer elements'),
    ("class Quaternion:\n    pass\nQuaternion()[0]\n", '[q.x, q.y, q.z, q.w]'),
    ("class Duration:\n    pass\nDuration() < 1.0\n", 'time.to_sec()'),
    ("a = None\na()\n", 'None stands before parentheses'),
])
def test_what_python_says(source, advice):
    said = said_by(source)
    assert advice in (failures.advice(said, source) or ''), said


MESSAGES = [  # program, its file, advice, {version of Python from which on it says this: the last line}; all but those
    # of the Python that runs the test are taken from CPython's sources and documentation
    ('min([])\n', 'a.py', 'min() gets an empty list', {
        (3, 11): 'ValueError: min() arg is an empty sequence',
        (3, 13): 'ValueError: min() iterable argument is empty'}),
    ("try:\n    int('a')\nexcept ValueError, e:\n    pass\n", 'a.py', 'this is Python 2', {
        (3, 11): 'SyntaxError: multiple exception types must be parenthesized',
        (3, 14): "NameError: name 'e' is not defined"}),
    ('import math\nmath.sqrt(-1)\n', 'a.py', 'has no root', {
        (3, 11): 'ValueError: math domain error', (3, 14): 'ValueError: expected a nonnegative input, got -1.0'}),
    ('import math\nmath.acos(2)\n', 'a.py', 'asin, acos or log', {
        (3, 11): 'ValueError: math domain error',
        (3, 14): 'ValueError: expected a number in range from -1 up to 1, got 2.0'}),
    ('import math\nmath.log(0)\n', 'a.py', 'asin, acos or log', {
        (3, 11): 'ValueError: math domain error', (3, 14): 'ValueError: expected a positive input'}),
    ('1.0 / 0\n', 'a.py', 'divided by 0', {
        (3, 11): 'ZeroDivisionError: float division by zero', (3, 14): 'ZeroDivisionError: division by zero'}),
    ('a, b = [1, 2, 3]\n', 'a.py', 'than names before it', {
        (3, 11): 'ValueError: too many values to unpack (expected 2)',
        (3, 14): 'ValueError: too many values to unpack (expected 2, got 3)'}),
    ('def f(speed):\n    pass\nf(sped=1)\n', 'a.py', 'f has no argument sped', {
        (3, 11): "TypeError: f() got an unexpected keyword argument 'sped'",
        (3, 13): "TypeError: f() got an unexpected keyword argument 'sped'. Did you mean 'speed'?"}),
    ("print('a', edn='')\n", 'a.py', 'print has no argument edn', {
        (3, 11): "TypeError: 'edn' is an invalid keyword argument for print()",
        (3, 13): "TypeError: print() got an unexpected keyword argument 'edn'"}),
    ('import random\nrandom.uniform(1, 2)\n', 'random.py', 'file random.py another name', {
        (3, 11): "AttributeError: partially initialized module 'random' has no attribute 'uniform' (most likely due "
                 'to a circular import)',
        (3, 13): "AttributeError: module 'random' has no attribute 'uniform' (consider renaming '{file}' since it has "
                 "the same name as the standard library module named 'random' and the import system gives it "
                 'precedence)',
        (3, 14): "AttributeError: module 'random' has no attribute 'uniform' (consider renaming '{file}' since it has "
                 "the same name as the standard library module named 'random' and prevents importing that standard "
                 'library module)'}),
    ('from random import uniform\n', 'random.py', 'file random.py another name', {
        (3, 11): "ImportError: cannot import name 'uniform' from partially initialized module 'random' (most likely "
                 'due to a circular import) ({file})',
        (3, 13): "ImportError: cannot import name 'uniform' from 'random' (consider renaming '{file}' since it has the "
                 "same name as the standard library module named 'random' and prevents importing that standard library "
                 'module)'}),
    ('from turtlesim import Pose\n', 'turtlesim.py', 'file turtlesim.py another name', {
        (3, 11): "ImportError: cannot import name 'Pose' from partially initialized module 'turtlesim' (most likely "
                 'due to a circular import) ({file})',
        (3, 13): "ImportError: cannot import name 'Pose' from 'turtlesim' (consider renaming '{file}' if it has the "
                 'same name as a library you intended to import)'}),
    ('from turtlesim.msg import Pose\n', 'turtlesim.py', 'file turtlesim.py another name', {
        (3, 11): "ModuleNotFoundError: No module named 'turtlesim.msg'; 'turtlesim' is not a package"}),
    ('import math.pi\n', 'a.py', '`from math import pi`', {
        (3, 11): "ModuleNotFoundError: No module named 'math.pi'; 'math' is not a package"}),
    ('time.sleep(1)\n', 'a.py', '`import time`', {
        (3, 11): "NameError: name 'time' is not defined",
        (3, 12): "NameError: name 'time' is not defined. Did you forget to import 'time'?"}),
    ('class A:\n    def __init__(self):\n        self.speed = 1\n        print(speed)\nA()\n', 'a.py',
     'speed is used', {
        (3, 11): "NameError: name 'speed' is not defined",
        (3, 12): "NameError: name 'speed' is not defined. Did you mean: 'self.speed'?"}),
    ('x = 1\ndef f():\n    x += 1\nf()\n', 'a.py', '`global x`', {
        (3, 11): "UnboundLocalError: cannot access local variable 'x' where it is not associated with a value"}),
    ("a = 'hello\n", 'a.py', 'quotation mark', {
        (3, 11): 'SyntaxError: unterminated string literal (detected at line 1)',
        (3, 14): 'SyntaxError: unterminated string literal (detected at line 1)'}),
    ("a = 'it's'\n", 'a.py', 'quotation mark', {
        (3, 11): "SyntaxError: unterminated string literal (detected at line 1)"}),
    ('x = 1\nprint(f"{x")\n', 'a.py', 'in an f-string', {
        (3, 11): "SyntaxError: f-string: expecting '}'",
        (3, 12): "SyntaxError: f-string: expecting '}'"}),
    ('print(f"{}")\n', 'a.py', 'in an f-string', {
        (3, 11): 'SyntaxError: f-string: empty expression not allowed',
        (3, 12): "SyntaxError: f-string: valid expression required before '}'"}),
    ('print(f"a)\n', 'a.py', 'quotation mark', {
        (3, 11): 'SyntaxError: unterminated string literal (detected at line 1)',
        (3, 12): 'SyntaxError: unterminated f-string literal (detected at line 1)'}),
    ('whille True:\n    pass\n', 'a.py', 'that line', {
        (3, 11): 'SyntaxError: invalid syntax', (3, 14): "SyntaxError: invalid syntax. Did you mean 'while'?"}),
    ("if True:\nprint('a')\n", 'a.py', 'four blanks', {
        (3, 11): "IndentationError: expected an indented block after 'if' statement on line 1"}),
    ('a = 1\nreturn a\n', 'a.py', 'four blanks', {(3, 11): "SyntaxError: 'return' outside function"}),
    ('a = {[1]: 2}\n', 'a.py', 'key of a dictionary', {
        (3, 11): "TypeError: unhashable type: 'list'",
        (3, 14): "TypeError: cannot use 'list' as a dict key (unhashable type: 'list')"}),
]


@pytest.mark.parametrize('source, _name, advice, messages', MESSAGES)
def test_what_each_version_of_python_says(source, _name, advice, messages):
    for said in messages.values():
        assert advice in failures.advice(said, source), said


@pytest.mark.parametrize('source, name, advice, messages', MESSAGES)
def test_this_python_says_so(tmp_path, source, name, advice, messages):
    (tmp_path / name).write_text(source)
    ended = subprocess.run([sys.executable, name], cwd=tmp_path, stderr=subprocess.PIPE, text=True, check=False)
    known = max((version for version in messages if version <= sys.version_info[:2]), default=None)
    if known is None:
        pytest.skip('a Python older than 3.11')
    assert ended.stderr.splitlines()[-1] == messages[known].replace('{file}', str(tmp_path / name))


@pytest.mark.parametrize('said, source, advice', [
    ("EOFError: EOF when reading a line; input() does not work here", '', 'nobody types'),
    ("rospy.exceptions.ROSInitException: time is not initialized. Have you called init_node()?", '', 'rospy.init_node'),
    ("ValueError: namespaces are not allowed in node names", '', 'letters, digits'),
    ("TypeError: Invalid number of arguments, args should be ['x', 'y', 'theta'] args are(1,)", '',
     "'x', 'y', 'theta'"),
    ("rospy.service.ServiceException: service [/turtle1/set_pens] unavailable", '', 'no service /turtle1/set_pens'),
    ("rospy.service.ServiceException: service [/node/spawn] unavailable", "rospy.ServiceProxy('~spawn', Spawn)",
     'leave the ~ of ~spawn out'),
    ("service handler returned None", '', 'must return a response'),
    ("service cannot process request: handler returned invalid value: Invalid number of arguments",
     "rospy.Service('/a', Trigger, go)", '`return TriggerResponse(...)`'),
    ("AttributeError: '_Pose' object has no attribute 'X'", '', 'Pose has no field X'),
    ("AttributeError: type object 'Twist' has no attribute 'linear'", '', 'message = Twist()'),
    ("TypeError: callback() missing 1 required positional argument: 'pose'",
     "rospy.Subscriber('/turtle1/pose', Pose, callback())", 'without parentheses'),
    ("TypeError: callback() missing 1 required positional argument: 'pose'",
     "rospy.Subscriber('/turtle1/pose', Pose, callback)", 'one argument'),
    ("SerializationError: field linear must be of type [geometry_msgs/Vector3]", '', 'message.linear.x = 0.5'),
    ("SerializationError: field r exceeds specified width [uint8]", '', 'colours and widths are 0 to 255'),
    ("TypeError: Message._check_types() missing 1 required positional argument: 'self'", '', 'as in Twist()'),
    ("AttributeError: sucess is not an attribute of TriggerResponse", '', 'TriggerResponse has no field sucess'),
    ("AttributeError: 'LaserScan' object has no attribute 'range'. Did you mean: 'ranges'?", '', 'mean ranges?'),
    ("ValueError: data_class [Pose] is not a class", '', 'without quotation marks'),
    ("ValueError: topic name is not a non-empty string", '', 'the first argument of Publisher'),
    ("AttributeError: type object 'Pose' has no attribute '_request_class'", '', 'the type of a service'),
    ("AttributeError: module 'geometry_msgs' has no attribute 'msg'", '', 'from geometry_msgs.msg import NAME'),
    ("NameError: name 'twist' is not defined", '', 'did you mean Twist?'),
    ("AttributeError: module 'rospy' has no attribute 'publisher'", '', 'rospy has no publisher'),
    ("topic types do not match: [Client wants topic /turtle1/pose to have datatype/md5sum [geometry_msgs/Pose/e4], but "
     "our version has [turtlesim/Pose/86]", '', 'one has geometry_msgs/Pose, the other has turtlesim/Pose'),
    ("UnboundLocalError: cannot access local variable 'twist' where it is not associated with a value",
     'def f():\n    twist = twist()\n', '`twist = Twist()`'),
    ('ERROR: cannot launch node of type [topic_demo/drive.py]: Cannot locate node of type [drive.py] in package '
     '[topic_demo]. Make sure file exists in package path and permission is set to executable (chmod +x)\n'
     'the program never started a node; does it call rospy.init_node?', '', 'chmod +x drive.py'),
    ('the program never started a node; does it call rospy.init_node?\nERROR: cannot launch node of type '
     '[topic_demo/drive.py]: topic_demo\nROS path [0]=/a', '', 'roslaunch finds no package topic_demo'),
])
def test_what_ros_says(said, source, advice):
    assert advice in failures.advice(said, source)


@pytest.mark.parametrize('said', [
    '', 'x: 1.0 y: 2.0', '[INFO] [1.0]: No AR markers detected.', 'shutdown request: user request',
    'speed < 10, error 0.1', 'rospy.init_node', 'usage of the pen'])
def test_usual_output_is_no_failure(said):
    assert failures.advice(said, '') is None


def test_long_lines_are_searched_at_once():
    """A program that printed 60 MB of digits took minutes: each digit could begin the name of a function."""
    begun = time.process_time()
    assert failures.advice('\n'.join(['5' * 2000] * 100), '') is None
    assert time.process_time() - begun < 10.0  # [s]; it was 60


def test_each_advice_is_one_sentence():
    for pattern, given in failures.FAILURES:
        re.compile(pattern)
        assert callable(given) or not given.endswith('.'), given


def test_the_type_of_an_own_service_is_left_to_the_exercise():
    said = 'incompatible service type'
    assert failures.advice(said, "rospy.Service('/a', Empty, go)\n") is None
    assert 'rosservice type' in failures.advice(said, "rospy.ServiceProxy('/a', Empty)()\n")
