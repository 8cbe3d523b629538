"""Extract programs and commands from the texts of the course, which are not part of the repository.

The texts are printed slides and a web page: programs have lost their indentation, continue over several slides and have
typographic quotes. This module repairs them as a student does who types them, and changes nothing else.
"""
import re
import textwrap
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[5] / 'shared' / 'seeds'
MISSING = (f'the course texts are not in {FOLDER}: the programs of the course are NOT tested. '
           'Put the folder "shared" beside the repository to test them.')

SHEBANG = '#!/usr/bin/env python'
SLIDE_HEAD = 3  # lines that each slide begins with: section, chapter, title
ROBOT_LOOP = '''velocity = Twist()
velocity.linear.x = 0.2
rate = rospy.Rate(1)
while not rospy.is_shutdown():
    velocity_pub.publish(velocity)
    rospy.loginfo(velocity)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
'''
PRINT_X = "rospy.loginfo('x of marker %d: %.3f m', marker.id, marker.pose.pose.position.x)"
COMMAND = re.compile(r'(?:.*:(?P<folder>~\S*))?\$ (?P<typed>\w[^#\n]*?) *(?:#.*)?')  # behind a prompt
BARE_COMMAND = re.compile(r' *(?P<typed>ros(?:core|run|launch|topic)(?: .*)?)')  # of a text without prompts
QUOTES = str.maketrans({'\u2018': "'", '\u2019': "'", '\u201c': '"', '\u201d': '"'})


def text(number):
    """Return the course text with a number, 0 to 2, with plain quotes."""
    path, = FOLDER.glob(f'{number:03d}_*.txt')
    return path.read_text(encoding='utf-8').translate(QUOTES)


def programs(course):
    """Return the programs of a text, indented: from a shebang line to an empty line or to the end of its main part."""
    lines = without_slides(course.splitlines())
    starts = [number for number, line in enumerate(lines) if line.startswith(SHEBANG)]
    return [indented(one_program(lines[start:])) for start in starts]


def function(course, name):
    """Return the source of a function that is printed separately, up to its return."""
    lines = course.splitlines()
    start = max(number for number, line in enumerate(lines) if line.startswith(f'def {name}('))
    end = next(number for number in range(start, len(lines)) if lines[number].startswith('return'))
    return indented(lines[start:end + 1])


def commands(course, program=''):
    """Return (command, lines printed below it) of each command line, in the order of the text.

    Those that cannot be typed unchanged, with [names] to be filled in, are left out, and those of other programs.
    """
    lines = course.splitlines()
    found = [[(match, number) for number, match in enumerate(map(form.fullmatch, lines)) if match]
             for form in (COMMAND, BARE_COMMAND)]
    return [(match['typed'], lines[number + 1:]) for match, number in found[0] or found[1]
            if match['typed'].split()[0].startswith(program) and '[' not in match['typed']]


def folder(course):
    """Return the folder that stands in the prompts of a text."""
    return next(match['folder'] for match in map(COMMAND.fullmatch, course.splitlines()) if match and match['folder'])


def output(course, *beginnings):
    """Return the lines that a text shows of a terminal and that begin so; `...` stands for the author's home folder.

    Two of them may stand in one line of the text.
    """
    lines = re.sub(r' (?=\[rosrun\]|Created file)', '\n', course).splitlines()
    return [re.sub(r'/home/\w+', '...', line) for line in lines if line.startswith(beginnings)]


def snippets(course, *beginnings):
    """Return the code of a web page that begins with each of these, one after the other, without its margin."""
    blocks = [textwrap.dedent(block).strip() for block in re.findall(r'(?m)(?:^ {4}.*\n)+', course)]
    return [next(block for block in blocks if re.search(beginning, block)) for beginning in beginnings]


def endless():
    """Return {name: source} of the programs of all texts that run until they are ended.

    The service is printed without the rospy.spin() that it needs.
    """
    (publisher, subscriber), (both, service) = programs(text(0)), programs(text(1))
    return {'publisher': publisher, 'pose_subscriber': subscriber, 'pub': both, 'service': with_spin(service),
            'ar_control_node': ar_control_node()}


def with_spin(program):
    """Return a program that does not end before Ctrl-C."""
    return f'{program}rospy.spin()\n'


def ar_control_node(markers=True, turn=0.0, print_x=False):
    """Return the program that is put together of the pieces of text 2: a publisher, and a subscriber of ``markers``.

    Its loop is said in words only: a Twist that goes forward, published and printed once a second; so are the turning
    component, and the x component of a marker's position.
    """
    twist, alvar, handler, init, publisher = snippets(text(2), 'import Twist', 'import AlvarMarkers',
                                                      'def ar_message_handler', 'init_node', 'rospy.Publisher')
    if print_x:
        handler = re.sub(r'(?m)^( *)(.*marker\.id.*)$', fr'\1\2\n\1{PRINT_X}', handler)
    if not markers:
        init = re.sub('(?m)^.*(ar_message_handler|ubscri).*$', '', init).strip()
    loop = ROBOT_LOOP.replace('rate =', f'velocity.angular.z = {turn}\nrate =')
    return '\n'.join(['#!/usr/bin/env python', 'import rospy', twist, *([alvar, handler] if markers else []), init,
                      publisher, loop])


def without_slides(lines):
    """Return the lines without the break in the middle of a program: a line with an address, the next slide's head."""
    kept, head = [], 0
    for line in lines:
        if 'https://' in line:
            head = SLIDE_HEAD
        elif head:
            head -= 1
        else:
            kept.append(line)
    return kept


def one_program(lines):
    main = False
    for number, line in enumerate(lines):
        main = main or line.startswith('if __name__')
        if not line.strip():
            return lines[:number]
        if main and line.strip() == 'pass':
            return lines[:number + 1]
    return lines


def indented(lines):
    """Return the source with the indentation that its lines have lost.

    A line that ends with a colon is followed by a block. Blocks end where a function or the main part begins, and at
    an except, which belongs to the try before it. That is all that the course's programs need.
    """
    result, depth, tries = [], 0, []
    for line in lines:
        if re.match(r'def |if __name__', line):
            depth = 0
        elif line.startswith('except'):
            depth = tries.pop()
        elif line.startswith('try:'):
            tries.append(depth)
        result.append(' ' * 4 * depth + line)
        if line.rstrip().endswith(':') and not line.startswith('#'):
            depth += 1
    return '\n'.join(result) + '\n'
