"""Kinds of mistakes, which a program makes in every right sample: what one line says is left out, swapped or misnamed.

Each kind changes a text at most once and says which hint names the cause. A change that leaves a program right, as an
equivalent one does, tells nothing about hints.
"""
import re
from typing import Callable, Dict, NamedTuple, Optional

NUMBER = r'-?\d+(?:\.\d+)?'


class Kind(NamedTuple):
    """A kind of mistake: ``change(text)`` returns the wrong program, or the same text if it does not apply.

    ``hint``: a pattern that the right hint contains.
    """

    change: Callable[[str], str]
    hint: str


def _first(pattern: str, new: str, flags: int = re.MULTILINE) -> Callable[[str], str]:
    return lambda text: re.sub(pattern, new, text, count=1, flags=flags)


def _last(pattern: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        found = list(re.finditer(pattern, text, re.MULTILINE))
        return text[:found[-1].start()] + found[-1].expand(new) + text[found[-1].end():] if found else text
    return change


def _negated(part: str) -> Callable[[str], str]:
    """Negate the first value that is set to ``part`` and is not 0."""
    return _first(rf'(\b{part} = )(?!0(?:\.0)?\s*$)(.+)$', r'\1-(\2)')


def _swapped_speeds(text: str) -> str:
    return re.sub(r'\b(linear\.x|angular\.z)( = )', lambda match: {
        'linear.x': 'angular.z', 'angular.z': 'linear.x'}[match[1]] + match[2], text)


def _without_import(name: str) -> Callable[[str], str]:
    """Leave a name out of the line that imports it."""
    return _first(rf'^(from [\w.]+ import )(?:{name}$|{name}, |(.*), {name}\b)', lambda match: (
        '' if match[0].endswith(f'import {name}') else match[1] + (match[2] or '')))


KINDS: Dict[str, Kind] = {
    'no parentheses after sleep': Kind(_last(r'rate\.sleep\(\)', 'rate.sleep'), r'parentheses call it'),
    'no sleep in the loop': Kind(_last(r'^( +)rate\.sleep\(\)$', r'\1pass'), r'sleep|pause|Rate'),
    'no spin': Kind(_first(r'^ *rospy\.spin\(\)\n?', ''), r'rospy\.spin'),
    'no init_node': Kind(_first(r'^( *)rospy\.init_node\(.*\)$', r'\1pass'), r'init_node'),
    'no publish': Kind(_first(r'^( +)\w+\.publish\(.*\)$', r'\1pass'), r'publish'),
    'no subscriber': Kind(_first(r'^( *)rospy\.Subscriber\(.*\)$', r'\1pass'), r'[Ss]ubscri|callback'),
    'no import of Twist': Kind(_without_import('Twist'), r'Twist is used, but not imported'),
    'no import of math': Kind(_first(r'^import math\n', ''), r'math is used, but not imported'),
    'lower-case Twist': Kind(_first(r'\bTwist\(\)', 'twist()'), r'Twist'),
    'callback called': Kind(_first(r'(rospy\.Subscriber\([^,\n]+, \w+, )(\w+)\)', r'\1\2())'), r'without parentheses'),
    'no colon': Kind(_first(r'^( *while .*):$', r'\1'), r'colon'),
    'bracket left open': Kind(_first(r'(rospy\.Publisher\(.*)\)$', r'\1'), r'bracket'),
    'indented by one': Kind(_first(r'^(    )(\w.*\.publish\(.*)$', r'\1 \2'), r'four blanks'),
    'name of the topic': Kind(_first(r"(['\"])/?turtle1/cmd_vel\1", r'\1/turtle/cmd_vel\1'), r'did you mean /turtle1/'),
    'name of the robot\'s topic': Kind(_first(r"(['\"])/cmd_vel\1", r'\1/cmdvel\1'), r'did you mean /cmd_vel'),
    'capital letter of a part': Kind(_first(r'\blinear\.x\b', 'linear.X'), r'has no field|no attribute|linear\.x'),
    'misspelt part': Kind(_first(r'\bangular\.z\b', 'angular.theta'), r'has no field|no attribute|angular\.z'),
    'linear backward': Kind(_negated(r'linear\.x'), r'backward|wrong way|sign|away|positive|negative|forward'),
    'turns to the other side': Kind(_negated(r'angular\.z'), r'left|right|sign|away|angular\.z|opposite|atan2'),
    'speeds swapped': Kind(_swapped_speeds, r'swapped|linear\.x|angular\.z|never turns'),
    'angular x instead of z': Kind(_first(r'\bangular\.z = ', 'angular.x = '), r'angular\.z'),
    'linear y instead of x': Kind(_first(r'\blinear\.x = ', 'linear.y = '), r'linear\.x'),
    'degrees': Kind(_first(r'\bmath\.pi / 2\b', '90'), r'radians'),
    'x and y swapped': Kind(_first(r'\b(pose|position|data|message)\.x, \1\.y\b', r'\1.y, \1.x'),
                            r'\bx\b.*\by\b|atan2'),
    'a response is not returned': Kind(_first(r'^( +)return (\w+Response\(.*\))$', r'\1\2'), r'return a response'),
    'Python 2': Kind(_first(r'^( +)print\((.*)\)$', r'\1print \2'), r'Python 2'),
    'text instead of a number': Kind(_first(rf'(linear\.x = )({NUMBER})$', r"\1'\2'"), r'text|number|type'),
    'service only named': Kind(_last(r'^( *)(clear|find)\(\)$', r'\1\2'), r'parentheses call it'),
    'action server not started': Kind(_first(r'^ *server\.start\(\)\n', ''), r'never started'),
    'text instead of a response': Kind(_first(r'^( +)return (\w+Response)\(.*\)$', r"\1return 'done'"),
                                       r'`return \w+Response'),
    'conditions in the wrong order': Kind(_first(
        r'(if \w+\.x < )(\d+)(:\n.*\n +elif \w+\.x < )(\d+)', r'\1\4\3\2'), r'never holds'),
    'sleep in the callback': Kind(_first(
        r'^(def (?:callback|send|log|control|on_\w+|print_pose)\(\w+\):\n)', r'\1    rospy.sleep(1.0)\n'),
                                  r'callback \w+ sleeps'),
    'x twice': Kind(_first(r'\b(pose|data|message)\.x\b(.*)\b\1\.y\b', r'\1.x\2\1.x'),
                    r'twice|\by\b'),
    'place instead of id': Kind(_first(r'\bmarker\.id\b', 'message.markers.index(marker)'), r'print marker\.id'),
    'never backward': Kind(_first(r'(linear\.x = )(GAIN \* .*)$', r'\1max(0.0, \2)'), r'backward'),
    'difference reversed': Kind(_first(r'([\w.\[\]]+) - ([\w.]+), ([\w.\[\]]+) - ([\w.]+)$', r'\2 - \1, \4 - \3'),
                                r'away|wrong way|sign'),
    'one topic for both turtles': Kind(_first(r"f'/\{name\}/pose'", "'/turtle1/pose'"), r'turtle2/pose|turtle2'),
}


def _scaled(part: str, factor: str) -> Callable[[str], str]:
    return _first(rf'(\b{part} = )({NUMBER})$', rf'\1\2 * {factor}')


def _inverted(text: str) -> str:
    """Invert the first comparison of an if, elif or while."""
    return re.sub(r'^( *(?:if|elif|while) .*?)( [<>]=? )', lambda match: match[1] + {
        '<': ' > ', '>': ' < ', '<=': ' >= ', '>=': ' <= '}[match[2].strip()], text, count=1, flags=re.MULTILINE)


# Written down, with their patterns, before anything was measured or changed for them.
HELD_OUT: Dict[str, Kind] = {
    'rate of the loop': Kind(_first(r'rospy\.Rate\(\d+\)', 'rospy.Rate(2)'), r'Rate|rate|times per second|too rarely'),
    'one = in a condition': Kind(_first(r'^( *if .*)==', r'\1='), r'=='),
    'comparison inverted': Kind(_inverted, r'condition|comparison|<|>|away|wrong way|never|sign'),
    'self left out': Kind(_first(r'^( +)self\.(\w+ = )', r'\1\2'), r'self'),
    'main not called': Kind(_last(r'^( *)main\(\)\n', r'\1pass\n'), r'main.*call|call.*main|nothing calls'),
    'mixed with a tab': Kind(_last(r'^ {8}(?=\S)', '\t'), r'[Tt]ab|blanks'),
    'name of the service': Kind(_first(r"(['\"])(/turtle1|/turtlesim)?/?(set_pen|teleport_absolute|spawn|clear)\1",
                                       r'\1\2/\3s\1'), r'did you mean'),
    'too fast': Kind(_scaled(r'linear\.x', '10'), r'fast|slow|linear\.x|speed'),
    'turns ten times as fast': Kind(_scaled(r'angular\.z', '10'), r'fast|angular\.z|turn speed|radius|diameter'),
    'quote left out': Kind(_first(r"(rospy\.init_node\('\w+)'", r'\1'), r'quot'),
    'callback without its argument': Kind(_first(r'^(def (?:on_|\w*callback|handle_)\w*\()\w+\)', r'\1)'),
                                          r'argument|parameter'),
    'type of the subscriber': Kind(_first(r'(rospy\.Subscriber\([^,\n]+, )Pose,', r'\1Twist,'), r'type|Pose|Twist'),
    'Twist of turtlesim': Kind(_first(r'from geometry_msgs\.msg import Twist$', 'from turtlesim.msg import Twist'),
                               r'geometry_msgs'),
    'topic without the turtle': Kind(_first(r"(['\"])/?turtle1/cmd_vel\1", r'\1cmd_vel\1'), r'/turtle1/cmd_vel'),
    'is_shutdown without parentheses': Kind(_first(r'is_shutdown\(\)', 'is_shutdown'), r'parentheses'),
    'lower-case rospy.Publisher': Kind(_first(r'rospy\.Publisher', 'rospy.publisher'), r'Publisher'),
}


def mutate(kind: str, text: str) -> Optional[str]:
    """Return a program with this kind of mistake, or None if it does not apply to it."""
    changed = {**KINDS, **HELD_OUT}[kind].change(text)
    return changed if changed != text else None
