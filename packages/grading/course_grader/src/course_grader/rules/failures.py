"""Explains error messages of Python and ROS to beginners, with advice for each. Without ROS.

The first entry of FAILURES whose pattern is found counts, so specific ones precede general ones. Messages differ
between versions of Python: MESSAGES of test_failures.py has those of 3.11 to 3.14.
"""
import re
from typing import Callable, Match, Optional, Tuple, Union

from plain_support.doctor.findings import SHEBANG, two_types

PACKAGES = {  # name: module that it is imported from
    'Twist': 'geometry_msgs.msg', 'Vector3': 'geometry_msgs.msg', 'TransformStamped': 'geometry_msgs.msg',
    'Quaternion': 'geometry_msgs.msg', 'Pose': 'turtlesim.msg', 'Color': 'turtlesim.msg',
    'TeleportAbsolute': 'turtlesim.srv', 'TeleportAbsoluteResponse': 'turtlesim.srv',
    'TeleportRelative': 'turtlesim.srv', 'SetPen': 'turtlesim.srv', 'SetPenRequest': 'turtlesim.srv',
    'Spawn': 'turtlesim.srv', 'Kill': 'turtlesim.srv', 'Empty': 'std_srvs.srv', 'Trigger': 'std_srvs.srv',
    'TriggerResponse': 'std_srvs.srv', 'SetBool': 'std_srvs.srv', 'String': 'std_msgs.msg', 'Float32': 'std_msgs.msg',
    'Float64': 'std_msgs.msg', 'Bool': 'std_msgs.msg', 'Int32': 'std_msgs.msg', 'Odometry': 'nav_msgs.msg',
    'LaserScan': 'sensor_msgs.msg', 'Image': 'sensor_msgs.msg', 'AlvarMarkers': 'ar_track_alvar_msgs.msg',
    'AlvarMarker': 'ar_track_alvar_msgs.msg', 'quaternion_from_euler': 'tf.transformations',
    'euler_from_quaternion': 'tf.transformations', 'pi': 'math', 'sqrt': 'math', 'atan2': 'math', 'sin': 'math',
    'cos': 'math', 'radians': 'math', 'degrees': 'math', 'hypot': 'math'}
PLAIN = 'math', 'sys', 'os', 'time', 'random', 'threading'  # modules of Python without modules in them
MODULES = (*PLAIN, 'rospy', 'tf', 'tf2_ros', 'roslib', 'numpy', 'turtlesim')
WORDS = {'true': 'True', 'false': 'False', 'none': 'None', 'null': 'None', 'nil': 'None', 'NULL': 'None'}
TEXT_AS_NUMBER = ('a text is used as a number: write numbers without quotation marks, or make a number of a text by '
                  'float(text)')
NO_VALUE_YET = ('a variable is still None when it is used: wait until the callback has stored a message in it; a '
                'function without return gives None, too')
NO_PARENTHESES = 'a function is called with parentheses, also one without arguments, as in rospy.Time.now()'
PYTHON_2 = 'this is Python 2: `2to3 -w FILE` makes it Python 3'
SHADOWS = 'a file of yours has the name of the module {0}: give the file {0}.py another name'
F_STRING = ('in an f-string, each {{ needs its }} and a value between them, and quotation marks inside are others than '
            'those around it: f"x = {{pose.x}}"')
INDENTATION = 'indent each block by four blanks, and use no tabs'
ONE_ARGUMENT = ('a callback gets one argument, the message or request: `def {0}(message):`, in a class '
                '`def {0}(self, message):`')
OF_A_TYPE = ('a type has no values: use the message that the callback gets, or make one with parentheses, as in '
             '`message = Twist()`')
PART = ('a number stands where a part of a message has to be, so that it has no {0}: set the numbers alone, as in '
        'message.linear.x = 0.5')
LIST = 'a list has no {0}, each of its elements has: `for marker in message.markers:`'
OF_PYTHON = {  # a type that lacks the attribute {0}
    'NoneType': NO_VALUE_YET, 'function': NO_PARENTHESES, 'method': NO_PARENTHESES,
    'builtin_function_or_method': NO_PARENTHESES, 'member_descriptor': OF_A_TYPE, 'getset_descriptor': OF_A_TYPE,
    'int': PART, 'float': PART, 'list': LIST, 'tuple': LIST,
    'str': 'a text has no {0}: check what the variable holds',
    'dict': "a dictionary has no {0}: its values are read by ['{0}']"}
Advice = Union[str, Callable[[Match[str], str], str]]  # of the match and the program's source


def _no_node(match: Match[str], source: str) -> str:
    """Advice on a program without a node, '' if it would make one: then nothing calls the function, for example."""
    if match[0] == 'never started a node' and re.search(r'^[^#\n]*init_node\(', source, re.MULTILINE):
        return ''
    return 'call rospy.init_node before everything else of rospy'


def _undefined(match: Match[str], source: str) -> str:
    name = match[1]
    if re.search(rf'^\s*except\b[^:#\n]*,\s*{name}\s*:', source, re.MULTILINE):  # no SyntaxError since Python 3.14
        return PYTHON_2
    if name in WORDS:
        return f'Python writes {WORDS[name]} instead of {name}'
    if name == 'self':
        return 'a method needs self as its first parameter: `def callback(self, message):`'
    if name in PACKAGES:
        return f'{name} is used, but not imported: `from {PACKAGES[name]} import {name}`'
    if name in MODULES:
        return f'{name} is used, but not imported: `import {name}` at the top'
    meant = match[2] or next((known for known in PACKAGES if known.lower() == name.lower()), '')
    if meant:
        return f'the name {name} is used, but nothing has it: did you mean {meant}?'
    return f'the name {name} is used, but nothing has it: check its spelling, and where it gets a value'


def _not_in_module(match: Match[str], _source: str) -> str:
    name, module = match[1], match[2]
    right = next((known for known in PACKAGES if known.lower() == name.lower()), None)
    if right and (right != name or PACKAGES[right] != module):
        return f'{right} is imported from {PACKAGES[right]}: `from {PACKAGES[right]} import {right}`'
    if name[0].islower() and module.endswith(('.msg', '.srv')):
        return f'names of messages and services start with a capital letter, as in Twist, and not {name}'
    return (f'{module} has no {name}: check the spelling, and whether it is a message (PACKAGE.msg) or a service '
            '(PACKAGE.srv)')


def _no_module(match: Match[str], _source: str) -> str:
    name = match[1]
    if re.match(r'ar_track_alvar\b', name):
        return 'the messages are in ar_track_alvar_msgs.msg'
    if name in ('Tkinter', 'Queue', 'ConfigParser', 'urllib2', 'commands'):
        return PYTHON_2
    return f'there is no module {name}: check its spelling; messages are in PACKAGE.msg, services in PACKAGE.srv'


def _no_package(match: Match[str], _source: str) -> str:
    """Return advice on a name that is imported from a module which has no modules in it, or should have some."""
    name, module = match[1], match[2]
    return f'{name} is a name in {module}: `from {module} import {name}`' if module in PLAIN else SHADOWS.format(module)


def _no_attribute(match: Match[str], source: str) -> str:
    """Return advice on ``'TYPE' object has no attribute 'NAME'``."""
    kind, name = match[1], match[2]
    if kind in ('int', 'float') and name in ('to_sec', 'to_nsec', 'secs'):
        return 'give a time as rospy.Duration(seconds), not as a number'
    if kind in OF_PYTHON:
        return OF_PYTHON[kind].format(name)
    if re.search(rf'\bclass\s+{kind}\b', source):
        return _not_in_class(kind, name, source)
    kind, meant = kind.lstrip('_'), match[3]
    if meant and kind[:1].isupper():
        return f'{kind} has no field {name}: did you mean {meant}?'
    service = re.fullmatch(r'(\w+)(Request|Response)', kind)
    if service:
        return f'{kind} has no field {name}: `rossrv show {service[1]}` lists its fields'
    if kind[:1].isupper():
        return (f'{kind} has no field {name}: `rosmsg show {kind}` lists its fields, such as pose.x of a turtle or '
                'marker.pose.pose.position.x')
    return f'a {kind} has no {name}: check its spelling and what the variable holds'


def _not_in_class(kind: str, name: str, source: str) -> str:
    """Return advice on a missing attribute of a class of the program."""
    if re.search(rf'\bself\.{name}\s*(,[^=\n]*)?=(?!=)', source):
        return (f'self.{name} is read before it has a value: set it in __init__, before the Subscriber, which calls '
                'its callback at once')
    if re.search(rf'\bdef\s+{name}\b', source):
        return f'{name} is a function outside of the class {kind}: call it without `self.`, or indent it'
    return f'{kind} has no attribute {name}: check its spelling, or give self.{name} a value in __init__ first'


def _too_few(match: Match[str], source: str) -> str:
    """Return advice on ``NAME() missing 1 required positional argument``."""
    name = match[1].rpartition('.')[2]
    if name == '__init__':
        return 'an object is made without what its __init__ asks for: give these values in the parentheses'
    if re.search(rf'\b(Subscriber|Service|Timer|on_shutdown)\([^\n]*\b{name}\(\s*\)', source):
        return f'hand over the function itself, without parentheses: `{name}`, not `{name}()`'
    if re.search(rf'\b(Subscriber|Service|Timer)\([^\n]*\b{name}\b', source):
        return ONE_ARGUMENT.format(name)
    return f'{name} is called with too few arguments: its `def` says which it needs'


def _too_many(match: Match[str], source: str) -> str:
    """Return advice on ``NAME() takes N positional arguments but M were given``."""
    name = match[1].rpartition('.')[2]
    defined = re.search(rf'^([ \t]*)def\s+{name}\s*\(\s*(\w*)', source, re.MULTILINE)
    if defined and defined[1] and defined[2] != 'self':
        return f'a method needs self as its first parameter: `def {name}(self, ...):`'
    if re.search(rf'\b(Subscriber|Service|Timer)\([^\n]*\b{name}\b', source):
        return ONE_ARGUMENT.format(name)
    return f'{name} is called with too many arguments: its `def`, or its documentation, says which it takes'


def _not_supported(match: Match[str], _source: str) -> str:
    """Return advice on an operator between two types that do not fit."""
    kinds = {match[1], match[2]}
    if 'NoneType' in kinds:
        return NO_VALUE_YET
    if 'str' in kinds:
        return TEXT_AS_NUMBER
    if kinds & {'function', 'method', 'builtin_function_or_method'}:
        return NO_PARENTHESES
    if kinds & {'Time', 'Duration'}:
        return 'a time of ROS is not a number: time.to_sec() is its seconds, and rospy.Duration(1.0) can be added to it'
    other = sorted(kinds - {'int', 'float'}) or ['number']
    if other[0].lstrip('_')[:1].isupper() or other[0] == 'member_descriptor':
        return 'a whole message is used as a number: use a field of it, such as pose.x'
    return f'a {other[0]} is used as a number: use one of its elements'


def _no_value_yet(name: str, source: str) -> str:
    right = next((known for known in PACKAGES if known.lower() == name), '')
    if right and re.search(rf'\b{name}\s*=\s*{name}\(', source):
        return f'{name}() is not {right}(): types begin with a capital letter, `{name} = {right}()`'
    if re.search(rf'\bimport\b[^\n]*\b{name}\b', source):
        return (f'a variable has the name of the imported {name}, which is then unknown in the whole function: give it '
                'another name')
    return (f'{name} has no value yet in the function: if it is the variable outside, write `global {name}` in the '
            'first line of the function')


def _not_callable(match: Match[str], source: str) -> str:
    kind = match[1]
    if kind == 'NoneType' and not re.search(r'(?:Subscriber|Service|Timer|on_shutdown)\([^\n]*\w\(', source):
        return 'None stands before parentheses, as if it were a function: check what the variable gets'
    if kind == 'NoneType':
        return 'hand over the function itself, without parentheses: `callback`, not `callback()`'
    if kind == 'module':
        return 'a module cannot be called: name what is in it, as in time.sleep() or rospy.Rate()'
    return f'a {kind} stands before parentheses, as if it were a function: does a variable have the name of a function?'


def _not_a_list(match: Match[str], _source: str) -> str:
    kind = match[1].lstrip('_')
    if kind == 'NoneType':
        return NO_VALUE_YET
    if kind == 'Quaternion':
        return 'a Quaternion is not a list: make one of its parts, [q.x, q.y, q.z, q.w]'
    if kind[:1].isupper():
        return f'{kind} is not a list: use the list in it, as in `for marker in message.markers:`, or its fields'
    return f'a {kind} is used as a list: check what the variable holds'


def _no_response(_match: Match[str], source: str) -> str:
    """Return advice on the function of a service that returns something else than a response."""
    kinds = set(re.findall(r'\brospy\.Service\([^,\n]+,\s*(\w+)', source))
    kind = kinds.pop() if len(kinds) == 1 else 'TeleportAbsolute'
    return f'the function of a service must return a response of its own type: `return {kind}Response(...)`'


def _no_service(name: str, source: str) -> str:
    own = re.search(r'~/?' + name.rpartition('/')[2] + r'\b', source)
    return f'there is no service {name}: ' + (
        f'with ~ it belongs to the node itself; leave the ~ of {own[0]} out' if own else
        '`rosservice list` lists all; check its spelling')


def _types_differ(match: Match[str], _source: str) -> str:
    return str(two_types('a topic', [('one', match[1]), ('the other', match[2])]))


FAILURES: Tuple[Tuple[str, Advice], ...] = (  # {0}, ... of an advice are the groups of the pattern
    (r"Missing parentheses in call to|multiple exception types must be parenthesized|"
     r"name '(?:raw_input|xrange|unicode|unichr)' is not defined|has no attribute '(?:has_key|iteritems)'",
     PYTHON_2),
    (r"inconsistent use of tabs|TabError|unindent does not match|expected an indented block|unexpected indent|"
     r"'(?:return|yield|break|continue)' (?:outside|not properly)", INDENTATION),
    (r"SyntaxError: f-string: |unterminated (?:triple-quoted )?f-string|unterminated t-string", F_STRING),
    (r"was never closed|unmatched '|does not match opening|unexpected EOF",
     'a bracket is missing or one too many: each ( [ {{ needs its ) ] }}'),
    (r"expected ':'", 'lines that begin with if, else, while, for, def or class end with a colon'),
    (r"invalid character|invalid non-printable",
     'a quotation mark, a minus or a space was copied from a document: type it again on the keyboard'),
    (r"Maybe you meant '==' or|cannot assign to .* here|SyntaxError: cannot assign",
     'one = gives a name a value, and == compares: names stand to the left of ='),
    (r"unterminated .*string|EOL while scanning|intended to be part of the string",
     'a text has to end with the quotation mark that it starts with'),
    (r"invalid syntax\. Did you mean '(\w+)'", 'a word of Python in that line is misspelt: it is {0}'),
    (r"SyntaxError", 'Python cannot read that line: look there, and in the line before, for a missing colon, comma, '
     'bracket or quotation mark'),
    (r"EOFError|input\(\) does not work", 'input() does not work here, because nobody types: write the values into the '
     'program instead'),
    (r"the following arguments are required|usage: .*\n.*error: ",
     'the program gets no arguments here: write the values into it, or give them defaults'),
    (r"partially initialized module '(\w+)|(?:from|module) '(\w+)[^\n]*\(consider renaming ",
     lambda match, _: SHADOWS.format(match[1] or match[2])),
    (r"No module named '\w+\.(\w+)'; '(\w+)' is not a package", _no_package),
    (r"No module named '([\w.]+)'", _no_module),
    (r"cannot import name '(\w+)' from '([\w.]+)'", _not_in_module),
    (r"attempted relative import", 'import without a leading dot: `import NAME`'),
    (r"cannot launch node of type \[(\w+)/[^\]]*\]: \1\b", 'roslaunch finds no package {0}: hand in its whole folder, '
     'with the package.xml that has this name, and write the same name after pkg= in the launch file'),
    (r"Cannot locate node of type \[(\S+)\] in package \[(\w+)\]", 'roslaunch finds no program {0} in the package {1}: '
     'check the spelling, and make it executable by chmod +x {0}'),
    (r"time is not initialized|never started a node|init_node\(\) (?:must|has to)|before init_node", _no_node),
    (r"init_node\(\) has already been called", 'call rospy.init_node only once in a program'),
    (r"namespaces are not allowed in node names|illegal character|[Ii]nvalid (?:graph resource )?name|not a legal",
     'names of nodes and topics are made of letters, digits and _ alone; blanks and other signs do not work'),
    (r"service cannot process request: parameter (\S+) is '.*must be a (?:whole )?number",
     'the parameter {0} is a text: write the number without quotation marks'),
    (r"service cannot process request: (?!(?:service )?handler returned)([^\"\n]{1,120})",
     'the service refuses the request: {0}'),
    (r"(?i)handler returned (?:None|invalid value|bad|wrong)|handler .*returned (?:bad|wrong)|invalid response|"
     r"service cannot process request", _no_response),
    (r"Invalid number of arguments, args should be \[(.*?)\]",
     'the call or message takes exactly these values, in this order: {0}'),
    (r"No field name|(?:is not a valid|has no|Unknown) field|"
     r"unexpected keyword argument '(?:x|y|theta|r|g|b|width|off|name)'",
     'a value of the call has a wrong name: `rossrv show TYPE` lists the right ones'),
    (r"\b(\w+) is not an attribute of (\w+)", '{1} has no field {0}: `rosmsg show {1}` or `rossrv show` lists them'),
    (r"_check_types\(\) missing|missing 1 required positional argument: 'self'",
     'a type stands where an object of it has to be: make one with parentheses, as in Twist()'),
    (r"field ([\w.]+) must be of type \[\w+/(\w+)\]", 'the value of {0} has to be a {1}: set its parts one by one, '
     'as in message.linear.x = 0.5, or make one of them, as in {1}(x, y, ...)'),
    (r"field ([\w.]+) exceeds", 'the value of {0} is outside of its range: colours and widths are 0 to 255'),
    (r"field (\w+) (?:must be|is not a|is a non)",
     'the value of {0} has the wrong type: it needs numbers, without quotation marks; whole ones, as 255, for colours; '
     'the values of a call are given in the order of `rossrv show TYPE`'),
    (r"required argument is not (?:a float|an integer)|must be real number, not (?:str|list|tuple)|"
     r"struct\.error|ROSSerializationException|[Ff]ield .* must be|an integer is required",
     'a number is needed where a text, a list or None is given, and a whole one, such as 255, for a colour: write '
     'numbers without quotation marks'),
    (r"\b(\w+) expected (?:at (?:least|most) )?(\d+) arguments?, got (\d+)", '{0} takes {1} values, and gets {2}'),
    (r"math domain error|expected a (?:nonnegative|positive|number in range)", 'the number has no root, or no '
     'asin, acos or log, because it is negative, or above 1: print it before'),
    (r"(min|max)\(\) (?:arg|iterable argument) is (?:an? )?empty", '{0}() gets an empty list: look at len(list) first'),
    (r"(?:too many|not enough) values to unpack|cannot unpack", 'there are more or fewer values after = than names '
     'before it: print the value'),
    (r"data_class \[.*is not a", 'the second argument of Publisher and Subscriber is the type of the messages, without '
     'quotation marks, from PACKAGE.msg'),
    (r"topic name is not a non-empty string", 'the first argument of Publisher and Subscriber is the name of the '
     'topic, as a text, and the second its type'),
    (r"has no attribute '_(?:request|response)_class'", 'ServiceProxy and Service need the type of a service, from '
     'PACKAGE.srv: no message, request or response'),
    (r"\b(\w+)\(\) takes no arguments", '{0} takes no values in its parentheses: the answer of a service is made by '
     '{0}Response(...), and a class of your own needs an __init__ for them'),
    (r"\b(\w+)(?:\.__init__)?\(\) got an unexpected keyword argument '(\w+)'(?:\. Did you mean '(\w+)')?",
     lambda match, _: f'{match[1]} has no argument {match[2]}: '
     + (f'did you mean {match[3]}?' if match[3] else 'check its spelling')),
    (r"'(\w+)' is an invalid keyword argument for (\w+)\(\)", '{1} has no argument {0}: check its spelling'),
    (r"could not convert string to float|invalid literal for int\(\)",
     'float() and int() read a text that holds one number and nothing else: print the text to see what is in it'),
    (r"(?:can only concatenate str|must be str, not|can't multiply sequence)",
     'a text and a number cannot be joined by +: print(x, y) with commas, or make a text of a number by str(x)'),
    (r"not enough arguments for format string",
     "the text and its values do not fit: several values after % stand in parentheses, as in '%f %f' % (x, y), one for "
     'each %f, %d or %s'),
    (r"not all arguments converted|a (?:real )?number is required, not|"
     r"unsupported format (?:string|character)|Unknown format code|Replacement index",
     'the text and its values do not fit: each %f, %s or {{}} needs one value, a number for %f and %d'),
    (r"(?<![\w.<>])([\w.<>]+)\(\) missing \d+ required (?:positional|keyword-only) argument", _too_few),
    (r"(?<![\w.<>])([\w.<>]+)\(\) takes (?:from )?\d+ (?:to \d+ )?positional arguments? but \d+ (?:was|were) given",
     _too_many),
    (r"not supported between instances of '(\w+)' and '(\w+)'", _not_supported),
    (r"unsupported operand type\(s\) for \S+: '(\w+)' and '(\w+)'", _not_supported),
    (r"'(\w+)' object is not callable", _not_callable),
    (r"'(\w+)' object is not (?:subscriptable|iterable)|'(\w+)' object does not support item",
     lambda match, source: _not_a_list(match, source) if match[1] else 'use the fields of a message by their names, as '
     'in message.linear.x'),
    (r"object of type '(\w+)' has no len", _not_a_list),
    (r"cannot access local variable '(\w+)'|local variable '(\w+)' referenced before",
     lambda match, source: _no_value_yet(match[1] or match[2], source)),
    (r"module '(\w+)' has no attribute '(msg|srv)'", 'import what is used of it: `from {0}.{1} import NAME`'),
    (r"module 'rospy' has no attribute '(\w+)'", 'rospy has no {0}: check the spelling and the capital letters, as in '
     'rospy.Publisher'),
    (r"module '([\w.]+)' has no attribute '(\w+)'", '{0} has no {1}: check the spelling and the capital letters, and '
     'that no file of yours is called {0}.py'),
    (r"type object '(\w+)' has no attribute '(\w+)'", OF_A_TYPE),
    (r"'([\w.]+)' object has no attribute '(\w+)'(?:\. Did you mean: '([\w.]+)')?", _no_attribute),
    (r"name '(\w+)' is not defined(?:\. Did you mean: '([\w.]+)')?", _undefined),
    (r'to have datatype/md5sum \[([\w/]+)/\w+\], but our version has \[([\w/]+)/\w+\]', _types_differ),
    (r'(?i)service.* md5sum|incompatible (?:service )?type|wants service .* to have',
     lambda _, source: '' if 'ServiceProxy' not in source and re.search(r'\bService\(', source) else
     'the type of a service has to be that which its owner gives it: `rosservice type NAME` prints it'),
    (r"service \[([\w/]+)\] unavailable|timeout exceeded while waiting for service ([\w/]+)",
     lambda match, source: _no_service(match[1] or match[2], source)),
    (r"IndexError: (?:list|tuple) index out of range", 'a list has fewer elements than the program takes from it, '
     'perhaps none: loop over it with `for`, or look at len(list) first'),
    (r"KeyError: '?(~?[\w/]+)", 'nothing has the name {0}: check its spelling, or give a default, as in '
     'rospy.get_param(NAME, 0.5)'),
    (r"unhashable type: '(\w+)'", 'a {0} cannot be a key of a dictionary or lie in a set: use a number, a text or a '
     'tuple'),
    (r"ZeroDivisionError", 'a number is divided by 0: look at it before'),
    (r"RecursionError", 'a function calls itself without end: use a loop'),
    (r"ROSBagUnindexedException|not indexed", 'close the bag, by bag.close(), before it is opened to read it'),
    (r"LookupException|ConnectivityException|ExtrapolationException",
     'a transform is not there at once: look it up in a loop, with try and except, until it is; and compare the names '
     'of its frames'),
    (r"env: .?python.?: No such file", f'the first line of the program has to be `{SHEBANG}`'),
    (r"FileNotFoundError", 'the program sees no files but its own: do not read others'),
)


def advice(said: str, source: str) -> Optional[str]:
    """Return advice on the first known failure in the output of a program, or None."""
    for pattern, given in FAILURES:
        match = re.search(pattern, said)
        found = match and (given(match, source) if callable(given) else given.format(*match.groups()))
        if found:
            return found
    return None
